//! All sections that weigh bins, opened together.

use super::{BinIndex, BinMap, BlockLists, InverseBinMap};
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::records::{Bins, INSTANCES, Instance, InverseKind};
use crate::section::{FourCc, SectionId};
use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

/// How an instance finds the texels of a bin.
#[derive(Clone, Copy, Debug)]
pub enum Inverse<'a> {
    /// By their positions, with a forest over them.
    Forest(InverseBinMap<'a>),
    /// By the blocks that hold them.
    Tiles(BlockLists<'a>),
    /// Not at all.
    None,
}

/// Bin map, index, and what finds the texels of a bin, of one instance.
#[derive(Clone, Copy, Debug)]
pub struct BinTables<'a> {
    /// What the tables were baked for.
    pub instance: Instance,
    /// The instance's bins.
    pub bins: Bins,
    /// From texel to key.
    pub bin_map: BinMap<'a>,
    /// From key to bin.
    pub index: BinIndex<'a>,
    /// From key to texels.
    pub inverse: Inverse<'a>,
}

impl<'a> BinTables<'a> {
    /// The tables of `instance`. O(1): element counts are checked, elements are not read.
    ///
    /// # Errors
    /// If the instance has no bins, a section is missing, or its count does not fit the map.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let bins = bins(instance)?;
        Ok(Self {
            instance: *instance,
            bins,
            bin_map: BinMap::open(container, instance)?,
            index: BinIndex::open(container, instance)?,
            inverse: match bins.inverse {
                InverseKind::Forest => Inverse::Forest(InverseBinMap::open(container, instance)?),
                InverseKind::Tiles => Inverse::Tiles(BlockLists::open(container, instance)?),
                InverseKind::None => Inverse::None,
            },
        })
    }

    /// The number of the bin of texel (`column`, `row`).
    ///
    /// # Errors
    /// If there is no such texel, or its key names no bin.
    pub fn bin_of_texel(&self, column: u32, row: u32) -> Result<u32, Finding> {
        let key = self
            .bin_map
            .key(column, row)
            .ok_or_else(|| Finding::new(Fault::PositionRange).within(self.bin_map.id))?;
        self.index.bin_of_key(key)
    }
}

/// The bins of `instance`, which a caller that knows its method has asked for.
pub(super) fn bins(instance: &Instance) -> Result<Bins, Finding> {
    instance
        .bins()
        .ok_or(Finding::new(Fault::InstanceField).within(SectionId::shared(INSTANCES)))
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
