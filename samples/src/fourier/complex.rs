//! Complex numbers, as far as a Fourier transform needs them.

use core::ops::{Add, Mul, Sub};

/// `re + i im`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Complex {
    pub re: f64,
    pub im: f64,
}

impl Complex {
    pub const ZERO: Self = Self { re: 0.0, im: 0.0 };

    /// `exp(2πi numerator/denominator)`.
    ///
    /// The angle is first brought to within an eighth of a turn, so that all roots are off by less than 2e-16.
    pub fn root(numerator: usize, denominator: usize) -> Self {
        let position = 8 * (numerator % denominator);
        let octant = position / denominator;
        let rest = position - octant * denominator;
        // Odd octants are measured backwards from their end.
        let rest = match octant % 2 {
            0 => rest,
            _ => denominator - rest,
        };
        let angle = core::f64::consts::FRAC_PI_4 * rest as f64 / denominator as f64;
        let (sin, cos) = libm::sincos(angle);
        let (re, im) = match octant {
            0 => (cos, sin),
            1 => (sin, cos),
            2 => (-sin, cos),
            3 => (-cos, sin),
            4 => (-cos, -sin),
            5 => (-sin, -cos),
            6 => (sin, -cos),
            _ => (cos, -sin),
        };
        Self { re, im }
    }

    pub const fn conjugate(self) -> Self {
        Self {
            re: self.re,
            im: -self.im,
        }
    }

    /// `i` times the number.
    pub const fn times_i(self) -> Self {
        Self {
            re: -self.im,
            im: self.re,
        }
    }

    pub fn scaled(self, factor: f64) -> Self {
        Self {
            re: self.re * factor,
            im: self.im * factor,
        }
    }
}

impl Add for Complex {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl Sub for Complex {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            re: self.re - other.re,
            im: self.im - other.im,
        }
    }
}

impl Mul for Complex {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_on_the_circle_at_their_angle() {
        for count in [1, 2, 3, 5, 7, 8, 12, 1000, 16381] {
            for k in 0..count {
                let root = Complex::root(k, count);
                // Itself rounded, to within 1e-15.
                let angle = core::f64::consts::TAU * k as f64 / count as f64;
                assert!((root.re - libm::cos(angle)).abs() < 1.5e-15, "{k}/{count}");
                assert!((root.im - libm::sin(angle)).abs() < 1.5e-15, "{k}/{count}");
                let opposite = root.conjugate() - Complex::root(count - k, count);
                assert!(opposite.re.abs().max(opposite.im.abs()) < 2e-16);
                assert_eq!(root, Complex::root(k + 3 * count, count));
            }
        }
        assert_eq!(Complex::root(1, 4).times_i(), Complex { re: -1.0, im: 0.0 });
    }
}
