//! Three-component vectors: directions and colours.

use libm::sqrt;

/// A direction or a colour.
pub(super) type Vector = [f64; 3];

/// `a + b`.
pub(super) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a` times `factor`.
pub(super) fn scale(a: Vector, factor: f64) -> Vector {
    a.map(|component| component * factor)
}

/// The product of each component.
pub(super) fn tint(a: Vector, b: Vector) -> Vector {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// The dot product.
pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a` scaled to unit length; `a` must not vanish.
pub(super) fn normalised(a: Vector) -> Vector {
    scale(a, 1.0 / sqrt(dot(a, a)))
}

/// 0 below `from`, 1 above `to`, a cubic without corners between; falls if `from` is above `to`.
pub(super) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
