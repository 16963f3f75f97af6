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
            let width = libm::pow(10.0, -f64::from(exponent));
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

/// A footprint and its weights from rational arithmetic over the exact values of these f64 numbers.
struct ExactCase {
    /// Columns, rows.
    size: [u32; 2],
    wrap: Wrap,
    /// Centre, first and second edge, in tiles.
    footprint: [f64; 6],
    /// (column, row) and weight, of the texels that take more than a millionth.
    weights: &'static [((u32, u32), f64)],
}

/// Area over that of the bounding rectangle: 5e-9, 9e-12, 2e-14, 5e-16, 3e-15, and 2e-17, which is a segment.
const EXACT_CASES: [ExactCase; 6] = [
    ExactCase {
        size: [6, 5],
        wrap: Wrap::Repeat,
        footprint: [
            0.16666666675321967,
            -0.5999999998775296,
            0.47822906161279555,
            0.05800538698748775,
            0.11900731110845676,
            0.014434642087615714,
        ],
        weights: &[
            ((0, 1), 0.3485080247539369),
            ((1, 2), 0.3485080266843127),
            ((2, 2), 0.1514919732856856),
            ((5, 1), 0.15149197292371258),
        ],
    },
    ExactCase {
        size: [7, 5],
        wrap: Wrap::Repeat,
        footprint: [
            0.7142857142866225,
            -1.7021971729091513e-12,
            -0.1444425041421549,
            0.5003474524302278,
            -0.03080212775606776,
            0.10669827584861373,
        ],
        weights: &[
            ((4, 0), 0.3996277943337653),
            ((4, 1), 0.10037220565942358),
            ((5, 3), 0.10037220566602514),
            ((5, 4), 0.3996277943368532),
        ],
    },
    ExactCase {
        size: [2, 4],
        wrap: Wrap::Clamp,
        footprint: [
            0.500000000000166,
            -0.24999999999999573,
            0.8621601094068457,
            -1.0591867620875821,
            0.43108005470342287,
            -0.5295933810438336,
        ],
        weights: &[
            ((0, 0), 0.4227495123172648),
            ((0, 1), 0.07549407484809147),
            ((0, 2), 0.0017564128344512075),
            ((1, 0), 0.5000000000001925),
        ],
    },
    ExactCase {
        size: [16384, 1],
        wrap: Wrap::Repeat,
        footprint: [
            926459.6610829493,
            -0.09893903997291442,
            0.0001641157646844636,
            -2.8712833777678757,
            -1.8358450512755694e-20,
            -1.0286659162132402e-15,
        ],
        weights: &[
            ((10829, 0), 0.060023565296897514),
            ((10830, 0), 0.37190306712672583),
            ((10831, 0), 0.37190306712672583),
            ((10832, 0), 0.19617030044965084),
        ],
    },
    ExactCase {
        size: [5, 5],
        wrap: Wrap::Repeat,
        footprint: [
            0.8,
            -0.3999999999999999,
            -0.5542759889717436,
            0.12141786766465112,
            0.16510622635432742,
            -0.036167624686917366,
        ],
        weights: &[
            ((0, 2), 0.1393291392277995),
            ((2, 3), 0.13932913922779933),
            ((3, 3), 0.36067086077220034),
            ((4, 2), 0.3606708607721995),
        ],
    },
    ExactCase {
        size: [6, 3],
        wrap: Wrap::Repeat,
        footprint: [
            0.3333333333333333,
            -0.6666666666666666,
            0.33257307739961517,
            -1.2575330248437948,
            8.682935363044934e-18,
            -8.20668898160439e-18,
        ],
        weights: &[
            ((1, 1), 0.2650692480817659),
            ((1, 2), 0.23493075191823412),
            ((2, 0), 0.26506924808176585),
            ((2, 2), 0.23493075191823407),
        ],
    },
];

#[test]
fn slivers_agree_with_rational_arithmetic() {
    for case in EXACT_CASES {
        let map = flat_map(case.size[0], case.size[1], case.wrap);
        let [u, v, u_1, v_1, u_2, v_2] = case.footprint;
        let footprint = Footprint {
            centre: [u, v],
            edge_1: [u_1, v_1],
            edge_2: [u_2, v_2],
        };
        let weights = checked_weights(&map, &footprint);
        for (texel, expected) in case.weights {
            let error = (weights[texel] - expected).abs();
            assert!(error < 5e-16, "{error} at {texel:?} of {footprint:?}");
        }
    }
}
