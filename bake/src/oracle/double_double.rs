//! Numbers of about 106 bits, as unevaluated sums of two f64.
//!
//! The area of a parallelogram a million times longer than wide is a difference of products that agree in most of
//! their digits. With twice the digits the plain formula is right as it stands, and the oracle needs no second
//! algorithm to be trusted where the first one fails.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low` with `|low|` at most half a unit in the last place of `high`.
///
/// Sums, products and quotients carry a relative error of a few 2⁻¹⁰⁴ (Joldes, Muller and Popescu 2017, "Tight and
/// rigorous error bounds for basic building blocks of double-word arithmetic"), also for sums that cancel. Values
/// must stay between about 1e-250 and 1e250 in magnitude, or be zero. Ordered by value.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub(super) struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    pub(super) const ZERO: Self = Self {
        high: 0.0,
        low: 0.0,
    };

    /// `a * b` without any error.
    pub(super) fn product(a: f64, b: f64) -> Self {
        // Dekker's product of split factors: unlike a fused multiply-add, it is the same machine code everywhere.
        let (a_high, a_low) = split(a);
        let (b_high, b_low) = split(b);
        let high = a * b;
        let low = ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low;
        Self { high, low }
    }

    /// The nearest f64.
    pub(super) fn value(self) -> f64 {
        self.high
    }

    pub(super) fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    /// Half of it, exactly.
    pub(super) fn half(self) -> Self {
        Self {
            high: 0.5 * self.high,
            low: 0.5 * self.low,
        }
    }
}

impl From<f64> for DoubleDouble {
    fn from(value: f64) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, high_error) = two_sum(self.high, other.high);
        let (low, low_error) = two_sum(self.low, other.low);
        let (high, low) = quick_two_sum(high, high_error + low);
        let (high, low) = quick_two_sum(high, low_error + low);
        Self { high, low }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let leading = Self::product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        let (high, low) = quick_two_sum(leading.high, leading.low + cross);
        Self { high, low }
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        // Long division with three f64 digits; the third only settles the rounding of the second.
        let first = self.high / other.high;
        let remainder = self - other * Self::from(first);
        let second = remainder.high / other.high;
        let remainder = remainder - other * Self::from(second);
        let third = remainder.high / other.high;
        let (high, low) = quick_two_sum(first, second);
        Self { high, low } + Self::from(third)
    }
}

/// Rounded sum and its error, exactly (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// Rounded sum and its error, exactly where `|a| >= |b|` or a = 0 (Dekker).
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Upper and lower half of the digits of `a` (Veltkamp).
fn split(a: f64) -> (f64, f64) {
    // 2²⁷ + 1 leaves 26 bits on each side, so that products of halves are exact.
    let scaled = 134_217_729.0 * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}
