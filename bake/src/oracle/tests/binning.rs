//! Counts of samples against the densities they stand for.

use super::super::analytic::Prepared;
use super::super::binning::{Binned, Window};
use super::super::gauss_legendre::GaussLegendre;
use super::{in_texels, varied_map};
use crate::normals::NormalMap;
use core::f64::consts::FRAC_1_SQRT_2;
use glintbake_format::model::{HalfVector, Interpolation, Wrap};

/// Pearson's statistic of counts against probabilities, over pixels where at least ten are expected; everything else is
/// one more. In standard deviations from its mean.
fn excess(binned: &Binned, probabilities: &[f64]) -> f64 {
    let samples = binned.samples as f64;
    let term = |count: f64, expected: f64| (count - expected) * (count - expected) / expected;
    let (mut statistic, mut freedom) = (0.0, 0.0);
    let (mut rest, mut expected_rest) = (samples, samples);
    for (&count, probability) in binned.counts.iter().zip(probabilities) {
        let expected = samples * probability;
        if expected >= 10.0 {
            statistic += term(count as f64, expected);
            freedom += 1.0;
            rest -= count as f64;
            expected_rest -= expected;
        }
    }
    if expected_rest >= 10.0 {
        statistic += term(rest, expected_rest);
    } else {
        freedom -= 1.0;
    }
    assert!(freedom > 50.0, "only {freedom} pixels have samples");
    (statistic - freedom) / libm::sqrt(2.0 * freedom)
}

#[test]
fn a_flat_map_is_a_gaussian_of_the_roughness() {
    let map = NormalMap::new(2, 2, Wrap::Repeat, vec![[0.125, -0.25]; 4]);
    let footprint = in_texels(&map, [1.0, 1.0], [1.0, 0.2], [0.0, 2.0]);
    let alpha = 0.1;
    let window = Window {
        centre: [0.15, -0.2],
        extent: 0.25,
        side: 32,
    };
    let binned = Binned::new(
        &map,
        &footprint,
        Interpolation::Linear,
        alpha,
        window,
        300_000,
        7,
    );
    let below =
        |x: f64, mean: f64| 0.5 * libm::erfc(-(x - mean) / (FRAC_1_SQRT_2 * alpha) * FRAC_1_SQRT_2);
    let half = 0.5 * window.pitch();
    let between = |x: f64, mean: f64| below(x + half, mean) - below(x - half, mean);
    let probabilities: Vec<f64> = (0..32 * 32)
        .map(|k| {
            let [s, t] = window.middle(k % 32, k / 32);
            between(s, 0.125) * between(t, -0.25)
        })
        .collect();
    let excess = excess(&binned, &probabilities);
    assert!(excess.abs() < 5.0, "{excess}");
}

#[test]
fn pictures_of_the_surface_are_its_integral() {
    for (wrap, interpolation) in [
        (Wrap::Repeat, Interpolation::Linear),
        (Wrap::Clamp, Interpolation::CatmullRom),
        (Wrap::Clamp, Interpolation::None),
    ] {
        let map = varied_map(5, 4, wrap);
        let footprint = in_texels(&map, [4.1, 0.7], [0.5, 0.2], [-0.3, 0.6]);
        let alpha = 0.1;
        let window = Window {
            centre: [0.05, 0.0],
            extent: 0.6,
            side: 12,
        };
        let binned = Binned::new(&map, &footprint, interpolation, alpha, window, 200_000, 1);
        let prepared = Prepared::new(&map, &footprint, interpolation);
        let rule = GaussLegendre::new(3);
        let half = 0.5 * window.pitch();
        let probabilities: Vec<f64> = (0..12 * 12)
            .map(|k| {
                let [s, t] = window.middle(k % 12, k / 12);
                let mut sum = 0.0;
                for (s, width) in rule.nodes(s - half, s + half) {
                    for (t, height) in rule.nodes(t - half, t + half) {
                        sum += width * height * prepared.ndf(HalfVector { s, t }, alpha);
                    }
                }
                sum
            })
            .collect();
        let excess = excess(&binned, &probabilities);
        assert!(excess.abs() < 5.0, "{wrap:?} {interpolation:?}: {excess}");
        // Densities are counts per area.
        let (peak, place) = binned
            .densities()
            .into_iter()
            .zip(0..)
            .fold((0.0, 0), |a: (f64, usize), b| if b.0 > a.0 { b } else { a });
        let expected = binned.counts[place] as f64 / 200_000.0 / (4.0 * half * half);
        assert!((peak / expected - 1.0).abs() < 1e-12);
    }
}

#[test]
fn counts_do_not_depend_on_threads_and_seeds_differ() {
    let map = varied_map(5, 4, Wrap::Repeat);
    let footprint = in_texels(&map, [4.1, 0.7], [0.8, 0.3], [-0.4, 1.1]);
    let drawn = |seed: u64| {
        let window = Window::disk(64);
        Binned::new(
            &map,
            &footprint,
            Interpolation::Linear,
            0.3,
            window,
            100_000,
            seed,
        )
    };
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap()
        .install(|| drawn(5));
    assert_eq!(alone, drawn(5));
    assert_ne!(alone, drawn(6));
    // What lies beyond the rim is not counted.
    let inside: u64 = alone.counts.iter().sum();
    assert!(inside < 100_000 && inside > 80_000, "{inside}");
    assert_eq!(alone.counts[0], 0);
    // s grows to the right and t upwards.
    let [s, t] = Window::disk(64).middle(63, 0);
    assert!(s > 0.98 && t > 0.98);
}
