//! Weights `W_j` of a few neighbouring bins over a footprint, \[AWKK21\] §5.4.
//!
//! Two ways to the same numbers: scan the bin map under the footprint (`bin_map`), or look the bins' texels up in the
//! inverse bin map and its forest (`lists`, `walk`). The first is cheaper for few texels, the second hardly grows with
//! their number; `cost` tells which to take.

mod bin_map;
mod cost;
mod lists;
mod walk;
mod window;

pub(crate) use window::BinWindow;

use crate::error::QueryError;
use crate::overlap::Parallelogram;
use crate::scan::MapShape;
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_format::view::BinTables;
use lists::Lists;
use window::{KeyRuns, WINDOW};

/// Which way to the weights a query takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Lookup {
    /// For each bin the cheaper way by the footprint's size and the length of the bin's list.
    #[default]
    Auto,
    /// Scan the bin map.
    Scan,
    /// Traverse the inverse bin map.
    Lists,
}

/// Calls `visit(column, row, weight)` for the bins of `window` that have weight over `footprint`.
///
/// # Errors
/// [`QueryError::TooManyTexels`] from a forced scan, [`QueryError::Damaged`].
pub(crate) fn bin_weights(
    tables: &BinTables<'_>,
    footprint: &Parallelogram,
    window: BinWindow,
    lookup: Lookup,
    visit: &mut impl FnMut(u32, u32, f64),
) -> Result<(), QueryError> {
    let grid = tables.instance.grid;
    let Some(runs) = KeyRuns::new(window, grid, &tables.index) else {
        return Ok(());
    };
    let mut sums = Sums([0.0; WINDOW * WINDOW]);
    let longest = match lookup {
        Lookup::Auto => cost::longest_list(tables, footprint),
        Lookup::Scan => 0,
        Lookup::Lists => u32::MAX,
    };
    if longest == 0 {
        sums.scan(tables, footprint, &runs)?;
    } else {
        let lists = Lists::new(tables, &runs)?;
        if lists.longest() > longest {
            sums.scan(tables, footprint, &runs)?;
        }
        let lists = lists.up_to(longest);
        sums.traverse(tables, footprint, &lists)?;
    }
    for (start, count, place) in runs.iter() {
        let sums = sums.0.iter().skip(place as usize).take(count as usize);
        for (key, &weight) in (start..).zip(sums) {
            if weight > 0.0 {
                let (column, row) = grid.column_row(tables.index.bin_of_key(key)?);
                // An index may lie about the bin of a key; no bin outside the window gets weight by that.
                if window.holds(column, row) {
                    visit(column, row, weight);
                }
            }
        }
    }
    Ok(())
}

/// Sums of weights by the places of [`KeyRuns`].
struct Sums([f64; WINDOW * WINDOW]);

impl Sums {
    fn clear(&mut self, place: u32) {
        if let Some(sum) = self.0.get_mut(place as usize) {
            *sum = 0.0;
        }
    }

    #[inline]
    fn add(&mut self, place: u32, weight: f64) {
        if let Some(sum) = self.0.get_mut(place as usize) {
            *sum += weight;
        }
    }
}

pub(crate) fn map_shape(tables: &BinTables<'_>) -> MapShape {
    MapShape {
        width: tables.instance.width,
        height: tables.instance.height,
        wrap: tables.instance.wrap,
    }
}

/// `footprint` on the map of `tables`, in texels.
pub(crate) fn parallelogram(
    tables: &BinTables<'_>,
    footprint: &Footprint,
) -> Result<Parallelogram, QueryError> {
    let MapShape {
        width,
        height,
        wrap,
    } = map_shape(tables);
    Parallelogram::new(footprint, width, height, wrap)
}

/// The number of the texel under a uniform point of `footprint`, drawn by two numbers in [0, 1).
pub(crate) fn texel_under(
    tables: &BinTables<'_>,
    footprint: &Footprint,
    uniform: [f64; 2],
) -> Result<usize, QueryError> {
    let footprint = parallelogram(tables, footprint)?;
    let [a, b] = uniform.map(|number| number - 0.5);
    let (column, row) = map_shape(tables).texel_at(&footprint, a, b);
    Ok(tables.texel(column, row))
}

/// Refuses a half vector that is no point.
pub(crate) fn check_finite(half_vector: HalfVector) -> Result<(), QueryError> {
    if half_vector.s.is_finite() && half_vector.t.is_finite() {
        Ok(())
    } else {
        Err(QueryError::NotFinite)
    }
}
