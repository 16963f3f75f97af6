//! Changing packages behind their checksums' back.

use glintbake_format::{Container, ENTRY_LENGTH, FourCc, HEADER_LENGTH, Header};
use std::ops::Range;
use zerocopy::IntoBytes;

/// Recomputes header and checksums of `bytes`, all but the content hash, so that only a lie itself can be found. Returns
/// whether it could: there must be room for the table that the header tells of.
pub fn reseal(bytes: &mut [u8]) -> bool {
    let count = word(bytes, 28, 4);
    let table_end = count
        .saturating_mul(ENTRY_LENGTH)
        .saturating_add(HEADER_LENGTH);
    if table_end > bytes.len() {
        return false;
    }
    for at in (HEADER_LENGTH..table_end).step_by(ENTRY_LENGTH) {
        let (offset, length) = (word(bytes, at + 24, 8), word(bytes, at + 32, 8));
        if let Some(section) = bytes.get(offset..offset.saturating_add(length)) {
            let crc = crc32(section);
            bytes[at + 48..at + 52].copy_from_slice(&crc.to_le_bytes());
        }
    }
    let table_crc = crc32(&bytes[HEADER_LENGTH..table_end]);
    let header = Header::new(
        bytes.len() as u64,
        count as u32,
        [0; 32],
        [0; 32],
        table_crc,
    );
    bytes[..HEADER_LENGTH].copy_from_slice(header.as_bytes());
    true
}

/// The number in the `length` bytes from `place`; beyond any bytes if there are none.
fn word(bytes: &[u8], place: usize, length: usize) -> usize {
    let Some(little_endian) = bytes.get(place..place + length) else {
        return usize::MAX;
    };
    little_endian
        .iter()
        .rev()
        .fold(0, |word, &byte| word << 8 | usize::from(byte))
}

/// CRC-32 bit by bit, apart from the library the package is written with.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

/// The bytes of instance `instance`'s section of `kind` in the sound package `bytes`.
///
/// # Panics
/// If the package does not open, or has no such section.
pub fn section_range(bytes: &[u8], kind: FourCc, instance: u16) -> Range<usize> {
    let container = Container::open(bytes).expect("a sound package opens");
    let entry = container
        .entries()
        .iter()
        .find(|entry| entry.kind == kind && entry.instance.get() == instance)
        .expect("the package has the section to lie in");
    let start = entry.offset.get() as usize;
    start..start + entry.length.get() as usize
}
