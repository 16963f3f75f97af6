//! The weight of a Gaussian on each texel of a square: its integral over the texel.
//!
//! A Gaussian convolved with a cell, at the cell's middle, is the integral over it up to the fourth order. Texels are
//! such cells where the Gaussian's least deviation is 2 of them or more, and are cut into cells of half as long elsewhere:
//! weights are within 1e-4 of the greatest.

use super::lobe::{CUT_EXPONENT, power_of_two};
use super::{LANES, Lanes, Region, SIDE};
use glintbake_format::model::Footprint;
use std::f64::consts::{LOG2_E, TAU};

/// Deviations at which Gaussians end, as those of the methods do.
const CUT: f64 = 4.8;
/// Cells that the least deviation is long.
const CELLS: f64 = 2.0;
/// Cells along a texel at most: Gaussians narrower than a sixteenth of a texel need no more.
const MOST_PARTS: f64 = 32.0;

/// A Gaussian.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gaussian {
    centre: [f64; 2],
    /// Half the bounding box of its end.
    extent: [f64; 2],
    /// Inverse covariance: xx, xy, yy.
    precision: [f64; 3],
    /// Deviations from a square's middle to its corners, at most.
    reach: f64,
    /// Along a row: slope of the middle, variance.
    shear: f64,
    variance: f64,
    /// Variance across rows.
    across: f64,
    parts: u32,
    /// The weight at the middle.
    peak: f32,
}

impl Gaussian {
    /// `footprint` on a map of `size`.
    ///
    /// # Panics
    /// If the footprint has no area.
    pub(super) fn new(footprint: &Footprint, size: [u32; 2]) -> Self {
        let size = size.map(f64::from);
        // Σ = (e1 e1ᵀ + e2 e2ᵀ) / 4, in texels.
        let [first, second] = [footprint.edge_1, footprint.edge_2]
            .map(|edge| [0.5 * edge[0] * size[0], 0.5 * edge[1] * size[1]]);
        let product = |i: usize, j: usize| first[i] * first[j] + second[i] * second[j];
        let (mut xx, xy, mut yy) = (product(0, 0), product(0, 1), product(1, 1));
        let turn = first[0] * second[1] - first[1] * second[0];
        assert!(turn.abs() > 0.0, "baselines need a footprint with an area");
        let trace = xx + yy;
        let most = 0.5 * (trace + (trace * trace - 4.0 * turn * turn).max(0.0).sqrt());
        let least = turn.abs() / most.sqrt();
        let parts = (CELLS / least).ceil().clamp(1.0, MOST_PARTS);
        let cell = 1.0 / (12.0 * parts * parts);
        let determinant = turn * turn + cell * trace + cell * cell;
        (xx, yy) = (xx + cell, yy + cell);
        let half = 0.5 * SIDE as f64;
        let precision = [yy, -xy, xx].map(|part| part / determinant);
        let [p, q, r] = precision;
        let kept = 1.0 - (-0.5 * CUT * CUT).exp();
        Self {
            centre: [0, 1].map(|axis| {
                let centre = footprint.centre[axis];
                (centre - centre.floor()) * size[axis]
            }),
            extent: [CUT * xx.sqrt() + 0.5, CUT * yy.sqrt() + 0.5],
            precision,
            reach: half * (p + r + 2.0 * q.abs()).sqrt(),
            shear: xy / yy,
            variance: determinant / yy,
            across: yy,
            parts: parts as u32,
            peak: (1.0 / (TAU * determinant.sqrt() * kept * parts * parts)) as f32,
        }
    }

    /// Deviations from the middle to `place`.
    #[inline(always)]
    fn deviations(&self, [x, y]: [f64; 2]) -> f64 {
        let [p, q, r] = self.precision;
        (p * x * x + 2.0 * q * x * y + r * y * y).max(0.0).sqrt()
    }
}

impl Region for Gaussian {
    #[inline(always)]
    fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        (self.centre, self.extent)
    }

    #[inline(always)]
    fn span(&self, y: f64) -> [f64; 2] {
        // Where the middles of squares lie within the ellipse that all squares touching the Gaussian's have theirs in.
        let reach = CUT + self.reach;
        let rest = (reach * reach - y * y / self.across).max(0.0);
        let half = (rest * self.variance).sqrt();
        [self.shear * y - half, self.shear * y + half]
    }

    #[inline(always)]
    fn left(&self, middle: [f64; 2]) -> f64 {
        // Both exponents together count: the Gaussian's is spent of what the lobe's may be.
        let least = (self.deviations(middle) - self.reach).max(0.0);
        1.0 - 0.5 * least * least / CUT_EXPONENT
    }

    #[inline(always)]
    fn weigh(&self, middle: [f64; 2], weights: &mut Lanes) {
        let [p, q, r] = self.precision.map(|part| (-0.5 * LOG2_E * part) as f32);
        let [middle_x, middle_y] = middle.map(|x| x as f32);
        let least = (-0.5 * LOG2_E * CUT * CUT) as f32;
        let step = 1.0 / self.parts as f32;
        let start = 0.5 * step - 0.5 * SIDE as f32;
        *weights = [0.0; LANES];
        for row in 0..self.parts {
            let y_start = middle_y + start + row as f32 * step;
            for column in 0..self.parts {
                let x_start = middle_x + start + column as f32 * step;
                for (lane, sum) in weights.iter_mut().enumerate() {
                    let x = x_start + (lane % SIDE) as f32;
                    let y = y_start + (lane / SIDE) as f32;
                    let exponent = (p * x + 2.0 * q * y) * x + r * y * y;
                    let weight = power_of_two(exponent) * self.peak;
                    *sum += if exponent >= least { weight } else { 0.0 };
                }
            }
        }
    }
}
