//! MIP lobes: the sample, how it is quilted, and the clustered lobes of its cells.

use super::bin_tables::{elements, expect_count};
use super::of_map;
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::{MipLayout, QuiltLayout};
use crate::records::{
    Instance, MIP_BLOCKS, MIP_INDEX, MipBlock, NORMALS, QUILT_CUTS, QUILT_ORIGINS, Structure,
    SurfaceNormal,
};
use crate::section::SectionId;
use zerocopy::little_endian::{U16, U32};

/// What an index of cells says of those that no patch has.
pub const NO_CELL: u32 = u32::MAX;

/// The MIP lobes of one surface.
#[derive(Clone, Copy, Debug)]
pub struct MipLobes<'a> {
    /// What they are.
    pub layout: MipLayout,
    /// The section of blocks.
    pub id: SectionId,
    /// Normals of the sample, row by row.
    pub normals: &'a [SurfaceNormal],
    /// Where the block of each patch begins in the sample; empty without a quilt.
    pub origins: &'a [[U16; 2]],
    /// The cuts of each patch; empty without a quilt.
    pub cuts: &'a [u8],
    /// For each place of cells of the sample, level by level, its number among those stored, or [`NO_CELL`]; empty without a quilt.
    pub index: &'a [U32],
    /// Blocks of lobes: those of cells of the sample, then those of cells of the surface, level by level and row by row.
    pub blocks: &'a [MipBlock],
    /// How many cells of the sample are stored.
    pub sample_cells: usize,
}

impl<'a> MipLobes<'a> {
    /// Those stored with `instance` itself, or `None` if it stores none. O(1).
    ///
    /// # Errors
    /// If one of its sections is missing, or has not as many elements as others say.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        let Structure::MipLobes(layout) = instance.structure else {
            return Ok(None);
        };
        let id = instance.section(MIP_BLOCKS);
        let texels = match layout.quilt {
            None => [instance.width, instance.height],
            Some(quilt) => quilt.sample,
        };
        if container.find(instance.section(NORMALS)).is_none() {
            return Ok(None);
        }
        let count = (texels[0] as usize).wrapping_mul(texels[1] as usize);
        let normals = elements(container, instance, NORMALS, count)?;
        let surface_cells = layout.cells_before(layout.top().wrapping_add(1));
        let blocks: &[MipBlock] = if container.find(id).is_none() {
            &[]
        } else {
            container.elements(id)?
        };
        let of_cell = usize::from(layout.blocks.max(1));
        let cells = blocks.len() / of_cell;
        let Some(sample_cells) = cells.checked_sub(surface_cells) else {
            return Err(Finding::new(Fault::SectionCount)
                .within(id)
                .values(surface_cells as u64, cells as u64));
        };
        expect_count(id, cells.wrapping_mul(of_cell), blocks.len())?;
        let mut lobes = Self {
            layout,
            id,
            normals,
            origins: &[],
            cuts: &[],
            index: &[],
            blocks,
            sample_cells,
        };
        match layout.quilt {
            Some(quilt) => {
                let patches = quilt.count();
                lobes.origins = elements(container, instance, QUILT_ORIGINS, patches)?;
                let cuts = patches.wrapping_mul(quilt.cuts());
                lobes.cuts = elements(container, instance, QUILT_CUTS, cuts)?;
                let places = layout.places_before(quilt.patch_log.wrapping_add(1));
                lobes.index = elements(container, instance, MIP_INDEX, places)?;
            }
            None => expect_count(id, surface_cells, cells)?,
        }
        Ok(Some(lobes))
    }

    /// Those of the surface that `instance` was baked for: its own, or those of the first other instance of the same surface and
    /// structure that stores them. O(instances).
    ///
    /// # Errors
    /// As [`open`](Self::open), and if no instance stores them.
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        of_map(container, instance, Self::open)?
            .ok_or(Finding::new(Fault::SectionMissing).within(instance.section(NORMALS)))
    }

    /// The normal of texel (`x`, `y`) of the surface; `None` where the package is damaged, or the texel beyond the surface.
    #[inline(always)]
    pub fn normal(&self, x: u32, y: u32) -> Option<[f64; 2]> {
        let ([column, row], width) = match &self.layout.quilt {
            None => ([x, y], self.layout.size[0]),
            Some(quilt) => {
                let (patch, within) = quilt.place(x, y);
                (self.texel(quilt, patch, within)?, quilt.sample[0])
            }
        };
        let place = (row as usize)
            .wrapping_mul(width as usize)
            .wrapping_add(column as usize);
        self.normals.get(place).map(|normal| normal.point())
    }

    /// The texel of the sample that stands for the one `within` the patch at `patch`.
    #[inline(always)]
    pub fn texel(
        &self,
        quilt: &QuiltLayout,
        patch: [u32; 2],
        within: [u32; 2],
    ) -> Option<[u32; 2]> {
        let (mut patch, mut within) = (patch, within);
        let overlap = u32::from(quilt.overlap);
        if within[0] < overlap || within[1] < overlap {
            let first = quilt.number(patch).wrapping_mul(quilt.cuts());
            let rows = first.wrapping_add(within[1] as usize);
            let columns = first
                .wrapping_add(quilt.patch() as usize)
                .wrapping_add(within[0] as usize);
            let cuts = [*self.cuts.get(rows)?, *self.cuts.get(columns)?];
            (patch, within) = quilt.supplier(patch, within, cuts);
        }
        let origin = self.origin(quilt, patch)?;
        Some(quilt.texel(origin, within))
    }

    /// Where the block of the patch at `patch` begins in the sample.
    #[inline(always)]
    pub fn origin(&self, quilt: &QuiltLayout, patch: [u32; 2]) -> Option<[u16; 2]> {
        let origin = self.origins.get(quilt.number(patch))?;
        Some(origin.map(U16::get))
    }

    /// The blocks of the cell of the surface in `column` and `row` of `level`; `None` beyond the surface, or where the package is
    /// damaged.
    #[inline(always)]
    pub fn cell(&self, level: u8, column: u32, row: u32) -> Option<&'a [MipBlock]> {
        let number = match &self.layout.quilt {
            Some(quilt) if level <= quilt.patch_log => {
                let shift = quilt.patch_log.wrapping_sub(level) & 31;
                let patch = [column >> shift, row >> shift];
                let mask = (1_u32 << shift).wrapping_sub(1);
                let within = [
                    (column & mask) << (level & 31),
                    (row & mask) << (level & 31),
                ];
                let origin = self.origin(quilt, patch)?;
                let [x, y] = quilt.texel(origin, within);
                self.sample_cell(quilt, level, [x, y])?
            }
            _ => {
                let [columns, rows] = self.layout.cells(level);
                if column >= columns || row >= rows {
                    return None;
                }
                self.sample_cells
                    .wrapping_add(self.layout.cells_before(level))
                    .wrapping_add((row as usize).wrapping_mul(columns as usize))
                    .wrapping_add(column as usize)
            }
        };
        self.blocks_of(number)
    }

    /// The number of the cell of the sample at `level` that begins at texel (`x`, `y`), if it is stored.
    #[inline(always)]
    pub fn sample_cell(&self, quilt: &QuiltLayout, level: u8, [x, y]: [u32; 2]) -> Option<usize> {
        let shift = quilt.grid_log.min(level) & 31;
        let [columns, _] = MipLayout::places(quilt, level);
        let place = self
            .layout
            .places_before(level)
            .wrapping_add(((y >> shift) as usize).wrapping_mul(columns as usize))
            .wrapping_add((x >> shift) as usize);
        let number = self.index.get(place)?.get();
        (number != NO_CELL).then_some(number as usize)
    }

    /// The blocks of cell `number`.
    #[inline(always)]
    pub fn blocks_of(&self, number: usize) -> Option<&'a [MipBlock]> {
        let count = usize::from(self.layout.blocks);
        let first = number.checked_mul(count)?;
        self.blocks.get(first..first.checked_add(count)?)
    }
}
