//! Block lists against lists counted texel by texel.

use glintbake_bake::build::bin_map::{self, BinMap};
use glintbake_bake::build::block_lists::{self, BlockLists};
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{BinGrid, Binning, Wrap};
use glintbake_format::{Container, check};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, sample_map, specular_package};
use glintbake_tests::naive_lists::{self, Blocks};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// Fails unless `lists` say of every page and key what counting says; returns how many lists have tiles.
fn compare(bin_map: &BinMap, lists: &BlockLists, width: u32, height: u32) -> usize {
    let expected = naive_lists::count(bin_map, width, height);
    assert_eq!(lists.pages.len(), expected.len());
    assert_eq!(lists.blocks.len(), lists.counts.len());
    let (mut next_list, mut next_block, mut next_tile) = (0, 0, 0);
    let mut tiled = 0;
    for (page, mut expected) in lists.pages.iter().zip(expected) {
        let first = page.first_list.get() as usize;
        assert_eq!(first, next_list, "pages follow each other");
        next_list += page.list_count.get() as usize;
        let mut previous = None;
        for list in first..next_list {
            let key = match lists.keys.get(list) {
                Some(key) => key.get(),
                None => (list - first) as u32,
            };
            assert!(previous < Some(key), "keys rise");
            previous = Some(key);
            let [start, end] = [lists.starts[list], lists.starts[list + 1]];
            let blocks = start.block.get() as usize..end.block.get() as usize;
            let tiles = start.tile.get() as usize..end.tile.get() as usize;
            assert_eq!((blocks.start, tiles.start), (next_block, next_tile));
            (next_block, next_tile) = (blocks.end, tiles.end);
            let found: Vec<_> = lists.blocks[blocks.clone()]
                .iter()
                .map(|name| name.get())
                .zip(lists.counts[blocks].iter().copied())
                .collect();
            let counted: Blocks = expected.remove(&key).unwrap_or_default();
            let tiles = &lists.tiles[tiles];
            let all_tiles = naive_lists::tiles(&counted);
            let pays = counted.len() >= 128 && counted.len() >= 4 * all_tiles.len();
            assert_eq!(tiles, if pays { &*all_tiles } else { &[] }, "key {key}");
            tiled += usize::from(pays);
            assert_eq!(found, Vec::from_iter(counted), "key {key}");
        }
        assert_eq!(expected, BTreeMap::new(), "no key of the page is missed");
    }
    assert_eq!(
        (next_list, next_block, next_tile),
        (
            lists.starts.len() - 1,
            lists.blocks.len(),
            lists.tiles.len()
        )
    );
    tiled
}

fn grid(side: u32) -> BinGrid {
    BinGrid::new(Binning::DiskGrid, side).expect("in range")
}

fn is_sound(bytes: &[u8]) {
    let container = Container::open(bytes).expect("a fresh package opens");
    check::full(&container, &mut |finding| panic!("{finding}"));
}

/// A map of some random normals in patches of random sizes: lists of every length.
fn patches(width: u32, height: u32, seed: u64) -> NormalMap {
    let mut stream = Stream::new(seed);
    let normals: Vec<_> = (0..12)
        .map(|_| {
            [
                stream.between(-0.7, 0.7) as f32,
                stream.between(-0.7, 0.7) as f32,
            ]
        })
        .collect();
    let size = 1 + (stream.uniform() * 20.0) as u32;
    let texels = (0..height)
        .flat_map(|row| (0..width).map(move |column| (column, row)))
        .map(|(column, row)| {
            let patch = u64::from(column / size * 7919 + row / size);
            let pick = if stream.uniform() < 0.1 {
                stream.uniform()
            } else {
                Stream::new(seed ^ patch).uniform()
            };
            normals[(pick * 12.0) as usize]
        })
        .collect();
    NormalMap::new(width, height, Wrap::Repeat, texels)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn lists_of_small_maps_are_what_counting_finds(
        width in 1_u32..150,
        height in 1_u32..150,
        side in 1_u32..60,
        seed in any::<u64>(),
    ) {
        let map = patches(width, height, seed);
        let bin_map = bin_map::build(&map, grid(side));
        compare(&bin_map, &block_lists::build(&bin_map, width, height), width, height);
    }
}

#[test]
fn lists_of_maps_of_several_pages_are_what_counting_finds() {
    let mut tiled = 0;
    let (mut with_keys, mut without) = (0, 0);
    for (width, height) in [(2100, 40), (33, 4100), (2049, 2051), (2048, 64)] {
        for (map, side) in [
            (sample_map(Kind::Waves, width, height, 3, Wrap::Repeat), 400),
            (patches(width, height, 8), 9),
            (patches(width, height, 9), 200),
        ] {
            let bin_map = bin_map::build(&map, grid(side));
            let lists = block_lists::build(&bin_map, width, height);
            tiled += compare(&bin_map, &lists, width, height);
            if lists.keys.is_empty() {
                without += 1;
            } else {
                with_keys += 1;
            }
        }
    }
    assert!(tiled > 20, "{tiled} lists have tiles");
    assert!(with_keys > 1 && without > 1, "{with_keys}, {without}");
}

#[test]
fn packages_of_block_lists_are_sound() {
    for (width, height) in [(1, 1), (13, 150), (96, 96), (2100, 40), (33, 4100)] {
        let map = sample_map(Kind::Waves, width, height, 3, Wrap::Clamp);
        is_sound(&flake_package(&map, &[0.9, 0.02, 0.001]));
        is_sound(&specular_package(&map, 31));
        is_sound(&naive_lists::package(&map, 0.02));
    }
}
