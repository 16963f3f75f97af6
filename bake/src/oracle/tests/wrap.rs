//! How weights fold over the border of the map.

use super::{Random, by_texel, checked_weights, difference, flat_map, in_texels};
use crate::oracle::box_weights;
use glintbake_format::model::{Footprint, Wrap};
use std::collections::BTreeMap;

#[test]
fn repeating_is_the_same_as_a_tiled_copy() {
    let (width, height) = (5, 3);
    let map = flat_map(width, height, Wrap::Repeat);
    let tiled = flat_map(3 * width, 3 * height, Wrap::Clamp);
    let mut random = Random(21);
    for _ in 0..40 {
        let centre = [random.between(0.0, 5.0), random.between(0.0, 3.0)];
        let (edge_1, edge_2) = (random.vector(3.0), random.vector(2.5));
        let weights = checked_weights(&map, &in_texels(&map, centre, edge_1, edge_2));
        let in_copy = [centre[0] + f64::from(width), centre[1] + f64::from(height)];
        let mut folded = BTreeMap::new();
        for ((column, row), weight) in
            checked_weights(&tiled, &in_texels(&tiled, in_copy, edge_1, edge_2))
        {
            *folded.entry((column % width, row % height)).or_insert(0.0) += weight;
        }
        // The copy's coordinates are thirds, rounded.
        assert!(difference(&weights, &folded) < 1e-14);
    }
}

#[test]
fn clamping_is_the_same_as_a_padded_copy() {
    let (width, height, padding) = (4, 3, 6);
    let map = flat_map(width, height, Wrap::Clamp);
    let padded = flat_map(width + 2 * padding, height + 2 * padding, Wrap::Repeat);
    let mut random = Random(22);
    for _ in 0..40 {
        let centre = [random.between(-3.0, 7.0), random.between(-3.0, 6.0)];
        let (edge_1, edge_2) = (random.vector(2.5), random.vector(1.5));
        let weights = checked_weights(&map, &in_texels(&map, centre, edge_1, edge_2));
        let in_copy = centre.map(|x| x + f64::from(padding));
        let mut folded = BTreeMap::new();
        for ((column, row), weight) in
            checked_weights(&padded, &in_texels(&padded, in_copy, edge_1, edge_2))
        {
            let source = |k: u32, size: u32| k.saturating_sub(padding).min(size - 1);
            *folded
                .entry((source(column, width), source(row, height)))
                .or_insert(0.0) += weight;
        }
        assert!(difference(&weights, &folded) < 1e-14);
    }
}

#[test]
fn far_beyond_a_clamped_map_only_its_corner_counts() {
    let map = flat_map(4, 3, Wrap::Clamp);
    for (far, texel) in [
        ([1e6, 1e6], (3, 2)),
        ([-1e6, 1e300], (0, 2)),
        ([-1e300, -7.0], (0, 0)),
    ] {
        for edge in [0.0, 0.1, 3.0] {
            let footprint = Footprint {
                centre: far,
                edge_1: [edge, 0.2 * edge],
                edge_2: [-0.3 * edge, edge],
            };
            assert_eq!(
                checked_weights(&map, &footprint),
                BTreeMap::from([(texel, 1.0)])
            );
        }
    }
}

#[test]
fn a_clamped_footprint_far_larger_than_the_map_falls_to_its_border() {
    // 100 × 100 tiles around a map of 2 × 2 texels: the border u = 1/2 halves them.
    let map = flat_map(2, 2, Wrap::Clamp);
    let footprint = Footprint {
        centre: [0.5, 0.5 + 25.0],
        edge_1: [100.0, 0.0],
        edge_2: [0.0, 100.0],
    };
    let expected = BTreeMap::from([
        ((0, 0), 0.125),
        ((1, 0), 0.125),
        ((0, 1), 0.375),
        ((1, 1), 0.375),
    ]);
    assert!(difference(&checked_weights(&map, &footprint), &expected) < 1e-16);
}

#[test]
fn whole_tiles_away_nothing_changes() {
    let map = flat_map(12, 10, Wrap::Repeat);
    let here = Footprint {
        centre: [0.312_5 + 1.0 / 1024.0, 0.75],
        edge_1: [0.37, -0.11],
        edge_2: [0.013, 0.029],
    };
    let weights = by_texel(&box_weights(&map, &here));
    for tiles in [[1.0, -1.0], [-1e6, 1e6], [1048576.0, -3.0]] {
        let there = Footprint {
            centre: [here.centre[0] + tiles[0], here.centre[1] + tiles[1]],
            ..here
        };
        let error = difference(&by_texel(&box_weights(&map, &there)), &weights);
        assert!(error < 1e-15, "{error} at {tiles:?}");
    }
}

#[test]
fn whole_tiles_weigh_every_texel_alike() {
    let map = flat_map(6, 9, Wrap::Repeat);
    for tiles in [1.0, 3.0, 64.0] {
        // A sheared cover of whole tiles covers each texel as often, wherever it stands.
        let footprint = Footprint {
            centre: [0.217, -3.4],
            edge_1: [tiles, 0.0],
            edge_2: [5.0, tiles],
        };
        let weights = checked_weights(&map, &footprint);
        assert_eq!(weights.len(), 54);
        for weight in weights.values() {
            assert!((weight - 1.0 / 54.0).abs() < 1e-16, "{weight}");
        }
    }
}

#[test]
fn one_texel_takes_everything() {
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let map = flat_map(1, 1, wrap);
        for size in [0.0, 1e-4, 0.7, 13.3] {
            let footprint = in_texels(&map, [0.3, -5.6], [size, 0.4 * size], [0.1 * size, -size]);
            let weights = checked_weights(&map, &footprint);
            assert!((weights[&(0, 0)] - 1.0).abs() < 1e-15, "{weights:?}");
        }
    }
}
