//! Gaussians on a lattice: how much of one lies beyond a place, and how to draw a point of it.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

/// Variance, in squared spacings, from which sums over a lattice follow from integrals.
///
/// By Euler and Maclaurin's formula, whose first term left out is 31/967680 of the fifth derivative: 2e-8 here.
const SMOOTH: f64 = 16.0;

/// Deviations beyond which nothing is drawn or counted: 2e-9 of all.
const FARTHEST: f64 = 6.0;

/// A Gaussian of one dimension over the lattice of all i + ½.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub mean: f64,
    pub variance: f64,
}

impl Line {
    /// Its density at `x`.
    fn density(&self, x: f64) -> f64 {
        let off = x - self.mean;
        libm::exp(-0.5 * off * off / self.variance) / libm::sqrt(2.0 * PI * self.variance)
    }

    /// Its sum over all points of the lattice below `border`, a whole number.
    pub fn below(&self, border: f64) -> f64 {
        let deviation = libm::sqrt(self.variance);
        if self.variance >= SMOOTH {
            let z = (border - self.mean) / deviation;
            let density = self.density(border) / deviation;
            // f' = -z f/σ and f''' = (3 z - z³) f/σ³.
            let first = -z * density;
            let third = (3.0 * z - z * z * z) * density / self.variance;
            return 0.5 * libm::erfc(-z * FRAC_1_SQRT_2) - first / 24.0 + 7.0 / 5760.0 * third;
        }
        let reach = FARTHEST * deviation + 1.0;
        let last = border.min(libm::ceil(self.mean + reach));
        let mut place = libm::floor(self.mean - reach);
        let mut sum = 0.0;
        while place < last {
            sum += self.density(place + 0.5);
            place += 1.0;
        }
        sum
    }

    /// Its sum over the whole lattice: `1 + 2 Σ exp(-2π² k² σ²) cos(2π k (mean - ½))`.
    pub fn total(&self) -> f64 {
        let mut sum = 1.0;
        for k in [1.0, 2.0] {
            let exponent = 2.0 * PI * PI * k * k * self.variance;
            if exponent < 22.0 {
                sum += 2.0 * libm::exp(-exponent) * libm::cos(2.0 * PI * k * (self.mean - 0.5));
            }
        }
        sum
    }

    /// The number i of the point of the lattice that `uniform`, in [0, 1), draws, and what is left of it: again a number in
    /// [0, 1), independent of the point. About 20 evaluations at most for wide Gaussians, 50 for narrow ones.
    pub fn draw(&self, uniform: f64) -> (f64, f64) {
        let wanted = uniform * self.total();
        let reach = FARTHEST * libm::sqrt(self.variance) + 1.0;
        let mut low = libm::floor(self.mean - reach);
        let mut high = libm::ceil(self.mean + reach);
        if self.variance >= SMOOTH {
            // Sums below `low` are at most `wanted`, those below `high + 1` above it.
            while high - low > 0.5 {
                let middle = libm::floor(0.5 * (low + high)) + 1.0;
                if self.below(middle) <= wanted {
                    low = middle;
                } else {
                    high = middle - 1.0;
                }
            }
            let rest = (wanted - self.below(low)) / self.density(low + 0.5);
            return (low, unit(rest));
        }
        let mut sum = 0.0;
        while low < high {
            let next = self.density(low + 0.5);
            if sum + next > wanted {
                return (low, unit((wanted - sum) / next));
            }
            sum += next;
            low += 1.0;
        }
        (high, 0.5)
    }
}

/// `x` moved into [0, 1).
fn unit(x: f64) -> f64 {
    if x >= 0.0 {
        x.min(1.0 - f64::EPSILON)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_draws_agree_with_plain_sums() {
        for (mean, variance) in [
            (0.3, 0.18),
            (7.5, 1.0),
            (-3.2, 15.9),
            (11.7, 16.0),
            (0.1, 900.0),
        ] {
            let line = Line { mean, variance };
            let reach = libm::ceil(9.0 * libm::sqrt(variance)) + 2.0;
            let mut place = libm::floor(mean) - reach;
            let mut sum = 0.0;
            let total = line.total();
            while place < mean + reach {
                assert!(
                    (line.below(place) - sum).abs() < 3e-8,
                    "{mean} {variance} {place}"
                );
                let next = line.density(place + 0.5);
                for share in [0.001, 0.4, 0.999] {
                    let uniform = (sum + share * next) / total;
                    if next > 1e-5 && uniform < 1.0 {
                        let (drawn, rest) = line.draw(uniform);
                        assert_eq!(drawn, place, "{mean} {variance}");
                        assert!((rest - share).abs() < 2e-3, "{rest} {share}");
                    }
                }
                sum += next;
                place += 1.0;
            }
            assert!((sum - total).abs() < 1e-8, "{mean} {variance}");
        }
    }
}
