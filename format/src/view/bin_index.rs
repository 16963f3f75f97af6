//! The index: from a bin to its key, and back.

use super::bin_tables::{bins, elements};
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::records::{IndexKind, Instance, OCCUPIED_BINS};
use core::ops::Range;
use zerocopy::little_endian::U32;

/// Which bin each key stands for.
#[derive(Clone, Copy, Debug)]
pub struct BinIndex<'a> {
    bin_count: u32,
    /// The bins of a sparse index.
    occupied: Option<&'a [U32]>,
}

impl<'a> BinIndex<'a> {
    /// The index of `instance`.
    ///
    /// # Errors
    /// If the instance has no bins, a section is missing, or it has another count than the keys of `instance` need.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let bins = bins(instance)?;
        let keys = bins.key_count as usize;
        Ok(Self {
            bin_count: bins.grid.count(),
            occupied: match bins.index {
                IndexKind::Dense => None,
                IndexKind::Sparse => Some(elements(container, instance, OCCUPIED_BINS, keys)?),
            },
        })
    }

    /// The bins of a sparse index by key, rising; empty for a dense index, whose keys are bin numbers.
    pub fn occupied(&self) -> &'a [U32] {
        self.occupied.unwrap_or_default()
    }

    /// The number of the bin that `key` stands for.
    ///
    /// # Errors
    /// [`Fault::KeyRange`] if there is no such key, or its bin is beyond the grid.
    #[inline]
    pub fn bin_of_key(&self, key: u32) -> Result<u32, Finding> {
        let bin = match self.occupied {
            None => Some(key),
            Some(occupied) => occupied.get(key as usize).map(|bin| bin.get()),
        };
        bin.filter(|&bin| bin < self.bin_count)
            .ok_or(Finding::new(Fault::KeyRange).at(u64::from(key)))
    }

    /// The keys of the bins numbered in `bins`; those without a texel may be left out. O(1) for a dense index, else a
    /// binary search.
    pub fn keys(&self, bins: Range<u32>) -> Range<u32> {
        let Some(occupied) = self.occupied else {
            return bins;
        };
        let start = occupied.partition_point(|bin| bin.get() < bins.start);
        // A run is a few bins of one row: walk instead of searching again.
        let width = bins.end.saturating_sub(bins.start) as usize;
        let run = occupied.get(start..).unwrap_or_default();
        let length = run
            .iter()
            .take(width)
            .take_while(|bin| bin.get() < bins.end)
            .count();
        // A section has fewer than 2³² keys.
        start as u32..start.saturating_add(length) as u32
    }
}
