//! All sections that weigh bins, opened together.

use super::{BinIndex, BinMap};
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::ForestShape;
use crate::records::{BIN_MAP, FOREST, ForestNode, INVERSE_BIN_MAP, Instance, TexelPosition};
use crate::section::{FourCc, SectionId};
use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

/// Bin map, index, inverse bin map and forest of one instance.
#[derive(Clone, Copy, Debug)]
pub struct BinTables<'a> {
    /// What the tables were baked for.
    pub instance: Instance,
    /// From texel to key.
    pub bin_map: BinMap<'a>,
    /// From key to list and bin.
    pub index: BinIndex<'a>,
    /// The inverse bin map: all texels, list after list.
    pub positions: &'a [TexelPosition],
    /// Absent if no list is longer than a leaf.
    pub forest: Option<&'a [ForestNode]>,
}

impl<'a> BinTables<'a> {
    /// The tables of `instance`. O(1): element counts are checked, elements are not read.
    ///
    /// # Errors
    /// If a section is missing or its count does not fit the map.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let texels = instance.texel_count() as usize;
        let slots = ForestShape::slot_count(instance.texel_count(), instance.leaf_size);
        Ok(Self {
            instance: *instance,
            bin_map: BinMap::open(container, instance)?,
            index: BinIndex::open(container, instance)?,
            positions: elements(container, instance, INVERSE_BIN_MAP, texels)?,
            forest: match container.find(instance.section(FOREST)) {
                Some(_) => Some(elements(container, instance, FOREST, slots as usize)?),
                None => None,
            },
        })
    }

    /// The number of the texel at (`column`, `row`), row-major.
    pub fn texel(&self, column: u32, row: u32) -> usize {
        (row as usize)
            .wrapping_mul(self.instance.width as usize)
            .wrapping_add(column as usize)
    }

    /// The number of the bin of texel number `texel`.
    ///
    /// # Errors
    /// If there is no such texel, or its key names no bin.
    pub fn bin_of_texel(&self, texel: usize) -> Result<u32, Finding> {
        let key = self.bin_map.key(texel).ok_or_else(|| {
            Finding::new(Fault::PositionRange)
                .within(self.instance.section(BIN_MAP))
                .at(texel as u64)
        })?;
        self.index.bin_of_key(key)
    }
}

/// The `count` elements of the section of `kind` that belongs to `instance`.
pub(super) fn elements<'a, T>(
    container: &Container<'a>,
    instance: &Instance,
    kind: FourCc,
    count: usize,
) -> Result<&'a [T], Finding>
where
    T: FromBytes + Immutable + KnownLayout + Unaligned,
{
    let id = instance.section(kind);
    let elements: &[T] = container.elements(id)?;
    expect_count(id, count, elements.len())?;
    Ok(elements)
}

pub(super) fn expect_count(id: SectionId, expected: usize, got: usize) -> Result<(), Finding> {
    if expected == got {
        Ok(())
    } else {
        Err(Finding::new(Fault::SectionCount)
            .within(id)
            .values(expected as u64, got as u64))
    }
}
