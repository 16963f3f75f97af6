//! Weights `W_j` of a few neighbouring bins over a footprint, \[AWKK21\] §5.4.
//!
//! Two ways to the same numbers: scan the bin map under the footprint, or look the bins' texels up in the inverse
//! bin map and its forest. The first is cheaper for few texels, the second does not grow with their number.

mod bin_map;
mod lists;
mod window;

pub(crate) use window::BinWindow;

use crate::error::QueryError;
use crate::overlap::Parallelogram;
use crate::scan::MapShape;
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_format::view::BinTables;
use window::{KeyRuns, WINDOW};

/// Footprint area, in texels, below which scanning the bin map is the cheaper way.
///
/// Measured with `cargo bench -p glintbake-tests --bench weights`: on flakes, brushed and noise maps at α = 0.01 the
/// two ways break even between 1 000 and 6 000 texels.
const SCAN_BELOW_TEXELS: f64 = 2000.0;

/// Which way to the weights a query takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Lookup {
    /// The cheaper way by the footprint's area.
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
    let bounds = footprint.bounds();
    let reach = (bounds.high[0] - bounds.low[0]).max(bounds.high[1] - bounds.low[1]);
    let scan = match lookup {
        Lookup::Auto => footprint.area() + 2.0 * reach < SCAN_BELOW_TEXELS,
        Lookup::Scan => true,
        Lookup::Lists => false,
    };
    if scan {
        sums.scan(tables, footprint, &runs)?;
    } else {
        sums.traverse(tables, footprint, &runs)?;
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
