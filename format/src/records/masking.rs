//! Records of the masking of a map's own normals.

use zerocopy::little_endian::U16;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// One value of a masking table: the excess `e` of a direction, see [`excess`](Self::excess). 2 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct MaskingValue(pub U16);

/// The stored number that means 0.
const ZERO: i32 = 1 << 15;

/// One more than the farthest stored number lies from [`ZERO`], so that every number means something finite.
const SCALE: f64 = 32_769.0;

impl MaskingValue {
    /// The nearest value to `excess`, within 3.1e-5 √(|e| (1 + |e|)³) for |e| up to 16 000, at least 2.4e-10 apart;
    /// 0 is stored exactly.
    pub fn from_excess(excess: f64) -> Self {
        let size = excess.abs();
        let root = libm::sqrt(size / (1.0 + size));
        let distance = libm::round(root * SCALE).min(f64::from(ZERO - 1)) as i32;
        let distance = if excess < 0.0 { -distance } else { distance };
        // Within 1 to 65535, as the distance is less than 32768.
        Self(U16::new(ZERO.wrapping_add(distance) as u16))
    }

    /// The excess `e = d |d| / (32769² - d²)` this stands for, d being the stored number less 32768.
    pub fn excess(self) -> f64 {
        let distance = f64::from(i32::from(self.0.get()).wrapping_sub(ZERO));
        distance * distance.abs() / (SCALE * SCALE - distance * distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_finite_rises_and_comes_back() {
        let mut previous = f64::NEG_INFINITY;
        for number in 0..=u16::MAX {
            let value = MaskingValue(U16::new(number));
            let excess = value.excess();
            assert!(excess.is_finite() && excess > previous, "{number}");
            previous = excess;
            if number > 0 {
                assert_eq!(MaskingValue::from_excess(excess), value);
            }
        }
        assert_eq!(MaskingValue::from_excess(0.0).excess(), 0.0);
    }

    #[test]
    fn excesses_are_kept_within_their_step() {
        for sign in [1.0, -1.0] {
            for step in 0..2000 {
                let excess = sign * 1e-8 * libm::pow(10.0, f64::from(step) * 0.005);
                let kept = MaskingValue::from_excess(excess).excess();
                let size = excess.abs();
                let bound = 3.1e-5 * libm::sqrt(size * (1.0 + size).powi(3)) + 2.4e-10;
                assert!((kept - excess).abs() <= bound, "{excess}: {kept}");
            }
        }
    }
}
