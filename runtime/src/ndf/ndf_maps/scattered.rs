//! The copies that a footprint may see.

use super::frame::Frame;
use core::ops::RangeInclusive;
use glintbake_format::view::{Copied, NdfMaps};

/// The most copies that are looked at, beside four times as many as there are: the grid of a damaged package may name them again and
/// again.
const MOST_VISITS: usize = 1 << 18;

/// A copy that the footprint may see.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub number: usize,
    pub copied: Copied,
    /// In which repetition of the surface it lies.
    pub surface: [i64; 2],
    /// How far from its place that is, in texels.
    pub shift: [f64; 2],
}

impl Candidate {
    /// Copy `number` in the repetition `surface`; `None` where the package is damaged.
    #[inline]
    pub fn new(maps: &NdfMaps<'_>, number: usize, surface: [i64; 2]) -> Option<Self> {
        let size = f64::from(maps.layout.size);
        Some(Self {
            number,
            copied: maps.copied(number)?,
            surface,
            shift: surface.map(|along| along as f64 * size),
        })
    }
}

/// The cells of the grid that may have centres of copies within reach of the footprint.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    columns: RangeInclusive<i64>,
    rows: RangeInclusive<i64>,
    bounds: [[f64; 2]; 2],
}

impl Cells {
    pub fn new(maps: &NdfMaps<'_>, frame: &Frame) -> Self {
        let width = f64::from(maps.layout.size) / f64::from(maps.root.cells.get().max(1));
        let reach = maps.root.reach.get();
        let bounds = frame.axes().map(|axis| axis.range());
        let cells = |[low, high]: [f64; 2]| {
            let first = libm::floor((low - reach) / width) as i64;
            first..=libm::floor((high + reach) / width) as i64
        };
        let [columns, rows] = bounds.map(cells);
        Self {
            columns,
            rows,
            bounds,
        }
    }

    /// About how many copies there are, counted as often as the surface repeats under the footprint.
    pub fn count(&self, maps: &NdfMaps<'_>) -> f64 {
        let along =
            |range: &RangeInclusive<i64>| range.end().saturating_sub(*range.start()) as f64 + 1.0;
        let cells = f64::from(maps.root.cells.get().max(1));
        let in_a_cell = maps.copies.len() as f64 / (cells * cells);
        along(&self.columns) * along(&self.rows) * (in_a_cell + 0.25)
    }

    /// Calls `visit` with each copy whose box the footprint's meets.
    pub fn each(&self, maps: &NdfMaps<'_>, mut visit: impl FnMut(&Candidate)) {
        let cells = i64::from(maps.root.cells.get().max(1));
        let half = 0.5 * f64::from(maps.layout.example());
        let [across, down] = self.bounds;
        let mut left = MOST_VISITS.saturating_add(maps.copies.len().saturating_mul(4));
        for row in self.rows.clone() {
            for column in self.columns.clone() {
                let surface = [column.div_euclid(cells), row.div_euclid(cells)];
                let cell = [
                    column.rem_euclid(cells) as u32,
                    row.rem_euclid(cells) as u32,
                ];
                for number in maps.copies_in(cell[0], cell[1]) {
                    left = left.saturating_sub(1);
                    if left == 0 {
                        return;
                    }
                    let Some(candidate) = Candidate::new(maps, number, surface) else {
                        continue;
                    };
                    let Candidate { copied, shift, .. } = &candidate;
                    let is_met = |centre: f64, [x, y]: [f64; 2], [low, high]: [f64; 2]| {
                        let reach = half * (x.abs() + y.abs());
                        centre + reach > low && centre - reach < high
                    };
                    let [row_x, row_y] = copied.matrix;
                    if is_met(copied.centre[0] + shift[0], row_x, across)
                        && is_met(copied.centre[1] + shift[1], row_y, down)
                    {
                        visit(&candidate);
                    }
                }
            }
        }
    }
}
