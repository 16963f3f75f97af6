//! The kernel about a half vector, of 16 normals at a time.
//!
//! All of it comes from `x = s - s_h` and `y = t - t_h`, which fixed point has without error. From
//! `p = x (2 s_h + x) + y (2 t_h + y) = z_h² - z²` follows z, and `z_h - z = p / (z + z_h)` without a difference of like
//! numbers; with the squared chord `d² = x² + y² + (z_h - z)²`, `cos θ = 1 - d²/2` and `sin²θ = d² (1 + cos θ) / 2`. Lengths
//! stay in fixed point's units.

use super::{High, LANES, Lanes, Low, UNIT, fixed, max};
use glintbake_format::model::HalfVector;
use std::f64::consts::{LN_2, LOG2_E, PI, SQRT_2};

/// Powers of two at which terms end: half of what the peak's last bit is worth.
const CUT: f64 = 24.0;
/// The exponent at which they end.
pub(super) const CUT_EXPONENT: f64 = CUT * LN_2;
/// Cosines count as this at least, where nothing is left of a lobe of roughness 1: tan² θ is 10⁴.
const LEAST_COSINE: f32 = 0.01;

/// The kernel about a half vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// s and t of the half vector.
    half: [i32; 2],
    /// Twice them, z, and its square.
    twice: [f32; 2],
    z: f32,
    z_square: f32,
    /// Half of one squared: from squared chords to what cosines lack.
    share: f32,
    /// −1/α² in powers of two: times squared distances, and times those with a factor of 2.
    scale: f32,
    half_scale: f32,
    /// Distance on the disk at which terms end, in fixed point's units.
    radius: f64,
    /// What upper halves within it differ by at most.
    pub reach: Reach,
    peak: f64,
}

/// A bound of the differences between upper halves: of each, and of both added.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    each: i16,
    both: i16,
}

impl Reach {
    /// All that is within `radius`: an octagon. Casts saturate, as the sums do that are compared.
    #[inline(always)]
    fn new(radius: f64) -> Self {
        const STEP: f64 = 65_536.0;
        Self {
            each: (radius / STEP + 1.0) as i16,
            both: (radius * SQRT_2 / STEP + 2.0) as i16,
        }
    }
}

impl Lobe {
    /// The lobe of Beckmann roughness `roughness` about `half_vector`; of σr = α / √2, so that 2 σr² is α², on the disk.
    pub(super) fn new(half_vector: HalfVector, roughness: f64) -> Self {
        let HalfVector { s, t } = half_vector;
        let square = roughness * roughness;
        let z_square = (1.0 - s * s - t * t).max(0.0);
        // tan² θ is no less than the squared distance on the disk.
        let radius = roughness * CUT_EXPONENT.sqrt() * UNIT;
        let scale = -LOG2_E / square / (UNIT * UNIT);
        Self {
            half: [fixed(s), fixed(t)],
            twice: [s, t].map(|part| (2.0 * part * UNIT) as f32),
            z: (z_square.sqrt() * UNIT) as f32,
            z_square: (z_square * UNIT * UNIT) as f32,
            share: (0.5 / (UNIT * UNIT)) as f32,
            scale: scale as f32,
            half_scale: (0.5 * scale) as f32,
            radius,
            reach: Reach::new(radius),
            peak: 1.0 / (PI * square),
        }
    }

    /// The density at the lobe's middle: 1 / (π α²).
    pub(super) fn peak(&self) -> f64 {
        self.peak
    }

    /// The reach of terms that may be no smaller than the share `left` of the exponent says.
    #[inline(always)]
    pub(super) fn reach_of(&self, left: f64) -> Reach {
        Reach::new(self.radius * left.sqrt())
    }

    /// Whether any normal of a square may be within reach of the half vector.
    #[inline(always)]
    pub(super) fn reaches(&self, square: &High, reach: Reach) -> bool {
        let [s, t] = [(self.half[0] >> 16) as i16, (self.half[1] >> 16) as i16];
        let mut near = 0_i16;
        for lane in 0..LANES {
            // No difference of numbers from 0 to 2^15 - 1 overflows.
            let x = square.s[lane].wrapping_sub(s).wrapping_abs();
            let y = square.t[lane].wrapping_sub(t).wrapping_abs();
            let is_near =
                (x <= reach.each) & (y <= reach.each) & (x.saturating_add(y) <= reach.both);
            near |= i16::from(is_near);
        }
        near != 0
    }

    /// Adds the terms of a square, as shares of the peak, times `weights` to `sums`.
    #[inline(always)]
    pub(super) fn add<const BECKMANN: bool>(
        &self,
        high: &High,
        low: &Low,
        weights: &Lanes,
        sums: &mut Lanes,
    ) {
        for lane in 0..LANES {
            let s = (i32::from(high.s[lane]) << 16) | i32::from(low.s[lane]);
            let t = (i32::from(high.t[lane]) << 16) | i32::from(low.t[lane]);
            let x = s.wrapping_sub(self.half[0]) as f32;
            let y = t.wrapping_sub(self.half[1]) as f32;
            let flat = x * x + y * y;
            let term = if BECKMANN {
                let p = x * (self.twice[0] + x) + y * (self.twice[1] + y);
                let z = max(self.z_square - p, 0.0).sqrt();
                let rise = p / max(z + self.z, 1.0);
                let chord = flat + rise * rise;
                let cosine = max(1.0 - chord * self.share, LEAST_COSINE);
                let secant = 1.0 / cosine;
                let square = secant * secant;
                let exponent = (chord * self.half_scale) * (square + square * cosine);
                power_of_two(exponent) * (square * square)
            } else {
                power_of_two(flat * self.scale)
            };
            sums[lane] += term * weights[lane];
        }
    }
}

/// `2^x` within 3e-7 of itself for x from −64 to 0, and that of −64 below: nothing
/// that it is multiplied by makes it subnormal, which would take processors a hundred times as long.
#[inline(always)]
pub(super) fn power_of_two(x: f32) -> f32 {
    /// 1.5 · 2²³: adding it rounds to a whole number, which is then in the low bits.
    const WHOLE: f32 = 12_582_912.0;
    /// `2^x` at the six Chebyshev points of [−1/2, 1/2], interpolated.
    const SERIES: [f32; 6] = [
        1.000_000_1,
        std::f32::consts::LN_2,
        0.240_221_07,
        0.055_503_57,
        0.009_676_032,
        0.001_339_086_3,
    ];
    let x = max(x, -64.0);
    let shifted = x + WHOLE;
    let rest = x - (shifted - WHOLE);
    let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    let [a, b, c, d, e, f] = SERIES;
    // As a tree, which takes half the time of a chain.
    let square = rest * rest;
    ((a + rest * b) + square * ((c + rest * d) + square * (e + rest * f))) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_are_within_what_they_say() {
        for step in 0..=24_000 {
            let x = -64.0 / 24_000.0 * step as f32;
            let exact = f64::from(x).exp2();
            let found = f64::from(power_of_two(x));
            assert!((found / exact - 1.0).abs() < 3e-7, "{x}: {found}");
        }
        assert!(power_of_two(-1e30) < 1e-19);
    }
}
