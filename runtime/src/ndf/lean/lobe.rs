//! One Gaussian on the projected disk.

use core::f64::consts::TAU;
use glintbake_format::model::HalfVector;

/// A Gaussian over (s, t); what lies beyond the disk is the probability of no vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    mean: [f64; 2],
    /// Standard deviation of s.
    deviation_s: f64,
    /// Mean of t for each unit that s is off its mean, and standard deviation of t about it.
    slope: f64,
    deviation_t: f64,
}

impl Lobe {
    /// The Gaussian about `mean` of variances `[ss, st, tt]`, positive semi-definite but for rounding, and `kernel`, above
    /// 0, in every direction.
    ///
    /// The determinant is a sum of positive terms, `det C + σr² tr C + σr⁴`, of which rounding can touch but the first.
    pub(super) fn new(mean: [f64; 2], [ss, st, tt]: [f64; 3], kernel: f64) -> Self {
        let determinant = (ss * tt - st * st).max(0.0) + kernel * (ss + tt + kernel);
        let variance_s = ss + kernel;
        Self {
            mean,
            deviation_s: libm::sqrt(variance_s),
            slope: st / variance_s,
            deviation_t: libm::sqrt(determinant / variance_s),
        }
    }

    /// The mean (s, t), within the disk but for the rounding of what is stored.
    pub const fn mean(&self) -> [f64; 2] {
        self.mean
    }

    /// Variance of s, covariance, variance of t, kernel included.
    pub fn covariance(&self) -> [f64; 3] {
        let variance = self.deviation_s * self.deviation_s;
        let covariance = self.slope * variance;
        [
            variance,
            covariance,
            self.slope * covariance + self.deviation_t * self.deviation_t,
        ]
    }

    /// The density at `half_vector`, per area of the disk and so numerically `D` per steradian; 0 outside the disk.
    pub fn density(&self, half_vector: HalfVector) -> f64 {
        if !half_vector.is_on_disk() {
            return 0.0;
        }
        let s = half_vector.s - self.mean[0];
        let t = half_vector.t - self.mean[1] - self.slope * s;
        let (x, y) = (s / self.deviation_s, t / self.deviation_t);
        libm::exp(-0.5 * (x * x + y * y)) / (TAU * self.deviation_s * self.deviation_t)
    }

    /// A point drawn from two uniform numbers in [0, 1) (Box and Muller 1958), on the disk or beyond.
    pub(super) fn sample(&self, uniform: [f64; 2]) -> HalfVector {
        let radius = libm::sqrt(-2.0 * libm::log1p(-uniform[0]));
        let angle = TAU * uniform[1];
        let s = radius * libm::cos(angle) * self.deviation_s;
        let t = radius * libm::sin(angle) * self.deviation_t;
        HalfVector {
            s: self.mean[0] + s,
            t: self.mean[1] + self.slope * s + t,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariances_come_back_and_needles_keep_their_width() {
        let kernel = 5e-9;
        for [ss, st, tt] in [
            [0.0, 0.0, 0.0],
            [0.1, 0.02, 0.3],
            [0.25, 0.25, 0.25],
            [0.25, -0.25, 0.25],
            [0.0, 0.0, 0.5],
            [1.0, 0.0, 1e-12],
        ] {
            let lobe = Lobe::new([0.1, -0.2], [ss, st, tt], kernel);
            let kept = lobe.covariance();
            for (kept, given) in kept.into_iter().zip([ss + kernel, st, tt + kernel]) {
                assert!((kept - given).abs() <= 1e-15 + 1e-14 * given.abs());
            }
            // Density at the mean is 1 / (2π √det): no term of it can be lost.
            let determinant = (ss * tt - st * st) + kernel * (ss + tt) + kernel * kernel;
            let peak = lobe.density(HalfVector { s: 0.1, t: -0.2 });
            assert!((peak * TAU * determinant.sqrt() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn outside_the_disk_is_nothing_and_samples_end_there_finite() {
        let lobe = Lobe::new([0.9, 0.0], [0.1, 0.0, 0.1], 1e-3);
        assert_eq!(lobe.density(HalfVector { s: 0.8, t: 0.61 }), 0.0);
        assert!(lobe.density(HalfVector { s: 0.8, t: -0.6 }) > 0.0);
        let last = 1.0 - f64::EPSILON / 2.0;
        let drawn = lobe.sample([last, 0.0]);
        assert!(drawn.s.is_finite() && !drawn.is_on_disk());
        assert_eq!(lobe.sample([0.0, 0.3]), HalfVector { s: 0.9, t: 0.0 });
    }
}
