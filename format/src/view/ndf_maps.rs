//! NDF maps: the example, the images of its tiles, and its copies.

use super::bin_tables::{elements, expect_count};
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::NdfMapLayout;
use crate::records::{
    Instance, NDF_COPIES, NDF_GRID, NDF_IMAGES, NDF_NEIGHBOURS, NDF_PIXELS, NDF_ROOT, NORMALS,
    NdfCopy, NdfImage, NdfMapRoot, Structure, SurfaceNormal,
};
use crate::section::SectionId;
use zerocopy::little_endian::{U16, U32};

/// The most neighbours a copy has.
pub const MAX_NEIGHBOURS: usize = 64;

/// The farthest that a tiled copy reaches, in texels.
const FARTHEST: f64 = 1e7;

/// The most cells along a side of a grid.
const MAX_CELLS: u32 = 4096;

/// The NDF maps of one surface.
#[derive(Clone, Copy, Debug)]
pub struct NdfMaps<'a> {
    /// What they are.
    pub layout: NdfMapLayout,
    /// The section of images.
    pub id: SectionId,
    /// What images and copies have in common.
    pub root: &'a NdfMapRoot,
    /// Normals of the example, row by row.
    pub normals: &'a [SurfaceNormal],
    /// The images.
    pub images: &'a [NdfImage],
    /// Their pixels.
    pub pixels: &'a [U16],
    /// Copies of the example; one if they are not scattered.
    pub copies: &'a [NdfCopy],
    /// Neighbours of copies, by their numbers.
    pub neighbours: &'a [U32],
    /// Where each cell of the grid has its first copy, and the number of copies; empty if copies are not scattered.
    pub grid: &'a [U32],
}

/// A copy of the example, in texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Copied {
    /// Its centre on the surface, less than the surface's side.
    pub centre: [f64; 2],
    /// The rows of M: the texel at `u` of an example of n texels a side lies at `centre + M (u - n/2)`.
    pub matrix: [[f64; 2]; 2],
}

impl<'a> NdfMaps<'a> {
    /// Those stored with `instance`. O(1).
    ///
    /// # Errors
    /// If one of its sections is missing, or has not as many elements as others say.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let id = instance.section(NDF_IMAGES);
        let Structure::NdfMaps(layout) = instance.structure else {
            return Err(Finding::new(Fault::SectionMissing).within(id));
        };
        let root_id = instance.section(NDF_ROOT);
        let roots: &[NdfMapRoot] = elements(container, instance, NDF_ROOT, 1)?;
        let root = roots
            .first()
            .ok_or(Finding::new(Fault::SectionMissing).within(root_id))?;
        let side = layout.example() as usize;
        // Queries rely on these alone.
        let farthest = if layout.is_scattered {
            0.25 * f64::from(layout.size)
        } else {
            FARTHEST
        };
        if !root.is_sound(farthest) {
            return Err(Finding::new(Fault::NdfRoot).within(root_id));
        }
        let cells = root.cells.get();
        if cells > MAX_CELLS || (cells > 0) != layout.is_scattered {
            return Err(Finding::new(Fault::NdfRoot)
                .within(root_id)
                .values(u64::from(MAX_CELLS), u64::from(cells)));
        }
        let mut maps = Self {
            layout,
            id,
            root,
            normals: elements(container, instance, NORMALS, side.wrapping_mul(side))?,
            images: elements(container, instance, NDF_IMAGES, layout.images())?,
            pixels: container.elements(instance.section(NDF_PIXELS))?,
            copies: container.elements(instance.section(NDF_COPIES))?,
            neighbours: &[],
            grid: &[],
        };
        if layout.is_scattered {
            let cells = (cells as usize).wrapping_mul(cells as usize);
            maps.grid = elements(container, instance, NDF_GRID, cells.wrapping_add(1))?;
            let neighbours = instance.section(NDF_NEIGHBOURS);
            if container.find(neighbours).is_some() {
                maps.neighbours = container.elements(neighbours)?;
            }
        } else {
            expect_count(instance.section(NDF_COPIES), 1, maps.copies.len())?;
        }
        Ok(maps)
    }

    /// The normal of texel (`x`, `y`) of the example; `None` where the package is damaged.
    #[inline(always)]
    pub fn normal(&self, x: u32, y: u32) -> Option<[f64; 2]> {
        let place = (y as usize)
            .wrapping_mul(self.layout.example() as usize)
            .wrapping_add(x as usize);
        self.normals.get(place).map(|normal| normal.point())
    }

    /// Copy `number`; `None` where the package is damaged.
    #[inline(always)]
    pub fn copied(&self, number: usize) -> Option<Copied> {
        let copy = self.copies.get(number)?;
        let unit = self.root.unit.get();
        let place = f64::from(self.layout.size) / 4_294_967_296.0;
        let [xx, xy, yx, yy] = copy.matrix.map(|entry| f64::from(entry.get()) * unit);
        Some(Copied {
            centre: copy.centre.map(|along| f64::from(along.get()) * place),
            matrix: [[xx, xy], [yx, yy]],
        })
    }

    /// The neighbours of copy `number`, at most [`MAX_NEIGHBOURS`]; none where the package is damaged.
    #[inline(always)]
    pub fn neighbours_of(&self, number: usize) -> &'a [U32] {
        let start = |number: usize| {
            self.copies
                .get(number)
                .map_or(self.neighbours.len(), |copy| copy.neighbours.get() as usize)
        };
        let (first, end) = (start(number), start(number.wrapping_add(1)));
        let end = end.min(first.wrapping_add(MAX_NEIGHBOURS));
        self.neighbours.get(first..end).unwrap_or_default()
    }

    /// The numbers of the copies whose centres are in the cell of `column` and `row`, both less than the grid's; none where the
    /// package is damaged.
    #[inline(always)]
    pub fn copies_in(&self, column: u32, row: u32) -> core::ops::Range<usize> {
        let cell = (row as usize)
            .wrapping_mul(self.root.cells.get() as usize)
            .wrapping_add(column as usize);
        let start = |cell: usize| self.grid.get(cell).map_or(0, |start| start.get() as usize);
        let end = start(cell.wrapping_add(1)).min(self.copies.len());
        start(cell)..end
    }
}
