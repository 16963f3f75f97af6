//! Weights `W_j` of a few neighbouring bins over a footprint, \[AWKK21\] §5.4.
//!
//! Three ways to the same numbers: scan the bin map under the footprint (`scan`), or find the bins' texels by the blocks
//! that hold them (`block_lists`) or by their positions (`forest`), whichever the package has. The first is cheaper for
//! few texels, the others hardly grow with their number; `cost` tells which to take.

mod block_lists;
mod cost;
mod forest;
mod frame;
mod gaussian;
mod keys;
mod scan;
mod sums;
mod window;

pub(crate) use gaussian::for_each_texel;
pub(crate) use window::BinWindow;

use crate::error::QueryError;
use crate::overlap::{GaussianFootprint, Outline, Parallelogram};
use crate::scan::{Budget, MapShape};
use crate::simd::Instructions;
use frame::Frame;
use glintbake_format::model::{Filter, Footprint, HalfVector};
use glintbake_format::records::{Instance, LISTS};
use glintbake_format::view::{BinTables, Inverse};
use sums::Sums;
use window::KeyRuns;

/// Which way to the weights a query takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Lookup {
    /// The cheaper way by the footprint's size and the length of the bins' lists.
    #[default]
    Auto,
    /// Scan the bin map.
    Scan,
    /// Look the bins' texels up in block lists or forest.
    Lists,
}

/// Tolerance of Gaussian footprints where none is named.
pub const DEFAULT_TOLERANCE: f64 = 0.125;

/// How footprints are weighed. Whatever the look-up and the instructions, the answer is the same.
#[derive(Clone, Copy, Debug)]
pub(crate) struct How {
    /// See [`SurfaceNdf::with_filter`](super::SurfaceNdf::with_filter).
    pub filter: Filter,
    pub lookup: Lookup,
    pub instructions: Instructions,
    /// See [`SurfaceNdf::with_tolerance`](super::SurfaceNdf::with_tolerance).
    pub tolerance: f64,
}

impl How {
    /// As `instance` asks for, and where it says nothing by default.
    pub fn new(instance: &Instance) -> Self {
        Self {
            filter: instance.filter,
            lookup: Lookup::default(),
            instructions: Instructions::default(),
            tolerance: DEFAULT_TOLERANCE,
        }
    }
}

/// A footprint on a map, in texels, as its filter weighs it.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "one a query, on the stack, for there is no heap"
)]
pub(crate) enum Patch {
    Box(Parallelogram),
    Gaussian(GaussianFootprint),
}

/// Calls `visit(column, row, weight)` for the bins of `window` that have weight over `patch`.
///
/// # Errors
/// [`QueryError::TooManyTexels`] from a scan, [`QueryError::NotBaked`] if lists are forced and there are none,
/// [`QueryError::Damaged`].
pub(crate) fn bin_weights(
    tables: &BinTables<'_>,
    patch: &Patch,
    window: BinWindow,
    how: How,
    visit: &mut impl FnMut(u32, u32, f64),
) -> Result<(), QueryError> {
    let grid = tables.bins.grid;
    let Some(runs) = KeyRuns::new(window, grid, &tables.index) else {
        return Ok(());
    };
    let weights = match patch {
        Patch::Box(footprint) => {
            let mut sums = Sums::new();
            find_sums(&mut sums, tables, footprint, &runs, how)?;
            sums.weights(footprint.texel_weight())
        }
        Patch::Gaussian(footprint) => gaussian::weights(tables, footprint, &runs, how)?,
    };
    for (start, count, place) in runs.iter() {
        let weights = weights.iter().skip(place as usize).take(count as usize);
        for (key, &weight) in (start..).zip(weights) {
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

/// Adds what is found of the keys of `runs` under `footprint`.
fn find_sums(
    sums: &mut Sums,
    tables: &BinTables<'_>,
    footprint: &Parallelogram,
    runs: &KeyRuns,
    how: How,
) -> Result<(), QueryError> {
    let by_lists = match how.lookup {
        Lookup::Auto => cost::lists_are_cheaper(tables, footprint, runs)?,
        Lookup::Scan => false,
        Lookup::Lists => true,
    };
    if by_lists {
        look_up(sums, tables, footprint, runs)
    } else {
        scan_tiles(sums, tables, footprint, runs)
    }
}

fn scan_tiles(
    sums: &mut Sums,
    tables: &BinTables<'_>,
    footprint: &Parallelogram,
    runs: &KeyRuns,
) -> Result<(), QueryError> {
    let shape = map_shape(tables);
    let outline = Outline::new(footprint);
    let mut budget = Budget::new(shape);
    let whole_tiles = shape.for_each_copy(footprint, &mut |tile| {
        let frame = Frame::new(tables, tile, outline.as_ref());
        scan::Scan {
            sums,
            frame: &frame,
            runs,
            budget: &mut budget,
        }
        .run()
    })?;
    if whole_tiles > 0 {
        scan::count_map(sums, tables, runs, whole_tiles)?;
    }
    Ok(())
}

fn look_up(
    sums: &mut Sums,
    tables: &BinTables<'_>,
    footprint: &Parallelogram,
    runs: &KeyRuns,
) -> Result<(), QueryError> {
    let shape = map_shape(tables);
    let outline = Outline::new(footprint);
    let outline = outline.as_ref();
    match &tables.inverse {
        Inverse::Tiles(lists) => {
            let whole_tiles = shape.for_each_copy(footprint, &mut |tile| {
                let frame = Frame::new(tables, tile, outline);
                block_lists::Traversal {
                    sums,
                    frame: &frame,
                    lists,
                    runs,
                }
                .run()
            })?;
            if whole_tiles > 0 {
                block_lists::count_map(sums, lists, runs, whole_tiles)?;
            }
            Ok(())
        }
        Inverse::Forest(inverse) => {
            let lists = forest::Lists::new(tables, inverse, runs)?;
            let whole_tiles = shape.for_each_copy(footprint, &mut |tile| {
                lists.traverse(sums, tables, inverse, tile, outline)
            })?;
            lists.count(sums, whole_tiles);
            Ok(())
        }
        Inverse::None => Err(QueryError::NotBaked {
            section: LISTS,
            option: "--index tiles",
        }),
    }
}

pub(crate) fn map_shape(tables: &BinTables<'_>) -> MapShape {
    MapShape {
        width: tables.instance.width,
        height: tables.instance.height,
        wrap: tables.instance.wrap,
    }
}

/// `footprint` on the map of `tables` as `filter` weighs it.
pub(crate) fn patch_under(
    tables: &BinTables<'_>,
    footprint: &Footprint,
    filter: Filter,
) -> Result<Patch, QueryError> {
    let MapShape {
        width,
        height,
        wrap,
    } = map_shape(tables);
    Ok(match filter {
        Filter::Box => Patch::Box(Parallelogram::new(footprint, width, height, wrap)?),
        Filter::Gaussian => {
            Patch::Gaussian(GaussianFootprint::new(footprint, width, height, wrap)?)
        }
    })
}

/// Column and row of the texel under a point of `footprint` drawn by `filter` and two numbers in [0, 1).
pub(crate) fn texel_under(
    tables: &BinTables<'_>,
    footprint: &Footprint,
    filter: Filter,
    uniform: [f64; 2],
) -> Result<(u32, u32), QueryError> {
    let shape = map_shape(tables);
    Ok(match patch_under(tables, footprint, filter)? {
        Patch::Box(footprint) => {
            let [a, b] = uniform.map(|number| number - 0.5);
            shape.texel_at(&footprint, a, b)
        }
        Patch::Gaussian(footprint) => shape.fold(footprint.sample(uniform)),
    })
}

/// Refuses a half vector that is no point.
pub(crate) fn check_finite(half_vector: HalfVector) -> Result<(), QueryError> {
    if half_vector.s.is_finite() && half_vector.t.is_finite() {
        Ok(())
    } else {
        Err(QueryError::NotFinite)
    }
}
