//! What a lobe's slope adds to its normals' variance, kept as a sum of squares.

use super::super::double_double::DoubleDouble;
use core::f64::consts::PI;

/// Where the exponential of less is 0 in f64.
const LEAST_EXPONENT: f64 = 746.0;

/// `J B Jᵀ` as `Σ g gᵀ`: a kernel's variance can be added to it, and the whole inverted, without any difference of
/// large numbers.
///
/// With `M = v I + Σ g gᵀ`, Cauchy and Binet give `det M = v² + v Σ |g|² + Σ_{k<l} (g_k × g_l)²`, and the adjugate
/// gives `dᵀ M⁻¹ d = (v |d|² + Σ (g × d)²) / det M`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::oracle) struct Spread {
    parts: [[f64; 2]; 4],
    /// `Σ |g|²`.
    squares: f64,
    /// `det J² det B`.
    determinant: f64,
}

impl Spread {
    /// `J B Jᵀ` for the columns of J and `B = Σ c cᵀ` by its columns c and its determinant.
    pub(in crate::oracle) fn new(
        slope: [[f64; 2]; 2],
        columns: [[f64; 2]; 4],
        determinant: f64,
    ) -> Self {
        let along = |x: [f64; 2], axis: usize| {
            (DoubleDouble::product(slope[0][axis], x[0])
                + DoubleDouble::product(slope[1][axis], x[1]))
            .value()
        };
        let parts = columns.map(|column| [along(column, 0), along(column, 1)]);
        let turn = (DoubleDouble::product(slope[0][0], slope[1][1])
            - DoubleDouble::product(slope[0][1], slope[1][0]))
        .value();
        Self {
            parts,
            squares: parts.as_flattened().iter().map(|x| x * x).sum(),
            determinant: turn * turn * determinant,
        }
    }

    /// `N(d; variance I + J B Jᵀ)`.
    pub(in crate::oracle) fn density(&self, d: [f64; 2], variance: f64) -> f64 {
        // No direction has more variance than all together: what is farther than its exponential reaches is 0.
        let square = d[0] * d[0] + d[1] * d[1];
        if square > 2.0 * LEAST_EXPONENT * (variance + self.squares) {
            return 0.0;
        }
        let determinant = variance * (variance + self.squares) + self.determinant;
        let mut adjugate = variance * square;
        for part in &self.parts {
            let turn = part[0] * d[1] - part[1] * d[0];
            adjugate += turn * turn;
        }
        libm::exp(-0.5 * adjugate / determinant) / (2.0 * PI * libm::sqrt(determinant))
    }

    /// The root of `variance I + J B Jᵀ` that has nothing above its diagonal: its first column, and what is left of the second.
    pub(in crate::oracle) fn root(&self, variance: f64) -> [f64; 3] {
        let sum = |a: usize, b: usize| -> f64 { self.parts.iter().map(|g| g[a] * g[b]).sum() };
        let determinant = variance * (variance + self.squares) + self.determinant;
        let first = libm::sqrt(variance + sum(0, 0));
        [first, sum(0, 1) / first, libm::sqrt(determinant) / first]
    }
}
