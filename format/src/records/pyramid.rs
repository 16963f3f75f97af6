//! Records of pyramids: means and spreads of normals.

use zerocopy::little_endian::{I16, I32, U16};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// A mean of normals on the projected disk, to 16 bits. 4 bytes.
///
/// Each component is `value / 32767`, at most 1.53e-5 from what was baked; 0 and ±1 are exact.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct NarrowMean(pub [I16; 2]);

/// A mean of normals on the projected disk, to 32 bits. 8 bytes.
///
/// Each component is `value / 2147483647`, at most 2.4e-10 from what was baked; 0 and ±1 are exact.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct WideMean(pub [I32; 2]);

const NARROW: f64 = i16::MAX as f64;
const WIDE: f64 = i32::MAX as f64;

/// The whole number nearest to `value`, away from 0 if two are: `round` without a call, for every texel of a map.
fn nearest(value: f64) -> i64 {
    // A cast truncates.
    (value + libm::copysign(0.5, value)) as i64
}

impl NarrowMean {
    /// How far a stored component may be from the one meant.
    pub const ERROR: f64 = 0.5 / NARROW;

    /// The nearest to (s, t), each within [-1, 1].
    pub fn new(mean: [f64; 2]) -> Self {
        Self(mean.map(|component| I16::new(nearest(component * NARROW) as i16)))
    }

    /// The point (s, t), each within [-1, 1] whatever is stored.
    #[inline]
    pub fn point(self) -> [f64; 2] {
        self.0
            .map(|component| (f64::from(component.get()) / NARROW).max(-1.0))
    }
}

impl WideMean {
    /// How far a stored component may be from the one meant.
    pub const ERROR: f64 = 0.5 / WIDE;

    /// The nearest to (s, t), each within [-1, 1].
    pub fn new(mean: [f64; 2]) -> Self {
        Self(mean.map(|component| I32::new(nearest(component * WIDE) as i32)))
    }

    /// The point (s, t), each within [-1, 1] whatever is stored.
    #[inline]
    pub fn point(self) -> [f64; 2] {
        self.0
            .map(|component| (f64::from(component.get()) / WIDE).max(-1.0))
    }
}

/// The covariance of normals within a cell, in a form that is positive whatever is stored. 6 bytes.
///
/// Standard deviations are squares and the correlation ends in squares, so that what decides about thin lobes is stored as
/// finely as wide ones: a deviation d within 7.7e-6 · 2 √d, and the smaller axis of a needle of length d within 1.6e-5 · d.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct SpreadRecord {
    /// Standard deviations of s and of t: `(value / 65535)²`, in [0, 1].
    pub deviation: [U16; 2],
    /// Correlation of s and t: `±(1 - (1 - |value| / 32767)²)`, in [-1, 1].
    pub correlation: I16,
}

impl SpreadRecord {
    /// The nearest to the covariance with variances `ss` and `tt`, at least 0, and covariance `st`.
    pub fn new([ss, st, tt]: [f64; 3]) -> Self {
        let deviation = [ss, tt].map(|variance| libm::sqrt(variance.max(0.0)));
        let stored = deviation.map(|deviation| {
            let root = libm::sqrt(deviation.min(1.0));
            U16::new(libm::round(root * f64::from(u16::MAX)) as u16)
        });
        let product = deviation[0] * deviation[1];
        let is_flat = stored.iter().any(|value| value.get() == 0);
        let correlation = if is_flat || product == 0.0 {
            0.0
        } else {
            (st / product).clamp(-1.0, 1.0)
        };
        let size = libm::round((1.0 - libm::sqrt(1.0 - correlation.abs())) * NARROW);
        Self {
            deviation: stored,
            correlation: I16::new(libm::copysign(size, correlation) as i16),
        }
    }

    /// Variance of s, covariance, variance of t: a positive semi-definite matrix whatever is stored.
    #[inline]
    pub fn covariance(self) -> [f64; 3] {
        let [s, t] = self.deviation.map(|value| {
            let root = f64::from(value.get()) / f64::from(u16::MAX);
            root * root
        });
        let value = f64::from(self.correlation.get());
        let rest = (1.0 - value.abs() / NARROW).max(0.0);
        let correlation = libm::copysign(1.0 - rest * rest, value);
        [s * s, correlation * s * t, t * t]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_kept_within_half_a_step_and_stay_in_range() {
        for step in -1000..=1000 {
            let x = f64::from(step) * 1e-3;
            let [s, t] = NarrowMean::new([x, -x]).point();
            assert!((s - x).abs() <= NarrowMean::ERROR * 1.000_001 && s == -t);
            let [s, t] = WideMean::new([x, -x]).point();
            assert!((s - x).abs() <= WideMean::ERROR * 1.000_001 && s == -t);
        }
        for exact in [0.0, 1.0, -1.0] {
            assert_eq!(NarrowMean::new([exact; 2]).point(), [exact; 2]);
            assert_eq!(WideMean::new([exact; 2]).point(), [exact; 2]);
        }
        assert_eq!(NarrowMean([I16::new(i16::MIN); 2]).point(), [-1.0; 2]);
        assert_eq!(WideMean([I32::new(i32::MIN); 2]).point(), [-1.0; 2]);
    }

    #[test]
    fn any_record_is_a_positive_covariance() {
        for correlation in [i16::MIN, -32_767, -1, 0, 1, 300, 32_766, 32_767] {
            for deviation in [[0, 0], [0, 65_535], [1, 65_535], [65_535; 2], [700, 9000]] {
                let [ss, st, tt] = SpreadRecord {
                    deviation: deviation.map(U16::new),
                    correlation: I16::new(correlation),
                }
                .covariance();
                assert!((0.0..=1.0).contains(&ss) && (0.0..=1.0).contains(&tt));
                assert!(st * st <= ss * tt * (1.0 + 1e-15));
            }
        }
    }

    #[test]
    fn long_and_short_axes_are_kept_within_their_steps() {
        for long in [1.0, 0.3, 1e-2, 1e-4] {
            for ratio in [1.0, 0.1, 1e-2, 1e-3, 1e-4, 0.0] {
                for turn in 0..24 {
                    let angle = f64::from(turn) * 0.13;
                    let (cos, sin) = (libm::cos(angle), libm::sin(angle));
                    let (a, b) = (long, long * ratio);
                    let turned = |a: f64, b: f64| {
                        [
                            a * a * cos * cos + b * b * sin * sin,
                            (a * a - b * b) * sin * cos,
                            a * a * sin * sin + b * b * cos * cos,
                        ]
                    };
                    let [ss, st, tt] = SpreadRecord::new(turned(a, b)).covariance();
                    let trace = ss + tt;
                    let root = libm::hypot(ss - tt, 2.0 * st);
                    let kept = [
                        libm::sqrt(0.5 * (trace + root)),
                        libm::sqrt((0.5 * (trace - root)).max(0.0)),
                    ];
                    let step = 1.6e-5 * libm::sqrt(long);
                    assert!((kept[0] - a).abs() <= 2.0 * step, "{long} {ratio} {turn}");
                    assert!(
                        (kept[1] - b).abs() <= 2.0 * step + 3e-5 * long + 2e-8,
                        "{long} {ratio} {turn}: {kept:?}"
                    );
                }
            }
        }
    }
}
