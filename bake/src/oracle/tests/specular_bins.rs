//! Bins of equal solid angle, and densities averaged over them.

use super::super::direction::direction;
use super::super::specular_bins::{
    Prepared, bin_of, bin_weights, ndf, normal_at, pdf, solid_angle, square_of,
};
use super::{Random, checked_weights, in_texels, varied_map};
use crate::normals::NormalMap;
use core::f64::consts::{PI, TAU};
use glintbake_format::model::{HalfVector, Wrap};

#[test]
fn bins_come_back_from_the_normals_in_them() {
    for bins in [1, 2, 3, 16, 63, 127] {
        for row in 0..bins {
            for column in 0..bins {
                for (x, y) in [(0.5, 0.5), (0.01, 0.02), (0.99, 0.03), (0.02, 0.98)] {
                    let place = |k: u32, part: f64| (f64::from(k) + part) / f64::from(bins);
                    let normal = normal_at([place(column, x), place(row, y)]);
                    assert_eq!(bin_of(normal, bins), (column, row), "of {bins}");
                }
            }
        }
    }
}

#[test]
fn squares_and_normals_are_inverse() {
    let mut random = Random(41);
    for _ in 0..20_000 {
        let [x, y] = [random.unit(), random.unit()];
        let normal = normal_at([x, y]);
        let [back_x, back_y] = square_of(normal);
        // s and t are rounded: near the horizon that shifts 1 - z by 1e-16 / z.
        let z = direction(normal.s, normal.t)[2];
        let tolerance = 2e-15 + 1e-15 / z.max(1e-8);
        assert!((x - back_x).abs() < tolerance && (y - back_y).abs() < tolerance);
    }
}

#[test]
fn landmarks_of_the_concentric_map() {
    let at = |s, t| square_of(HalfVector { s, t });
    assert_eq!(at(0.0, 0.0), [0.5, 0.5]);
    assert_eq!(at(1.0, 0.0), [1.0, 0.5]);
    assert_eq!(at(-1.0, 0.0), [0.0, 0.5]);
    assert_eq!(at(0.0, 1.0), [0.5, 1.0]);
    assert_eq!(at(0.0, -1.0), [0.5, 0.0]);
    // The rim's diagonal is the square's corner, where the last bin begins nothing new.
    let diagonal = core::f64::consts::FRAC_1_SQRT_2;
    let [x, y] = at(diagonal, -diagonal);
    assert!((x - 1.0).abs() < 2e-8 && y.abs() < 2e-8, "{x} {y}");
    assert_eq!(bin_of(HalfVector { s: 1.0, t: 0.0 }, 7), (6, 3));
    assert_eq!(bin_of(HalfVector { s: 0.0, t: -1.0 }, 7), (3, 0));
    // 1 - z = ρ²: 60 degrees from the pole is ρ = sqrt(1/2).
    let [x, y] = at(libm::sqrt(0.75), 0.0);
    assert!((x - 0.5 - 0.5 * diagonal).abs() < 1e-15 && y == 0.5);
    // An azimuth of 22.5 degrees is half way from the axis to the diagonal.
    let (sine, cosine) = (libm::sin(PI / 8.0), libm::cos(PI / 8.0));
    let [x, y] = at(0.5 * cosine, 0.5 * sine);
    assert!(((y - 0.5) / (x - 0.5) - 0.5).abs() < 1e-15);
    // Beyond the disk: the nearest point of the rim.
    assert_eq!(at(3.0, 0.0), [1.0, 0.5]);
}

#[test]
fn every_bin_spans_the_same_solid_angle() {
    // Uniform directions on a fine grid of z and azimuth (Archimedes): 8 × 8 bins.
    let bins = 8;
    let (heights, azimuths) = (1500, 3000);
    let mut counts = vec![0u32; 64];
    for i in 0..heights {
        let z = (f64::from(i) + 0.5) / f64::from(heights);
        let sine = libm::sqrt(1.0 - z * z);
        for j in 0..azimuths {
            let azimuth = TAU * (f64::from(j) + 0.5) / f64::from(azimuths);
            let normal = HalfVector {
                s: sine * libm::cos(azimuth),
                t: sine * libm::sin(azimuth),
            };
            let (x, y) = bin_of(normal, bins);
            counts[(y * bins + x) as usize] += 1;
        }
    }
    let expected = f64::from(heights * azimuths) / 64.0;
    for (bin, &count) in counts.iter().enumerate() {
        let error = (f64::from(count) / expected - 1.0).abs();
        assert!(error < 5e-3, "bin {bin} is off by {error}");
    }
    assert!((solid_angle(bins) * 64.0 - TAU).abs() < 1e-14);
}

#[test]
fn density_is_the_bin_weight_per_solid_angle() {
    let map = NormalMap::new(2, 1, Wrap::Repeat, vec![[0.25, 0.5], [-0.5, 0.0]]);
    let footprint = in_texels(&map, [1.25, 0.5], [1.0, 0.0], [0.0, 1.0]);
    let bins = 9;
    for (texel, weight) in [([0.25, 0.5], 0.25), ([-0.5, 0.0], 0.75)] {
        let h = HalfVector {
            s: texel[0],
            t: texel[1],
        };
        let expected = weight * 81.0 / TAU;
        let density = ndf(&map, &footprint, h, bins);
        assert!((density / expected - 1.0).abs() < 1e-15);
        assert_eq!(pdf(&map, &footprint, h, bins), density);
    }
    for (s, t) in [(0.9, 0.0), (1.0, 1e-7), (2.0, 0.0), (f64::NAN, 0.0)] {
        assert_eq!(ndf(&map, &footprint, HalfVector { s, t }, bins), 0.0);
    }
}

#[test]
fn densities_integrate_to_one() {
    let map = varied_map(11, 8, Wrap::Clamp);
    let footprint = in_texels(&map, [5.0, 3.0], [6.0, 1.0], [-1.0, 9.0]);
    let bins = 13;
    let prepared = Prepared::new(&map, &footprint, bins);
    let mut mass = 0.0;
    for row in 0..bins {
        for column in 0..bins {
            let place = |k: u32| (f64::from(k) + 0.5) / f64::from(bins);
            mass += prepared.pdf(normal_at([place(column), place(row)])) * solid_angle(bins);
        }
    }
    assert!((mass - 1.0).abs() < 1e-13, "{mass}");
    let weights = bin_weights(&map, &footprint, bins);
    let by_hand: f64 = checked_weights(&map, &footprint)
        .into_iter()
        .filter(|((column, row), _)| {
            let [s, t] = map.texels()[(row * 11 + column) as usize].map(f64::from);
            let [x, y] = square_of(HalfVector { s, t });
            (6.0 / 13.0..7.0 / 13.0).contains(&x) && (7.0 / 13.0..8.0 / 13.0).contains(&y)
        })
        .map(|(_, weight)| weight)
        .sum();
    let answer = weights.get(&(6, 7)).copied().unwrap_or(0.0);
    assert!(
        by_hand > 0.0 && (answer - by_hand).abs() < 1e-15,
        "{answer} {by_hand}"
    );
}
