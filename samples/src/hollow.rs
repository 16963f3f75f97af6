//! The round hollow of pores and dents.
//!
//! ```text
//!     h(q) = −depth (1 − q²)³      q = distance from the middle over the radius, q ≤ 1
//! ```
//!
//! Height, slope and curvature are continuous; the wall is steepest at q = 1/√5.

/// The slope (∂h/∂x, ∂h/∂y) at `offset` from the middle, in radii, of a hollow whose wall is as steep as `steepness`.
#[inline]
pub fn slope(offset: [f64; 2], steepness: f64) -> [f64; 2] {
    /// Largest q (1 − q²)²: at q² = 1/5, (16/25)/√5.
    const STEEPEST: f64 = 0.286_216_7;
    let inside = 1.0 - offset[0] * offset[0] - offset[1] * offset[1];
    if inside <= 0.0 {
        return [0.0; 2];
    }
    let steep = steepness * inside * inside / STEEPEST;
    offset.map(|x| steep * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_derivatives_and_nowhere_steeper_than_said() {
        let height = |x: f64, y: f64| -(1.0 - x * x - y * y).max(0.0).powi(3);
        // h′ = 6 q (1 − q²)², at q² = 1/5.
        let steepness = 6.0 * 0.2_f64.sqrt() * 0.64;
        let mut steepest = 0.0_f64;
        for i in -60..=60 {
            for j in -60..=60 {
                let [x, y] = [i, j].map(|k| f64::from(k) / 50.0);
                let step = 1e-5;
                let expected = [
                    (height(x + step, y) - height(x - step, y)) / (2.0 * step),
                    (height(x, y + step) - height(x, y - step)) / (2.0 * step),
                ];
                let found = slope([x, y], steepness);
                for axis in 0..2 {
                    assert!((found[axis] - expected[axis]).abs() < 1e-6, "({x}, {y})");
                }
                steepest = steepest.max(found[0].hypot(found[1]));
            }
        }
        // The grid has a point with q² = 1/5.
        assert!((steepest / steepness - 1.0).abs() < 1e-6, "{steepest}");
    }
}
