//! Weights of Gaussian footprints against closed forms, plain sums and identities.

use super::super::gauss_legendre::GaussLegendre;
use super::super::{flake_bins, specular_bins};
use super::{Random, check_weights, difference, flat_map, in_texels, varied_map};
use crate::normals::NormalMap;
use crate::oracle::{MAX_SPAN_TILES, gaussian_weights, texel_weights};
use core::f64::consts::{FRAC_1_SQRT_2, PI};
use glintbake_format::model::{Filter, Footprint, HalfVector, Neighbourhood, Wrap};
use std::collections::BTreeMap;

type Weights = BTreeMap<(u32, u32), f64>;

fn checked(map: &NormalMap, footprint: &Footprint) -> Weights {
    check_weights(map, footprint, &gaussian_weights(map, footprint))
}

/// The share of N(0, deviation²) below x.
fn below(x: f64, deviation: f64) -> f64 {
    0.5 * libm::erfc(-x / deviation * FRAC_1_SQRT_2)
}

#[test]
fn gauss_legendre_is_exact_for_polynomials() {
    for count in 1..=12 {
        let rule = GaussLegendre::new(count);
        for degree in 0..2 * count {
            let sum: f64 = rule
                .nodes(0.0, 2.0)
                .map(|(x, length)| length * libm::pow(x, degree as f64))
                .sum();
            let exact = libm::exp2(degree as f64 + 1.0) / (degree as f64 + 1.0);
            assert!((sum / exact - 1.0).abs() < 1e-13, "{count} {degree} {sum}");
        }
    }
}

#[test]
fn edges_along_the_axes_give_products_of_error_functions() {
    let map = flat_map(7, 5, Wrap::Repeat);
    let centre = [3.3, 1.9];
    for deviations in [
        [0.01, 0.02],
        [0.3, 0.7],
        [2.0, 0.05],
        [0.4, 9.0],
        [11.0, 1e-5],
    ] {
        let footprint = in_texels(
            &map,
            centre,
            [0.0, 2.0 * deviations[1]],
            [-2.0 * deviations[0], 0.0],
        );
        let share = |axis: usize, size: i64, texel: i64| -> f64 {
            (-30..30)
                .map(|tile| {
                    let low = (texel + tile * size) as f64 - centre[axis];
                    below(low + 1.0, deviations[axis]) - below(low, deviations[axis])
                })
                .sum()
        };
        let mut expected = Weights::new();
        for (row, column) in (0..5).flat_map(|row| (0..7).map(move |column| (row, column))) {
            expected.insert(
                (column as u32, row as u32),
                share(0, 7, column) * share(1, 5, row),
            );
        }
        let error = difference(&checked(&map, &footprint), &expected);
        assert!(error < 2e-15, "{error} for {deviations:?}");
    }
}

/// Composite Simpson sums of the density over every texel, `2 steps` intervals a side.
fn summed(map: &NormalMap, centre: [f64; 2], edges: [[f64; 2]; 2], steps: i64) -> Weights {
    let [a, b, d] = {
        let entry = |i: usize, j: usize| 0.25 * edges.iter().map(|e| e[i] * e[j]).sum::<f64>();
        [entry(0, 0), entry(0, 1), entry(1, 1)]
    };
    let determinant = a * d - b * b;
    let density = |x: f64, y: f64| {
        let square = (d * x * x - 2.0 * b * x * y + a * y * y) / determinant;
        libm::exp(-0.5 * square) / (2.0 * PI * libm::sqrt(determinant))
    };
    let reach = [8.0 * libm::sqrt(a), 8.0 * libm::sqrt(d)];
    let place = |axis: usize, sign: f64| libm::floor(centre[axis] + sign * reach[axis]) as i64;
    let coefficient = |i: i64| match i {
        0 => 1.0,
        i if i == 2 * steps => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let mut weights = Weights::new();
    for row in place(1, -1.0)..=place(1, 1.0) {
        for column in place(0, -1.0)..=place(0, 1.0) {
            let mut sum = 0.0;
            for (i, j) in (0..=2 * steps).flat_map(|i| (0..=2 * steps).map(move |j| (i, j))) {
                let step = 0.5 / steps as f64;
                let x = column as f64 + i as f64 * step - centre[0];
                let y = row as f64 + j as f64 * step - centre[1];
                sum += coefficient(i) * coefficient(j) * density(x, y);
            }
            let fold = |k: i64, size: u32| match map.wrap() {
                Wrap::Repeat => k.rem_euclid(i64::from(size)) as u32,
                Wrap::Clamp => k.clamp(0, i64::from(size) - 1) as u32,
            };
            *weights
                .entry((fold(column, map.width()), fold(row, map.height())))
                .or_insert(0.0) += sum / (36 * steps * steps) as f64;
        }
    }
    weights
}

#[test]
fn every_shape_agrees_with_simpson_sums() {
    let mut random = Random(31);
    let mut compared = 0;
    for case in 0..60 {
        let wrap = [Wrap::Repeat, Wrap::Clamp][case % 2];
        let map = flat_map(3 + case as u32 % 7, 2 + case as u32 % 5, wrap);
        let centre = [random.between(-4.0, 9.0), random.between(-4.0, 9.0)];
        let longest = libm::exp(random.between(0.2, 2.2));
        let edges = [random.vector(longest), random.vector(2.0 + 0.5 * longest)];
        // Simpson errs by (step / least deviation)⁴ / 60, so nothing much thinner than a texel.
        let area = (edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]).abs();
        if area < 2.0 * (longest + 2.0) {
            continue;
        }
        compared += 1;
        let weights = checked(&map, &in_texels(&map, centre, edges[0], edges[1]));
        let error = difference(&weights, &summed(&map, centre, edges, 16));
        assert!(error < 1e-8, "{error} for {edges:?} at {centre:?}");
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn turning_the_edges_into_each_other_changes_nothing() {
    // E and E R have the same covariance for every rotation R, but other edges, slopes and panels.
    let mut random = Random(32);
    let map = flat_map(16, 11, Wrap::Repeat);
    for case in 0..120 {
        let length = libm::exp(random.between(-6.0, 3.0));
        let ratio = libm::exp(random.between(-13.8, 0.0));
        let (first, second) = (random.vector(length), random.vector(length * ratio));
        let centre = [random.between(0.0, 16.0), random.between(0.0, 11.0)];
        let angle = random.between(0.0, 2.0 * PI);
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let turned = [0, 1].map(|i| cosine * first[i] + sine * second[i]);
        let other = [0, 1].map(|i| -sine * first[i] + cosine * second[i]);
        let weights = checked(&map, &in_texels(&map, centre, first, second));
        let again = checked(&map, &in_texels(&map, centre, turned, other));
        // Rounding of the turned edges tilts a needle by 1e-16 of its length, 1e-16 / ratio of its width.
        let error = difference(&weights, &again);
        assert!(error < 1e-14 + 2e-16 / ratio, "{error} in case {case}");
    }
}

#[test]
fn mirrored_and_transposed_footprints_have_mirrored_weights() {
    let size = 12;
    let map = flat_map(size, size, Wrap::Repeat);
    let mut random = Random(33);
    for _ in 0..30 {
        let grid = |x: f64| libm::round(x * 256.0) / 256.0;
        let length = libm::exp(random.between(-3.0, 2.0));
        let (first, second) = (
            random.vector(length).map(grid),
            random.vector(1.5).map(grid),
        );
        let centre = [random.between(0.0, 12.0), random.between(0.0, 12.0)].map(grid);
        let swap = |[x, y]: [f64; 2]| [y, x];
        let weights = checked(&map, &in_texels(&map, centre, first, second));
        let transposed = checked(
            &map,
            &in_texels(&map, swap(centre), swap(first), swap(second)),
        );
        let back: Weights = transposed.iter().map(|(&(x, y), &w)| ((y, x), w)).collect();
        assert!(difference(&weights, &back) < 1e-14);
        let flip = |[x, y]: [f64; 2]| [-x, y];
        let mirrored = checked(
            &map,
            &in_texels(
                &map,
                [f64::from(size) - centre[0], centre[1]],
                flip(first),
                flip(second),
            ),
        );
        let back: Weights = mirrored
            .iter()
            .map(|(&(x, y), &w)| ((size - 1 - x, y), w))
            .collect();
        assert!(difference(&weights, &back) < 1e-14);
    }
}

#[test]
fn texels_are_the_sum_of_their_quarters_at_any_anisotropy() {
    let mut random = Random(34);
    let coarse = flat_map(16, 8, Wrap::Repeat);
    let fine = flat_map(32, 16, Wrap::Repeat);
    for case in 0..150 {
        let length = libm::exp(random.between(-5.0, 3.5));
        let ratio = libm::exp(random.between(-30.0, 0.0));
        let centre = [random.between(0.0, 16.0), random.between(0.0, 8.0)];
        let footprint = in_texels(
            &coarse,
            centre,
            random.vector(length),
            random.vector(length * ratio),
        );
        let mut sums = Weights::new();
        for ((column, row), weight) in checked(&fine, &footprint) {
            *sums.entry((column / 2, row / 2)).or_insert(0.0) += weight;
        }
        let error = difference(&checked(&coarse, &footprint), &sums);
        assert!(error < 1e-13, "{error} in case {case}");
    }
}

#[test]
fn parallel_edges_give_the_gaussian_along_their_line() {
    let map = flat_map(8, 4, Wrap::Clamp);
    // Along one line the squares of edges add up: 3 and 4 are as good as 5 and 0.
    for (first, second) in [
        ([3.0, 1.5], [-4.0, -2.0]),
        ([5.0, 2.5], [0.0; 2]),
        ([0.0; 2], [-5.0, -2.5]),
    ] {
        let weights = checked(&map, &in_texels(&map, [3.0, 2.0], first, second));
        // x has σ = 2.5 and y = x / 2, crossing v = 2 at u = 3, v = 3 at u = 5, v = 1 at u = 1.
        let share = |from: f64, to: f64| below(to, 2.5) - below(from, 2.5);
        let expected = Weights::from([
            ((0, 0), share(-30.0, -2.0)),
            ((1, 1), share(-2.0, -1.0)),
            ((2, 1), share(-1.0, 0.0)),
            ((3, 2), share(0.0, 1.0)),
            ((4, 2), share(1.0, 2.0)),
            ((5, 3), share(2.0, 3.0)),
            ((6, 3), share(3.0, 4.0)),
            ((7, 3), share(4.0, 30.0)),
        ]);
        assert!(difference(&weights, &expected) < 1e-15, "{weights:?}");
    }
    // Along the border v = 2, which belongs to the row below it.
    let weights = checked(&map, &in_texels(&map, [4.5, 2.0], [2.0, 0.0], [0.0; 2]));
    assert!(weights.keys().all(|&(_, row)| row == 2));
    let centre = below(0.5, 1.0) - below(-0.5, 1.0);
    assert!((weights[&(4, 2)] - centre).abs() < 1e-15);
}

#[test]
fn needles_run_into_lines() {
    let map = flat_map(8, 4, Wrap::Repeat);
    for share in [0.0, 0.25, -1.0] {
        let edge = [6.0, 3.7];
        let with_width = |width: f64| {
            let other = [share * edge[0] - 0.4 * width, share * edge[1] + 0.9 * width];
            checked(&map, &in_texels(&map, [3.3, 1.7], edge, other))
        };
        let line = with_width(0.0);
        let mut last = f64::INFINITY;
        for exponent in 2..=28 {
            let width = libm::pow(10.0, -f64::from(exponent));
            let change = difference(&with_width(width), &line);
            assert!(change <= 2.0 * width + 1e-13, "{change} at width {width}");
            assert!(change <= last + 1e-13, "the limit must be approached");
            last = change;
        }
    }
}

#[test]
fn points_and_whatever_runs_into_them_are_the_texel_at_the_centre() {
    let map = flat_map(8, 4, Wrap::Repeat);
    for (centre, texel) in [
        ([3.5, 2.25], (3, 2)),
        ([3.0, 2.0], (3, 2)),
        ([-0.25, -4.0], (7, 0)),
        ([-1e-30, 4e-30], (7, 0)),
    ] {
        let weights = checked(&map, &in_texels(&map, centre, [0.0; 2], [0.0; 2]));
        assert_eq!(weights, Weights::from([(texel, 1.0)]), "at {centre:?}");
    }
    for exponent in [3, 5, 20, 80, 110, 200, 320] {
        let tiny = libm::pow(10.0, -f64::from(exponent));
        for second in [[0.0; 2], [-0.2 * tiny, tiny]] {
            let footprint = in_texels(&map, [3.25, 1.5], [tiny, 0.3 * tiny], second);
            let weights = checked(&map, &footprint);
            assert!((weights[&(3, 1)] - 1.0).abs() < 1e-15, "{weights:?}");
        }
    }
    // On a corner of texels a quarter each, however small.
    for tiny in [1e-3, 1e-20, 1e-90] {
        let footprint = in_texels(&map, [4.0, 2.0], [tiny, 0.0], [0.0, 3.0 * tiny]);
        let weights = checked(&map, &footprint);
        let quarters = [(3, 1), (4, 1), (3, 2), (4, 2)].map(|texel| (texel, 0.25));
        assert!(difference(&weights, &Weights::from(quarters)) < 1e-15);
    }
}

#[test]
fn stretching_an_axis_changes_nothing() {
    let map = flat_map(64, 4, Wrap::Repeat);
    let of_height = |height: f64| {
        let centre = [32.0, 2.0 + 0.125 * height];
        checked(
            &map,
            &in_texels(&map, centre, [20.0, 0.25 * height], [3.0, 0.75 * height]),
        )
    };
    let fat = of_height(1.0 / 32.0);
    for exponent in [10.0, 20.0, 40.0, 48.0] {
        let error = difference(&of_height(libm::exp2(-exponent)), &fat);
        assert!(error < 2e-15, "{error} at 2^-{exponent}");
    }
}

#[test]
fn copies_add_up_and_borders_extend() {
    let mut random = Random(35);
    for case in 0..20 {
        let (width, height) = (5, 3);
        let (first, second) = (random.vector(2.0), random.vector(0.7));
        let centre = [random.between(-1.0, 6.0), random.between(-1.0, 4.0)];
        // Room for 9 standard deviations of at most 1.1 texels on all sides.
        let copies = 9;
        let fine = flat_map(width * copies, height * copies, Wrap::Clamp);
        let shift = [f64::from(width * 4), f64::from(height * 4)];
        let moved = [centre[0] + shift[0], centre[1] + shift[1]];
        let apart = checked(&fine, &in_texels(&fine, moved, first, second));
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            let map = flat_map(width, height, wrap);
            let mut folded = Weights::new();
            for (&(column, row), &weight) in &apart {
                let fold = |k: u32, size: u32| match wrap {
                    Wrap::Repeat => k % size,
                    Wrap::Clamp => k.saturating_sub(4 * size).min(size - 1),
                };
                *folded
                    .entry((fold(column, width), fold(row, height)))
                    .or_insert(0.0) += weight;
            }
            let weights = checked(&map, &in_texels(&map, centre, first, second));
            let error = difference(&weights, &folded);
            assert!(error < 1e-14, "{error} in case {case}, {wrap:?}");
        }
    }
}

#[test]
fn beyond_one_and_a_half_tiles_all_texels_weigh_alike() {
    let map = flat_map(6, 9, Wrap::Repeat);
    // Just below the change by integration, just above it without.
    for deviation in [1.499, 1.501, 60.0] {
        let (sine, cosine) = (libm::sin(0.4), libm::cos(0.4));
        let footprint = Footprint {
            centre: [0.217, -3.4],
            edge_1: [2.0 * deviation * cosine, 2.0 * deviation * sine],
            edge_2: [-2.0 * deviation * sine, 2.0 * deviation * cosine],
        };
        let weights = checked(&map, &footprint);
        assert_eq!(weights.len(), 54);
        for weight in weights.values() {
            assert!((weight - 1.0 / 54.0).abs() < 1e-15, "{weight}");
        }
    }
    // A needle of as great a deviation is not even across.
    let needle = Footprint {
        centre: [0.25, 0.5],
        edge_1: [120.0, 0.0],
        edge_2: [0.0, 1e-6],
    };
    let weights = checked(&map, &needle);
    assert!(weights.keys().all(|&(_, row)| row == 4) && weights.len() == 6);
}

#[test]
fn a_clamped_footprint_far_larger_than_the_map_falls_to_its_border() {
    let map = flat_map(2, 2, Wrap::Clamp);
    let footprint = Footprint {
        centre: [0.5, 0.5 + 40.0],
        edge_1: [100.0, 0.0],
        edge_2: [0.0, 80.0],
    };
    let above = below(-1.0, 1.0);
    for ((_, row), weight) in checked(&map, &footprint) {
        let expected = 0.5 * [above, 1.0 - above][row as usize];
        assert!((weight - expected).abs() < 1e-15, "{weight}");
    }
}

#[test]
fn whole_tiles_away_nothing_changes() {
    let map = flat_map(12, 10, Wrap::Repeat);
    let here = Footprint {
        centre: [0.312_5 + 1.0 / 1024.0, 0.75],
        edge_1: [0.17, -0.11],
        edge_2: [0.013, 0.029],
    };
    let weights = checked(&map, &here);
    for tiles in [[1.0, -1.0], [-1e6, 1e6]] {
        let there = Footprint {
            centre: [here.centre[0] + tiles[0], here.centre[1] + tiles[1]],
            ..here
        };
        assert!(difference(&checked(&map, &there), &weights) < 1e-15);
    }
}

#[test]
fn points_drawn_from_the_gaussian_fall_on_texels_by_their_weights() {
    let map = flat_map(5, 3, Wrap::Repeat);
    let footprint = in_texels(&map, [1.3, 2.9], [2.4, 0.7], [-0.9, 1.6]);
    let weights = checked(&map, &footprint);
    let mut random = Random(36);
    let mut counts = Weights::new();
    let points = 400_000;
    for _ in 0..points {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - random.unit()));
        let [a, b] = random.vector(0.5 * radius);
        let texel = [0, 1].map(|i| {
            let place = footprint.centre[i] + a * footprint.edge_1[i] + b * footprint.edge_2[i];
            let size = [5.0, 3.0][i];
            (libm::floor(place * size) as i64).rem_euclid(size as i64) as u32
        });
        *counts.entry((texel[0], texel[1])).or_insert(0.0) += 1.0 / f64::from(points);
    }
    let error = difference(&weights, &counts);
    assert!(error < 5.0 * 0.5 / libm::sqrt(f64::from(points)), "{error}");
}

#[test]
fn densities_are_sums_over_the_texels_of_the_filter() {
    let map = varied_map(9, 7, Wrap::Repeat);
    let footprint = in_texels(&map, [4.2, 3.1], [3.0, 1.0], [-0.5, 2.0]);
    let half_vector = HalfVector { s: 0.1, t: -0.2 };
    let setting = flake_bins::Setting::Binned(Neighbourhood::Bins45);
    let of = |filter| {
        let weights = texel_weights(&map, &footprint, filter);
        let flakes = flake_bins::Prepared::from_weights(&map, &weights, 0.1, setting);
        let specular = specular_bins::Prepared::from_weights(&map, &weights, 3);
        [
            flakes.ndf(half_vector),
            flakes.pdf(half_vector),
            specular.ndf(half_vector),
        ]
    };
    let boxed = [
        flake_bins::ndf(&map, &footprint, half_vector, 0.1, setting),
        flake_bins::pdf(&map, &footprint, half_vector, 0.1, setting),
        specular_bins::ndf(&map, &footprint, half_vector, 3),
    ];
    assert_eq!(of(Filter::Box), boxed);
    let gaussian = of(Filter::Gaussian);
    let weights = checked(&map, &footprint);
    let bins = flake_bins::bin_weights_of(
        &map,
        &texel_weights(&map, &footprint, Filter::Gaussian),
        0.1,
    );
    assert!((bins.values().sum::<f64>() - 1.0).abs() < 1e-14);
    let by_hand: f64 = weights
        .iter()
        .filter(|((column, row), _)| {
            let [s, t] = map.texels()[(row * 9 + column) as usize].map(f64::from);
            let bin = |h| specular_bins::bin_of(h, 3);
            bin(HalfVector { s, t }) == bin(half_vector)
        })
        .map(|(_, weight)| weight / specular_bins::solid_angle(3))
        .sum();
    assert!((gaussian[2] / by_hand - 1.0).abs() < 1e-13);
    assert!(gaussian.iter().zip(boxed).all(|(a, b)| *a > 0.0 && *a != b));
}

#[test]
#[should_panic(expected = "span at most")]
fn endless_footprints_are_refused() {
    let footprint = Footprint {
        centre: [0.0, 0.0],
        edge_1: [0.5 * MAX_SPAN_TILES, 0.0],
        edge_2: [1.0, 1.0],
    };
    gaussian_weights(&flat_map(2, 2, Wrap::Clamp), &footprint);
}

#[test]
#[should_panic(expected = "finite")]
fn footprints_that_are_not_numbers_are_refused() {
    let footprint = Footprint {
        centre: [0.0, f64::INFINITY],
        edge_1: [0.0, 0.0],
        edge_2: [1.0, 1.0],
    };
    gaussian_weights(&flat_map(2, 2, Wrap::Clamp), &footprint);
}
