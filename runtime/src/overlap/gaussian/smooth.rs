//! Weights of texels that are small against the Gaussian: its density, smoothed by the texel.
//!
//! The weight of a texel is the value, at the texel's centre, of the Gaussian smoothed by the texel. The Fourier
//! transform of a unit square is `sinc(k_x/2) sinc(k_y/2)`, and
//! `ln sinc(k/2) = -k²/24 - k⁴/2880 - k⁶/181440 - …`: smoothing adds 1/12 to the variance along each axis, and what is
//! left multiplies the transform by `1 - (k_x⁴ + k_y⁴)/2880`, that is, takes `(∂_x⁴ + ∂_y⁴) G / 2880` off the Gaussian
//! G of covariance `S = Σ + I/12`. The next term, `(∂_x⁶ + ∂_y⁶) G / 181440`, is at most
//! `30 / 181440 σ⁻⁶ = 2.6e-6 (2/σ)⁶` of the peak, σ the least standard deviation; without the fourth derivatives the
//! error would be `6 / 2880 σ⁻⁴ = 1.3e-4 (2/σ)⁴`. A texel cut into n × n has n times the σ.

use super::exponential::exp_negative;
use super::{LOST, RADIUS};
use core::f64::consts::PI;

/// Half the diagonal of a texel, a little more.
const HALF_DIAGONAL: f64 = 0.7072;
/// Most parts a texel is cut into along each axis.
const MOST_PARTS: usize = 4;

/// The Gaussian of covariance `S = Σ + I/(12 n²)`, for texels cut into n × n parts.
///
/// Its factor is `y = l₁₁ z₁`, `x = l₂₁ z₁ + l₂₂ z₂` for unit Gaussians z₁, z₂; with z, `S⁻¹ (x, y)` and the
/// Mahalanobis distance |z| come out of products and sums without forming the inverse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Smooth {
    /// n: 1, 2 or 4.
    parts: usize,
    /// `1 / l₁₁`.
    inverse_11: f64,
    /// `l₂₁ / l₁₁`: the mean of x at y = 1.
    lean: f64,
    /// `1 / l₂₂`.
    inverse_22: f64,
    /// Diagonal and off-diagonal of `S⁻¹`: xx, yy, xy.
    precision: [f64; 3],
    /// Weight of a part at the centre, corrections aside.
    peak: f64,
    /// `1 / (2880 n⁴)`.
    fourth: f64,
    /// Square of the distance up to which a texel's centre is certainly in the Gaussian's ellipse.
    inside: f64,
    /// Square of the distance from which a texel certainly does not meet it.
    outside: f64,
}

/// One row of parts, as seen from the Gaussian's centre.
#[derive(Clone, Copy, Debug, Default)]
struct PartRow {
    /// `z₁ / l₁₁`.
    height: f64,
    /// The mean of x in this row.
    mean: f64,
    /// Weight of a part at the mean, corrections aside.
    peak: f64,
}

/// One row of texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmoothRow<'a> {
    smooth: &'a Smooth,
    parts: [PartRow; MOST_PARTS],
}

impl Smooth {
    /// The smoothed Gaussian for texels cut into `parts` × `parts`, of covariance xx, yy, xy with the determinant
    /// `determinant`, and the least standard deviation `least`.
    pub fn new(covariance: [f64; 3], determinant: f64, least: f64, parts: usize) -> Self {
        let count = parts as f64;
        let added = 1.0 / (12.0 * count * count);
        let [xx, yy, xy] = covariance;
        // A sum of what is not negative: nothing cancels, however thin the Gaussian is.
        let determinant = determinant + added * (xx + yy) + added * added;
        let (xx, yy) = (xx + added, yy + added);
        let lean = xy / yy;
        let (root_yy, root) = (libm::sqrt(yy), libm::sqrt(determinant));
        let smoothed_least = libm::sqrt(least * least + added);
        let reach = RADIUS * (1.0 + 1e-8) + HALF_DIAGONAL / smoothed_least;
        Self {
            parts,
            inverse_11: 1.0 / root_yy,
            lean,
            inverse_22: root_yy / root,
            precision: [yy / determinant, xx / determinant, -xy / determinant],
            peak: 1.0 / (2.0 * PI * root * count * count * (1.0 - LOST)),
            fourth: 1.0 / (2880.0 * count * count * count * count),
            // Σ ≤ S ≤ (1 + added / least²) Σ bounds each distance by the other.
            inside: RADIUS * RADIUS / (1.0 + added / (least * least)),
            outside: reach * reach,
        }
    }

    /// Whether texels are taken as a whole.
    pub fn is_whole(&self) -> bool {
        self.parts == 1
    }

    /// The coordinates z of a point.
    #[inline]
    fn unit(&self, x: f64, y: f64) -> [f64; 2] {
        [y * self.inverse_11, (x - self.lean * y) * self.inverse_22]
    }

    /// Square of the Mahalanobis distance of a point.
    #[inline]
    fn distance_squared(&self, x: f64, y: f64) -> f64 {
        let [first, second] = self.unit(x, y);
        first * first + second * second
    }

    /// Whether the texel centred at (`x`, `y`) meets the ellipse of [`RADIUS`], if that is plain.
    #[inline]
    pub fn meets(&self, x: f64, y: f64) -> Option<bool> {
        let square = self.distance_squared(x, y);
        if square > self.outside {
            Some(false)
        } else if square <= self.inside {
            Some(true)
        } else {
            None
        }
    }

    /// The row of texels whose centres are `y` below the Gaussian's.
    #[inline]
    pub fn row(&self, y: f64) -> SmoothRow<'_> {
        let mut parts = [PartRow::default(); MOST_PARTS];
        let step = 1.0 / self.parts as f64;
        let mut y = y - 0.5 + 0.5 * step;
        for part in parts.iter_mut().take(self.parts) {
            let first = y * self.inverse_11;
            *part = PartRow {
                height: first * self.inverse_11,
                mean: self.lean * y,
                peak: self.peak * exp_negative(0.5 * first * first),
            };
            y += step;
        }
        SmoothRow {
            smooth: self,
            parts,
        }
    }
}

impl SmoothRow<'_> {
    /// The weight of the texel whose centre is `x` right of the Gaussian's.
    #[inline]
    pub fn weight(&self, x: f64) -> f64 {
        match self.smooth.parts {
            1 => self.sum_parts::<1>(x),
            2 => self.sum_parts::<2>(x),
            _ => self.sum_parts::<4>(x),
        }
    }

    /// Weights of the texels at `x`, `x + 1`, …
    #[inline(always)]
    pub fn fill(&self, x: f64, weights: &mut [f64]) {
        match self.smooth.parts {
            1 => self.fill_parts::<1>(x, weights),
            2 => self.fill_parts::<2>(x, weights),
            _ => self.fill_parts::<4>(x, weights),
        }
    }

    #[inline(always)]
    fn fill_parts<const N: usize>(&self, x: f64, weights: &mut [f64]) {
        for (weight, place) in weights.iter_mut().zip(0_u32..) {
            *weight = self.sum_parts::<N>(x + f64::from(place));
        }
    }

    #[inline(always)]
    fn sum_parts<const N: usize>(&self, x: f64) -> f64 {
        let step = 1.0 / N as f64;
        let mut sum = 0.0;
        for row in self.parts.iter().take(N) {
            for part in 0..N {
                sum += self.part(row, x + (step * (part as f64 + 0.5) - 0.5));
            }
        }
        sum
    }

    #[inline(always)]
    fn part(&self, row: &PartRow, x: f64) -> f64 {
        let smooth = self.smooth;
        let second = (x - row.mean) * smooth.inverse_22;
        let density = row.peak * exp_negative(0.5 * second * second);
        // ∂_x⁴ G / G = g⁴ - 6 g² p + 3 p² = (g² - 3p)² - 6p², with g a component of S⁻¹ (x, y) and p = (S⁻¹)_xx.
        let [xx, yy, _] = smooth.precision;
        let slope_x = second * smooth.inverse_22;
        let slope_y = row.height - smooth.lean * slope_x;
        let of_x = slope_x * slope_x - 3.0 * xx;
        let of_y = slope_y * slope_y - 3.0 * yy;
        let fourth = (of_x * of_x + of_y * of_y) - 6.0 * (xx * xx + yy * yy);
        density * (1.0 - smooth.fourth * fourth)
    }
}
