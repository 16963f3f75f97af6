//! The distribution of a flake's normals.

use super::direction::dot;
use core::f64::consts::PI;

/// Beckmann density `D^α(h, m)` per solid angle of h, of a flake with mean normal `m`: \[AWKK21\] eq. 14.
///
/// `χ⁺(h·m) / (π α² cos⁴θ) exp(-tan²θ / α²)`, θ the angle between the unit vectors `h` and `m`; 0 from θ = 90° on.
/// `∫ D (h·m) dω = 1` over all directions. `alpha` > 0.
///
/// # Accuracy
/// Relative error below 1e-12 where `tan θ ≤ 10 α`, down to α = 1e-5, apart from what the rounding of `h` and `m`
/// themselves does to θ: `sin θ` comes from the cross product with the difference `h - m`, which is exact for
/// close vectors, not from `1 - cos²θ`.
pub fn beckmann(h: [f64; 3], m: [f64; 3], alpha: f64) -> f64 {
    let cosine = dot(h, m);
    if cosine <= 0.0 {
        return 0.0;
    }
    // h × m = (h - m) × m
    let d = [h[0] - m[0], h[1] - m[1], h[2] - m[2]];
    let cross = [
        d[1] * m[2] - d[2] * m[1],
        d[2] * m[0] - d[0] * m[2],
        d[0] * m[1] - d[1] * m[0],
    ];
    let tangent_over_alpha_squared = dot(cross, cross) / (cosine * alpha) / (cosine * alpha);
    let exponential = libm::exp(-tangent_over_alpha_squared);
    if exponential == 0.0 {
        // Near 90° the denominator may vanish as well.
        return 0.0;
    }
    let cosine_squared = cosine * cosine;
    exponential / (PI * alpha * alpha * cosine_squared * cosine_squared)
}
