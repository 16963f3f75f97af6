//! The 128 bytes a package begins with.

use crate::version::{MAGIC, MAJOR, MINOR};
use zerocopy::little_endian::{U16, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Length of the header, and the offset of the section table.
pub const HEADER_LENGTH: usize = 128;

/// The header as it lies in the file; byte offsets on the left of each field's description.
#[derive(Clone, Copy, Debug, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct Header {
    /// 0: [`MAGIC`].
    pub magic: [u8; 12],
    /// 12: major version; a reader refuses any but its own.
    pub major: U16,
    /// 14: minor version; additive.
    pub minor: U16,
    /// 16: length of the whole file in bytes.
    pub file_length: U64,
    /// 24: length of this header, 128.
    pub header_length: U32,
    /// 28: number of entries in the section table.
    pub section_count: U32,
    /// 32: offset of the section table, 128.
    pub table_offset: U64,
    /// 40: features a reader must understand; a reader refuses bits it does not know. None is defined yet.
    pub must_understand: U32,
    /// 44: features a reader may ignore. None is defined yet.
    pub may_ignore: U32,
    /// 48: BLAKE3 of the recipe, the contents of the inputs and the algorithm's version: the cache key.
    pub recipe_hash: [u8; 32],
    /// 80: BLAKE3 of every byte after this header.
    pub content_hash: [u8; 32],
    /// 112: CRC-32 of the section table.
    pub table_crc: U32,
    /// 116: zero.
    pub reserved: [u8; 8],
    /// 124: CRC-32 of bytes 0 to 123 of this header.
    pub header_crc: U32,
}

const _: () = assert!(
    size_of::<Header>() == HEADER_LENGTH,
    "the header is 128 bytes"
);

/// Bytes of the header that its own checksum covers.
pub(crate) const HEADER_CRC_COVERS: usize = HEADER_LENGTH - 4;

impl Header {
    /// The header of a package of `file_length` bytes with `section_count` sections; checksum included.
    pub fn new(
        file_length: u64,
        section_count: u32,
        recipe_hash: [u8; 32],
        content_hash: [u8; 32],
        table_crc: u32,
    ) -> Self {
        let mut header = Self {
            magic: MAGIC,
            major: U16::new(MAJOR),
            minor: U16::new(MINOR),
            file_length: U64::new(file_length),
            header_length: U32::new(HEADER_LENGTH as u32),
            section_count: U32::new(section_count),
            table_offset: U64::new(HEADER_LENGTH as u64),
            must_understand: U32::ZERO,
            may_ignore: U32::ZERO,
            recipe_hash,
            content_hash,
            table_crc: U32::new(table_crc),
            reserved: [0; 8],
            header_crc: U32::ZERO,
        };
        header.header_crc = U32::new(header.computed_crc());
        header
    }

    /// The CRC-32 this header should carry.
    pub(crate) fn computed_crc(&self) -> u32 {
        let (covered, _) = self.as_bytes().split_at(HEADER_CRC_COVERS);
        crc32fast::hash(covered)
    }
}
