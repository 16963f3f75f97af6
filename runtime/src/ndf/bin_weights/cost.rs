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
/// A scan's time for a texel.
const SCAN_TEXEL: f64 = 0.85;
/// A scan's time for a block on the outline.
const SCAN_CROSSING: f64 = 60.0;
/// The time to find a window's block lists.
const WINDOW: f64 = 1500.0;
/// The time to test a block or a tile of a list.
const ENTRY: f64 = 1.5;
/// The time to fetch and scan a listed block on the outline.
const CROSSING: f64 = 130.0;
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
    let blocks = outline / f64::from(BLOCK_SIDE) * 1.3;
    let scan = SCAN_TEXEL * texels + SCAN_CROSSING * blocks;
    let reach = Reach {
        height,
        outline,
        blocks,
        map_texels,
    };
    let lists = match &tables.inverse {
        Inverse::Tiles(lists) => reach.block_lists(lists, runs)?,
        Inverse::Forest(inverse) => reach.forest(tables, inverse, runs)?,
        Inverse::None => f64::INFINITY,
    };
    Ok(lists < scan)
}

/// What a footprint meets.
struct Reach {
    height: f64,
    /// Length of the outline in texels.
    outline: f64,
    /// Blocks on the outline.
    blocks: f64,
    map_texels: f64,
}

impl Reach {
    /// The time to traverse the block lists of `runs`, by their lengths on the first page.
    fn block_lists(&self, lists: &BlockLists<'_>, runs: &KeyRuns) -> Result<f64, QueryError> {
        let of_page = lists.lists(0)?;
        let (mut blocks, mut tiles) = (0.0, 0.0);
        for (start, count, _) in runs.iter() {
            let numbers = lists.lists_of_keys(of_page.clone(), start..start.saturating_add(count));
            let (more_blocks, more_tiles) = lists.sizes(numbers);
            blocks += f64::from(more_blocks);
            tiles += f64::from(more_tiles);
        }
        let side = f64::from(PAGE_SIDE);
        let page = (side * side).min(self.map_texels);
        // Lists are cut down to the rows of tiles that the footprint meets; where they have tiles, to those it crosses.
        let rows = ((self.height + f64::from(TILE_SIDE)) / side).min(1.0);
        let crossed = (self.outline * f64::from(TILE_SIDE) * 1.3 / page).min(1.0);
        let tested = if tiles > 0.0 {
            tiles * rows + blocks * crossed.min(rows)
        } else {
            blocks * rows
        };
        let on_outline = f64::from(BLOCK_SIDE * BLOCK_SIDE) * self.blocks / page;
        let crossing = (blocks * on_outline).min(self.blocks);
        Ok(WINDOW + ENTRY * tested + CROSSING * crossing)
    }

    /// The time to traverse the lists of positions of `runs`: leaves of a list of `n` of the map's `M` texels are
    /// `√(32 M / n)` texels wide, so that the outline crosses about `outline √(n / 32 M)` of them.
    fn forest(
        &self,
        tables: &BinTables<'_>,
        inverse: &InverseBinMap<'_>,
        runs: &KeyRuns,
    ) -> Result<f64, QueryError> {
        let lists = Lists::new(tables, inverse, runs)?;
        Ok(lists
            .lengths()
            .map(|length| {
                let leaves =
                    self.outline * libm::sqrt(f64::from(length) / (32.0 * self.map_texels));
                LIST + LEAF * leaves
            })
            .sum())
    }
}
