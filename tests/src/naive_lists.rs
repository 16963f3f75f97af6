//! Block lists as another baker may write them: counted texel by texel, every list with its key and its tiles.
//!
//! Small maps baked by glintbake have neither keys nor tiles; a reader must take both anywhere.

use glintbake_bake::PackagePlan;
use glintbake_bake::build::bin_map::{self, BinMap, Keys};
use glintbake_bake::normals::NormalMap;
use glintbake_format::SectionId;
use glintbake_format::model::{BinGrid, Binning, Filter, Method, disk_grid_resolution};
use glintbake_format::records::{
    BIN_MAP, BLOCKED_BIN_MAP, Bins, INSTANCES, Instance, InverseKind, LIST_BLOCKS, LIST_COUNTS,
    LIST_KEYS, LIST_TILES, LISTS, ListStart, METADATA, OCCUPIED_BINS, PAGES, PageRecord, Structure,
    TileRecord,
};
use glintbake_format::view::KeyLayout;
use std::collections::BTreeMap;
use zerocopy::little_endian::{U16, U32};

/// The blocks of one list, by name, and the texels each has.
pub type Blocks = BTreeMap<u16, u8>;

/// The blocks of each key that is on each page: by number of the page, then by key. One texel at a time, in the
/// specification's words.
pub fn count(bin_map: &BinMap, width: u32, height: u32) -> Vec<BTreeMap<u32, Blocks>> {
    let page_columns = width.div_ceil(2048);
    let mut pages = vec![BTreeMap::new(); (page_columns * height.div_ceil(2048)) as usize];
    for j in 0..height {
        for i in 0..width {
            let page = i / 2048 + page_columns * (j / 2048);
            let (x, y) = (i % 2048 / 8, j % 2048 / 8);
            let name = x % 8 + 8 * (y % 8) + 64 * (x / 8) + 2048 * (y / 8);
            let page: &mut BTreeMap<u32, Blocks> = &mut pages[page as usize];
            let list = page.entry(bin_map.key(i, j)).or_default();
            *list.entry(name as u16).or_default() += 1;
        }
    }
    pages
}

/// The tiles that `blocks` lie in.
pub fn tiles(blocks: &Blocks) -> Vec<TileRecord> {
    let mut tiles: BTreeMap<u16, (u16, u16)> = BTreeMap::new();
    for (place, (name, &texels)) in (0..).zip(blocks) {
        let (_, sum) = tiles.entry(name / 64).or_insert((place, 0));
        *sum += u16::from(texels);
    }
    tiles
        .into_iter()
        .map(|(tile, (first, texels))| TileRecord {
            tile: U16::new(tile),
            first: U16::new(first),
            texels: U16::new(texels),
        })
        .collect()
}

/// The bytes of `map` baked for `flake-bins` at `roughness`: every block list with its key and its tiles.
///
/// # Panics
/// If the roughness has no bins.
pub fn package(map: &NormalMap, roughness: f64) -> Vec<u8> {
    let grid = BinGrid::new(Binning::DiskGrid, disk_grid_resolution(roughness));
    let grid = grid.expect("the roughnesses of fixtures have bins");
    let bin_map = bin_map::build(map, grid);
    let instance = Instance {
        layer: 0,
        number: 1,
        method: Method::FlakeBins,
        wrap: map.wrap(),
        width: map.width(),
        height: map.height(),
        roughness: Some(roughness),
        filter: Filter::Box,
        structure: Structure::Bins(Bins {
            grid,
            inverse: InverseKind::Tiles,
            leaf_size: 0,
            index: bin_map.index,
            key_count: bin_map.key_count,
        }),
    };
    let mut plan = PackagePlan::new([0; 32]);
    plan.add_critical(SectionId::shared(INSTANCES), vec![instance.to_record()]);
    plan.add(SectionId::shared(METADATA), b"{}".to_vec());
    add_lists(&mut plan, &instance, &bin_map);
    if !bin_map.occupied.is_empty() {
        plan.add(instance.section(OCCUPIED_BINS), bin_map.occupied);
    }
    let id = instance.section(match bin_map.layout {
        KeyLayout::Rows { .. } => BIN_MAP,
        KeyLayout::Blocks(_) => BLOCKED_BIN_MAP,
    });
    match bin_map.keys {
        Keys::Narrow(keys) => plan.add(id, keys),
        Keys::Wide(keys) => plan.add(id, keys),
    }
    plan.to_bytes()
}

fn add_lists(plan: &mut PackagePlan, instance: &Instance, bin_map: &BinMap) {
    let (mut pages, mut keys, mut starts) = (Vec::new(), Vec::new(), Vec::new());
    let (mut names, mut counts, mut all_tiles) = (Vec::new(), Vec::new(), Vec::new());
    for page in count(bin_map, instance.width, instance.height) {
        pages.push(PageRecord {
            first_list: U32::new(keys.len() as u32),
            list_count: U32::new(page.len() as u32),
        });
        for (key, blocks) in page {
            keys.push(U32::new(key));
            starts.push(start(&names, &all_tiles));
            all_tiles.extend(tiles(&blocks));
            names.extend(blocks.keys().map(|&name| U16::new(name)));
            counts.extend(blocks.into_values());
        }
    }
    starts.push(start(&names, &all_tiles));
    plan.add(instance.section(PAGES), pages);
    plan.add(instance.section(LIST_KEYS), keys);
    plan.add(instance.section(LISTS), starts);
    plan.add(instance.section(LIST_BLOCKS), names);
    plan.add(instance.section(LIST_COUNTS), counts);
    plan.add(instance.section(LIST_TILES), all_tiles);
}

/// Where a list begins that comes after `names` and `tiles`.
fn start(names: &[U16], tiles: &[TileRecord]) -> ListStart {
    ListStart {
        block: U32::new(names.len() as u32),
        tile: U32::new(tiles.len() as u32),
    }
}
