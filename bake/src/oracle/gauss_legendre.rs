//! Gauss-Legendre quadrature, its nodes found by Newton's method.

use core::f64::consts::PI;

/// The rule of n nodes, exact for polynomials of degree 2n - 1.
#[derive(Clone, Debug)]
pub(super) struct GaussLegendre {
    /// Node in [-1, 1] and weight; the weights sum to 2.
    rule: Vec<(f64, f64)>,
}

impl GaussLegendre {
    /// The rule of `count` nodes.
    pub(super) fn new(count: usize) -> Self {
        let rule = (0..count)
            .map(|i| {
                // Within 1e-2 of the root already, from where Newton doubles the digits.
                let mut x = libm::cos(PI * (i as f64 + 0.75) / (count as f64 + 0.5));
                for _ in 0..8 {
                    let (value, slope) = legendre(count, x);
                    x -= value / slope;
                }
                let (_, slope) = legendre(count, x);
                (x, 2.0 / ((1.0 - x * x) * slope * slope))
            })
            .collect();
        Self { rule }
    }

    /// Places between `from` and `to`, each with the length it stands for.
    pub(super) fn nodes(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
        let half = 0.5 * (to - from);
        let middle = 0.5 * (from + to);
        self.rule
            .iter()
            .map(move |&(node, weight)| (middle + half * node, half * weight))
    }
}

/// The Legendre polynomial of degree `degree` > 0 and its derivative, at x inside (-1, 1).
fn legendre(degree: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut value) = (1.0, x);
    for k in 2..=degree {
        let k = k as f64;
        (previous, value) = (
            value,
            ((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / k,
        );
    }
    (
        value,
        degree as f64 * (x * value - previous) / (x * x - 1.0),
    )
}
