//! Random numbers that belong to a feature, not to a moment: the same whichever thread asks, and in which order.

use rand_core::{RngCore, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Increment of `SplitMix64`: 2⁶⁴ over the golden ratio, odd (Steele, Lea, Flood 2014, figure 16).
const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

/// What random numbers are for, so that no two uses of a seed share them.
#[derive(Clone, Copy, Debug)]
#[repr(u64)]
pub enum Stream {
    Flake = 1,
    Scratch = 2,
    ScratchBase = 3,
    Streak = 4,
    Wave = 5,
    Pebble = 6,
    Wrinkle = 7,
    Pore = 8,
    Warp = 9,
    Noise = 10,
    Phase = 11,
    Swell = 12,
    Centre = 13,
    Facet = 14,
    Dent = 15,
}

/// The finaliser of `SplitMix64`, "Mix13" of Stafford (2011): a bijection in which each input bit flips each output bit
/// with probability close to ½.
const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The key of one use of a seed; `part` tells apart fields of the same stream.
pub const fn key(seed: u64, stream: Stream, part: u64) -> u64 {
    absorb(absorb(absorb(0, seed), stream as u64), part)
}

/// `key` with one more word mixed in; a bijection of the word, so neighbours of one key never collide.
const fn absorb(key: u64, word: u64) -> u64 {
    mix(key.wrapping_add(GOLDEN_GAMMA) ^ word)
}

/// A short stream of random numbers of one feature.
pub struct Random(Xoshiro256PlusPlus);

impl Random {
    /// The numbers of the feature at (column, row) under `key`.
    pub fn at(key: u64, column: u64, row: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(absorb(
            absorb(key, column),
            row,
        )))
    }

    /// The numbers of the wave with `wave` periods along (columns, rows) of the tile, under `key`.
    pub fn of_wave(key: u64, wave: [i64; 2]) -> Self {
        Self::at(key, wave[0] as u64, wave[1] as u64)
    }

    /// Uniform in [0, 1): the top 53 bits, so that every value is a multiple of 2⁻⁵³.
    pub fn unit(&mut self) -> f64 {
        const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * UNIT
    }

    /// Uniform in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Two independent standard normal numbers (Box and Muller 1958).
    pub fn gaussian_pair(&mut self) -> [f64; 2] {
        // 1 − u lies in (0, 1]: the logarithm is finite, the longest pair has length √(2·53·ln 2) = 8.6.
        let radius = (-2.0 * libm::log(1.0 - self.unit())).sqrt();
        let (sin, cos) = libm::sincos(core::f64::consts::TAU * self.unit());
        [radius * cos, radius * sin]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mix_is_splitmix64() {
        // First outputs of the reference splitmix64.c (Vigna 2015) for state 0.
        assert_eq!(mix(GOLDEN_GAMMA), 0xe220_a839_7b1d_cdaf);
        assert_eq!(mix(GOLDEN_GAMMA.wrapping_mul(2)), 0x6e78_9e6a_a1b9_65f4);
    }

    #[test]
    fn neighbouring_features_are_uncorrelated() {
        let key = key(3, Stream::Noise, 0);
        let at = |x, y| Random::at(key, x, y).unit() - 0.5;
        let side = 200;
        let [mut across, mut down, mut transposed] = [0.0; 3];
        for y in 0..side {
            for x in 0..side {
                across += at(x, y) * at(x + 1, y);
                down += at(x, y) * at(x, y + 1);
                transposed += at(x, y) * at(y, x) * f64::from(u8::from(x != y));
            }
        }
        // Each product has standard deviation 1/12; the mean of n, 1/(12·√n); five of those, doubled for `transposed`
        // where every pair counts twice.
        let bound = 5.0 / 12.0 / (side as f64);
        let count = (side * side) as f64;
        for sum in [across, down, transposed / 2.0] {
            assert!((sum / count).abs() < bound, "{} vs {bound}", sum / count);
        }
    }

    #[test]
    fn gaussian_pairs_have_unit_variance_and_no_correlation() {
        let key = key(4, Stream::Noise, 0);
        let count = 40_000;
        let mut moments = [0.0; 4];
        for i in 0..count {
            let [a, b] = Random::at(key, i, 0).gaussian_pair();
            for (moment, value) in moments.iter_mut().zip([a * a, b * b, a * b, a + b]) {
                *moment += value / count as f64;
            }
        }
        for (moment, expected) in moments.into_iter().zip([1.0, 1.0, 0.0, 0.0]) {
            // Standard deviations are at most √2/√count = 0.007.
            assert!((moment - expected).abs() < 0.035, "{moments:?}");
        }
    }
}
