//! The Beckmann distribution of a flake's own microfacets and its masking, Walter et al. 2007.

use super::vector::{cross, dot, frame};
use core::f64::consts::PI;

/// The density of facet normals at `half_vector` about `normal`, per steradian: \[AWKK21\] eq. 14.
///
/// `D = exp(-tan²θ / α²) / (π α² cos⁴θ)`, 0 where the angle θ between the unit vectors is 90° or more.
/// `∫ D (h·n) dω = 1`. sin θ comes from the cross product, so that nothing cancels for needle-sharp lobes.
pub fn density(half_vector: [f64; 3], normal: [f64; 3], roughness: f64) -> f64 {
    let cosine = dot(half_vector, normal);
    if cosine <= 0.0 {
        return 0.0;
    }
    let perpendicular = cross(half_vector, normal);
    let squared = cosine * cosine;
    let tangent_squared = dot(perpendicular, perpendicular) / squared;
    let alpha_squared = roughness * roughness;
    // The exponential underflows to zero before cos⁴ can overflow the quotient, except at cos ≈ 1e-80, where the
    // product is 0 × ∞: far below the smallest tangent that leaves anything of the exponential.
    let tail = libm::exp(-tangent_squared / alpha_squared);
    if tail == 0.0 {
        0.0
    } else {
        tail / (PI * alpha_squared * squared * squared)
    }
}

/// A facet normal drawn with density `D (m·n)` about the unit vector `normal`, from two uniform numbers in [0, 1).
///
/// tan²θ = -α² ln(1 - ξ), φ uniform (Walter et al. 2007, eq. 28 and 29).
pub fn sample(normal: [f64; 3], roughness: f64, uniform: [f64; 2]) -> [f64; 3] {
    let tangent_squared = -roughness * roughness * libm::log1p(-uniform[0]);
    let cosine = 1.0 / libm::sqrt(1.0 + tangent_squared);
    let sine = cosine * libm::sqrt(tangent_squared);
    let angle = 2.0 * PI * uniform[1];
    let (x, y) = (sine * libm::cos(angle), sine * libm::sin(angle));
    let [tangent, bitangent] = frame(normal);
    core::array::from_fn(|axis| {
        #[expect(
            clippy::indexing_slicing,
            reason = "an array of three, indexed below three"
        )]
        let component = x * tangent[axis] + y * bitangent[axis] + cosine * normal[axis];
        component
    })
}

/// Smith's masking of the unit `direction` seen from a facet of normal `half_vector` on a flake of `normal`, in [0, 1].
///
/// `G1 = χ⁺((v·m)/(v·n)) 2 / (1 + erf(a) + exp(-a²) / (a √π))` with `a = 1 / (α tan θ)`: the exact form of Walter
/// et al. 2007 eq. 23, of which their rational fit (eq. 27) is within 0.35 %.
pub fn masking(
    direction: [f64; 3],
    half_vector: [f64; 3],
    normal: [f64; 3],
    roughness: f64,
) -> f64 {
    let cosine = dot(direction, normal);
    if cosine <= 0.0 || dot(direction, half_vector) <= 0.0 {
        return 0.0;
    }
    let perpendicular = cross(direction, normal);
    let sine = libm::sqrt(dot(perpendicular, perpendicular));
    let a = cosine / (roughness * sine);
    // Beyond 6 the error function is 1 and the tail below 1e-16; also catches a = ∞ at normal incidence.
    if a > 6.0 {
        return 1.0;
    }
    2.0 / (1.0 + libm::erf(a) + libm::exp(-a * a) / (a * libm::sqrt(PI)))
}
