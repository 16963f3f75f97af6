//! The truth of the kernel `disk`: a Gaussian on the projected disk about every texel's normal \[YHJ*14\].
//!
//! `D(s) = Σ_k w_k N(s - t_k; σr² I)` with σr = α / √2 (\[Hei14\]), as a density of the disk. Because ds = (h·n) dω that is
//! numerically the microfacet density D, and `∫_disk D ds + P(no vector) = 1`: what a Gaussian leaves beyond the rim is the
//! probability of no vector. Every method of this kernel is an approximation of this sum.

use super::direction::half_vector_direction;
use super::double_double::DoubleDouble;
use super::weights::{TexelWeight, texel_weights};
use crate::normals::NormalMap;
use core::f64::consts::PI;
use glintbake_format::model::{Filter, Footprint, HalfVector};

/// Density `D(h)` under the footprint, per solid angle of h; 0 outside the closed unit disk.
///
/// # Panics
/// As [`texel_weights`].
pub fn ndf(
    map: &NormalMap,
    footprint: &Footprint,
    filter: Filter,
    h: HalfVector,
    alpha: f64,
) -> f64 {
    Prepared::new(map, footprint, filter, alpha).ndf(h)
}

/// Density per solid angle with which a sampler of the sum draws `h`: see [`Prepared::pdf`].
///
/// # Panics
/// As [`texel_weights`].
pub fn pdf(
    map: &NormalMap,
    footprint: &Footprint,
    filter: Filter,
    h: HalfVector,
    alpha: f64,
) -> f64 {
    Prepared::new(map, footprint, filter, alpha).pdf(h)
}

/// The texels of one footprint, for many half vectors.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// σr² = α² / 2.
    variance: f64,
    /// Point of the disk and weight of each texel.
    texels: Vec<([f64; 2], f64)>,
}

impl Prepared {
    /// The texels under `footprint` as `filter` weighs them, for Beckmann roughness `alpha`.
    ///
    /// # Panics
    /// As [`texel_weights`].
    pub fn new(map: &NormalMap, footprint: &Footprint, filter: Filter, alpha: f64) -> Self {
        Self::from_weights(map, &texel_weights(map, footprint, filter), alpha)
    }

    /// The texels in `weights`, weighed by any filter.
    ///
    /// # Panics
    /// If a texel is not on the map.
    pub fn from_weights(map: &NormalMap, weights: &[TexelWeight], alpha: f64) -> Self {
        let width = map.width() as usize;
        let texels = weights
            .iter()
            .map(|texel| {
                let index = texel.row as usize * width + texel.column as usize;
                (map.texels()[index].map(f64::from), texel.weight)
            })
            .collect();
        Self {
            variance: 0.5 * alpha * alpha,
            texels,
        }
    }

    /// Density `D(h)` per solid angle of h, which is that per area of the disk; 0 outside the closed unit disk.
    pub fn ndf(&self, h: HalfVector) -> f64 {
        if half_vector_direction(h).is_none() {
            return 0.0;
        }
        let peak = 1.0 / (2.0 * PI * self.variance);
        let add = |sum: DoubleDouble, &([s, t], weight): &([f64; 2], f64)| {
            let squared = (h.s - s) * (h.s - s) + (h.t - t) * (h.t - t);
            sum + DoubleDouble::product(weight, peak * libm::exp(-squared / (2.0 * self.variance)))
        };
        self.texels.iter().fold(DoubleDouble::ZERO, add).value()
    }

    /// Density per solid angle of h of a sampler that draws a texel, then a point about its normal, and gives no vector
    /// beyond the rim: `D(h) (h·n)` with the surface's normal n.
    pub fn pdf(&self, h: HalfVector) -> f64 {
        half_vector_direction(h).map_or(0.0, |[.., cosine]| self.ndf(h) * cosine)
    }
}
