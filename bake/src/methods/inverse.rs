//! How the texels of a bin are to be found: the choice by cost, and the sections of what was chosen.

use super::Bake;
use crate::build::bin_map::BinMap;
use crate::build::block_lists::{self, BlockLists};
use crate::build::{forest, inverse_bin_map};
use crate::recipe::MethodRecipe;
use glintbake_format::model::{BLOCK_SIDE, BinGrid, TILE_SIDE};
use glintbake_format::records::{
    FOREST, INDEX, INVERSE_BIN_MAP, Instance, InverseKind, LIST_BLOCKS, LIST_COUNTS, LIST_KEYS,
    LIST_TILES, LISTS, PAGES,
};

/// What was chosen, and why.
pub(super) struct Choice {
    pub kind: InverseKind,
    /// For people; in the metadata.
    pub reason: String,
    /// The block lists, if they have been built to be measured or used.
    lists: Option<BlockLists>,
}

/// Up to this number of texels a scan of the whole map takes no longer than finding lists.
const SCANNED_TEXELS: u64 = 4096;
/// How much larger than block lists a forest may be that is quicker.
const LARGER: f64 = 1.25;
/// Share of a square grid's bins that lie on the disk.
const DISK: f64 = std::f64::consts::FRAC_PI_4;
/// Bins of a query's window.
const WINDOW: f64 = 45.0;

/// The choice for `bin_map`, the one `recipe` names or else the one that costs least on this map.
///
/// Sizes are measured, times estimated from the lengths of the map's own lists by what the runtime takes for a list, a
/// block, a leaf and so on (`cargo bench -p glintbake-tests --bench weights`). Nothing is timed: the same map gets the
/// same package on any machine.
pub(super) fn choose(
    bin_map: &BinMap,
    grid: BinGrid,
    recipe: &MethodRecipe,
    size: [u32; 2],
) -> Choice {
    let [width, height] = size;
    let texels = u64::from(width) * u64::from(height);
    let build = || block_lists::build(bin_map, width, height);
    if let Some(kind) = recipe.inverse {
        return Choice {
            kind,
            reason: "asked for".to_owned(),
            lists: (kind == InverseKind::Tiles).then(build),
        };
    }
    if texels <= SCANNED_TEXELS {
        return Choice {
            kind: InverseKind::None,
            reason: format!("a scan of all {texels} texels takes no longer than finding lists"),
            lists: None,
        };
    }
    let lists = build();
    let lengths = Lengths::of(&lists, grid, texels);
    let by_tiles = lengths.tiles_microseconds();
    let by_forest = lengths.forest_microseconds(recipe.leaf_size);
    let tiles_bytes = lists.bytes() as f64 / texels as f64;
    let forest_bytes = 4.0
        + 32.0 / f64::from(recipe.leaf_size)
        + 4.0 * f64::from(bin_map.key_count) / texels as f64;
    let kind = if by_forest < by_tiles && forest_bytes <= LARGER * tiles_bytes {
        InverseKind::Forest
    } else {
        InverseKind::Tiles
    };
    Choice {
        kind,
        reason: format!(
            "tile lists take {tiles_bytes:.2} bytes a texel and about {by_tiles:.0} us for a quarter of the map, a \
             forest {forest_bytes:.2} and {by_forest:.0}"
        ),
        lists: (kind == InverseKind::Tiles).then_some(lists),
    }
}

/// Lengths of lists as a query meets them, whose half vector is drawn from the map: means over texels.
struct Lengths {
    texels: f64,
    /// Share of the window's bins that have a list.
    present: f64,
    /// Square root of the number of texels of a list.
    root: f64,
    /// Blocks of a list without tiles.
    blocks: f64,
    /// Blocks and tiles of a list with tiles.
    tiled_blocks: f64,
    tiles: f64,
}

impl Lengths {
    fn of(lists: &BlockLists, grid: BinGrid, texels: u64) -> Self {
        let mut lengths = Self {
            texels: texels as f64,
            present: 0.0,
            root: 0.0,
            blocks: 0.0,
            tiled_blocks: 0.0,
            tiles: 0.0,
        };
        let mut weight = 0.0;
        for ends in lists.starts.windows(2) {
            let blocks = ends[0].block.get() as usize..ends[1].block.get() as usize;
            let tiles = f64::from(ends[1].tile.get() - ends[0].tile.get());
            let count: u64 = lists.counts[blocks.clone()]
                .iter()
                .map(|&count| u64::from(count))
                .sum();
            // Lists are met as often as they have texels.
            let count = count as f64;
            weight += count;
            lengths.root += count * count.sqrt();
            if tiles > 0.0 {
                lengths.tiled_blocks += count * blocks.len() as f64;
                lengths.tiles += count * tiles;
            } else {
                lengths.blocks += count * blocks.len() as f64;
            }
            lengths.present += f64::from(u8::from(!blocks.is_empty()));
        }
        for sum in [
            &mut lengths.root,
            &mut lengths.blocks,
            &mut lengths.tiled_blocks,
            &mut lengths.tiles,
        ] {
            *sum /= weight.max(1.0);
        }
        lengths.present = (lengths.present / (DISK * f64::from(grid.count()))).min(1.0);
        lengths
    }

    /// Length of the outline of a square of a quarter of the map, in texels, turned as most are.
    fn outline(&self) -> f64 {
        4.0 * (self.texels / 4.0).sqrt() * 1.27
    }

    /// Lists a query finds.
    fn lists(&self) -> f64 {
        (WINDOW * self.present).max(1.0)
    }

    fn tiles_microseconds(&self) -> f64 {
        let crossed = |side: u32| self.outline() / f64::from(side);
        let share = |side: u32| (crossed(side) * f64::from(side * side) / self.texels).min(1.0);
        let listed = self.lists() * (self.blocks + self.tiled_blocks) * share(BLOCK_SIDE);
        3.0 + 0.06 * crossed(TILE_SIDE)
            + self.lists()
                * (0.0007 * self.blocks
                    + self.tiles * (0.0009 + 0.06 * share(TILE_SIDE))
                    + 0.0012 * self.tiled_blocks * share(TILE_SIDE))
            + 0.2 * listed.min(crossed(BLOCK_SIDE))
    }

    fn forest_microseconds(&self, leaf_size: u32) -> f64 {
        let leaves = self.outline() * self.root / (f64::from(leaf_size) * self.texels).sqrt();
        self.lists() * (0.22 + 0.12 * leaves)
    }
}

/// Adds what finds the texels of a bin to the package.
pub(super) fn add(
    choice: Choice,
    bin_map: &BinMap,
    instance: &Instance,
    leaf_size: u32,
    bake: &mut Bake<'_>,
) {
    match choice.kind {
        InverseKind::Forest => {
            let inverse = inverse_bin_map::build(bin_map, instance.width, instance.height);
            match forest::build(&inverse, leaf_size) {
                Some(nodes) => bake.plan.add(instance.section(FOREST), nodes),
                None => bake.leave_out(instance, "FRST", "no bin holds more texels than a leaf"),
            }
            bake.plan.add(instance.section(INDEX), inverse.offsets);
            bake.plan
                .add(instance.section(INVERSE_BIN_MAP), inverse.positions);
        }
        InverseKind::Tiles => {
            let lists = choice
                .lists
                .unwrap_or_else(|| block_lists::build(bin_map, instance.width, instance.height));
            bake.plan.add(instance.section(PAGES), lists.pages);
            bake.plan.add(instance.section(LISTS), lists.starts);
            bake.plan.add(instance.section(LIST_BLOCKS), lists.blocks);
            bake.plan.add(instance.section(LIST_COUNTS), lists.counts);
            if lists.keys.is_empty() {
                let reason = "a list for every key of every page is hardly larger than naming keys";
                bake.leave_out(instance, "LKEY", reason);
            } else {
                bake.plan.add(instance.section(LIST_KEYS), lists.keys);
            }
            if lists.tiles.is_empty() {
                bake.leave_out(instance, "LTIL", "no list is long and dense enough");
            } else {
                bake.plan.add(instance.section(LIST_TILES), lists.tiles);
            }
        }
        InverseKind::None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::bin_map;
    use crate::normals::NormalMap;
    use glintbake_format::model::{Binning, Method, Wrap, disk_grid_resolution};

    /// The choice for a map of `side` × `side` texels in cells of `cell` texels a side, each with a normal of its own.
    fn choice(side: u32, cell: u32, alpha: f64) -> Choice {
        let scattered =
            |number: u32| f64::from(number.wrapping_mul(2_654_435_761)) / 4_294_967_296.0;
        let texels = (0..side * side)
            .map(|texel| {
                let (column, row) = (texel % side / cell, texel / side / cell);
                let number = row * side + column + 1;
                let radius = 0.5 * scattered(number).sqrt();
                let (sine, cosine) = (std::f64::consts::TAU * scattered(number * 7 + 1)).sin_cos();
                [(radius * cosine) as f32, (radius * sine) as f32]
            })
            .collect();
        let map = NormalMap::new(side, side, Wrap::Repeat, texels);
        let grid = BinGrid::new(Binning::DiskGrid, disk_grid_resolution(alpha)).unwrap();
        let recipe = MethodRecipe::new(Method::FlakeBins, &[alpha]);
        choose(&bin_map::build(&map, grid), grid, &recipe, [side, side])
    }

    #[test]
    fn coherent_maps_get_lists_incoherent_ones_a_forest_and_small_ones_neither() {
        assert_eq!(choice(64, 4, 0.01).kind, InverseKind::None);
        assert_eq!(choice(512, 6, 0.01).kind, InverseKind::Tiles);
        // Every texel is alone in its bin: a name for each key costs more than a position.
        assert_eq!(choice(512, 1, 1e-4).kind, InverseKind::Forest);
    }
}
