//! Densities of rough flakes: values by hand, energy, and the binned sum against the exact one.

use super::super::direction::{direction, dot};
use super::super::flake_bins::{
    Prepared, Setting, bin_centre, bin_of, bin_weights, ndf, neighbourhood_holds, neighbours, pdf,
    resolution,
};
use super::{checked_weights, in_texels, varied_map};
use crate::normals::NormalMap;
use crate::oracle::beckmann;
use glintbake_format::model::{Footprint, HalfVector, Neighbourhood, Wrap};
use std::collections::BTreeSet;

const BINS_45: Setting = Setting::Binned(Neighbourhood::Bins45);
const BINS_21: Setting = Setting::Binned(Neighbourhood::Bins21);

#[test]
fn resolutions_are_those_of_equation_16() {
    // Table 4 of the paper prints 942, 235, 59 and 15: one less, the ceiling left out.
    for (alpha, expected) in [
        (0.0025, 943),
        (0.01, 236),
        (0.04, 60),
        (0.16, 16),
        (1e-4, 23_571),
    ] {
        assert_eq!(resolution(alpha), expected, "alpha {alpha}");
    }
}

#[test]
fn bins_follow_the_paper() {
    assert_eq!(bin_of(0.0, 0.0, 5), (2, 2));
    assert_eq!(bin_of(-1.0, 1.0, 5), (0, 4));
    assert_eq!(bin_of(0.5, -0.5, 4), (3, 1));
    assert_eq!(bin_centre((2, 2), 5), [0.0, 0.0, 1.0]);
    assert_eq!(bin_centre((1, 2), 4), direction(-0.25, 0.25));
    // The middle of a corner bin lies beyond the disk.
    let corner = bin_centre((0, 0), 5);
    assert!((corner[0] + core::f64::consts::FRAC_1_SQRT_2).abs() < 1e-15 && corner[2] == 0.0);
}

#[test]
fn neighbourhoods_are_squares_without_corners() {
    let bins = |centre, neighbourhood| -> BTreeSet<(u32, u32)> {
        neighbours(centre, 20, neighbourhood).collect()
    };
    let inner = bins((10, 7), Neighbourhood::Bins45);
    assert_eq!(inner.len(), 45);
    assert!(inner.contains(&(7, 5)) && !inner.contains(&(7, 4)) && !inner.contains(&(13, 10)));
    let paper = bins((10, 7), Neighbourhood::Bins21);
    assert_eq!(paper.len(), 21);
    assert!(paper.contains(&(8, 6)) && !paper.contains(&(8, 5)));
    // In the grid's corner a quarter is left: 4 × 4 and 3 × 3 without the one far corner.
    assert_eq!(bins((0, 0), Neighbourhood::Bins45).len(), 15);
    assert_eq!(bins((19, 19), Neighbourhood::Bins21).len(), 8);
    assert_eq!(neighbours((0, 0), 1, Neighbourhood::Bins45).count(), 1);
}

#[test]
fn bins_gather_the_texels_that_fall_into_them() {
    let map = varied_map(9, 6, Wrap::Repeat);
    let footprint = in_texels(&map, [4.1, 2.2], [5.0, 1.0], [-2.0, 4.0]);
    let bins = bin_weights(&map, &footprint, 0.3);
    assert!((bins.values().sum::<f64>() - 1.0).abs() < 1e-14);
    let side = f64::from(resolution(0.3));
    for (&bin, &weight) in &bins {
        let expected: f64 = checked_weights(&map, &footprint)
            .into_iter()
            .filter(|((column, row), _)| {
                let [s, t] = map.texels()[(row * 9 + column) as usize].map(f64::from);
                let inside = |x: f64, k: u32| {
                    let low = 2.0 * f64::from(k) / side - 1.0;
                    (low..low + 2.0 / side).contains(&x)
                };
                inside(s, bin.0) && inside(t, bin.1)
            })
            .map(|(_, weight)| weight)
            .sum();
        assert!((weight - expected).abs() < 1e-15, "bin {bin:?}");
    }
}

#[test]
fn exact_density_is_the_sum_over_texels() {
    // Two texels under a footprint that takes a quarter of the one and three quarters of the other.
    let map = NormalMap::new(2, 1, Wrap::Repeat, vec![[0.25, 0.5], [-0.125, 0.0]]);
    let footprint = in_texels(&map, [1.25, 0.5], [1.0, 0.0], [0.0, 1.0]);
    let (alpha, h) = (0.5, HalfVector { s: 0.1, t: 0.3 });
    let direction_of_h = direction(0.1, 0.3);
    let normals = [(direction(0.25, 0.5), 0.25), (direction(-0.125, 0.0), 0.75)];
    let terms = normals.map(|(m, weight)| weight * beckmann(direction_of_h, m, alpha));
    let density = ndf(&map, &footprint, h, alpha, Setting::Exact);
    assert!((density - terms[0] - terms[1]).abs() < 1e-15 * density);
    let projected =
        terms[0] * dot(direction_of_h, normals[0].0) + terms[1] * dot(direction_of_h, normals[1].0);
    let drawn = pdf(&map, &footprint, h, alpha, Setting::Exact);
    assert!((drawn - projected).abs() < 1e-15 * drawn);
}

#[test]
fn binned_density_sees_the_neighbourhood_and_nothing_else() {
    let alpha = 0.16;
    let side = resolution(alpha);
    // One texel; h walks away from its bin along a row.
    let map = NormalMap::new(1, 1, Wrap::Repeat, vec![[0.03, 0.03]]);
    let footprint = in_texels(&map, [0.5, 0.5], [1.0, 0.0], [0.0, 1.0]);
    let (x, y) = bin_of(0.03, 0.03, side);
    let centre = bin_centre((x, y), side);
    for (setting, reach) in [(BINS_45, 3), (BINS_21, 2)] {
        for dx in -5i32..=5 {
            for dy in -5i32..=5 {
                let middle = |k: u32, d: i32| {
                    (2.0 * (f64::from(k) + f64::from(d)) + 1.0) / f64::from(side) - 1.0
                };
                let h = HalfVector {
                    s: middle(x, dx) + 0.1 / f64::from(side),
                    t: middle(y, dy),
                };
                let near = dx.abs().max(dy.abs()) <= reach && dx.abs() + dy.abs() < 2 * reach;
                let expected = if near {
                    beckmann(direction(h.s, h.t), centre, alpha)
                } else {
                    0.0
                };
                assert_eq!(
                    ndf(&map, &footprint, h, alpha, setting),
                    expected,
                    "{dx} {dy}"
                );
            }
        }
    }
}

#[test]
fn outside_the_disk_there_is_nothing() {
    let map = varied_map(4, 4, Wrap::Repeat);
    let footprint = in_texels(&map, [1.0, 1.0], [3.0, 0.0], [0.0, 3.0]);
    for setting in [Setting::Exact, BINS_45, BINS_21] {
        let prepared = Prepared::new(&map, &footprint, 1.0, setting);
        for (s, t) in [
            (1.0 + 1e-15, 0.0),
            (0.8, 0.61),
            (-3.0, 4.0),
            (f64::NAN, 0.0),
        ] {
            let h = HalfVector { s, t };
            assert_eq!((prepared.ndf(h), prepared.pdf(h)), (0.0, 0.0), "({s}, {t})");
        }
    }
    let rim = HalfVector { s: -0.6, t: 0.8 };
    let prepared = Prepared::new(&map, &footprint, 1.0, Setting::Exact);
    assert!(prepared.ndf(rim) > 0.0 && prepared.pdf(rim) > 0.0);
}

/// Mass of the sampler's pdf over the bins at most `reach` from the bin of the only normal of a map.
fn mass_about(prepared: &Prepared, (x, y): (u32, u32), side: u32, reach: i32) -> f64 {
    // Midpoints whose cells do not cross a border of bins, where the density jumps.
    let per_bin = 24;
    let width = 2.0 / f64::from(side) / f64::from(per_bin);
    let first = |k: u32| 2.0 * f64::from(k) / f64::from(side) - 1.0;
    let steps = -reach * per_bin..(reach + 1) * per_bin;
    let mut mass = 0.0;
    for row in steps.clone() {
        for column in steps.clone() {
            let h = HalfVector {
                s: first(x) + (f64::from(column) + 0.5) * width,
                t: first(y) + (f64::from(row) + 0.5) * width,
            };
            if h.s * h.s + h.t * h.t < 1.0 {
                // dω = ds dt / z
                mass += prepared.pdf(h) * width * width / direction(h.s, h.t)[2];
            }
        }
    }
    mass
}

#[test]
fn the_neighbourhood_keeps_the_energy() {
    for (s, t) in [(0.0, 0.0), (0.3, -0.4), (0.7, 0.1)] {
        let map = NormalMap::new(1, 1, Wrap::Repeat, vec![[s, t]]);
        let footprint = Footprint::square([0.5, 0.5], 1.0, 1, 1);
        for alpha in [0.01, 0.04, 0.07] {
            let side = resolution(alpha);
            let bin = bin_of(f64::from(s), f64::from(t), side);
            let lost = |setting| {
                let prepared = Prepared::new(&map, &footprint, alpha, setting);
                1.0 - mass_about(&prepared, bin, side, 5)
            };
            // Foreshortening narrows a tilted kernel on the disk, so the pole loses most. Rounding b up shrinks the
            // bins: by 2 % at α = 0.07, whence 8.2e-5 instead of 6.1e-5, and 1.3 % instead of 1.0 %.
            let loss_45 = lost(BINS_45);
            assert!((1e-5..8.5e-5).contains(&loss_45), "{loss_45} {alpha}");
            let loss_21 = lost(BINS_21);
            assert!((3e-3..1.35e-2).contains(&loss_21), "{loss_21} {alpha}");
            // Five bins to a side reach beyond 6σ: the exact sum loses nothing there.
            let exact = lost(Setting::Exact);
            assert!(exact.abs() < 2e-7, "{exact} {alpha}");
        }
    }
}

#[test]
fn at_the_pole_the_loss_is_the_tail_of_a_normal_distribution() {
    for alpha in [0.001, 0.0025] {
        // A normal at the middle of its bin, so near the pole that slopes and the disk are the same.
        let side = resolution(alpha);
        let sigma = alpha * core::f64::consts::FRAC_1_SQRT_2;
        let above = |bins: f64| {
            let deviations = bins / f64::from(side) / sigma;
            0.5 * libm::erfc(deviations * core::f64::consts::FRAC_1_SQRT_2)
        };
        let map = NormalMap::new(1, 1, Wrap::Repeat, vec![[0.0, 0.0]]);
        let footprint = Footprint::square([0.5, 0.5], 1.0, 1, 1);
        for (setting, bins) in [(BINS_45, 7.0), (BINS_21, 5.0)] {
            let prepared = Prepared::new(&map, &footprint, alpha, setting);
            let lost = 1.0 - mass_about(&prepared, (side / 2, side / 2), side, 4);
            // A square of `bins` bins a side, half of it to either side of the middle, without four corner bins.
            let inside = 1.0 - 2.0 * above(bins);
            let edge = above(bins - 2.0) - above(bins);
            let expected = 1.0 - inside * inside + 4.0 * edge * edge;
            assert!(
                (lost / expected - 1.0).abs() < 5e-3,
                "{lost} instead of {expected} with {bins} bins a side, alpha {alpha}"
            );
        }
    }
}

#[test]
fn binned_and_exact_densities_agree_for_normals_at_bin_centres() {
    let alpha = 0.04;
    let side = resolution(alpha);
    let texels = [(30, 30), (31, 33), (28, 30), (33, 29)].map(|bin| {
        let [s, t, _] = bin_centre(bin, side);
        [s as f32, t as f32]
    });
    let map = NormalMap::new(2, 2, Wrap::Repeat, texels.to_vec());
    let footprint = in_texels(&map, [0.9, 1.2], [1.1, 0.3], [-0.2, 0.8]);
    let [exact, binned] =
        [Setting::Exact, BINS_45].map(|setting| Prepared::new(&map, &footprint, alpha, setting));
    let mut largest: f64 = 0.0;
    for i in 0..60 {
        for j in 0..60 {
            let h = HalfVector {
                s: f64::from(i) / 100.0 - 0.3,
                t: f64::from(j) / 100.0 - 0.3,
            };
            let (truth, answer) = (exact.ndf(h), binned.ndf(h));
            largest = largest.max(truth);
            // What the neighbourhood cuts off starts 3.5 bins = 4.2σ from the normal: exp(-4.2²/2) of a peak at most.
            let peak = 1.0 / (core::f64::consts::PI * alpha * alpha);
            assert!(
                (truth - answer).abs() < 2e-4 * peak,
                "{truth} {answer} at {h:?}"
            );
        }
    }
    assert!(largest > 50.0, "the picture must hold something: {largest}");
}

#[test]
fn a_neighbourhood_holds_its_neighbours_and_no_other_bin() {
    let side = resolution(0.3);
    for neighbourhood in [Neighbourhood::Bins21, Neighbourhood::Bins45] {
        for centre in [(0, 0), (1, side - 1), (side / 2, side / 2)] {
            let near: BTreeSet<_> = neighbours(centre, side, neighbourhood).collect();
            for bin in (0..side).flat_map(|row| (0..side).map(move |column| (column, row))) {
                let holds = neighbourhood_holds(centre, bin, neighbourhood);
                assert_eq!(holds, near.contains(&bin), "{centre:?} {bin:?}");
            }
        }
    }
}
