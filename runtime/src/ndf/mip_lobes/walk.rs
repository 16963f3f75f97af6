//! The lobes of one level within reach of a footprint.

use super::batch::Batch;
use super::sixteen::{Asked, Positions, Source};
use crate::error::QueryError;
use crate::ndf::lobes::placed::{Placed, covariance, cross, span};
use core::ops::Range;
use glintbake_format::model::LobeLattice;
use glintbake_format::view::MipLobes;
use glintbake_format::{Fault, Finding};

/// Standard deviations of position, of footprint and lobes together, that are looked at: beyond lie 4e-5 of all.
const REACH: f64 = 4.0;

/// Variance of positions of lobes of a cell that reach is reckoned with, of the cell's side squared: twice that of a cell all of whose
/// texels are one lobe.
const CELL_VARIANCE: f64 = 1.0 / 12.0;

/// How many tiles wide an axis is that weighs evenly: then a lobe's place in its tile changes its weight by 1e-6 at most.
const EVEN_TILES: f64 = 1e3;

/// Who is shown lobes.
pub(super) trait Visitor {
    /// Sixteen lobes, or fewer, and where their normals come from.
    fn sixteen(&mut self, positions: &Positions, source: &impl Source);
}

/// The lobes of a surface under a footprint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk<'q> {
    pub lobes: &'q MipLobes<'q>,
    pub asked: Asked,
    centre: [f64; 2],
    half_edges: [[f64; 2]; 2],
    even: [bool; 2],
}

impl<'q> Walk<'q> {
    pub fn new(lobes: &'q MipLobes<'q>, placed: &Placed, normal: [f64; 2], sigma: f64) -> Self {
        let [width, height] = placed.size;
        let [xx, yy, _] = covariance(placed.half_edges);
        let (x, y) = (EVEN_TILES * width, EVEN_TILES * height);
        // What weighs evenly along an axis does so whatever the place along the other.
        let half_edges = match placed.even {
            [true, true] => [[x, 0.0], [0.0, y]],
            [true, false] => [[x, 0.0], [0.0, libm::sqrt(yy)]],
            [false, true] => [[libm::sqrt(xx), 0.0], [0.0, y]],
            [false, false] => placed.half_edges,
        };
        Self {
            lobes,
            asked: Asked {
                half_edges: half_edges.map(|edge| edge.map(|x| x as f32)),
                normal,
                scale: 1.0 / sigma,
            },
            centre: placed.centre,
            half_edges,
            even: placed.even,
        }
    }

    /// Shows `visitor` every lobe of `level` within reach, in all copies of the surface; of the lobes themselves for `None`.
    ///
    /// # Errors
    /// [`QueryError::Damaged`].
    #[inline(always)]
    pub fn level<V: Visitor>(&self, level: Option<u8>, visitor: &mut V) -> Result<(), QueryError> {
        let layout = &self.lobes.layout;
        let variance = match level {
            None => square(LobeLattice::DEVIATION / f64::from(layout.per_side.max(1))),
            Some(level) => CELL_VARIANCE * square(f64::from(1_u32 << (level & 31))),
        };
        let reach = Reach::new(self.half_edges, variance);
        let [width, height] = layout.size.map(f64::from);
        let [_, y] = self.centre;
        let rows = copies(y, reach.down(), height, self.even[1]);
        for copy_row in rows {
            let below = copy_row as f64 * height;
            let slab = [below - y, below + height - y];
            let columns = if self.even[0] {
                0..1
            } else {
                let [low, high] = reach.columns(slab);
                span(self.centre[0] + low, self.centre[0] + high, width)
            };
            for copy_column in columns {
                let centre = [
                    self.centre[0] - copy_column as f64 * width,
                    self.centre[1] - below,
                ];
                match level {
                    None => {
                        let all = layout.size.map(|side| 0..side);
                        self.texels(centre, &reach, all, visitor)?;
                    }
                    Some(level) => self.cells(level, centre, &reach, visitor)?,
                }
            }
        }
        Ok(())
    }

    /// The cells of `level` in the copy over which the footprint is at `centre`.
    #[inline(always)]
    fn cells<V: Visitor>(
        &self,
        level: u8,
        centre: [f64; 2],
        reach: &Reach,
        visitor: &mut V,
    ) -> Result<(), QueryError> {
        let layout = &self.lobes.layout;
        let size = layout.size;
        let side_texels = 1_u32 << (level & 31);
        let side = f64::from(side_texels);
        let [across, down] = layout.cells(level);
        let rows = if self.even[1] {
            0..down
        } else {
            clipped(centre[1], [-reach.down(), reach.down()], side, down)
        };
        for row in rows {
            let top = f64::from(row) * side;
            let columns = if self.even[0] {
                0..across
            } else {
                let slab = [top - centre[1], top + side - centre[1]];
                clipped(centre[0], reach.columns(slab), side, across)
            };
            for column in columns {
                if self.is_cut(level, [column, row]) {
                    self.texels_of(centre, reach, [column, row], visitor)?;
                    continue;
                }
                let blocks = self
                    .lobes
                    .cell(level, column, row)
                    .ok_or(Finding::new(Fault::MipIndex))?;
                let extent = |axis: usize, place: u32| {
                    let first = place.wrapping_mul(side_texels);
                    let size = if axis == 0 { size[0] } else { size[1] };
                    side_texels.min(size.saturating_sub(first))
                };
                let area = f64::from(extent(0, column)) * f64::from(extent(1, row));
                let offset = [
                    (centre[0] - f64::from(column) * side) as f32,
                    (centre[1] - top) as f32,
                ];
                for block in blocks {
                    let positions = Positions::of_block(block, side as f32, area as f32, offset);
                    visitor.sixteen(&positions, block);
                }
            }
        }
        Ok(())
    }

    /// Whether a seam runs through a cell of the lowest level. There, where a footprint is not much larger than a cell, clusters would
    /// blur the seam, so its own lobes stand for it; above, cells count as if they ended at their patch.
    #[inline(always)]
    fn is_cut(&self, level: u8, [column, row]: [u32; 2]) -> bool {
        match &self.lobes.layout.quilt {
            Some(quilt) if level == self.lobes.layout.first_level && quilt.overlap > 0 => {
                let shift = quilt.patch_log.saturating_sub(level) & 31;
                let mask = (1_u32 << shift).wrapping_sub(1);
                column & mask == 0 || row & mask == 0
            }
            _ => false,
        }
    }

    /// The lobes of the texels within reach of those in `columns` and `rows`, in the copy over which the footprint is at `centre`.
    #[inline(always)]
    fn texels<V: Visitor>(
        &self,
        centre: [f64; 2],
        reach: &Reach,
        [columns, rows]: [Range<u32>; 2],
        visitor: &mut V,
    ) -> Result<(), QueryError> {
        let [width, height] = self.lobes.layout.size;
        let within = if self.even[1] {
            0..height
        } else {
            clipped(centre[1], [-reach.down(), reach.down()], 1.0, height)
        };
        let mut batch = Batch::new(self.lobes, &self.asked);
        for row in rows.start.max(within.start)..rows.end.min(within.end) {
            let top = f64::from(row);
            let within = if self.even[0] {
                0..width
            } else {
                let slab = [top - centre[1], top + 1.0 - centre[1]];
                clipped(centre[0], reach.columns(slab), 1.0, width)
            };
            let columns = columns.start.max(within.start)..columns.end.min(within.end);
            batch.row(centre, row, columns, visitor)?;
        }
        batch.finish(visitor);
        Ok(())
    }

    /// The same of a cell of the lowest level.
    #[inline(never)]
    fn texels_of<V: Visitor>(
        &self,
        centre: [f64; 2],
        reach: &Reach,
        cell: [u32; 2],
        visitor: &mut V,
    ) -> Result<(), QueryError> {
        let side = 1_u32 << (self.lobes.layout.first_level & 31);
        let texels = cell.map(|place| {
            let first = place.wrapping_mul(side);
            first..first.wrapping_add(side)
        });
        self.texels(centre, reach, texels, visitor)
    }
}

#[inline(always)]
fn square(x: f64) -> f64 {
    x * x
}

/// The ellipse within reach.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// How x leans with y.
    lean: f64,
    /// How far it reaches along x from where it leans to, and along y.
    half: [f64; 2],
}

impl Reach {
    fn new(half_edges: [[f64; 2]; 2], variance: f64) -> Self {
        let [xx, yy, xy] = covariance(half_edges);
        let area = cross(half_edges);
        let determinant = area * area + variance * (xx + yy + variance);
        let down = yy + variance;
        Self {
            lean: xy / down,
            half: [
                REACH * libm::sqrt(determinant / down),
                REACH * libm::sqrt(down),
            ],
        }
    }

    fn down(&self) -> f64 {
        self.half[1]
    }

    /// The columns, from the centre, that it reaches between two rows from the centre.
    #[inline(always)]
    fn columns(&self, [top, bottom]: [f64; 2]) -> [f64; 2] {
        let limit = |y: f64| self.lean * y.clamp(-self.half[1], self.half[1]);
        let (one, other) = (limit(top), limit(bottom));
        [one.min(other) - self.half[0], one.max(other) + self.half[0]]
    }
}

/// The copies of an axis of `side` texels that are within `reach` of `centre`.
fn copies(centre: f64, reach: f64, side: f64, is_even: bool) -> Range<i64> {
    if is_even {
        0..1
    } else {
        span(centre - reach, centre + reach, side)
    }
}

/// The cells of `side`, of `count`, that the interval about `centre` meets.
#[inline(always)]
fn clipped(centre: f64, [low, high]: [f64; 2], side: f64, count: u32) -> Range<u32> {
    let cell = |place: f64| libm::floor((centre + place) / side).clamp(-1.0, f64::from(count));
    let first = cell(low).max(0.0) as u32;
    let last = (cell(high) + 1.0) as u32;
    first..last.min(count)
}
