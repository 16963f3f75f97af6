//! Texel weights against a sweep: exact segments over b, the midpoint rule over a; and against plain sampling.

use super::{Random, checked_weights, difference, flat_map, in_texels};
use crate::normals::NormalMap;
use glintbake_format::model::{Footprint, Wrap};
use std::collections::BTreeMap;

/// Weights from `lines` segments `b edge_2`, each cut exactly at the texel borders, at the midpoints of a.
///
/// The length on a texel is piecewise linear in a, so that the error falls with the square of `lines`.
fn swept_weights(map: &NormalMap, footprint: &Footprint, lines: u32) -> BTreeMap<(u32, u32), f64> {
    let size = [f64::from(map.width()), f64::from(map.height())];
    let texels = |v: [f64; 2]| [v[0] * size[0], v[1] * size[1]];
    let centre = texels(footprint.centre);
    let (edge_1, edge_2) = (texels(footprint.edge_1), texels(footprint.edge_2));
    let mut weights = BTreeMap::new();
    for line in 0..lines {
        let a = (f64::from(line) + 0.5) / f64::from(lines) - 0.5;
        let middle = [0, 1].map(|i| centre[i] + a * edge_1[i]);
        let mut cuts = vec![-0.5, 0.5];
        for axis in 0..2 {
            let reach = 0.5 * edge_2[axis].abs();
            let mut border = libm::ceil(middle[axis] - reach);
            while edge_2[axis] != 0.0 && border <= middle[axis] + reach {
                cuts.push(((border - middle[axis]) / edge_2[axis]).clamp(-0.5, 0.5));
                border += 1.0;
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        for piece in cuts.windows(2) {
            let b = 0.5 * (piece[0] + piece[1]);
            let place = [0, 1].map(|i| libm::floor(middle[i] + b * edge_2[i]) as i64);
            let texel = [0, 1].map(|i| match map.wrap() {
                Wrap::Repeat => place[i].rem_euclid(size[i] as i64) as u32,
                Wrap::Clamp => place[i].clamp(0, size[i] as i64 - 1) as u32,
            });
            *weights.entry((texel[0], texel[1])).or_insert(0.0) +=
                (piece[1] - piece[0]) / f64::from(lines);
        }
    }
    weights
}

#[test]
fn every_shape_and_size_agrees_with_a_sweep() {
    let mut random = Random(7);
    let lines = 8192;
    for case in 0..120 {
        let wrap = if case % 3 == 2 {
            Wrap::Clamp
        } else {
            Wrap::Repeat
        };
        let map = flat_map(1 + case % 9, 1 + (case / 2) % 11, wrap);
        // From a thousandth of a texel to thirty texels, anisotropy 1 to 1e6, both edges in any direction.
        let length = libm::exp(random.between(-7.0, 3.4));
        let thin = length * libm::exp(random.between(-13.8, 0.0));
        let centre = [random.between(-20.0, 20.0), random.between(-20.0, 20.0)];
        let footprint = in_texels(&map, centre, random.vector(thin), random.vector(length));
        let weights = checked_weights(&map, &footprint);
        let swept = swept_weights(&map, &footprint, lines);
        // Kinks in the middle of a step: a change of slope up to `length` per texel, step squared / 8, a few borders.
        let tolerance =
            1e-12 + (1.0 + length) * 4.0 / f64::from(lines * lines) * thin.max(1.0) * 8.0;
        let error = difference(&weights, &swept);
        assert!(error < tolerance, "{error} for {footprint:?}");
    }
}

#[test]
fn nearly_parallel_edges_agree_with_a_sweep() {
    let mut random = Random(8);
    let map = flat_map(7, 5, Wrap::Repeat);
    for exponent in 1..=20 {
        let along = random.vector(9.0);
        let across = [-along[1], along[0]];
        let tilt = libm::exp2(-2.5 * f64::from(exponent));
        let edge_1 = [0, 1].map(|i| -0.4 * along[i] + tilt * across[i]);
        let footprint = in_texels(&map, [2.2, 3.7], edge_1, along);
        let lines = 16384;
        let error = difference(
            &checked_weights(&map, &footprint),
            &swept_weights(&map, &footprint, lines),
        );
        assert!(error < 1e-6, "{error} at tilt {tilt}");
    }
}

#[test]
fn uniform_points_fall_on_texels_by_their_weights() {
    let map = flat_map(5, 3, Wrap::Repeat);
    let footprint = in_texels(&map, [1.3, 2.9], [2.4, 0.7], [-0.9, 1.6]);
    let weights = checked_weights(&map, &footprint);
    let mut random = Random(9);
    let mut counts = BTreeMap::new();
    let points = 400_000;
    for _ in 0..points {
        let (a, b) = (random.unit() - 0.5, random.unit() - 0.5);
        let texel = [0, 1].map(|i| {
            let place = footprint.centre[i] + a * footprint.edge_1[i] + b * footprint.edge_2[i];
            let size = [5.0, 3.0][i];
            (libm::floor(place * size) as i64).rem_euclid(size as i64) as u32
        });
        *counts.entry((texel[0], texel[1])).or_insert(0.0) += 1.0 / f64::from(points);
    }
    // Five standard deviations of a fair coin, the most any texel's count can vary.
    let error = difference(&weights, &counts);
    assert!(error < 5.0 * 0.5 / libm::sqrt(f64::from(points)), "{error}");
}
