//! The bins a query wants, and the keys that stand for them.

use core::ops::Range;
use glintbake_format::model::{BinGrid, Neighbourhood};
use glintbake_format::view::BinIndex;

/// Bins per side of the largest window.
pub(super) const WINDOW: usize = 7;

/// The bins around one bin of which weights are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BinWindow {
    pub column: u32,
    pub row: u32,
    /// `None` for the one bin alone.
    pub neighbourhood: Option<Neighbourhood>,
}

impl BinWindow {
    fn reach(self) -> i32 {
        self.neighbourhood.map_or(0, Neighbourhood::reach)
    }

    /// Whether the bin (`column`, `row`) belongs to the window.
    pub fn holds(self, column: u32, row: u32) -> bool {
        let dx = i64::from(column) - i64::from(self.column);
        let dy = i64::from(row) - i64::from(self.row);
        let reach = i64::from(self.reach());
        dx.abs() <= reach
            && dy.abs() <= reach
            && self
                .neighbourhood
                .is_none_or(|neighbourhood| neighbourhood.holds(dx as i32, dy as i32))
    }

    /// Row and columns of the window's bins on a grid of `resolution` bins a side, row by row; x and y are clipped
    /// apart, so that no neighbour leaks into the next row.
    fn runs(self, resolution: u32) -> impl Iterator<Item = (u32, Range<u32>)> {
        let reach = self.reach();
        (-reach..=reach).filter_map(move |dy| {
            let row = self.row.checked_add_signed(dy)?;
            // The outermost rows lack their corners.
            let wide = self
                .neighbourhood
                .is_none_or(|neighbourhood| neighbourhood.holds(reach, dy));
            let side = reach.unsigned_abs() - u32::from(!wide);
            let columns = self.column.saturating_sub(side)
                ..self.column.saturating_add(side + 1).min(resolution);
            (row < resolution).then_some((row, columns))
        })
    }
}

/// Places for runs: one more than a window has rows, so that they fill whole vector registers.
pub(super) const RUNS: usize = WINDOW + 1;

/// The keys of a window's bins: a run of at most seven consecutive keys for each of its rows.
///
/// A key's place among the sums is 7 × row + column of its bin within the window, or for a sparse index, which may
/// leave bins out, 7 × run + position in the run.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeyRuns {
    /// The first key of each run.
    pub starts: [u32; RUNS],
    /// The number of keys of each run; zero beyond the last.
    pub counts: [u32; RUNS],
    /// The place of each run's first key.
    pub places: [u32; RUNS],
    /// The least key of any run.
    pub least: u32,
    /// The greatest key of any run less [`least`](Self::least).
    pub spread: u32,
    pub lattice: Option<Lattice>,
}

/// The keys of a window on a grid of less than 2¹⁶ bins whose numbers are the keys: `base + stride × row + column`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    base: u16,
    /// Bins per row of the grid.
    stride: u16,
    /// 2¹⁶ / `stride`, rounded up.
    reciprocal: u16,
    rows: u16,
    columns: u16,
}

impl Lattice {
    /// Row and column of `key` if both are within the window, else any numbers that are not.
    ///
    /// The quotient by the reciprocal is right or, for large remainders, one too large; then the remainder wraps
    /// around and is out of the window as it should be. A window's own keys are less than `7 stride` from `base`
    /// with a remainder of at most 6 out of 8 or more, far from that.
    #[inline(always)]
    fn cell(self, key: u16) -> (u16, u16) {
        let distance = key.wrapping_sub(self.base);
        let row = ((u32::from(distance) * u32::from(self.reciprocal)) >> 16) as u16;
        (row, distance.wrapping_sub(row.wrapping_mul(self.stride)))
    }

    /// Whether `key` is of a bin in the window's square, corners included.
    #[inline(always)]
    pub fn holds(self, key: u16) -> bool {
        let (row, column) = self.cell(key);
        (row < self.rows) & (column < self.columns)
    }

    /// The place of `key`, or `elsewhere`.
    #[inline(always)]
    pub fn place(self, key: u16, elsewhere: u16) -> u16 {
        let (row, column) = self.cell(key);
        let place = row.wrapping_mul(WINDOW as u16).wrapping_add(column);
        if (row < self.rows) & (column < self.columns) {
            place
        } else {
            elsewhere
        }
    }
}

impl KeyRuns {
    /// The keys of `window`, or `None` if it holds no bin that has texels.
    pub fn new(window: BinWindow, grid: BinGrid, index: &BinIndex<'_>) -> Option<Self> {
        let dense = index.occupied().is_empty();
        let reach = window.reach().unsigned_abs();
        let resolution = grid.resolution();
        let first_column = window.column.saturating_sub(reach);
        let mut keys = Self {
            starts: [0; RUNS],
            counts: [0; RUNS],
            places: [0; RUNS],
            least: u32::MAX,
            spread: 0,
            lattice: None,
        };
        let mut end = 0;
        let mut runs = keys
            .starts
            .iter_mut()
            .zip(&mut keys.counts)
            .zip(keys.places.iter_mut().zip((0..).step_by(WINDOW)));
        for (row, columns) in window.runs(resolution) {
            let range = index.keys(grid.number(columns.start, row)..grid.number(columns.end, row));
            if !range.is_empty()
                && let Some(((start, count), (place, first))) = runs.next()
            {
                *start = range.start;
                *count = (range.end - range.start).min(WINDOW as u32);
                *place = first
                    + if dense {
                        columns.start - first_column
                    } else {
                        0
                    };
                keys.least = keys.least.min(range.start);
                end = end.max(range.end);
            }
        }
        if keys.least >= end {
            return None;
        }
        keys.spread = end - 1 - keys.least;
        let first_row = window.row.saturating_sub(reach);
        let cells = |from: u32, centre: u32| (centre + reach + 1).min(resolution) - from;
        if dense
            && resolution > WINDOW as u32
            && let Ok(base) = u16::try_from(grid.number(first_column, first_row))
            && let Ok(reciprocal) = u16::try_from(0x1_0000_u32.div_ceil(resolution))
        {
            keys.lattice = (grid.count() <= 0x1_0000).then_some(Lattice {
                base,
                stride: resolution as u16,
                reciprocal,
                rows: cells(first_row, window.row) as u16,
                columns: cells(first_column, window.column) as u16,
            });
        }
        Some(keys)
    }

    /// The place of `key`, if it is one of the window's.
    pub fn place(&self, key: u32) -> Option<u32> {
        self.iter()
            .find(|&(start, count, _)| key.wrapping_sub(start) < count)
            .map(|(start, _, place)| place + (key - start))
    }

    /// First key, number of keys and first place of each run.
    pub fn iter(&self) -> impl Iterator<Item = (u32, u32, u32)> {
        self.starts
            .into_iter()
            .zip(self.counts)
            .zip(self.places)
            .map(|((start, count), place)| (start, count, place))
    }
}
