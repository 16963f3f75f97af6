//! One Beckmann lobe about the surface's normal: layers without a map.

use crate::microfacet::beckmann;
use crate::microfacet::vector::dot;

/// The surface's normal.
const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// `D^α(h) G1(i) G1(o)` of a lobe of `roughness`, per steradian: what
/// [`masked_density`](crate::microfacet::brdf::masked_density) is of a P-NDF.
pub(super) fn masked_density(
    roughness: f64,
    incoming: [f64; 3],
    outgoing: [f64; 3],
    half: [f64; 3],
) -> f64 {
    beckmann::density(half, UP, roughness)
        * beckmann::masking(incoming, half, UP, roughness)
        * beckmann::masking(outgoing, half, UP, roughness)
}

/// A facet normal drawn with density `D (h·n)`.
pub(super) fn sample(roughness: f64, uniform: [f64; 2]) -> [f64; 3] {
    beckmann::sample(UP, roughness, uniform)
}

/// The density per solid angle of `incoming` of what [`sample`] mirrors: `D (h·n) / (4 (i·h))`.
pub(super) fn pdf(roughness: f64, incoming: [f64; 3], half: [f64; 3]) -> f64 {
    let [.., cosine] = half;
    beckmann::density(half, UP, roughness) * cosine / (4.0 * dot(incoming, half))
}
