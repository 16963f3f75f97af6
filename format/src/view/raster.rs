//! Rasters of normals: every texel's own.

use super::bin_tables::elements;
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::records::{
    HALF_RASTER, Instance, RASTER, RASTER_SIDE, RasterBlock, RasterLattice, unpack_raster,
};
use crate::section::SectionId;

/// The raster of one map.
#[derive(Clone, Copy, Debug)]
pub struct Raster<'a> {
    /// The section.
    pub id: SectionId,
    /// What its numbers stand for.
    pub lattice: RasterLattice,
    /// The map's columns and rows.
    pub size: [u32; 2],
    /// Blocks in a row.
    pub columns: u32,
    /// Blocks row by row; texels of theirs that lie beyond the map are zero and mean nothing.
    pub blocks: &'a [RasterBlock],
}

impl<'a> Raster<'a> {
    /// The raster stored with `instance` itself, or `None` if it stores none. O(1).
    ///
    /// # Errors
    /// If it has not as many blocks as the map.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        let kinds = [
            (RASTER, RasterLattice::Whole),
            (HALF_RASTER, RasterLattice::Half),
        ];
        for (kind, lattice) in kinds {
            let id = instance.section(kind);
            if container.find(id).is_none() {
                continue;
            }
            let columns = instance.width.div_ceil(RASTER_SIDE);
            let rows = instance.height.div_ceil(RASTER_SIDE);
            let count = usize::try_from(u64::from(columns) * u64::from(rows))
                .map_err(|_| Finding::new(Fault::SectionCount).within(id))?;
            return Ok(Some(Self {
                id,
                lattice,
                size: [instance.width, instance.height],
                columns,
                blocks: elements(container, instance, kind, count)?,
            }));
        }
        Ok(None)
    }

    /// The raster of the map that `instance` was baked from: its own, or that of the first other instance of the same map and
    /// method that stores one, or `None`. O(instances).
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        super::of_map(container, instance, Self::open)
    }

    /// The place in [`blocks`](Self::blocks) of the block in `column` and `row` of blocks.
    #[inline(always)]
    pub fn place(&self, column: u32, row: u32) -> usize {
        (row as usize)
            .wrapping_mul(self.columns as usize)
            .wrapping_add(column as usize)
    }

    /// The two numbers of the texel in `column` and `row`, if there is one.
    #[inline]
    pub fn numbers(&self, column: u32, row: u32) -> Option<[i16; 2]> {
        let place = self.place(column / RASTER_SIDE, row / RASTER_SIDE);
        let within = RASTER_SIDE * (row % RASTER_SIDE) + column % RASTER_SIDE;
        let word = self.blocks.get(place)?.0.get(within as usize)?;
        Some(unpack_raster(word.get()))
    }

    /// The point (s, t) of the normal of the texel in `column` and `row`: that of the map within half a step of either. O(1).
    ///
    /// # Errors
    /// If there is no such texel.
    #[inline]
    pub fn normal(&self, column: u32, row: u32) -> Result<[f64; 2], Finding> {
        let numbers = self
            .numbers(column, row)
            .ok_or(Finding::new(Fault::SectionCount).within(self.id))?;
        Ok(numbers.map(|n| self.lattice.component(n)))
    }
}
