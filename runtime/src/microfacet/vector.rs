//! Three-component vectors, as far as microfacets need them.

/// The dot product of `a` and `b`.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product of `a` and `b`.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `a` scaled to unit length, or `None` if it has no direction.
pub(crate) fn normalised(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = libm::sqrt(dot(a, a));
    (length > 0.0 && length.is_finite()).then(|| a.map(|component| component / length))
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`.
///
/// Duff et al. 2017, "Building an Orthonormal Basis, Revisited": no branch but the sign, no loss anywhere.
pub(crate) fn frame(n: [f64; 3]) -> [[f64; 3]; 2] {
    let sign = if n[2] < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [
        [1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]],
        [b, sign + n[1] * n[1] * a, -n[1]],
    ]
}
