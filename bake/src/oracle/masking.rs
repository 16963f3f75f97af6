//! Masking of the map's own normals: the plain sum over all texels, \[AWKK21\] eq. 5.

use super::direction::{direction, dot};
use super::double_double::DoubleDouble;
use crate::normals::NormalMap;

/// What a texel's cosine to the surface is floored at, so that one at the rim has no infinite area.
pub const LEAST_COSINE: f64 = 0.01;

/// The share, in [0, 1], of the facets that face the unit direction `ω` which it sees, if no facet knows of another.
///
/// `G1(ω) = (ω·n) / Σ_k w_k max(0, ω·t_k) / max(t_k·n, LEAST_COSINE)` with `w_k` = 1/N, at most 1, and 1 where no facet
/// faces ω (the limit); 0 at the horizon and below. Texture area is area of the surface here, so each texel stands for
/// `1/(t_k·n)` of facet: the G1 for which the facets that ω sees project to as much as the surface does (\[Hei14\]), if it is
/// the same for all that face ω, as Smith has it.
pub fn masking(map: &NormalMap, omega: [f64; 3]) -> f64 {
    if omega[2] <= 0.0 {
        return 0.0;
    }
    let sum = map
        .texels()
        .iter()
        .fold(DoubleDouble::ZERO, |sum, &[s, t]| {
            let normal = direction(f64::from(s), f64::from(t));
            let facing = dot(omega, normal).max(0.0) / normal[2].max(LEAST_COSINE);
            sum + DoubleDouble::from(facing)
        });
    let seen = omega[2] * map.texels().len() as f64;
    let facing = sum.value();
    if seen < facing { seen / facing } else { 1.0 }
}
