//! Directions from points of the projected disk, right to the last digits at the rim.

use super::double_double::DoubleDouble;
use glintbake_format::model::HalfVector;

/// The unit direction above the point (s, t) of the disk; beyond the disk the nearest direction on the horizon.
///
/// `1 - s² - t²` is formed with 106 bits: in f64 its rounding alone tilts a direction at the rim by up to 1e-8.
pub(super) fn direction(s: f64, t: f64) -> [f64; 3] {
    let squared = DoubleDouble::product(s, s) + DoubleDouble::product(t, t);
    let rest = DoubleDouble::from(1.0) - squared;
    if rest >= DoubleDouble::ZERO {
        [s, t, libm::sqrt(rest.value())]
    } else {
        let length = libm::sqrt(squared.value());
        [s / length, t / length, 0.0]
    }
}

/// The direction of `h`, or `None` outside the closed disk.
///
/// Whether a point is on the disk is decided in f64, as the word is defined for everyone: a unit vector's own
/// rounding must not put it outside.
pub(super) fn half_vector_direction(h: HalfVector) -> Option<[f64; 3]> {
    (h.s * h.s + h.t * h.t <= 1.0).then(|| direction(h.s, h.t))
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
