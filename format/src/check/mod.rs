//! Verifying a package beyond what opening promises.
//!
//! Opening is O(1) in the data. [`structure`] reads every element and reports what queries would trip over or
//! answer wrongly; [`full`] adds checksums and hashes, so that every flipped bit of the file is found. Results that
//! are *right* need this; results that are *safe* (no panic, bounded time) never do.

mod bins;
mod block_lists;
mod box_pyramid;
mod clusters;
mod inverse_bin_map;
mod lobes;
mod masking;
mod material;
mod mip_lobes;
mod ndf_maps;
mod pyramid;
mod surface;

use crate::Container;
use crate::finding::{Fault, Finding};
use crate::records::{METADATA, Structure};
use crate::section::SectionId;
use crate::version::MAX_METADATA;

/// Reports every structural fault of `container` to `report`, at most [`MAX_FINDINGS_PER_SECTION`] a section and
/// kind of fault. O(elements), no allocation.
pub fn structure(container: &Container<'_>, report: &mut dyn FnMut(Finding)) {
    padding(container, report);
    metadata(container, report);
    material::check(container, report);
    for instance in container.instances() {
        match instance {
            Ok(instance) => {
                match instance.structure {
                    Structure::Bins(_) => bins::check(container, &instance, report),
                    Structure::Pyramid { .. } => pyramid::check(container, &instance, report),
                    Structure::Clusters { .. } => clusters::check(container, &instance, report),
                    Structure::Lobes(_) => lobes::check(container, &instance, report),
                    Structure::MipLobes(_) => mip_lobes::check(container, &instance, report),
                    Structure::NdfMaps(_) => ndf_maps::check(container, &instance, report),
                    Structure::Surface { .. } => {
                        box_pyramid::check(container, &instance, report);
                        surface::check(container, &instance, report);
                    }
                }
                masking::check(container, &instance, report);
            }
            Err(finding) => report(finding),
        }
    }
}

/// Reports checksum faults of each section of `container`, then its [`structure`]; with the `content-hash` feature
/// also whether the BLAKE3 hash of the content matches. O(bytes), no allocation.
pub fn full(container: &Container<'_>, report: &mut dyn FnMut(Finding)) {
    checksums(container, report);
    #[cfg(feature = "content-hash")]
    if content_hash(container) != container.header().content_hash {
        report(Finding::new(Fault::ContentHash));
    }
    structure(container, report);
}

/// Reports each section of `container` whose bytes do not match its CRC-32. O(bytes).
pub fn checksums(container: &Container<'_>, report: &mut dyn FnMut(Finding)) {
    for entry in container.entries() {
        match container.section_bytes(entry) {
            Ok(bytes) => {
                let crc = crc32fast::hash(bytes);
                if crc != entry.crc.get() {
                    report(
                        Finding::new(Fault::SectionChecksum)
                            .within(entry.id())
                            .values(u64::from(entry.crc.get()), u64::from(crc)),
                    );
                }
            }
            Err(finding) => report(finding),
        }
    }
}

/// The BLAKE3 hash of every byte after the header, which the header should carry.
#[cfg(feature = "content-hash")]
pub fn content_hash(container: &Container<'_>) -> [u8; 32] {
    let content = container
        .bytes()
        .get(crate::HEADER_LENGTH..)
        .unwrap_or_default();
    *blake3::hash(content).as_bytes()
}

/// How often one fault is reported for one section before the rest is only worth a re-bake.
pub const MAX_FINDINGS_PER_SECTION: u32 = 8;

/// Passes on the first few findings of one kind.
struct Limited<'r> {
    report: &'r mut dyn FnMut(Finding),
    left: u32,
}

impl<'r> Limited<'r> {
    fn new(report: &'r mut dyn FnMut(Finding)) -> Self {
        Self {
            report,
            left: MAX_FINDINGS_PER_SECTION,
        }
    }

    fn report(&mut self, finding: Finding) {
        if self.left > 0 {
            self.left = self.left.saturating_sub(1);
            (self.report)(finding);
        }
    }
}

fn padding(container: &Container<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let bytes = container.bytes();
    let table = size_of_val(container.entries());
    let mut end = crate::HEADER_LENGTH.saturating_add(table);
    for entry in container.entries() {
        // Opening has checked that offsets rise and fit the file, so they fit usize.
        let start = entry.offset.get() as usize;
        for (place, &byte) in (end..).zip(bytes.get(end..start).unwrap_or_default()) {
            if byte != 0 {
                limited.report(Finding::new(Fault::PaddingNotZero).at(place as u64));
            }
        }
        end = start.saturating_add(entry.length.get() as usize);
    }
}

fn metadata(container: &Container<'_>, report: &mut dyn FnMut(Finding)) {
    let id = SectionId::shared(METADATA);
    match container.elements::<u8>(id) {
        Ok(bytes) => {
            if bytes.len() as u64 > MAX_METADATA || core::str::from_utf8(bytes).is_err() {
                report(Finding::new(Fault::Metadata).within(id));
            }
        }
        Err(finding) => report(finding),
    }
}
