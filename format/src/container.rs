//! Opening a package: header, section table, and typed views of sections, all over borrowed bytes.
#![deny(clippy::arithmetic_side_effects, clippy::cast_possible_truncation)]

use crate::finding::{Fault, Finding};
use crate::header::{HEADER_LENGTH, Header};
use crate::records::{self, INSTANCES, Instance, InstanceRecord};
use crate::section::{ENTRY_LENGTH, FLAG_CRITICAL, SectionEntry, SectionId};
use crate::version::{ALIGNMENT, MAGIC, MAJOR, MAX_SECTIONS};
use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

/// A package whose header and section table are sound, over borrowed bytes.
///
/// Opening reads the header, the table and the instance records, which lie side by side at the start of the file,
/// and nothing else, so its cost does not depend on the size of the package.
#[derive(Clone, Copy, Debug)]
pub struct Container<'a> {
    bytes: &'a [u8],
    header: &'a Header,
    entries: &'a [SectionEntry],
    instances: &'a [InstanceRecord],
}

impl<'a> Container<'a> {
    /// The package in `bytes`.
    ///
    /// # Errors
    /// The first [`Finding`] among the 1xxx, 2xxx and 4xxx faults. Data sections are not looked at: see
    /// [`check`](crate::check).
    pub fn open(bytes: &'a [u8]) -> Result<Self, Finding> {
        let header = read_header(bytes)?;
        let entries = read_table(bytes, header)?;
        let mut container = Self {
            bytes,
            header,
            entries,
            instances: &[],
        };
        container.check_entries()?;
        container.instances = container.elements(SectionId::shared(INSTANCES))?;
        for (place, record) in (0..).zip(container.instances) {
            Instance::from_record(record, place)?;
        }
        Ok(container)
    }

    /// Every byte of the package.
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The header.
    pub const fn header(&self) -> &'a Header {
        self.header
    }

    /// The section table, in the order of the bytes.
    pub const fn entries(&self) -> &'a [SectionEntry] {
        self.entries
    }

    /// All instances, in order of their number.
    pub fn instances(&self) -> impl Iterator<Item = Result<Instance, Finding>> + use<'a> {
        (0..)
            .zip(self.instances)
            .map(|(place, record)| Instance::from_record(record, place))
    }

    /// The table's entry for section `id`, if there is one. Binary search.
    pub fn find(&self, id: SectionId) -> Option<&'a SectionEntry> {
        let place = self
            .entries
            .binary_search_by_key(&id, SectionEntry::id)
            .ok()?;
        self.entries.get(place)
    }

    /// The bytes of the section that `entry`, an entry of this package's table, describes.
    ///
    /// # Errors
    /// [`Fault::SectionOffset`] if the entry does not fit the bytes, which opening has ruled out for own entries.
    pub fn section_bytes(&self, entry: &SectionEntry) -> Result<&'a [u8], Finding> {
        let out_of_bounds = Finding::new(Fault::SectionOffset).within(entry.id());
        let start = usize::try_from(entry.offset.get()).map_err(|_| out_of_bounds)?;
        let length = usize::try_from(entry.length.get()).map_err(|_| out_of_bounds)?;
        let end = start.checked_add(length).ok_or(out_of_bounds)?;
        self.bytes.get(start..end).ok_or(out_of_bounds)
    }

    /// The elements of section `id`, in place.
    ///
    /// # Errors
    /// [`Fault::SectionMissing`] if the package has no such section, [`Fault::SectionSchema`] if its elements are
    /// not of `T`'s size.
    pub fn elements<T>(&self, id: SectionId) -> Result<&'a [T], Finding>
    where
        T: FromBytes + Immutable + KnownLayout + Unaligned,
    {
        let entry = self
            .find(id)
            .ok_or(Finding::new(Fault::SectionMissing).within(id))?;
        let size = u64::from(entry.element_size.get());
        if size != size_of::<T>() as u64 {
            return Err(Finding::new(Fault::SectionSchema)
                .within(id)
                .values(size_of::<T>() as u64, size));
        }
        let bytes = self.section_bytes(entry)?;
        <[T]>::ref_from_bytes(bytes).map_err(|_| Finding::new(Fault::SectionLength).within(id))
    }

    fn check_entries(&self) -> Result<(), Finding> {
        let mut end = (HEADER_LENGTH as u64).saturating_add(size_of_val(self.entries) as u64);
        let mut previous: Option<SectionId> = None;
        for entry in self.entries {
            let id = entry.id();
            let finding = |fault| Finding::new(fault).within(id);
            if previous.is_some_and(|previous| previous >= id) {
                return Err(finding(Fault::TableOrder));
            }
            previous = Some(id);
            if entry.flags.get() & !FLAG_CRITICAL != 0 || entry.reserved != [0; 12] {
                return Err(finding(Fault::ReservedNotZero));
            }
            let size = entry.element_size.get();
            match records::element_sizes(entry.kind) {
                Some(sizes) if !sizes.contains(&size) || entry.schema.get() != records::SCHEMA => {
                    return Err(finding(Fault::SectionSchema));
                }
                None if entry.is_critical() => return Err(finding(Fault::UnknownSection)),
                _ => {}
            }
            let length = entry.length.get();
            if u64::from(size).checked_mul(entry.count.get()) != Some(length) {
                return Err(finding(Fault::SectionLength));
            }
            let offset = entry.offset.get();
            let expected = end
                .checked_next_multiple_of(ALIGNMENT)
                .ok_or(finding(Fault::SectionOffset))?;
            if offset != expected {
                return Err(finding(Fault::SectionOffset).values(expected, offset));
            }
            end = offset
                .checked_add(length)
                .ok_or(finding(Fault::SectionOffset))?;
        }
        let file_length = self.bytes.len() as u64;
        if end != file_length {
            return Err(Finding::new(Fault::SectionEnd).values(file_length, end));
        }
        Ok(())
    }
}

fn read_header(bytes: &[u8]) -> Result<&Header, Finding> {
    let length = bytes.len() as u64;
    // A short file that begins like something else is better called something else.
    let begin = bytes.get(..MAGIC.len().min(bytes.len())).unwrap_or(bytes);
    if !MAGIC.starts_with(begin) {
        return Err(Finding::new(Fault::NotAPackage));
    }
    let (header, _) = Header::ref_from_prefix(bytes)
        .map_err(|_| Finding::new(Fault::TooShort).values(HEADER_LENGTH as u64, length))?;
    // The version comes before the checksum: another version may compute it in another way.
    if header.major.get() != MAJOR {
        return Err(Finding::new(Fault::UnsupportedVersion)
            .values(u64::from(MAJOR), u64::from(header.major.get())));
    }
    if header.computed_crc() != header.header_crc.get() {
        return Err(Finding::new(Fault::HeaderChecksum));
    }
    if header.file_length.get() != length {
        return Err(Finding::new(Fault::FileLength).values(header.file_length.get(), length));
    }
    for (expected, got) in [
        (HEADER_LENGTH as u64, u64::from(header.header_length.get())),
        (HEADER_LENGTH as u64, header.table_offset.get()),
        (0, u64::from_le_bytes(header.reserved)),
    ] {
        if expected != got {
            return Err(Finding::new(Fault::HeaderField).values(expected, got));
        }
    }
    let sections = header.section_count.get();
    if sections > MAX_SECTIONS {
        return Err(
            Finding::new(Fault::HeaderField).values(u64::from(MAX_SECTIONS), u64::from(sections))
        );
    }
    if header.must_understand.get() != 0 {
        return Err(
            Finding::new(Fault::UnknownFeature).values(0, u64::from(header.must_understand.get()))
        );
    }
    Ok(header)
}

fn read_table<'a>(bytes: &'a [u8], header: &Header) -> Result<&'a [SectionEntry], Finding> {
    let out_of_bounds = Finding::new(Fault::TableBounds);
    let count = usize::try_from(header.section_count.get()).map_err(|_| out_of_bounds)?;
    let end = count
        .checked_mul(ENTRY_LENGTH)
        .and_then(|length| length.checked_add(HEADER_LENGTH))
        .ok_or(out_of_bounds)?;
    let table = bytes.get(HEADER_LENGTH..end).ok_or(out_of_bounds)?;
    let crc = crc32fast::hash(table);
    if crc != header.table_crc.get() {
        return Err(Finding::new(Fault::TableChecksum)
            .values(u64::from(header.table_crc.get()), u64::from(crc)));
    }
    <[SectionEntry]>::ref_from_bytes(table).map_err(|_| out_of_bounds)
}
