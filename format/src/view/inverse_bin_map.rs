//! The inverse bin map: the texels of each key, and the forest over them.

use super::bin_tables::{bins, elements};
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::ForestShape;
use crate::records::{FOREST, ForestNode, INDEX, INVERSE_BIN_MAP, Instance, TexelPosition};
use crate::section::SectionId;
use core::ops::Range;
use zerocopy::little_endian::U32;

/// Inverse bin map and forest of one instance, \[AWKK21\] §5.4.
#[derive(Clone, Copy, Debug)]
pub struct InverseBinMap<'a> {
    id: SectionId,
    offsets: &'a [U32],
    /// All texels, list after list.
    pub positions: &'a [TexelPosition],
    /// Absent if no list is longer than a leaf.
    pub forest: Option<&'a [ForestNode]>,
}

impl<'a> InverseBinMap<'a> {
    /// The inverse bin map of `instance`. O(1).
    ///
    /// # Errors
    /// If a section is missing or its count does not fit the map.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let texels = instance.texel_count() as usize;
        let bins = bins(instance)?;
        let keys = bins.key_count as usize;
        let slots = ForestShape::slot_count(instance.texel_count(), bins.leaf_size);
        Ok(Self {
            id: instance.section(INDEX),
            offsets: elements(container, instance, INDEX, keys.saturating_add(1))?,
            positions: elements(container, instance, INVERSE_BIN_MAP, texels)?,
            forest: match container.find(instance.section(FOREST)) {
                Some(_) => Some(elements(container, instance, FOREST, slots as usize)?),
                None => None,
            },
        })
    }

    /// The places of `key`'s texels among [`positions`](Self::positions), within bounds.
    ///
    /// # Errors
    /// [`Fault::IndexOrder`] if there is no such key, or its offsets contradict each other.
    #[inline]
    pub fn list(&self, key: u32) -> Result<Range<u32>, Finding> {
        let place = key as usize;
        match self.offsets.get(place..place.saturating_add(2)) {
            Some([start, end])
                if start.get() <= end.get() && end.get() as usize <= self.positions.len() =>
            {
                Ok(start.get()..end.get())
            }
            _ => Err(Finding::new(Fault::IndexOrder)
                .within(self.id)
                .at(u64::from(key))),
        }
    }
}
