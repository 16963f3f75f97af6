//! What all lobes of one size have in common under a footprint.
//!
//! A lobe at `u_i` with the position covariance A, the normal `s_i` there, the slope J and the residual covariance R gives a query
//! of position `u_p`, footprint covariance Σp and half vector s
//!
//! ```text
//!     N(u_p; u_i, S) · N(s; s_i + J K (u_p - u_i), R + J Q Jᵀ),    S = A + Σp,  K = A S⁻¹,  Q = A S⁻¹ Σp
//! ```
//!
//! Derivation: `N(u; u_p, Σp) N(u; u_i, A)` is `N(u_p`; `u_i`, S) times a Gaussian in u of mean `u_i + K (u_p - u_i)` and covariance
//! Q, the parallel sum of A and Σp; and s is an affine function of u plus a residual. This is \[TZX22\] eq. 6 without the inverse
//! of its 4 × 4 matrix, whose entries reach |J|²/σr². Here every matrix is a sum of positive parts, and nothing cancels.
//!
//! A = a I throughout. With p = T (`u_p` - `u_i`), T upper triangular and `TᵀT` = S⁻¹, `K (u_p - u_i) = a Tᵀ p`. With Σp = E Eᵀ and
//! `N = I + EᵀE / a = L Lᵀ`, `Q = E N⁻¹ Eᵀ = G Gᵀ` for G = E L⁻ᵀ.

use super::placed::{POSITION_VARIANCE, Placed, covariance, cross};
use core::f64::consts::PI;

/// The matrices of lobes of one size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// T, as `[a, b, c]`: `p = (a x + b y, c y)`.
    pub whiten: [f64; 3],
    /// a: the position variance of a lobe.
    pub variance: f64,
    /// The columns of G.
    pub spread: [[f64; 2]; 2],
    /// The factor of `exp(-|p|²/2)` in `N(u_p`; `u_i`, S).
    pub amplitude: f64,
    /// S: xx, yy and xy.
    pub total: [f64; 3],
}

impl Frame {
    /// For lobes of position variance `variance`, at least σh², under `placed`.
    pub fn new(placed: &Placed, variance: f64) -> Self {
        let deviation = libm::sqrt(variance);
        let [xx, yy, xy] = covariance(placed.half_edges);
        let total = [variance + xx, variance + yy, xy];
        // What is left of Q along an axis whose position is known by Σp alone.
        let rest = |own: f64| deviation * libm::sqrt(own / (variance + own));
        let [width, height] = placed.size;
        let along = |own: f64| 1.0 / (libm::sqrt(2.0 * PI * (variance + own)));
        match placed.even {
            // Averaged over all positions, normals spread by all of J A Jᵀ: Q + K S Kᵀ = A.
            [true, true] => Self {
                whiten: [0.0; 3],
                variance,
                spread: [[deviation, 0.0], [0.0, deviation]],
                amplitude: 1.0 / (width * height),
                total,
            },
            [false, true] => Self {
                whiten: [1.0 / libm::sqrt(total[0]), 0.0, 0.0],
                variance,
                spread: [[rest(xx), 0.0], [0.0, deviation]],
                amplitude: along(xx) / height,
                total,
            },
            [true, false] => Self {
                whiten: [0.0, 0.0, 1.0 / libm::sqrt(total[1])],
                variance,
                spread: [[deviation, 0.0], [0.0, rest(yy)]],
                amplitude: along(yy) / width,
                total,
            },
            [false, false] => Self::correlated(placed, variance, total),
        }
    }

    fn correlated(placed: &Placed, variance: f64, total: [f64; 3]) -> Self {
        let [_, yy, xy] = total;
        let [e1, e2] = placed.half_edges;
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let area = cross(placed.half_edges);
        let determinant =
            variance * variance + variance * (dot(e1, e1) + dot(e2, e2)) + area * area;
        // The variance of x given y.
        let given = determinant / yy;
        let inverse = 1.0 / libm::sqrt(given);
        // N = L Lᵀ.
        let n_11 = 1.0 + dot(e1, e1) / variance;
        let l_11 = libm::sqrt(n_11);
        let ratio = dot(e1, e2) / variance / n_11;
        let l_22 = libm::sqrt(determinant / (variance * variance) / n_11);
        Self {
            whiten: [inverse, -xy / yy * inverse, 1.0 / libm::sqrt(yy)],
            variance,
            spread: [
                e1.map(|x| x / l_11),
                [
                    (e2[0] - ratio * e1[0]) / l_22,
                    (e2[1] - ratio * e1[1]) / l_22,
                ],
            ],
            amplitude: 1.0 / (2.0 * PI * libm::sqrt(determinant)),
            total,
        }
    }

    /// For the lobes themselves.
    pub fn of_lobes(placed: &Placed) -> Self {
        Self::new(placed, POSITION_VARIANCE)
    }

    /// p of a point (x, y) off a lobe.
    #[inline(always)]
    pub fn whitened(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.whiten;
        [a * x + b * y, c * y]
    }

    /// `K (u_p - u_i)` of p.
    #[inline(always)]
    pub fn shift(&self, [first, second]: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.whiten;
        [
            self.variance * a * first,
            self.variance * (b * first + c * second),
        ]
    }

    /// The columns of F = J G, for which `J Q Jᵀ = F Fᵀ`.
    #[inline(always)]
    pub fn fan(&self, [s_x, s_y, t_x, t_y]: [f64; 4]) -> [[f64; 2]; 2] {
        self.spread
            .map(|[x, y]| [s_x * x + s_y * y, t_x * x + t_y * y])
    }
}
