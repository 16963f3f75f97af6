//! Weights of bins under a Gaussian footprint.
//!
//! The same three ways as under a box: a scan of the bin map, block lists, lists of positions. A block or a tile over
//! which the Gaussian hardly changes counts by its number of texels times the Gaussian's average over it; what
//! "hardly" means is the tolerance, see [`Forms`]. Everything else is opened, down to texels, which are weighed exactly.

mod blocks;
mod border;
mod forms;
mod positions;
mod tables;
mod texels;
mod wide;

pub(crate) use texels::for_each_texel;

use super::sums::Sums;
use super::window::{KeyRuns, WINDOW};
use super::{How, Lookup, block_lists, forest, map_shape, scan};
use crate::error::QueryError;
use crate::overlap::GaussianFootprint;
use crate::scan::{Budget, MapShape};
use forms::Forms;
use glintbake_format::model::Wrap;
use glintbake_format::records::LISTS;
use glintbake_format::view::{BinTables, Inverse};

/// Texels within the ellipse up to which a scan is the cheaper way.
const SCAN_BELOW_TEXELS: f64 = 6000.0;
/// Least standard deviation, in tiles, from which a repeating Gaussian weighs all texels alike: the sum of its copies is
/// a Fourier series whose first waves have the amplitude `2 exp(-2π² σ²)`, here 1.3e-6.
const EVEN_TILES: f64 = 0.85;

/// What weights are looked for, and where they are summed.
pub(super) struct Target<'t> {
    pub sums: Sums,
    pub tables: &'t BinTables<'t>,
    pub runs: &'t KeyRuns,
}

/// Whether `footprint` weighs all texels of a map of `shape` alike.
fn is_even(shape: MapShape, footprint: &GaussianFootprint) -> bool {
    let (width, height) = (f64::from(shape.width), f64::from(shape.height));
    shape.wrap == Wrap::Repeat && footprint.least_deviation_in_tiles(width, height) >= EVEN_TILES
}

/// The weights by place of the keys of `runs` under `footprint`.
pub(super) fn weights(
    tables: &BinTables<'_>,
    footprint: &GaussianFootprint,
    runs: &KeyRuns,
    how: How,
) -> Result<[f64; WINDOW * WINDOW], QueryError> {
    let by_lists = match how.lookup {
        Lookup::Auto => {
            !matches!(tables.inverse, Inverse::None)
                && footprint.support_texels() > SCAN_BELOW_TEXELS
        }
        Lookup::Scan => false,
        Lookup::Lists => true,
    };
    let shape = map_shape(tables);
    let mut target = Target {
        sums: Sums::new(),
        tables,
        runs,
    };
    if is_even(shape, footprint) {
        count_map(&mut target, by_lists)?;
        let texels = f64::from(shape.width) * f64::from(shape.height);
        return Ok(target.sums.weights(1.0 / texels));
    }
    if by_lists {
        look_up(&mut target, footprint, how)?;
    } else {
        let mut budget = Budget::for_gaussian(shape);
        texels::for_each_copy(shape, footprint, false, &mut |footprint| {
            how.instructions.run(texels::Scan {
                target: &mut target,
                footprint,
                budget: &mut budget,
            })
        })?;
    }
    border::for_each_texel(shape, footprint, &mut |column, row, weight| {
        let key = tables
            .bin_map
            .key(column, row)
            .ok_or(scan::missing(tables))?;
        if let Some(place) = runs.place(key) {
            target.sums.add(place, weight);
        }
        Ok(())
    })?;
    // No texel is counted as inside.
    Ok(target.sums.weights(0.0))
}

/// Counts every texel of the map once.
fn count_map(target: &mut Target<'_>, by_lists: bool) -> Result<(), QueryError> {
    let Target { sums, tables, runs } = target;
    match &tables.inverse {
        Inverse::Tiles(lists) if by_lists => block_lists::count_map(sums, lists, runs, 1),
        Inverse::Forest(inverse) if by_lists => {
            forest::Lists::new(tables, inverse, runs)?.count(sums, 1);
            Ok(())
        }
        Inverse::None if by_lists => Err(NO_LISTS),
        _ => scan::count_map(sums, tables, runs, 1),
    }
}

fn look_up(
    target: &mut Target<'_>,
    footprint: &GaussianFootprint,
    how: How,
) -> Result<(), QueryError> {
    let shape = map_shape(target.tables);
    let [x, y] = footprint.centred(0.0, 0.0);
    // A map's texels lie no further from the centre than this; a copy's that counts, nearer.
    let reach = x.abs().max(y.abs()) + f64::from(shape.width) + f64::from(shape.height);
    let forms = Forms::new(footprint, how.tolerance, reach);
    match &target.tables.inverse {
        Inverse::Tiles(lists) if forms.tile_rule.accepts_all() => {
            how.instructions.run(wide::WideTraversal {
                target,
                footprint,
                forms: &forms,
                lists,
            })
        }
        Inverse::Tiles(lists) => {
            let fold = blocks::folds(shape, footprint);
            texels::for_each_copy(shape, footprint, fold, &mut |footprint| {
                how.instructions.run(blocks::Traversal {
                    target,
                    footprint,
                    forms: &forms,
                    lists,
                    fold,
                })
            })
        }
        Inverse::Forest(inverse) => how.instructions.run(positions::Walk {
            target,
            footprint,
            inverse,
            forms: &forms,
        }),
        Inverse::None => Err(NO_LISTS),
    }
}

const NO_LISTS: QueryError = QueryError::NotBaked {
    section: LISTS,
    option: "--index tiles",
};
