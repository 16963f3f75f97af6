//! Half vectors drawn from a truth: a texel by its weight, then its kernel. Apart from the runtime's samplers.

use glintbake_format::model::HalfVector;
use std::f64::consts::TAU;

/// A half vector of a flake about the point (s, t) of the disk with Beckmann roughness `alpha`, or `None` below the
/// horizon.
///
/// `P(tan²θ < x) = 1 - exp(-x / α²)` about the flake's normal, any azimuth (Walter 2007, eq. 28 and 29).
pub(super) fn beckmann([s, t]: [f64; 2], alpha: f64, uniform: [f64; 2]) -> Option<HalfVector> {
    let tangent = alpha * (-libm::log1p(-uniform[0])).sqrt();
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let sine = tangent * cosine;
    let azimuth = TAU * uniform[1];
    let (along, across) = (sine * libm::cos(azimuth), sine * libm::sin(azimuth));
    // The frame whose pole is the normal (s, t, z), turned about (-t, s, 0): no length is divided by that may vanish.
    let z = (1.0 - s * s - t * t).max(0.0).sqrt();
    let share = 1.0 / (1.0 + z);
    let first = [1.0 - s * s * share, -s * t * share, -s];
    let second = [-s * t * share, 1.0 - t * t * share, -t];
    let normal = [s, t, z];
    let direction =
        [0, 1, 2].map(|axis| along * first[axis] + across * second[axis] + cosine * normal[axis]);
    let half_vector = HalfVector {
        s: direction[0],
        t: direction[1],
    };
    (direction[2] > 0.0 && half_vector.is_on_disk()).then_some(half_vector)
}

/// Two independent numbers of the standard normal distribution from two in [0, 1) (Box and Muller 1958).
pub(in crate::measure) fn standard_normal(uniform: [f64; 2]) -> [f64; 2] {
    let radius = (-2.0 * libm::log1p(-uniform[0])).sqrt();
    let angle = TAU * uniform[1];
    [radius * libm::cos(angle), radius * libm::sin(angle)]
}

/// The half vector at a point of the plane, if that is on the disk.
pub(super) fn on_disk([s, t]: [f64; 2]) -> Option<HalfVector> {
    let half_vector = HalfVector { s, t };
    half_vector.is_on_disk().then_some(half_vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_lie_about_the_normal_as_tangents_of_beckmann_do() {
        for normal in [[0.0, 0.0], [0.3, -0.4], [0.0, 0.9]] {
            let z = (1.0_f64 - normal[0] * normal[0] - normal[1] * normal[1]).sqrt();
            for step in 0..20 {
                let uniform = [f64::from(step) / 20.0, 0.37 + f64::from(step) * 0.21];
                let Some(h) = beckmann(normal, 0.01, uniform) else {
                    panic!("{normal:?} is far from the horizon");
                };
                let cosine =
                    h.s * normal[0] + h.t * normal[1] + z * (1.0 - h.s * h.s - h.t * h.t).sqrt();
                let below = 1.0 - (-(1.0 / (cosine * cosine) - 1.0) / 1e-4).exp();
                assert!((below - uniform[0]).abs() < 1e-9, "{below} {uniform:?}");
            }
        }
    }
}
