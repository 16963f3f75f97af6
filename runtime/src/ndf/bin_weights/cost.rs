//! Which way to the weights is the cheaper one.
//!
//! The constants are nanoseconds measured with `cargo bench -p glintbake-tests --bench weights` on 2048² maps, cold, one
//! thread: a scan costs the same wherever it looks, lists cost more the longer they are.

use super::forest::Lists;
use super::map_shape;
use super::window::KeyRuns;
use crate::error::QueryError;
use crate::overlap::{Parallelogram, TexelBox};
use glintbake_format::model::{BLOCK_SIDE, PAGE_SIDE, TILE_SIDE};
use glintbake_format::view::{BinTables, BlockLists, Inverse, InverseBinMap};

/// Texels under a footprint up to which a scan is always the cheaper way.
const SCAN_BELOW_TEXELS: f64 = 800.0;
/// A scan's time for anything, and for a texel, few of which are wanted, or many.
const SCAN: f64 = 1000.0;
const SCAN_TEXEL: [f64; 2] = [0.4, 1.0];
/// The time to look through a block on the outline, few of whose texels are wanted, or many.
const CROSSING: [f64; 2] = [60.0, 300.0];
/// The time to ask for a listed block on the outline and to wait for it.
const LISTED: f64 = 90.0;
/// The time to find a window's block lists.
const WINDOW: f64 = 3000.0;
/// The time to find the wanted rows of its lists if they are long and have no tiles, and the length that is long.
const SEARCH: f64 = 9000.0;
const LONG: f64 = 256.0;
/// The time for a block of a list, for a tile of a list, for the blocks of one on the outline, and to test the blocks of a
/// tile on the outline.
const BLOCK: f64 = 1.2;
const TILE: f64 = 1.5;
const TILE_OF_LIST: f64 = 60.0;
const TILE_OF_PAGE: f64 = 60.0;
/// The time to find a list of positions and its root.
const LIST: f64 = 220.0;
/// The time to look through a crossing leaf of about 32 positions and the nodes above it.
const LEAF: f64 = 120.0;

/// Whether lists are cheaper than a scan for the keys of `runs` under `footprint`.
///
/// # Errors
/// If the lists are damaged.
pub(super) fn lists_are_cheaper(
    tables: &BinTables<'_>,
    footprint: &Parallelogram,
    runs: &KeyRuns,
) -> Result<bool, QueryError> {
    let TexelBox { low, high } = footprint.bounds();
    let (width, height) = (high[0] - low[0], high[1] - low[1]);
    // About the length of the outline, of a needle twice its length.
    let outline = 2.0 * width.max(height) + 2.0 * footprint.area() / width.max(height).max(1.0);
    let texels = footprint.area() + outline;
    if texels < SCAN_BELOW_TEXELS || matches!(tables.inverse, Inverse::None) {
        return Ok(false);
    }
    let shape = map_shape(tables);
    let map_texels = f64::from(shape.width) * f64::from(shape.height);
    if texels > map_texels {
        // Lists count tiles that lie wholly inside without looking at a texel.
        return Ok(true);
    }
    let reach = Reach {
        texels,
        height,
        outline,
        map_texels,
    };
    let [lists, scan] = match &tables.inverse {
        Inverse::Tiles(lists) => reach.block_lists(lists, runs)?,
        Inverse::Forest(inverse) => reach.forest(tables, inverse, runs)?,
        Inverse::None => [f64::INFINITY, 0.0],
    };
    Ok(lists < scan)
}

/// What a footprint meets.
struct Reach {
    texels: f64,
    height: f64,
    /// Length of the outline in texels.
    outline: f64,
    map_texels: f64,
}

impl Reach {
    /// How many squares of `side` texels the outline crosses.
    fn crossed(&self, side: u32) -> f64 {
        1.3 * self.outline / f64::from(side) + 1.0
    }

    fn scan(&self, dense: usize) -> f64 {
        let pick = |times: [f64; 2]| times.into_iter().nth(dense).unwrap_or_default();
        SCAN + pick(SCAN_TEXEL) * self.texels + pick(CROSSING) * self.crossed(BLOCK_SIDE)
    }

    /// The times to traverse the block lists of `runs`, by their lengths on the first page, and to scan.
    fn block_lists(&self, lists: &BlockLists<'_>, runs: &KeyRuns) -> Result<[f64; 2], QueryError> {
        let of_page = lists.lists(0)?;
        let (mut blocks, mut tiles, mut count) = (0.0, 0.0, 0.0);
        for (start, keys, _) in runs.iter() {
            let numbers = lists.lists_of_keys(of_page.clone(), start..start.saturating_add(keys));
            count += f64::from(numbers.end - numbers.start);
            let (more_blocks, more_tiles) = lists.sizes(numbers);
            blocks += f64::from(more_blocks);
            tiles += f64::from(more_tiles);
        }
        let side = f64::from(PAGE_SIDE);
        let page = (side * side).min(self.map_texels);
        let share =
            |number: f64, side: u32| (number * f64::from(side) * f64::from(side) / page).min(1.0);
        // Lists are cut down to the rows of tiles that the footprint meets; where they have tiles, to those it crosses.
        let rows = ((self.height + f64::from(TILE_SIDE)) / side).min(1.0);
        let tiles_crossed = self.crossed(TILE_SIDE);
        let crossed = share(tiles_crossed, TILE_SIDE).min(rows);
        let dense = usize::from(tiles > 0.0);
        let mut time = WINDOW + TILE_OF_PAGE * tiles_crossed;
        if dense > 0 {
            time += TILE * tiles * rows + TILE_OF_LIST * tiles * crossed + BLOCK * blocks * crossed;
        } else {
            time += BLOCK * blocks * rows;
            if blocks > LONG * count {
                time += SEARCH;
            }
        }
        let on_outline = self.crossed(BLOCK_SIDE);
        let wanted = (blocks * share(on_outline, BLOCK_SIDE)).min(on_outline);
        let crossing = CROSSING.into_iter().nth(dense).unwrap_or_default();
        Ok([time + (LISTED + crossing) * wanted, self.scan(dense)])
    }

    /// The times to traverse the lists of positions of `runs` and to scan: leaves of a list of `n` of the map's `M` texels are
    /// `√(32 M / n)` texels wide, so that the outline crosses about `outline √(n / 32 M)` of them.
    fn forest(
        &self,
        tables: &BinTables<'_>,
        inverse: &InverseBinMap<'_>,
        runs: &KeyRuns,
    ) -> Result<[f64; 2], QueryError> {
        let lists = Lists::new(tables, inverse, runs)?;
        let time = lists
            .lengths()
            .map(|length| {
                let leaves =
                    self.outline * libm::sqrt(f64::from(length) / (32.0 * self.map_texels));
                LIST + LEAF * leaves
            })
            .sum();
        Ok([time, self.scan(0)])
    }
}
