//! The bins around a half vector, as the baselines go through them.

use glintbake_format::model::{BinGrid, HalfVector, Neighbourhood};
use std::ops::Range;

/// Bins of the largest neighbourhood's square, and so of any window's.
pub const MOST_BINS: usize = 49;
/// Rows of the largest neighbourhood.
pub const MOST_ROWS: usize = 7;

/// Row and columns, on `grid`, of the bins of `neighbourhood` around the bin of `half_vector`, row by row.
pub fn rows(
    grid: BinGrid,
    half_vector: HalfVector,
    neighbourhood: Neighbourhood,
) -> impl Iterator<Item = (u32, Range<u32>)> {
    let (column, row) = grid.bin_of(half_vector);
    let reach = neighbourhood.reach();
    (-reach..=reach).filter_map(move |dy| {
        let row = row.checked_add_signed(dy)?;
        let side = (0..=reach).rev().find(|&dx| neighbourhood.holds(dx, dy))? as u32;
        let columns = column.saturating_sub(side)..(column + side + 1).min(grid.resolution());
        (row < grid.resolution()).then_some((row, columns))
    })
}
