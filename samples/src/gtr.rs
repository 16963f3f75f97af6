//! The generalised Trowbridge-Reitz distribution that flakes are drawn from.

/// Generalised Trowbridge-Reitz distribution of normals, `D(θ) ∝ (α² cos² θ + sin² θ)^(−γ)`.
///
/// Source: Burley 2012, appendix B.2 (our α ∈ \[0, 1\], γ > 0). The density is normalised as microfacet
/// distributions are, `∫ D cos θ dω = 1`, so it is a density on the projected disk: drawing the normal of each equal
/// area of a map from it makes D the map's own NDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gtr {
    /// Width α, in \[0, 1\]: 0 is a mirror, 1 spreads evenly over the disk for any γ.
    pub alpha: f64,
    /// Exponent γ > 0: smaller has longer tails; 2 is GGX, 1 is Berry's.
    pub gamma: f64,
}

impl Gtr {
    /// sin² θ of the normal at which the distribution function of sin² θ is `xi`, in [0, 1).
    ///
    /// The inverse of Burley's eq. (5) and (9), written for y = (α² cos² θ + sin² θ)/α² so that nothing cancels when
    /// α is small: `y = (1 − ξ(1 − α^(2(γ−1))))^(1/(1−γ))`, or `α^(−2ξ)` for γ = 1, and
    /// `sin² θ = (y − 1) α²/(1 − α²)`. Relative error below 1e-9 for α ≥ 1e-4 and |γ − 1| not in (0, 1e-6).
    pub fn sin_squared(&self, xi: f64) -> f64 {
        let Self { alpha, gamma } = *self;
        if alpha == 0.0 {
            return 0.0;
        }
        if alpha == 1.0 {
            return xi;
        }
        let log_alpha_squared = 2.0 * libm::log(alpha);
        let log_y = if gamma == 1.0 {
            -xi * log_alpha_squared
        } else {
            let kept = libm::expm1((gamma - 1.0) * log_alpha_squared);
            libm::log1p(xi * kept) / (1.0 - gamma)
        };
        // 1/α² − 1, again without cancellation for α near 1.
        let range = libm::expm1(-log_alpha_squared);
        (libm::expm1(log_y) / range).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ over sin² θ in [0, x] of the unnormalised density (α² + (1 − α²) sin² θ)^(−γ), by Simpson's rule in log(α² + …).
    fn mass(gtr: Gtr, x: f64) -> f64 {
        let a = gtr.alpha * gtr.alpha;
        // With q = α² + (1 − α²) x = e^p: dx = e^p dp/(1 − α²).
        let [low, high] = [a, a + (1.0 - a) * x].map(libm::log);
        let steps = 2000;
        let width = (high - low) / f64::from(steps);
        let f = |i: i32| libm::exp((low + width * f64::from(i)) * (1.0 - gtr.gamma));
        let sum: f64 = (1..steps).map(|i| f(i) * f64::from(2 + 2 * (i % 2))).sum();
        (f(0) + sum + f(steps)) * width / 3.0 / (1.0 - a)
    }

    #[test]
    fn inverts_the_integral_of_the_density() {
        for alpha in [0.002, 0.12, 0.5, 0.99] {
            for gamma in [0.5, 1.0, 1.5, 2.0, 4.0] {
                let gtr = Gtr { alpha, gamma };
                for xi in [0.0, 1e-6, 0.1, 0.5, 0.9, 0.999] {
                    let found = mass(gtr, gtr.sin_squared(xi)) / mass(gtr, 1.0);
                    assert!((found - xi).abs() < 1e-8, "{gtr:?} at {xi}: {found}");
                }
            }
        }
    }

    #[test]
    fn the_ends_of_alpha_are_a_mirror_and_an_even_spread() {
        let at = |alpha, xi| Gtr { alpha, gamma: 1.5 }.sin_squared(xi);
        assert_eq!(at(0.0, 0.7), 0.0);
        assert_eq!(at(1.0, 0.7), 0.7);
        assert!((at(1.0 - 1e-9, 0.7) - 0.7).abs() < 1e-8);
        assert!(at(1e-4, 0.999) < 1e-2, "{}", at(1e-4, 0.999));
    }
}
