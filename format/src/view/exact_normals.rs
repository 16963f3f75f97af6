//! Exact normals: each texel's own normal, by its place within its bin.

use super::bin_tables::{bins, elements};
use super::{BinIndex, BinMap};
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::{BinGrid, HalfVector};
use crate::records::{EXACT_NORMALS, ExactNormal, Instance};
use crate::section::SectionId;

/// Exact normals of one instance, and the bins they refine.
#[derive(Clone, Copy, Debug)]
pub struct ExactNormals<'a> {
    id: SectionId,
    width: u32,
    grid: BinGrid,
    bin_map: BinMap<'a>,
    index: BinIndex<'a>,
    normals: &'a [ExactNormal],
}

impl<'a> ExactNormals<'a> {
    /// The exact normals of `instance`, or `None` if they were not asked for.
    ///
    /// # Errors
    /// If they or the bins they refine are not sized for the map.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        let id = instance.section(EXACT_NORMALS);
        if container.find(id).is_none() {
            return Ok(None);
        }
        let texels = instance.texel_count() as usize;
        Ok(Some(Self {
            id,
            width: instance.width,
            grid: bins(instance)?.grid,
            bin_map: BinMap::open(container, instance)?,
            index: BinIndex::open(container, instance)?,
            normals: elements(container, instance, EXACT_NORMALS, texels)?,
        }))
    }

    /// The normal of texel (`column`, `row`).
    ///
    /// # Errors
    /// If there is no such texel, or its key names no bin.
    pub fn normal(&self, column: u32, row: u32) -> Result<HalfVector, Finding> {
        let texel = (row as usize)
            .wrapping_mul(self.width as usize)
            .wrapping_add(column as usize);
        let missing = || {
            Finding::new(Fault::SectionCount)
                .within(self.id)
                .at(texel as u64)
        };
        let key = self.bin_map.key(column, row).ok_or_else(missing)?;
        let (bin_column, bin_row) = self.grid.column_row(self.index.bin_of_key(key)?);
        let [x, y] = self.normals.get(texel).ok_or_else(missing)?.fractions();
        Ok(self.grid.normal_in_bin(bin_column, bin_row, x, y))
    }
}
