//! What the normals of a map are like.

use super::NormalMap;
use super::vectors::CHUNK_TEXELS;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Facts about a decoded map, for the user to judge it by and for a package's metadata.
///
/// All but the lengths and the lattice describe the normals as they are stored, after clamping and repair. Sums run
/// over fixed chunks in order, so each figure is the same for any number of threads. Serialises with kebab-case keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Statistics {
    /// Texels of the map.
    pub texels: u64,
    /// Lengths of the stored vectors; none for two-component maps and heights.
    pub lengths: Option<Lengths>,
    /// Texels moved to the rim of the disk, because they lay at most a few lattice steps beyond it.
    pub clamped_to_rim: u64,
    /// Texels that could not be a normal (or a height), and took the nearest valid one.
    pub repaired: u64,
    /// Mean of (s, t); far from (0, 0) for a map that leans, or whose channels or zero are not what was said.
    pub mean: [f64; 2],
    /// Covariance of (s, t): of s, of s with t, of t; divided by the number of texels.
    pub covariance: [f64; 3],
    /// Mean of t·n, the texels' cosines to the surface: the integral of D over the disk \[AWKK21\].
    pub mean_cosine: f64,
    /// Largest angle between a texel's normal and the surface's, in degrees, 0 to 90.
    pub largest_tilt_degrees: f64,
    /// The lattice that s and t lie on; none for floats.
    pub lattice: Option<Lattice>,
}

impl Statistics {
    /// Standard deviation of the normals on the disk, `sqrt((var s + var t) / 2)`: the roughness that the map as a
    /// whole adds, in units of σr.
    pub fn spread(&self) -> f64 {
        let [ss, _, tt] = self.covariance;
        libm::sqrt((ss + tt) / 2.0)
    }
}

/// Lengths of stored vectors before they were normalised, over all valid texels.
///
/// 1 for a map as it was made; 0.9 and less after filtering, scaling or lossy compression.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Lengths {
    /// Mean.
    pub mean: f64,
    /// Shortest.
    pub shortest: f64,
    /// Longest.
    pub longest: f64,
}

/// The lattice of an integer map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Lattice {
    /// Bits per component: 8, or 16. Samples of 16 bit that are all multiples of 257, which is what widening does to
    /// 8 bit, count as 8.
    pub bits: u8,
    /// Distance of neighbouring values of s or t near the pole: 2/255 for 8-bit normals. For heights, half of the
    /// smallest height difference, in texels. Bins finer than this stay empty in rows.
    pub step: f64,
}

/// Moments of a map: the part of [`Statistics`] that the normals alone tell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    pub mean: [f64; 2],
    pub covariance: [f64; 3],
    pub mean_cosine: f64,
    pub largest_tilt_degrees: f64,
}

/// Sums over some texels; `spread` are sums of products of deviations from `mean`.
#[derive(Clone, Copy)]
struct Sums {
    count: f64,
    mean: [f64; 2],
    spread: [f64; 3],
    cosine: f64,
    least_cosine_squared: f64,
}

impl Moments {
    /// The moments of `map`.
    pub(super) fn of(map: &NormalMap) -> Self {
        let sums: Vec<Sums> = map
            .texels()
            .par_chunks(CHUNK_TEXELS)
            .map(Sums::of)
            .collect();
        let Some(total) = sums.into_iter().reduce(Sums::then) else {
            return Self {
                mean: [0.0; 2],
                covariance: [0.0; 3],
                mean_cosine: 1.0,
                largest_tilt_degrees: 0.0,
            };
        };
        let least = total.least_cosine_squared;
        let tilt = libm::atan2(libm::sqrt(1.0 - least), libm::sqrt(least));
        let [ss, st, tt] = total.spread.map(|sum| sum / total.count);
        Self {
            mean: total.mean,
            // Rounding may leave the variance of a constant map below zero.
            covariance: [ss.max(0.0), st, tt.max(0.0)],
            mean_cosine: total.cosine / total.count,
            largest_tilt_degrees: tilt.to_degrees(),
        }
    }
}

impl Sums {
    /// Sums over a chunk, which is not empty; deviations are taken from its first texel, so that a nearly flat map
    /// far from the pole loses no digits.
    fn of(texels: &[[f32; 2]]) -> Self {
        let [s_0, t_0] = texels[0].map(f64::from);
        let (mut ds, mut dt) = (0.0, 0.0);
        let mut products = [0.0; 3];
        let mut cosine = 0.0;
        let mut least_cosine_squared = 1.0_f64;
        for &[s, t] in texels {
            let (s, t) = (f64::from(s), f64::from(t));
            let squared = 1.0 - (s * s + t * t);
            cosine += squared.sqrt();
            least_cosine_squared = least_cosine_squared.min(squared);
            let (s, t) = (s - s_0, t - t_0);
            ds += s;
            dt += t;
            products[0] += s * s;
            products[1] += s * t;
            products[2] += t * t;
        }
        let count = texels.len() as f64;
        Self {
            count,
            mean: [s_0 + ds / count, t_0 + dt / count],
            spread: [
                products[0] - ds * ds / count,
                products[1] - ds * dt / count,
                products[2] - dt * dt / count,
            ],
            cosine,
            least_cosine_squared,
        }
    }

    /// Both together: the pairwise update of Chan, Golub and `LeVeque` (1979), eq. 1.5.
    fn then(self, later: Self) -> Self {
        let count = self.count + later.count;
        let delta = [0, 1].map(|i| later.mean[i] - self.mean[i]);
        let weight = self.count * later.count / count;
        let between = [
            delta[0] * delta[0] * weight,
            delta[0] * delta[1] * weight,
            delta[1] * delta[1] * weight,
        ];
        Self {
            count,
            mean: [0, 1].map(|i| self.mean[i] + delta[i] * (later.count / count)),
            spread: [0, 1, 2].map(|i| self.spread[i] + later.spread[i] + between[i]),
            cosine: self.cosine + later.cosine,
            least_cosine_squared: self.least_cosine_squared.min(later.least_cosine_squared),
        }
    }
}
