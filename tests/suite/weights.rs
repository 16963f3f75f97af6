//! Bin weights of the runtime against the oracle's, which clips in another space by other means.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle;
use glintbake_format::model::{BinGrid, Binning, Footprint, Neighbourhood, Wrap};
use glintbake_runtime::ndf::Lookup;
use glintbake_runtime::{FlakeBins, Ndf, Package, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, forest_package, sample_map};
use glintbake_tests::naive_lists;
use glintbake_tests::tolerances::{WEIGHT, WEIGHT_ROUNDING, WEIGHT_SUM};
use std::collections::BTreeMap;

/// Weights of all bins of a coarse grid, gathered window by window.
fn all_weights(ndf: &FlakeBins<'_>, footprint: &Footprint) -> BTreeMap<(u32, u32), f64> {
    let grid = ndf.instance().bins().unwrap().grid;
    let mut weights = BTreeMap::new();
    // Windows of 5 × 5 lie within 7 × 7 without corners, and tile the grid without overlap.
    let centres = || (2..grid.resolution() + 2).step_by(5);
    for (row, column) in centres().flat_map(|row| centres().map(move |column| (row, column))) {
        let column = column.min(grid.resolution() - 1);
        let row = row.min(grid.resolution() - 1);
        let centre = grid.normal_in_bin(column, row, 0.5, 0.5);
        ndf.bin_weights(
            footprint,
            centre,
            Neighbourhood::Bins45,
            &mut |x, y, weight| {
                let previous = weights.insert((x, y), weight);
                assert!(
                    previous.is_none_or(|previous| previous == weight),
                    "two windows disagree about bin ({x}, {y})"
                );
            },
        )
        .expect("the fixture's footprints are in range");
    }
    weights
}

fn flake_bins<'a>(package: &Package<'a>) -> FlakeBins<'a> {
    match package.ndf(1).expect("the fixture has an instance") {
        SurfaceNdf::FlakeBins(ndf) => ndf,
        _ => {
            panic!("the fixture was baked for flake-bins")
        }
    }
}

/// Every way to look weights up: a package, and how it is asked.
fn ways(map: &NormalMap, alpha: f64, leaf_size: u32) -> Vec<(Vec<u8>, Lookup)> {
    let tiles = || flake_package(map, &[alpha]);
    vec![
        (tiles(), Lookup::Lists),
        (tiles(), Lookup::Scan),
        (tiles(), Lookup::Auto),
        (forest_package(map, &[alpha], leaf_size), Lookup::Lists),
    ]
}

/// Largest difference of any bin's weight, and the sum, by every way to look weights up.
fn compare(map: &NormalMap, alpha: f64, leaf_size: u32, footprints: &[Footprint], tolerance: f64) {
    compare_by(
        &ways(map, alpha, leaf_size),
        map,
        alpha,
        footprints,
        tolerance,
    );
}

fn compare_by(
    ways: &[(Vec<u8>, Lookup)],
    map: &NormalMap,
    alpha: f64,
    footprints: &[Footprint],
    tolerance: f64,
) {
    for footprint in footprints {
        let expected = oracle::flake_bins::bin_weights(map, footprint, alpha);
        for (bytes, lookup) in ways {
            let package = Package::open(bytes).expect("a fresh package opens");
            let lookup = *lookup;
            let ndf = flake_bins(&package).with_lookup(lookup);
            let weights = all_weights(&ndf, footprint);
            let sum: f64 = weights.values().sum();
            assert!(
                (sum - 1.0).abs() <= WEIGHT_SUM,
                "weights of {footprint:?} add up to {sum} by {lookup:?}"
            );
            for bin in weights.keys().chain(expected.keys()) {
                let difference =
                    weights.get(bin).unwrap_or(&0.0) - expected.get(bin).unwrap_or(&0.0);
                assert!(
                    difference.abs() <= tolerance,
                    "bin {bin:?} of {footprint:?} is off by {difference:e} by {lookup:?}"
                );
            }
        }
    }
}

#[test]
fn weights_equal_the_oracles_on_every_kind_of_map() {
    for (seed, kind) in (1..).zip([
        Kind::Flakes,
        Kind::Scratches,
        Kind::Brushed,
        Kind::Waves,
        Kind::Leather,
        Kind::Noise,
    ]) {
        for (width, height, wrap) in [
            (64, 64, Wrap::Repeat),
            (37, 61, Wrap::Repeat),
            (53, 32, Wrap::Clamp),
        ] {
            let map = sample_map(kind, width, height, seed, wrap);
            let mut stream = Stream::new(seed);
            let footprints: Vec<_> = [0.01, 0.5, 3.0, 16.0, 100.0]
                .into_iter()
                .flat_map(|texels| [texels; 4])
                .map(|texels| stream.footprint(&map, texels))
                .collect();
            compare(&map, 0.16, 4, &footprints, WEIGHT_ROUNDING);
        }
    }
}

#[test]
fn weights_equal_the_oracles_for_degenerate_and_axis_aligned_footprints() {
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let map = sample_map(Kind::Flakes, 40, 24, 3, wrap);
        let texel = [1.0 / 40.0, 1.0 / 24.0];
        let shapes = [
            // A point, segments along and across, parallel edges, nearly parallel edges, whole texels, a mirrored box.
            ([0.0, 0.0], [0.0, 0.0]),
            ([5.0, 0.0], [0.0, 0.0]),
            ([0.0, 0.0], [0.0, -7.5]),
            ([3.0, 2.0], [0.0, 0.0]),
            ([3.0, 2.0], [1.5, 1.0]),
            ([3.0, 2.0], [-6.0, -4.0]),
            ([3.0, 2.0], [3.0, 2.000_000_1]),
            ([30.0, 0.0], [0.0, 1e-9]),
            ([4.0, 0.0], [0.0, 4.0]),
            ([-4.0, 0.0], [0.0, 4.0]),
            ([40.0, 0.0], [0.0, 24.0]),
            ([120.0, 0.0], [0.0, 48.0]),
        ];
        // On a corner of texels, within a texel, on the tile's corner, far away.
        let centres = [
            [0.25, 0.5],
            [0.313, 0.777],
            [0.0, 0.0],
            [-1e6 + 0.7, 1e6 + 0.1],
        ];
        let footprints: Vec<_> = shapes
            .into_iter()
            .flat_map(|(first, second)| {
                centres.map(|centre| Footprint {
                    centre,
                    edge_1: [first[0] * texel[0], first[1] * texel[1]],
                    edge_2: [second[0] * texel[0], second[1] * texel[1]],
                })
            })
            .collect();
        // Edges that run exactly along a texel border may give the border's measure-zero line to either side once
        // rounding of the sheared edge moves it; such cases are compared on the promise, not on rounding.
        compare(&map, 0.3, 2, &footprints, WEIGHT);
    }
}

#[test]
fn weights_hold_for_every_leaf_size_and_for_maps_of_one_row() {
    for leaf_size in [1, 2, 10, 64, 100_000] {
        let map = sample_map(Kind::Waves, 1, 97, 5, Wrap::Repeat);
        let mut stream = Stream::new(u64::from(leaf_size));
        let footprints = [0.3, 5.0, 40.0].map(|texels| stream.footprint(&map, texels));
        compare(&map, 0.2, leaf_size, &footprints, WEIGHT_ROUNDING);
    }
}

#[test]
fn the_largest_footprint_is_the_maps_average() {
    let map = sample_map(Kind::Flakes, 32, 32, 9, Wrap::Repeat);
    let tiles = Footprint {
        centre: [0.5, 0.5],
        edge_1: [64.0, 0.0],
        edge_2: [0.0, 64.0],
    };
    // A scan would refuse to visit each texel of the border's tiles.
    let ways: Vec<_> = ways(&map, 0.25, 8)
        .into_iter()
        .filter(|(_, lookup)| *lookup != Lookup::Scan)
        .collect();
    compare_by(&ways, &map, 0.25, &[tiles], WEIGHT_ROUNDING);
}

#[test]
fn a_sparse_index_gives_the_same_weights() {
    // 4 096 texels against 23 571² bins: keys are ranks of occupied bins.
    let map = sample_map(Kind::Noise, 64, 64, 2, Wrap::Repeat);
    let alpha = 1e-3;
    let bytes = flake_package(&map, &[alpha]);
    let package = Package::open(&bytes).expect("a fresh package opens");
    let ndf = flake_bins(&package);
    let grid =
        BinGrid::new(Binning::DiskGrid, oracle::flake_bins::resolution(alpha)).expect("in range");
    let mut stream = Stream::new(8);
    for _ in 0..50 {
        let footprint = stream.footprint(&map, 20.0);
        let half_vector = stream.half_vector_near(&map, &footprint, 1e-3);
        let expected = oracle::flake_bins::bin_weights(&map, &footprint, alpha);
        let (column, row) = grid.bin_of(half_vector);
        let mut seen = 0.0;
        ndf.bin_weights(
            &footprint,
            half_vector,
            Neighbourhood::Bins45,
            &mut |x, y, weight| {
                let difference = weight - expected.get(&(x, y)).unwrap_or(&0.0);
                assert!(difference.abs() < WEIGHT_ROUNDING, "bin ({x}, {y})");
                seen += weight;
            },
        )
        .expect("in range");
        let near: f64 = expected
            .iter()
            .filter(|((x, y), _)| {
                let (dx, dy) = (x.abs_diff(column), y.abs_diff(row));
                dx <= 3 && dy <= 3 && dx + dy < 6
            })
            .map(|(_, weight)| weight)
            .sum();
        assert!((seen - near).abs() < WEIGHT_ROUNDING, "no bin is missed");
    }
}

/// A footprint of two perpendicular edges at a random angle, in texels of a map of `width` × `height`.
fn box_at_random(stream: &mut Stream, edges: [f64; 2], width: u32, height: u32) -> Footprint {
    let angle = stream.between(0.0, std::f64::consts::TAU);
    let size = [f64::from(width), f64::from(height)];
    let (cosine, sine) = (angle.cos(), angle.sin());
    Footprint {
        centre: [stream.between(-2.0, 3.0), stream.between(-2.0, 3.0)],
        edge_1: [edges[0] * cosine / size[0], edges[0] * sine / size[1]],
        edge_2: [-edges[1] * sine / size[0], edges[1] * cosine / size[1]],
    }
}

#[test]
fn weights_equal_the_oracles_for_every_size_and_thinness() {
    // From footprints weighed by coverage to slivers clipped in parameter space, and the change between the two.
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let (width, height) = (48, 40);
        let map = sample_map(Kind::Flakes, width, height, 6, wrap);
        let mut stream = Stream::new(12);
        let mut footprints = Vec::new();
        for long in [0.003, 0.05, 0.7, 1.0, 4.0, 20.0, 75.0] {
            for thinness in [1.0, 3.0, 30.0, 300.0, 900.0, 1100.0, 1e4] {
                for _ in 0..3 {
                    let edges = [long, long / thinness];
                    footprints.push(box_at_random(&mut stream, edges, width, height));
                }
            }
        }
        compare(&map, 0.3, 4, &footprints, WEIGHT_ROUNDING);
    }
}

#[test]
fn weights_equal_the_oracles_where_texels_are_counted_by_the_hundred() {
    // Rows of many chunks of keys: narrow keys of a dense and of a sparse index, and wide keys.
    for (side, alpha, texels) in [(300, 0.02, 250.0), (200, 0.002, 150.0), (400, 0.001, 300.0)] {
        for kind in [Kind::Scratches, Kind::Brushed, Kind::Noise] {
            let map = sample_map(kind, side, side, 4, Wrap::Repeat);
            let bytes = flake_package(&map, &[alpha]);
            let package = Package::open(&bytes).expect("a fresh package opens");
            let ndf = flake_bins(&package);
            let grid = ndf.instance().bins().unwrap().grid;
            let mut stream = Stream::new(9);
            for thinness in [1.0, 2.0, 40.0] {
                let footprint = box_at_random(&mut stream, [texels, texels / thinness], side, side);
                let expected = oracle::flake_bins::bin_weights(&map, &footprint, alpha);
                for _ in 0..20 {
                    let half_vector = stream.half_vector_near(&map, &footprint, alpha);
                    let (column, row) = grid.bin_of(half_vector);
                    let near: BTreeMap<_, _> = expected
                        .iter()
                        .filter(|((x, y), _)| {
                            let (dx, dy) = (x.abs_diff(column), y.abs_diff(row));
                            dx <= 3 && dy <= 3 && dx + dy < 6
                        })
                        .collect();
                    for lookup in [Lookup::Lists, Lookup::Scan, Lookup::Auto] {
                        let mut found = 0;
                        ndf.with_lookup(lookup)
                            .bin_weights(
                                &footprint,
                                half_vector,
                                Neighbourhood::Bins45,
                                &mut |x, y, weight| {
                                    let expected = near.get(&(x, y)).map_or(0.0, |weight| **weight);
                                    assert!(
                                        (weight - expected).abs() <= WEIGHT_ROUNDING,
                                        "bin ({x}, {y}) of {footprint:?}: {weight} instead of \
                                         {expected} by {lookup:?}"
                                    );
                                    found += usize::from(expected > WEIGHT_ROUNDING);
                                },
                            )
                            .expect("in range");
                        let present = near.values().filter(|weight| ***weight > WEIGHT_ROUNDING);
                        assert_eq!(found, present.count(), "no bin is missed by {lookup:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn weights_equal_the_oracles_across_the_borders_of_pages() {
    // Three pages in a row, the last of four texels; and two pages, one above the other.
    for (width, height, wrap) in [
        (4100, 72, Wrap::Repeat),
        (4100, 72, Wrap::Clamp),
        (72, 2060, Wrap::Repeat),
    ] {
        let map = sample_map(Kind::Waves, width, height, 3, wrap);
        let size = [f64::from(width), f64::from(height)];
        let long = size[0].max(size[1]);
        let mut stream = Stream::new(21);
        let mut footprints = vec![
            // Along all pages; half a map and more, beyond its border.
            box_of([0.5, 0.5], [0.0, 1.0], [0.97 * long, 40.3], size),
            box_of([0.95, 0.1], [0.02, 1.0], [0.6 * long, 21.0], size),
        ];
        for border in [0.0, 2048.0, 4096.0, long] {
            let along = border.min(long) / long;
            for edge in [0.7, 9.0, 33.3, 70.0] {
                let mut centre = [along, stream.uniform()];
                if height > width {
                    centre.swap(0, 1);
                }
                let angle = [stream.between(-1.0, 1.0), stream.between(-1.0, 1.0)];
                footprints.push(box_of(centre, angle, [edge, edge * 0.8], size));
            }
        }
        let naive = [(naive_lists::package(&map, 0.2), Lookup::Lists)];
        compare(&map, 0.2, 8, &footprints, WEIGHT_ROUNDING);
        compare_by(&naive, &map, 0.2, &footprints, WEIGHT_ROUNDING);
    }
}

/// A box around `centre` with `edges` in texels of a map of `size`, the first along (`cosine`, `sine`) made to length 1;
/// (0, 1) is along the map's longer side.
fn box_of(
    centre: [f64; 2],
    [sine, cosine]: [f64; 2],
    edges: [f64; 2],
    size: [f64; 2],
) -> Footprint {
    let length = sine.hypot(cosine);
    let (mut cosine, mut sine) = (cosine / length, sine / length);
    if size[1] > size[0] {
        (cosine, sine) = (-sine, cosine);
    }
    Footprint {
        centre,
        edge_1: [edges[0] * cosine / size[0], edges[0] * sine / size[1]],
        edge_2: [-edges[1] * sine / size[0], edges[1] * cosine / size[1]],
    }
}
