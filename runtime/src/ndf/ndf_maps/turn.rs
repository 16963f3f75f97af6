//! How a copy turns the normals of its example.

/// The normal of the example that a copy under `matrix` shows as `normal`, and how much larger areas of the disk are there.
///
/// With t up where texture space has v down, M is `F M F`, F = diag(1, -1). Normals turn with its orthogonal polar factor, which of
/// two by two entries is M plus, or of a mirror minus, its adjugate transposed, but for length. If `scales_slopes`, slopes
/// `n / n_z` are multiplied by `Mᵀ`; an area of slopes is one of the disk by `n_z⁴`.
#[inline]
pub(super) fn pulled_back(
    [[xx, xy], [yx, yy]]: [[f64; 2]; 2],
    scales_slopes: bool,
    [s, t]: [f64; 2],
) -> ([f64; 2], f64) {
    let (xy, yx) = (-xy, -yx);
    let determinant = xx * yy - xy * yx;
    if !scales_slopes {
        let sign = if determinant > 0.0 { 1.0 } else { -1.0 };
        let (a, b) = (xx + sign * yy, xy - sign * yx);
        let length = libm::sqrt(a * a + b * b);
        // The transpose of [[a, b], [-b, a]] or [[a, b], [b, -a]].
        return (
            [
                (a * s - sign * b * t) / length,
                (b * s + sign * a * t) / length,
            ],
            1.0,
        );
    }
    let z = libm::sqrt((1.0 - s * s - t * t).max(0.0));
    // Times z, so that nothing is divided by it.
    let (x, y) = (xx * s + yx * t, xy * s + yy * t);
    let length = libm::sqrt(z * z + x * x + y * y);
    let ratio = 1.0 / length;
    let square = ratio * ratio;
    ([x * ratio, y * ratio], determinant.abs() * square * square)
}

/// Where a copy under `matrix` shows the normal that its example has at `normal`: the inverse of [`pulled_back`].
pub(super) fn pushed_forward(
    [[xx, xy], [yx, yy]]: [[f64; 2]; 2],
    scales_slopes: bool,
    [s, t]: [f64; 2],
) -> [f64; 2] {
    let (xy, yx) = (-xy, -yx);
    let determinant = xx * yy - xy * yx;
    if !scales_slopes {
        let sign = if determinant > 0.0 { 1.0 } else { -1.0 };
        let (a, b) = (xx + sign * yy, xy - sign * yx);
        let length = libm::sqrt(a * a + b * b);
        return [(a * s + b * t) / length, sign * (a * t - b * s) / length];
    }
    let z = libm::sqrt((1.0 - s * s - t * t).max(0.0));
    let (x, y) = (
        (yy * s - yx * t) / determinant,
        (xx * t - xy * s) / determinant,
    );
    let length = libm::sqrt(z * z + x * x + y * y);
    [x / length, y / length]
}

#[cfg(test)]
mod tests {
    use super::*;

    const MATRICES: [[[f64; 2]; 2]; 5] = [
        [[1.0, 0.0], [0.0, 1.0]],
        [[0.8, 0.6], [-0.6, 0.8]],
        [[-1.0, 0.0], [0.0, 1.0]],
        [[2.0, 0.3], [-0.4, 0.7]],
        [[0.3, 2.0], [1.0, -0.2]],
    ];

    #[test]
    fn there_and_back() {
        for matrix in MATRICES {
            for scales in [false, true] {
                let normal = [0.31, -0.47];
                let (own, _) = pulled_back(matrix, scales, normal);
                let back = pushed_forward(matrix, scales, own);
                assert!((back[0] - normal[0]).abs() < 1e-12, "{matrix:?} {scales}");
                assert!((back[1] - normal[1]).abs() < 1e-12, "{matrix:?} {scales}");
            }
        }
    }

    #[test]
    fn a_turn_of_the_picture_turns_normals_with_it() {
        // A quarter counter-clockwise takes what is to the right up.
        let quarter = [[0.0, 1.0], [-1.0, 0.0]];
        assert_eq!(pushed_forward(quarter, false, [0.5, 0.0]), [0.0, 0.5]);
        let (own, area) = pulled_back(quarter, true, [0.0, 0.5]);
        assert!((own[0] - 0.5).abs() < 1e-12 && own[1].abs() < 1e-12);
        assert!((area - 1.0).abs() < 1e-12);
    }

    #[test]
    fn areas_are_those_of_small_steps() {
        for matrix in MATRICES {
            let (s, t, step) = (0.2, 0.35, 1e-5);
            let at = |s: f64, t: f64| pulled_back(matrix, true, [s, t]).0;
            let (left, right) = (at(s - step, t), at(s + step, t));
            let (below, above) = (at(s, t - step), at(s, t + step));
            let d = |x: [f64; 2], y: [f64; 2]| {
                [(y[0] - x[0]) / (2.0 * step), (y[1] - x[1]) / (2.0 * step)]
            };
            let (u, v) = (d(left, right), d(below, above));
            let expected = (u[0] * v[1] - u[1] * v[0]).abs();
            // Of directions, areas of the disk also change by the ratio of n_z, which both share.
            let (own, area) = pulled_back(matrix, true, [s, t]);
            assert!(
                (area / expected - 1.0).abs() < 1e-6,
                "{matrix:?} {own:?} {area} {expected}"
            );
        }
    }
}
