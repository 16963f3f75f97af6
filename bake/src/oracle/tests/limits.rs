//! Footprints that lose their area, their length, or their proportions.

use super::super::segment::trapezoid_below;
use super::{Random, checked_weights, difference, flat_map, in_texels};
use crate::normals::NormalMap;
use glintbake_format::model::{Footprint, Wrap};
use std::collections::BTreeMap;

#[test]
fn a_footprint_without_edges_is_the_texel_at_its_centre() {
    let map = flat_map(8, 4, Wrap::Repeat);
    for (centre, texel) in [
        ([3.5, 2.25], (3, 2)),
        ([3.0, 2.0], (3, 2)),
        ([-0.25, -4.0], (7, 0)),
        ([-1e-30, 4e-30], (7, 0)),
        ([8.0, 3.999_999], (0, 3)),
    ] {
        let weights = checked_weights(&map, &in_texels(&map, centre, [0.0; 2], [0.0; 2]));
        assert_eq!(weights, BTreeMap::from([(texel, 1.0)]), "at {centre:?}");
    }
}

#[test]
fn a_vanished_edge_leaves_a_uniform_segment() {
    let map = flat_map(8, 4, Wrap::Repeat);
    // From (1.5, 1.25) to (4.5, 2.75): slope 1/2, so v = 2 is crossed at u = 3, with the border u = 3.
    let expected = BTreeMap::from([
        ((1, 1), 0.5 / 3.0),
        ((2, 1), 1.0 / 3.0),
        ((3, 2), 1.0 / 3.0),
        ((4, 2), 0.5 / 3.0),
    ]);
    for (edge_1, edge_2) in [([3.0, 1.5], [0.0; 2]), ([0.0; 2], [-3.0, -1.5])] {
        let weights = checked_weights(&map, &in_texels(&map, [3.0, 2.0], edge_1, edge_2));
        assert!(difference(&weights, &expected) < 1e-15, "{weights:?}");
    }
}

#[test]
fn parallel_edges_leave_a_trapezoid() {
    let map = flat_map(8, 4, Wrap::Repeat);
    // Steps of 3 and of 1 texel: full density 1/3 on the middle two texels, a ramp of one texel at either end.
    let sixth = 1.0 / 6.0;
    let expected = BTreeMap::from([
        ((2, 1), sixth),
        ((3, 1), 2.0 * sixth),
        ((4, 1), 2.0 * sixth),
        ((5, 1), sixth),
    ]);
    for (edge_1, edge_2) in [
        ([3.0, 0.0], [1.0, 0.0]),
        ([-1.0, 0.0], [3.0, 0.0]),
        ([1.0, 0.0], [-3.0, 0.0]),
    ] {
        let weights = checked_weights(&map, &in_texels(&map, [4.0, 1.5], edge_1, edge_2));
        assert!(difference(&weights, &expected) < 1e-15, "{weights:?}");
    }
    // Two equal steps make a triangle: 1/8, 3/8, 3/8, 1/8 along a diagonal.
    let diagonal = in_texels(&map, [4.0, 2.0], [2.0, 2.0], [2.0, 2.0]);
    let weights = checked_weights(&map, &diagonal);
    for (texel, eighths) in [((2, 0), 1.0), ((3, 1), 3.0), ((4, 2), 3.0), ((5, 3), 1.0)] {
        assert!(
            (weights[&texel] - eighths / 8.0).abs() < 1e-15,
            "{weights:?}"
        );
    }
}

#[test]
fn the_trapezoid_has_the_moments_of_two_uniform_steps() {
    for shorter in [0.0, 1e-12, 0.1, 0.3, 0.5] {
        // Variance of the sum: ((1 - l)² + l²) / 12, by parts from the distribution function.
        let steps = 20_000;
        let width = 1.0 / f64::from(steps);
        let variance: f64 = (0..steps)
            .map(|i| {
                let x = (f64::from(i) + 0.5) * width - 0.5;
                let above = if x > 0.0 { 1.0 } else { 0.0 };
                2.0 * x * (above - trapezoid_below(x, shorter)) * width
            })
            .sum();
        let longer = 1.0 - shorter;
        let expected = (longer * longer + shorter * shorter) / 12.0;
        assert!((variance - expected).abs() < 1e-8, "{variance} {expected}");
        assert_eq!(trapezoid_below(-0.5, shorter), 0.0);
        assert_eq!(trapezoid_below(0.5, shorter), 1.0);
    }
}

/// The change of weights when `edge_2` is replaced by a multiple of the first edge plus `across` texels.
fn change_from_segment(map: &NormalMap, edge_1: [f64; 2], share: f64, across: [f64; 2]) -> f64 {
    let parallel = edge_1.map(|x| share * x);
    let tilted = [parallel[0] + across[0], parallel[1] + across[1]];
    let centre = [3.3, 1.7];
    difference(
        &checked_weights(map, &in_texels(map, centre, edge_1, tilted)),
        &checked_weights(map, &in_texels(map, centre, edge_1, parallel)),
    )
}

#[test]
fn slivers_run_into_segments() {
    // Across the change from clipping to the segment at 1e-16: a jump there would show as a change that does not shrink.
    let map = flat_map(8, 4, Wrap::Repeat);
    let edge = [6.0, 3.7];
    for share in [0.0, 0.25, -1.0] {
        let mut last = f64::INFINITY;
        for exponent in 2..=28 {
            let width = libm::exp(-2.302_585 * f64::from(exponent));
            let change = change_from_segment(&map, edge, share, [-0.4 * width, 0.9 * width]);
            assert!(
                change <= 4.0 * width + 1e-14,
                "{change} at width {width}, share {share}"
            );
            assert!(change <= last + 1e-14, "the limit must be approached");
            last = change;
        }
    }
}

#[test]
fn segments_run_into_points() {
    let map = flat_map(8, 4, Wrap::Repeat);
    let point = checked_weights(&map, &in_texels(&map, [3.25, 1.5], [0.0; 2], [0.0; 2]));
    for exponent in [1, 5, 20, 80, 110, 200, 320] {
        let tiny = libm::pow(10.0, -f64::from(exponent));
        for footprint in [
            in_texels(&map, [3.25, 1.5], [tiny, 0.3 * tiny], [0.0; 2]),
            in_texels(&map, [3.25, 1.5], [tiny, 0.3 * tiny], [-0.2 * tiny, tiny]),
        ] {
            assert!(difference(&checked_weights(&map, &footprint), &point) < 1e-15);
        }
    }
}

#[test]
fn halves_average_to_the_whole_at_any_anisotropy() {
    // `A` cut across its first edge: an identity of the weights that no quadrature limits. Edges and centre are
    // multiples of 2⁻⁴⁴, so that the centres of the halves are exact.
    let mut random = Random(11);
    let map = flat_map(16, 32, Wrap::Repeat);
    let grid = |x: f64| libm::round(x * libm::exp2(44.0)) / libm::exp2(44.0);
    let mut worst: f64 = 0.0;
    for case in 0..400 {
        let length = libm::exp(random.between(-4.0, 4.0));
        let ratio = libm::exp(random.between(-24.0, 0.0));
        let long = random.vector(length);
        let short = match case % 3 {
            // Short and in any direction, nearly parallel and long, or axis-aligned.
            0 => random.vector(length * ratio),
            1 => [0, 1].map(|i| 0.7 * long[i] + ratio * [-long[1], long[0]][i]),
            _ => [0.0, length * ratio],
        };
        let tiles = |[u, v]: [f64; 2]| [4.0 * grid(u / 64.0), 4.0 * grid(v / 128.0)];
        let whole = Footprint {
            centre: [random.unit(), random.unit()].map(|x| libm::round(x * 4096.0) / 4096.0),
            edge_1: tiles(long),
            edge_2: tiles(short),
        };
        let half = |sign: f64| Footprint {
            centre: [0, 1].map(|i| whole.centre[i] + 0.25 * sign * whole.edge_1[i]),
            edge_1: whole.edge_1.map(|x| 0.5 * x),
            edge_2: whole.edge_2,
        };
        let mut mean: BTreeMap<(u32, u32), f64> = BTreeMap::new();
        for part in [half(-1.0), half(1.0)] {
            for (texel, weight) in checked_weights(&map, &part) {
                *mean.entry(texel).or_insert(0.0) += 0.5 * weight;
            }
        }
        worst = worst.max(difference(&mean, &checked_weights(&map, &whole)));
    }
    assert!(worst < 1e-13, "{worst}");
}

#[test]
fn stretching_an_axis_changes_nothing() {
    // A sliver along the border v = 2, of any thickness and tilt, must be split by it as the fat one is.
    let map = flat_map(64, 4, Wrap::Repeat);
    let of_height = |height: f64| {
        let centre = [32.0, 2.0 + 0.125 * height];
        let footprint = in_texels(&map, centre, [40.0, 0.25 * height], [3.0, 0.75 * height]);
        checked_weights(&map, &footprint)
    };
    let fat = of_height(0.5);
    for exponent in [10.0, 20.0, 40.0, 48.0] {
        let error = difference(&of_height(libm::exp2(-exponent)), &fat);
        assert!(error < 1e-15, "{error} at 2^-{exponent}");
    }
}
