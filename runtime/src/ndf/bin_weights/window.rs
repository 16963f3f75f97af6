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

/// Consecutive keys, of bins in one row of a window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub start: u32,
    /// At most [`WINDOW`].
    pub count: u32,
}

/// The keys of a window's bins: a run a row. Keys rise with bin numbers, so runs rise as well.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeyRuns {
    runs: [Run; WINDOW],
    /// The least key of any run.
    pub least: u32,
    /// The greatest key of any run less [`least`](Self::least).
    pub spread: u32,
}

impl KeyRuns {
    /// The keys of `window`, or `None` if it holds no bin that has texels.
    pub fn new(window: BinWindow, grid: BinGrid, index: &BinIndex<'_>) -> Option<Self> {
        let mut runs = [Run { start: 0, count: 0 }; WINDOW];
        let (mut least, mut end) = (u32::MAX, 0);
        for (run, (row, columns)) in runs.iter_mut().zip(window.runs(grid.resolution())) {
            let keys = index.keys(grid.number(columns.start, row)..grid.number(columns.end, row));
            if keys.is_empty() {
                continue;
            }
            least = least.min(keys.start);
            end = end.max(keys.end);
            *run = Run {
                start: keys.start,
                count: (keys.end - keys.start).min(WINDOW as u32),
            };
        }
        (least < end).then(|| Self {
            runs,
            least,
            spread: end - 1 - least,
        })
    }


    /// Every key with its place: run × 7 + position in its run.
    pub fn keys(&self) -> impl Iterator<Item = (usize, u32)> {
        (0..)
            .step_by(WINDOW)
            .zip(self.runs)
            .flat_map(|(place, run)| (place..).zip(run.start..run.start.saturating_add(run.count)))
    }

    /// The place of `key`, if it is one of the window's.
    #[inline]
    pub fn place(&self, key: u32) -> Option<usize> {
        if key.wrapping_sub(self.least) > self.spread {
            return None;
        }
        (0..)
            .step_by(WINDOW)
            .zip(&self.runs)
            .find_map(|(place, run)| {
                let offset = key.wrapping_sub(run.start);
                (offset < run.count).then_some(place + offset as usize)
            })
    }
}
