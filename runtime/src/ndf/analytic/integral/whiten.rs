//! Whitening: an affine piece of the surface, seen by the query's Gaussian of four dimensions, laid into a plane.
//!
//! In standard deviations, the query of a footprint and a half vector is a unit Gaussian about the origin of four dimensions,
//! two of position and two of normals. A piece on which normals are affine is a plane piece there: two edges from one corner.
//! An orthonormal basis of its plane gives it two coordinates, under which the integrand of \[YHJ*14\] eq. 8 is a unit Gaussian of two
//! dimensions, times `e^{-c²/2}` for the plane's distance c from the origin. That basis is the QR factorisation of the
//! stacked factors `[E⁻¹; J/σr]`, times the edges; the sum `Σp⁻¹ + JᵀJ/σr²`, which loses what matters when J is stiff or
//! singular, is never formed.

/// A point or an edge: position, in standard deviations of the footprint, and normal, in those of the roughness.
pub(crate) type Point = [f64; 4];

/// A piece in the coordinates of its own plane.
///
/// Its edges are (`length`, 0) and (`shear`, `height`), turning left from the first to the second; `length` and `height` are positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whitened {
    /// The corner that both edges leave from; the origin is the foot of the Gaussian's centre.
    pub corner: [f64; 2],
    pub length: f64,
    pub shear: f64,
    pub height: f64,
    /// Squared distance of the plane from the Gaussian's centre.
    pub residual: f64,
}

/// The piece at `corner` with two `edges`; `None` if these do not span a plane.
///
/// Rows of normals go first, edges of greater change of normal first: then rows keep their own relative accuracy whatever
/// the ratio of their scales (Powell and Reid 1969; Cox and Higham 1998), and a Jacobian of rank 1, mirrored or folded,
/// leaves exactly nothing for its second column. Nothing is a difference of squares.
#[inline]
pub(super) fn whiten(corner: Point, edges: [Point; 2]) -> Option<Whitened> {
    let [first, second] = edges;
    let change = |[_, _, s, t]: Point| s * s + t * t;
    let is_ordered = change(first) >= change(second);
    let [[p_1, q_1, s_1, t_1], [p_2, q_2, s_2, t_2]] = if is_ordered {
        [first, second]
    } else {
        [second, first]
    };
    let [p_0, q_0, s_0, t_0] = corner;
    // The two rows of normals turned so that the first column has one entry.
    let steep = libm::sqrt(s_1 * s_1 + t_1 * t_1);
    let (along, across, corner_along, corner_across) = if steep > 0.0 {
        let (c, s) = (s_1 / steep, t_1 / steep);
        (
            c * s_2 + s * t_2,
            cross([s_1, t_1], [s_2, t_2]) / steep,
            c * s_0 + s * t_0,
            c * t_0 - s * s_0,
        )
    } else {
        (0.0, 0.0, s_0, t_0)
    };
    let (steep, along, corner_along, p_2, p_0) =
        turn([steep, along, corner_along], [p_1, p_2, p_0]);
    let (length, shear, x, q_2, q_0) = turn([steep, along, corner_along], [q_1, q_2, q_0]);
    // What is left of the second edge and of the corner is perpendicular to the first edge, in three dimensions.
    let height = libm::sqrt(across * across + p_2 * p_2 + q_2 * q_2);
    let spans = length > 0.0 && height > 0.0;
    if !spans {
        return None;
    }
    let inverse = 1.0 / height;
    let [a, p, q] = [across * inverse, p_2 * inverse, q_2 * inverse];
    let y = a * corner_across + p * p_0 + q * q_0;
    let [u, v, w] = [
        a * p_0 - p * corner_across,
        p * q_0 - q * p_0,
        q * corner_across - a * q_0,
    ];
    Some(Whitened {
        corner: [x, y],
        length,
        shear,
        height,
        residual: u * u + v * v + w * w,
    })
}

/// Two rows turned so that the lower one begins with zero: the upper one's entries, and the rest of the lower one.
#[inline(always)]
fn turn(upper: [f64; 3], lower: [f64; 3]) -> (f64, f64, f64, f64, f64) {
    let ([a_1, a_2, a_0], [b_1, b_2, b_0]) = (upper, lower);
    let length = libm::sqrt(a_1 * a_1 + b_1 * b_1);
    if length > 0.0 {
        let (c, s) = (a_1 / length, b_1 / length);
        (
            length,
            c * a_2 + s * b_2,
            c * a_0 + s * b_0,
            c * b_2 - s * a_2,
            c * b_0 - s * a_0,
        )
    } else {
        (0.0, a_2, a_0, b_2, b_0)
    }
}

/// `a × b`, to the last digits also where its products nearly cancel: then with the errors of both products (Dekker 1971).
#[inline]
fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (first, second) = (a[0] * b[1], a[1] * b[0]);
    let difference = first - second;
    if difference.abs() > 0.125 * first.abs() {
        return difference;
    }
    difference + (product_error(a[0], b[1], first) - product_error(a[1], b[0], second))
}

/// `a b - product` without rounding, where `product` is their rounded product; both below 1e150.
#[inline]
fn product_error(a: f64, b: f64, product: f64) -> f64 {
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
}

/// A number as the sum of two of 26 bits (Veltkamp).
#[inline]
fn split(x: f64) -> (f64, f64) {
    /// 2²⁷ + 1.
    const SPLITTER: f64 = 134_217_729.0;
    let scaled = x * SPLITTER;
    let high = scaled - (scaled - x);
    (high, x - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(a: Point, b: Point) -> f64 {
        a.iter().zip(&b).map(|(a, b)| a * b).sum()
    }

    /// Every inner product of a whitened piece is that of the piece itself.
    fn check(corner: Point, edges: [Point; 2], tolerance: f64) {
        let found = whiten(corner, edges).expect("it spans a plane");
        let ordered = edges[0][2].hypot(edges[0][3]) >= edges[1][2].hypot(edges[1][3]);
        let [first, second] = if ordered { edges } else { [edges[1], edges[0]] };
        let (one, two) = ([found.length, 0.0], [found.shear, found.height]);
        let plane = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let scale = |a: Point, b: Point| (dot(a, a) * dot(b, b)).sqrt();
        for (exact, got, size) in [
            (dot(first, first), plane(one, one), scale(first, first)),
            (dot(first, second), plane(one, two), scale(first, second)),
            (dot(second, second), plane(two, two), scale(second, second)),
            (
                dot(first, corner),
                plane(one, found.corner),
                scale(first, corner),
            ),
            (
                dot(second, corner),
                plane(two, found.corner),
                scale(second, corner),
            ),
            (
                dot(corner, corner),
                plane(found.corner, found.corner) + found.residual,
                scale(corner, corner),
            ),
        ] {
            assert!(
                (exact - got).abs() <= tolerance * size,
                "{corner:?} {edges:?}: {got} for {exact}"
            );
        }
    }

    #[test]
    fn pieces_keep_their_inner_products() {
        check(
            [0.3, -0.2, 1.0, 2.0],
            [[1.0, 0.0, 0.4, 0.1], [0.0, 2.0, -0.3, 0.7]],
            1e-15,
        );
        check(
            [0.3, -0.2, 1.0, 2.0],
            [[1.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0]],
            1e-15,
        );
        check(
            [0.3, -0.2, 1.0, 2.0],
            [[1.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 9.0]],
            1e-15,
        );
        check(
            [1e3, -2e4, 1e6, 3.0],
            [[1e4, 0.0, 1e6, 1e6], [5e5, 1e6, -1e6, 2e5]],
            1e-15,
        );
        check(
            [0.0; 4],
            [[1e-4, 0.0, 1e6, -1e6], [1e-4, 1e-4, -1e6, -1e6]],
            1e-15,
        );
    }

    #[test]
    fn stiff_jacobians_of_rank_one_keep_the_height_that_position_gives() {
        // Normals change along (3, 4) alone, by up to 1e6 σr a texel, under a footprint of thousands of texels; in a rotated
        // frame the height is that of the position across, 1e-3 sin of the angle between gradient and edge.
        for ratio in [0.0, 0.5, -1.0, 1.0 / 3.0] {
            for stiff in [1.0, 1e3, 1e6] {
                let (s, t) = (3.0 * stiff, 4.0 * stiff);
                let edges = [[1e-3, 0.0, s, t], [0.0, 1e-3, ratio * s, ratio * t]];
                let found = whiten([0.2, 0.1, 0.5 * s, 0.5 * t - 1.0], edges).expect("a plane");
                // |first ∧ second|² / |first|², by the six minors.
                let (m, n) = (1e-6, 1e-3 * 5.0 * stiff);
                let length = (1e-6 + 25.0 * stiff * stiff).sqrt();
                let exact = (m * m + n * n * (1.0 + ratio * ratio)).sqrt() / length;
                // A third of s is rounded, which is a true change of rank.
                let rounding = if ratio == 1.0 / 3.0 {
                    1e-16 * stiff
                } else {
                    0.0
                };
                assert!(
                    (found.height - exact).abs() <= 4e-16 * exact + rounding,
                    "{} for {exact}",
                    found.height
                );
                assert!(found.residual <= 1.0 && found.residual >= 0.0);
            }
        }
    }

    #[test]
    fn residuals_do_not_cancel() {
        // A flat piece under a tiny footprint: the residual is the normal's own distance, whatever the position.
        for place in [0.0, 1.0, 1e6, 1e9] {
            let corner = [place, -0.7 * place, 1e-5, 2e-5];
            let found =
                whiten(corner, [[1e6, 0.0, 0.0, 0.0], [-3e5, 1e6, 0.0, 0.0]]).expect("a plane");
            assert!(
                (found.residual / 5e-10 - 1.0).abs() < 1e-12,
                "{}",
                found.residual
            );
        }
    }

    #[test]
    fn pieces_without_a_plane_are_none() {
        assert!(whiten([1.0; 4], [[0.0; 4], [1.0; 4]]).is_none());
        assert!(whiten([1.0; 4], [[0.0; 4], [0.0; 4]]).is_none());
        assert!(whiten([1.0; 4], [[f64::NAN; 4], [1.0; 4]]).is_none());
    }
}
