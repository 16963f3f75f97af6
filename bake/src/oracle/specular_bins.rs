//! Specular flakes, averaged over bins of equal solid angle \[ABKK20\].

use super::direction::direction;
use super::double_double::DoubleDouble;
use super::weights::{TexelWeight, box_weights};
use crate::normals::NormalMap;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use glintbake_format::model::{Footprint, HalfVector};
use std::collections::BTreeMap;

/// Bin (column, row) of a normal, for a grid of `bins_per_side` × `bins_per_side` over [`square_of`].
///
/// A coordinate of exactly 1 belongs to the last bin.
pub fn bin_of(normal: HalfVector, bins_per_side: u32) -> (u32, u32) {
    let place = |x: f64| {
        let bin = libm::floor(x * f64::from(bins_per_side));
        bin.clamp(0.0, f64::from(bins_per_side - 1)) as u32
    };
    let [x, y] = square_of(normal);
    (place(x), place(y))
}

/// The point of the unit square that stands for a normal: the inverse of [`normal_at`].
///
/// Beyond the disk, that of the nearest normal on the horizon. Accurate to about 1e-15 for the numbers given, so a
/// test can tell how near to a border of its bin a normal lies; near the rim the rounding of s and t to f64 alone
/// shifts the point by up to 1e-8.
pub fn square_of(normal: HalfVector) -> [f64; 2] {
    let HalfVector { s, t } = normal;
    // 1 - z = sin²θ / (1 + cos θ), which has no difference of near numbers at the pole.
    let cosine = direction(s, t)[2];
    let radius = libm::sqrt((s * s + t * t).min(1.0) / (1.0 + cosine));
    // The map mirrors with s and with t: each quarter of the disk around an axis needs only the angle from it.
    let across = |minor: f64, major: f64| radius * libm::atan2(minor, major.abs()) / FRAC_PI_4;
    let [a, c] = if s.abs() > t.abs() {
        [libm::copysign(radius, s), across(t, s)]
    } else {
        [across(s, t), libm::copysign(radius, t)]
    };
    [0.5 * a + 0.5, 0.5 * c + 0.5]
}

/// The normal at a point of the unit square: concentric map to the disk (Shirley and Chiu 1997), then equal-area lift.
///
/// With a = 2x - 1 and c = 2y - 1, `(r, φ) = (a, π/4 c/a)` where |a| > |c|, else `(c, π/2 - π/4 a/c)`; the normal at
/// azimuth φ has `1 - z = r²`, so `dω = 2 r dr dφ` and equal areas of the square are equal solid angles.
pub fn normal_at([x, y]: [f64; 2]) -> HalfVector {
    let (a, c) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let (radius, azimuth) = if a == 0.0 && c == 0.0 {
        (0.0, 0.0)
    } else if a.abs() > c.abs() {
        (a, FRAC_PI_4 * c / a)
    } else {
        (c, FRAC_PI_2 - FRAC_PI_4 * a / c)
    };
    let z = 1.0 - radius * radius;
    // sin²θ = (1 - z)(1 + z)
    let sine = radius * libm::sqrt(1.0 + z);
    HalfVector {
        s: sine * libm::cos(azimuth),
        t: sine * libm::sin(azimuth),
    }
}

/// Solid angle of each bin, `|H| = 2π / B` with B = `bins_per_side`².
pub fn solid_angle(bins_per_side: u32) -> f64 {
    2.0 * PI / (f64::from(bins_per_side) * f64::from(bins_per_side))
}

/// Weight `Σ w_k` of every bin (column, row) that holds a normal under the footprint; they sum to 1.
///
/// # Panics
/// As [`box_weights`].
pub fn bin_weights(
    map: &NormalMap,
    footprint: &Footprint,
    bins_per_side: u32,
) -> BTreeMap<(u32, u32), f64> {
    bin_weights_of(map, &box_weights(map, footprint), bins_per_side)
}

/// [`bin_weights`] of texels weighed by any filter.
///
/// # Panics
/// If a texel is not on the map.
pub fn bin_weights_of(
    map: &NormalMap,
    weights: &[TexelWeight],
    bins_per_side: u32,
) -> BTreeMap<(u32, u32), f64> {
    let mut bins: BTreeMap<(u32, u32), DoubleDouble> = BTreeMap::new();
    for texel in weights {
        let index = texel.row as usize * map.width() as usize + texel.column as usize;
        let [s, t] = map.texels()[index].map(f64::from);
        let sum = bins
            .entry(bin_of(HalfVector { s, t }, bins_per_side))
            .or_default();
        *sum = *sum + DoubleDouble::from(texel.weight);
    }
    bins.into_iter()
        .map(|(bin, sum)| (bin, sum.value()))
        .collect()
}

/// Density `D(h) = Σ w_k / |H|` over the texels whose normal is in h's bin; 0 outside the closed unit disk.
///
/// Per solid angle of h, \[ABKK20\] §2.
///
/// # Panics
/// As [`box_weights`].
pub fn ndf(map: &NormalMap, footprint: &Footprint, h: HalfVector, bins_per_side: u32) -> f64 {
    Prepared::new(map, footprint, bins_per_side).ndf(h)
}

/// Density per solid angle with which the sampler draws `h`: see [`Prepared::pdf`].
///
/// # Panics
/// As [`box_weights`].
pub fn pdf(map: &NormalMap, footprint: &Footprint, h: HalfVector, bins_per_side: u32) -> f64 {
    Prepared::new(map, footprint, bins_per_side).pdf(h)
}

/// The weights of one footprint, for many half vectors.
#[derive(Clone, Debug)]
pub struct Prepared {
    bins_per_side: u32,
    bins: BTreeMap<(u32, u32), f64>,
}

impl Prepared {
    /// The bins under `footprint`.
    ///
    /// # Panics
    /// As [`box_weights`].
    pub fn new(map: &NormalMap, footprint: &Footprint, bins_per_side: u32) -> Self {
        Self::from_weights(map, &box_weights(map, footprint), bins_per_side)
    }

    /// The bins of the texels in `weights`, weighed by any filter (see [`texel_weights`](super::texel_weights)).
    ///
    /// # Panics
    /// If a texel is not on the map.
    pub fn from_weights(map: &NormalMap, weights: &[TexelWeight], bins_per_side: u32) -> Self {
        Self {
            bins_per_side,
            bins: bin_weights_of(map, weights, bins_per_side),
        }
    }

    /// Density `D(h) = Σ w_k / |H|` over the texels whose normal is in h's bin; 0 outside the closed unit disk.
    pub fn ndf(&self, h: HalfVector) -> f64 {
        let is_on_disk = h.s * h.s + h.t * h.t <= 1.0;
        if !is_on_disk {
            return 0.0;
        }
        let weight = self.bins.get(&bin_of(h, self.bins_per_side));
        weight.map_or(0.0, |weight| weight / solid_angle(self.bins_per_side))
    }

    /// Density per solid angle of h of a sampler that draws a texel, then a normal uniform in its bin.
    ///
    /// The same number as [`Self::ndf`]; it integrates to 1 over the hemisphere.
    pub fn pdf(&self, h: HalfVector) -> f64 {
        self.ndf(h)
    }
}
