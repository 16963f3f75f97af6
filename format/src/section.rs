//! The section table: what is in a package, and where.

use core::fmt;
use zerocopy::little_endian::{U16, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Length of one entry of the section table.
pub const ENTRY_LENGTH: usize = 64;

/// Flag bit 0 of an entry: a reader that does not know the section's kind must refuse the package.
pub const FLAG_CRITICAL: u32 = 1;

/// Four ASCII letters that name a kind of section.
#[derive(
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    FromBytes,
    IntoBytes,
    Immutable,
    KnownLayout,
    Unaligned,
)]
#[repr(transparent)]
pub struct FourCc(pub [u8; 4]);

impl fmt::Display for FourCc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for byte in self.0 {
            // A damaged table may hold anything: keep terminals safe.
            let letter = if byte.is_ascii_graphic() {
                char::from(byte)
            } else {
                '?'
            };
            write!(f, "{letter}")?;
        }
        Ok(())
    }
}

impl fmt::Debug for FourCc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FourCc({self})")
    }
}

/// What names a section within its package: no two sections share all four.
///
/// The derived order (layer, instance, kind, ordinal) is the order of the table and of the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SectionId {
    /// Layer of the material, 0 for the first or for what all share.
    pub layer: u16,
    /// Number of the instance (a method with its recipe), from 1; 0 for what all instances share.
    pub instance: u16,
    /// What the section holds.
    pub kind: FourCc,
    /// Level or tile, 0 where there is only one.
    pub ordinal: u32,
}

impl SectionId {
    /// The only section of `kind` that belongs to `instance` of `layer`.
    pub const fn of_instance(layer: u16, instance: u16, kind: FourCc) -> Self {
        Self {
            layer,
            instance,
            kind,
            ordinal: 0,
        }
    }

    /// The only section of `kind` that all instances share.
    pub const fn shared(kind: FourCc) -> Self {
        Self::of_instance(0, 0, kind)
    }
}

impl fmt::Display for SectionId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.kind)?;
        if self.instance != 0 {
            write!(f, " of instance {}", self.instance)?;
        }
        if self.layer != 0 {
            write!(f, " in layer {}", self.layer)?;
        }
        if self.ordinal != 0 {
            write!(f, " number {}", self.ordinal)?;
        }
        Ok(())
    }
}

/// One entry of the section table as it lies in the file.
#[derive(Clone, Copy, Debug, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct SectionEntry {
    /// 0: kind.
    pub kind: FourCc,
    /// 4: layer.
    pub layer: U16,
    /// 6: instance.
    pub instance: U16,
    /// 8: ordinal.
    pub ordinal: U32,
    /// 12: flags, see [`FLAG_CRITICAL`]; other bits are zero.
    pub flags: U32,
    /// 16: bytes of one element.
    pub element_size: U32,
    /// 20: version of the element's layout, 1 so far.
    pub schema: U32,
    /// 24: offset of the first byte from the start of the file, a multiple of 256.
    pub offset: U64,
    /// 32: length in bytes: element size × element count.
    pub length: U64,
    /// 40: number of elements.
    pub count: U64,
    /// 48: CRC-32 of the section's bytes.
    pub crc: U32,
    /// 52: zero.
    pub reserved: [u8; 12],
}

const _: () = assert!(
    size_of::<SectionEntry>() == ENTRY_LENGTH,
    "an entry is 64 bytes"
);

impl SectionEntry {
    /// What names this section.
    pub const fn id(&self) -> SectionId {
        SectionId {
            layer: self.layer.get(),
            instance: self.instance.get(),
            kind: self.kind,
            ordinal: self.ordinal.get(),
        }
    }

    /// Whether a reader that does not know the kind must refuse the package.
    pub const fn is_critical(&self) -> bool {
        self.flags.get() & FLAG_CRITICAL != 0
    }
}
