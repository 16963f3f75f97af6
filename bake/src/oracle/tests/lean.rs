//! The model of `lean`, against hand-made cases and identities.

use super::super::disk;
use super::super::lean::{Prepared, box_places, cell_moments, gaussian_places, principal};
use super::{Random, in_texels, varied_map};
use crate::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, HalfVector, Wrap};

/// Mean and covariance of all texels of `map`, each weighed the same.
fn whole(map: &NormalMap) -> ([f64; 2], [f64; 3]) {
    let count = map.texels().len() as f64;
    let mut mean = [0.0; 2];
    for texel in map.texels() {
        mean = [mean[0] + f64::from(texel[0]), mean[1] + f64::from(texel[1])];
    }
    let mean = mean.map(|sum| sum / count);
    let mut covariance = [0.0; 3];
    for texel in map.texels() {
        let (s, t) = (f64::from(texel[0]) - mean[0], f64::from(texel[1]) - mean[1]);
        covariance[0] += s * s / count;
        covariance[1] += s * t / count;
        covariance[2] += t * t / count;
    }
    (mean, covariance)
}

#[test]
fn the_top_is_the_whole_map_and_level_0_its_texels() {
    for [width, height] in [[8, 8], [7, 3], [1, 5], [13, 13]] {
        let map = varied_map(width, height, Wrap::Repeat);
        let top = width.max(height).ilog2();
        let (mean, covariance) = cell_moments(&map, top, 0, 0);
        let (expected_mean, expected_covariance) = whole(&map);
        for (got, expected) in mean.iter().zip(expected_mean) {
            assert!((got - expected).abs() < 1e-14, "{width} x {height}");
        }
        for (got, expected) in covariance.iter().zip(expected_covariance) {
            assert!((got - expected).abs() < 1e-14, "{width} x {height}");
        }
        let texel = cell_moments(&map, 0, width - 1, 0);
        let own = map.texels()[width as usize - 1].map(f64::from);
        assert_eq!(texel, (own, [0.0; 3]));
    }
}

#[test]
fn cells_cut_texels_by_their_area() {
    let map = NormalMap::new(
        5,
        1,
        Wrap::Repeat,
        vec![[0.1, 0.0], [0.2, 0.0], [0.6, 0.0], [0.0; 2], [0.0; 2]],
    );
    // Two cells of two and a half texels.
    let ([mean, _], [variance, ..]) = cell_moments(&map, 1, 0, 0);
    let texels = [
        (f64::from(0.1_f32), 0.4),
        (f64::from(0.2_f32), 0.4),
        (f64::from(0.6_f32), 0.2),
    ];
    let expected: f64 = texels.iter().map(|(s, share)| s * share).sum();
    let spread: f64 = texels
        .iter()
        .map(|(s, share)| share * (s - expected).powi(2))
        .sum();
    assert!((mean - expected).abs() < 1e-15);
    assert!((variance - spread).abs() < 1e-15);
}

#[test]
fn axes_are_the_ellipses_own() {
    let mut random = Random(5);
    for _ in 0..200 {
        let (e1, e2) = (random.vector(3.0), random.vector(0.7));
        let (angle, [long, short]) = principal([e1, e2]);
        let along = [libm::cos(angle), libm::sin(angle)];
        // Variance along a direction d is (d·e1)² + (d·e2)²: greatest along the long axis.
        let variance = |d: [f64; 2]| {
            let dot = |e: [f64; 2]| d[0] * e[0] + d[1] * e[1];
            dot(e1) * dot(e1) + dot(e2) * dot(e2)
        };
        assert!((variance(along) - long * long).abs() < 1e-12);
        assert!((variance([-along[1], along[0]]) - short * short).abs() < 1e-12);
        assert!(long >= short);
    }
    assert_eq!(principal([[0.0; 2]; 2]).1, [0.0, 0.0]);
    let (_, [long, short]) = principal([[3.0, 4.0], [-6.0, -8.0]]);
    assert!((long - libm::sqrt(125.0)).abs() < 1e-13 && short == 0.0);
}

#[test]
fn places_share_what_there_is_and_are_even_to_both_sides() {
    for long in [0.5, 1.0, 1.2, 2.9, 3.0, 3.1, 7.5, 14.99] {
        let boxes = box_places(long, 1.0);
        let most = if long > 7.9 { long / 7.9 } else { 1.0 };
        for places in [boxes, gaussian_places(long, most)] {
            let sum: f64 = places.iter().map(|(_, weight)| weight).sum();
            let lean: f64 = places.iter().map(|(place, weight)| place * weight).sum();
            assert!((sum - 1.0).abs() < 1e-14 && lean.abs() < 1e-14, "{long}");
            assert!(places.len() <= 17);
        }
    }
    // Three whole pieces.
    assert_eq!(box_places(3.0, 1.0).len(), 3);
    // One whole piece and two of a tenth, where all three have the second moment of a piece of 1.2.
    let pieces = box_places(1.2, 1.0);
    let place = libm::sqrt(1.2 * 2.2 / 12.0);
    assert!((pieces[1].0 - place).abs() < 1e-14 && (pieces[1].1 - 0.1 / 1.2).abs() < 1e-15);
}

#[test]
fn a_footprint_of_one_texel_or_one_cell_is_right() {
    let map = varied_map(16, 16, Wrap::Repeat);
    let alpha = 0.3;
    // A texel: the model and the truth of the kernel are the same Gaussian.
    let texel = in_texels(&map, [3.5, 9.5], [1.0, 0.0], [0.0, 1.0]);
    let lean = Prepared::new(&map, &texel, Filter::Box, alpha, 0);
    let truth = disk::Prepared::new(&map, &texel, Filter::Box, alpha);
    for s in [-0.5, 0.0, 0.4] {
        let h = HalfVector { s, t: 0.2 };
        assert!((lean.ndf(h) / truth.ndf(h) - 1.0).abs() < 1e-9);
        assert!((lean.pdf(h) / truth.pdf(h) - 1.0).abs() < 1e-9);
    }
    // A cell of level 2: mean and covariance are those of its 16 texels.
    let cell = in_texels(&map, [6.0, 10.0], [4.0, 0.0], [0.0, 4.0]);
    let lean = Prepared::new(&map, &cell, Filter::Box, alpha, 0);
    let (mean, [ss, ..]) = cell_moments(&map, 2, 1, 2);
    assert!((lean.mean()[0] - mean[0]).abs() < 1e-14);
    assert!((lean.covariance()[0] - ss - 0.5 * alpha * alpha).abs() < 1e-14);
    // Tiles and more: the whole map, wherever it is.
    for edge in [16.0, 100.0, 3000.0] {
        let tiles = in_texels(&map, [-77.3, 1e6], [edge, 0.0], [0.0, edge]);
        let lean = Prepared::new(&map, &tiles, Filter::Gaussian, alpha, 3);
        let (mean, _) = whole(&map);
        assert!((lean.mean()[1] - mean[1]).abs() < 1e-14);
    }
}

#[test]
fn the_finest_level_is_a_floor_and_needles_stay_finite() {
    let map = varied_map(16, 8, Wrap::Clamp);
    let at = |finest, edges: [[f64; 2]; 2]| {
        let footprint = Footprint {
            centre: [0.21, 0.8],
            edge_1: edges[0],
            edge_2: edges[1],
        };
        Prepared::new(&map, &footprint, Filter::Box, 1e-4, finest)
    };
    let (point, coarse) = (at(0, [[0.0; 2]; 2]), at(3, [[0.0; 2]; 2]));
    assert!(point.covariance()[0] < coarse.covariance()[0]);
    assert_eq!(coarse.mean(), at(3, [[0.5, 0.0], [0.0, 1.0]]).mean());
    for edges in [[[200.0, 3.0], [1e-4, -1e-4]], [[1e-300, 0.0], [0.0, 1e-12]]] {
        let lobe = at(0, edges);
        let density = lobe.ndf(HalfVector {
            s: lobe.mean()[0],
            t: lobe.mean()[1],
        });
        assert!(density.is_finite() && density > 0.0, "{edges:?}");
    }
}
