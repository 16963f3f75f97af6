//! The baselines of the contest against the oracle, so that nobody is measured against wrong numbers.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle;
use glintbake_cli::measure::baselines::paper_forest::{
    LEAF_SIZE, PaperForest, PaperLookup, Traversal,
};
use glintbake_cli::measure::baselines::plain_scan::PlainScan;
use glintbake_format::model::{BinGrid, Binning, Footprint, HalfVector, Neighbourhood, Wrap};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, sample_map};
use glintbake_tests::tolerances::WEIGHT;
use std::collections::BTreeMap;

/// A way to the weights of the 45 bins around a half vector.
type Lookup<'l> = &'l mut dyn FnMut(&Footprint, HalfVector, &mut dyn FnMut(u32, u32, f64));

/// Compares the weights of the bins around some half vectors with the oracle's; returns how many were not zero.
fn compare(
    name: &str,
    lookup: Lookup<'_>,
    map: &NormalMap,
    alpha: f64,
    footprint: &Footprint,
    stream: &mut Stream,
) -> usize {
    let expected = oracle::flake_bins::bin_weights(map, footprint, alpha);
    let side = oracle::flake_bins::resolution(alpha);
    let grid = BinGrid::new(Binning::DiskGrid, side).expect("in range");
    let mut lit = 0;
    for corner in [None, None, None, Some([-1.0, 0.1]), Some([0.7, 0.7])] {
        let half_vector = match corner {
            Some([s, t]) => HalfVector { s, t },
            None => stream.half_vector_near(map, footprint, 2.0 * alpha),
        };
        let (column, row) = grid.bin_of(half_vector);
        let mut near: BTreeMap<_, _> = expected
            .iter()
            .filter(|((x, y), _)| {
                let (dx, dy) = (x.abs_diff(column), y.abs_diff(row));
                dx <= 3 && dy <= 3 && dx + dy < 6
            })
            .collect();
        lookup(footprint, half_vector, &mut |x, y, weight| {
            let expected = near.remove(&(x, y)).copied().unwrap_or_default();
            assert!(
                (weight - expected).abs() <= WEIGHT,
                "{name}: bin ({x}, {y}) of {footprint:?}: {weight} instead of {expected}"
            );
            lit += 1;
        });
        for (bin, weight) in near {
            assert!(
                *weight <= WEIGHT,
                "{name}: bin {bin:?} of {footprint:?} is missed"
            );
        }
    }
    lit
}

/// Compares every baseline on `map`, the paper's with leaves of `leaf_size`; returns how many weights were not zero.
fn compare_all(
    map: &NormalMap,
    alpha: f64,
    leaf_size: u32,
    footprints: &[Footprint],
    stream: &mut Stream,
) -> usize {
    let side = oracle::flake_bins::resolution(alpha);
    let grid = BinGrid::new(Binning::DiskGrid, side).expect("in range");
    let forest = PaperForest::new(map, grid, leaf_size);
    let mut together = PaperLookup::new(&forest, Traversal::Together);
    let mut one_by_one = PaperLookup::new(&forest, Traversal::OneByOne);
    let scan = PlainScan::new(map, grid);
    let bins = Neighbourhood::Bins45;
    let mut lit = 0;
    for footprint in footprints {
        let lookups: [(&str, Lookup<'_>); 3] = [
            ("together", &mut |footprint, h, visit| {
                together.bin_weights(footprint, h, bins, visit);
            }),
            ("one by one", &mut |footprint, h, visit| {
                one_by_one.bin_weights(footprint, h, bins, visit);
            }),
            ("scan", &mut |footprint, h, visit| {
                scan.bin_weights(footprint, h, bins, visit);
            }),
        ];
        for (name, lookup) in lookups {
            lit += compare(name, lookup, map, alpha, footprint, stream);
        }
    }
    lit
}

#[test]
fn baselines_equal_the_oracle_on_every_kind_of_map_and_size_of_footprint() {
    let mut lit = 0;
    for (seed, kind) in (1..).zip([Kind::Flakes, Kind::Waves, Kind::Scratches, Kind::Noise]) {
        for (width, height) in [(128, 128), (97, 61), (1, 70), (90, 1)] {
            let map = sample_map(kind, width, height, seed, Wrap::Repeat);
            let mut stream = Stream::new(seed);
            let footprints =
                [0.02, 0.6, 4.0, 11.0, 33.0, 90.0, 260.0].map(|size| stream.footprint(&map, size));
            for (alpha, leaf_size) in [(0.3, LEAF_SIZE), (0.05, 1), (0.05, LEAF_SIZE)] {
                lit += compare_all(&map, alpha, leaf_size, &footprints, &mut stream);
            }
        }
    }
    assert!(lit > 20_000, "only {lit} weights were not zero");
}

#[test]
fn baselines_equal_the_oracle_on_fine_grids_of_wide_keys() {
    // 471 and 2 358 bins a side.
    for alpha in [0.005, 0.001] {
        let map = sample_map(Kind::Flakes, 200, 200, 3, Wrap::Repeat);
        let mut stream = Stream::new(5);
        let footprints = [3.0, 40.0, 150.0].map(|texels| stream.footprint(&map, texels));
        assert!(compare_all(&map, alpha, LEAF_SIZE, &footprints, &mut stream) > 20);
    }
}

#[test]
fn baselines_equal_the_oracle_for_boxes_along_the_rows() {
    let map = sample_map(Kind::Noise, 64, 48, 3, Wrap::Repeat);
    let mut stream = Stream::new(2);
    let mut footprints = Vec::new();
    for edge in [0.5, 1.0, 8.0, 64.0, 100.0] {
        for centre in [[0.5, 0.5], [0.0, 0.0], [0.3, 0.7]] {
            let square = Footprint::square(centre, edge, 64, 48);
            footprints.push(square);
            // Mirrored, and turned by 90 degrees.
            footprints.push(Footprint {
                edge_1: square.edge_1.map(|x| -x),
                ..square
            });
            footprints.push(Footprint {
                edge_1: square.edge_2,
                edge_2: square.edge_1,
                ..square
            });
        }
    }
    assert!(compare_all(&map, 0.3, LEAF_SIZE, &footprints, &mut stream) > 2_000);
}
