//! Laying sections out and writing them as one package.

use crate::progress::{Progress, Stage};
use glintbake_format::records::SCHEMA;
use glintbake_format::version::ALIGNMENT;
use glintbake_format::{
    ENTRY_LENGTH, FLAG_CRITICAL, HEADER_LENGTH, Header, SectionEntry, SectionId,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io::{self, Seek, SeekFrom, Write};
use zerocopy::little_endian::{U16, U32, U64};
use zerocopy::{Immutable, IntoBytes};

/// The elements of a section, seen as bytes where they lie.
trait Elements: Send + Sync {
    fn bytes(&self) -> &[u8];
}

impl<T: IntoBytes + Immutable + Send + Sync> Elements for Vec<T> {
    fn bytes(&self) -> &[u8] {
        self.as_slice().as_bytes()
    }
}

/// Bytes hashed, and then written, at once: the hash finds them in memory, and the write may still in the cache.
const PIECE: usize = 1 << 20;

struct Section {
    critical: bool,
    element_size: usize,
    elements: Box<dyn Elements>,
}

/// The sections of a package to be, in the order they will have in the file.
pub struct PackagePlan {
    recipe_hash: [u8; 32],
    sections: BTreeMap<SectionId, Section>,
}

impl PackagePlan {
    /// A plan without sections, whose header will carry `recipe_hash`.
    pub fn new(recipe_hash: [u8; 32]) -> Self {
        Self {
            recipe_hash,
            sections: BTreeMap::new(),
        }
    }

    /// Adds a section of `elements` that a reader may skip if it does not know the kind.
    ///
    /// # Panics
    /// If the plan has a section of this name already.
    pub fn add<T>(&mut self, id: SectionId, elements: Vec<T>)
    where
        T: IntoBytes + Immutable + Send + Sync + 'static,
    {
        self.insert(id, false, elements);
    }

    /// Adds a section of `elements` that a reader must understand.
    ///
    /// # Panics
    /// If the plan has a section of this name already.
    pub fn add_critical<T>(&mut self, id: SectionId, elements: Vec<T>)
    where
        T: IntoBytes + Immutable + Send + Sync + 'static,
    {
        self.insert(id, true, elements);
    }

    /// Whether the plan has a section called `id`.
    pub fn holds(&self, id: SectionId) -> bool {
        self.sections.contains_key(&id)
    }

    fn insert<T>(&mut self, id: SectionId, critical: bool, elements: Vec<T>)
    where
        T: IntoBytes + Immutable + Send + Sync + 'static,
    {
        let section = Section {
            critical,
            element_size: size_of::<T>(),
            elements: Box::new(elements),
        };
        let previous = self.sections.insert(id, section);
        assert!(previous.is_none(), "section {id} is planned twice");
    }

    /// The whole package in memory; for tests, previews and small packages.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = io::Cursor::new(Vec::new());
        self.write(&mut bytes)
            .expect("writing to memory does not fail");
        bytes.into_inner()
    }

    /// Writes the package to `output`, which must be at its start and empty; returns the package's length in bytes.
    ///
    /// The content is hashed while it is written; the header, which holds the hash, is written last.
    ///
    /// # Errors
    /// Whatever `output` fails with.
    pub fn write<W: Write + Seek>(&self, output: &mut W) -> io::Result<u64> {
        self.write_with_progress(output, &())
    }

    /// [`write`](Self::write), telling `progress` how many bytes are written.
    ///
    /// # Errors
    /// Whatever `output` fails with.
    pub fn write_with_progress<W: Write + Seek>(
        &self,
        output: &mut W,
        progress: &dyn Progress,
    ) -> io::Result<u64> {
        progress.report(Stage::Write, 0, self.content_length());
        let table = self.table();
        let table_bytes = table.as_slice().as_bytes();
        let mut content = HashingWriter {
            output,
            hasher: blake3::Hasher::new(),
            position: 0,
        };
        // The header's place: neither hashed nor known yet.
        content.output.write_all(&[0; HEADER_LENGTH])?;
        content.position = HEADER_LENGTH as u64;
        content.write(table_bytes)?;
        let mut written = 0;
        for (entry, section) in table.iter().zip(self.sections.values()) {
            let gap = entry.offset.get() - content.position;
            content.write(&[0; ALIGNMENT as usize][..gap as usize])?;
            for piece in section.elements.bytes().chunks(PIECE) {
                content.write(piece)?;
                written += piece.len() as u64;
                progress.report(Stage::Write, written, self.content_length());
            }
        }
        let header = Header::new(
            content.position,
            table.len() as u32,
            self.recipe_hash,
            *content.hasher.finalize().as_bytes(),
            crc32fast::hash(table_bytes),
        );
        let length = content.position;
        output.seek(SeekFrom::Start(0))?;
        output.write_all(header.as_bytes())?;
        output.flush()?;
        Ok(length)
    }

    /// Bytes of all sections, without the header, the table and padding.
    fn content_length(&self) -> u64 {
        let lengths = self.sections.values();
        lengths
            .map(|section| section.elements.bytes().len() as u64)
            .sum()
    }

    fn table(&self) -> Vec<SectionEntry> {
        let sections: Vec<_> = self.sections.iter().collect();
        let checksums: Vec<u32> = sections
            .par_iter()
            .map(|(_, section)| crc32fast::hash(section.elements.bytes()))
            .collect();
        let mut end = (HEADER_LENGTH + ENTRY_LENGTH * sections.len()) as u64;
        sections
            .into_iter()
            .zip(checksums)
            .map(|((id, section), crc)| {
                let length = section.elements.bytes().len();
                let offset = end.next_multiple_of(ALIGNMENT);
                end = offset + length as u64;
                SectionEntry {
                    kind: id.kind,
                    layer: U16::new(id.layer),
                    instance: U16::new(id.instance),
                    ordinal: U32::new(id.ordinal),
                    flags: U32::new(if section.critical { FLAG_CRITICAL } else { 0 }),
                    element_size: U32::new(section.element_size as u32),
                    schema: U32::new(SCHEMA),
                    offset: U64::new(offset),
                    length: U64::new(length as u64),
                    count: U64::new((length / section.element_size) as u64),
                    crc: U32::new(crc),
                    reserved: [0; 12],
                }
            })
            .collect()
    }
}

struct HashingWriter<'w, W> {
    output: &'w mut W,
    hasher: blake3::Hasher,
    position: u64,
}

impl<W: Write> HashingWriter<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.hasher.update(bytes);
        self.output.write_all(bytes)?;
        self.position += bytes.len() as u64;
        Ok(())
    }
}
