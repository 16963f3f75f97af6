//! The exponential of numbers that are not positive, for loops.

/// Arguments beyond this count as this: `e^-708` is about 3e-308, still a normal number.
const GREATEST: f64 = 708.0;

/// 1.5 · 2⁵²: adding it rounds to a whole number, which is then in the low bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// ln 2 in two parts; the first has 32 bits, so that whole multiples of it are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// `e^-x` for x ≥ 0 within 4e-16 of its value; beyond 708 as at 708, and so for NaN.
///
/// Branchless and without a call, so that loops over it become vector instructions: a whole power of two, put together in
/// the bits of a float, times Taylor's polynomial of degree 12 for the rest in [-0.35, 0.35].
#[inline(always)]
pub(super) fn exp_negative(x: f64) -> f64 {
    let y = -x.min(GREATEST);
    let shifted = y * core::f64::consts::LOG2_E + ROUNDING;
    let whole = shifted - ROUNDING;
    let r = (y - whole * LN_2_HIGH) - whole * LN_2_LOW;
    // Only the low 12 bits survive the shift: the whole number plus the bias, which is in [1, 1023].
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    let square = r * r;
    let fourth = square * square;
    let pair = |constant: f64, slope: f64| constant + slope * r;
    let low = pair(1.0 / 2.0, 1.0 / 6.0) + square * pair(1.0 / 24.0, 1.0 / 120.0);
    let middle = pair(1.0 / 720.0, 1.0 / 5040.0) + square * pair(1.0 / 40_320.0, 1.0 / 362_880.0);
    let high = pair(1.0 / 3_628_800.0, 1.0 / 39_916_800.0) + square * (1.0 / 479_001_600.0);
    let curved = low + fourth * (middle + fourth * high);
    (1.0 + (r + square * curved)) * power
}

#[cfg(test)]
mod tests {
    use super::exp_negative;

    #[test]
    fn it_is_right_to_two_last_places() {
        let mut worst: f64 = 0.0;
        for i in 0..=1_000_000 {
            let x = f64::from(i) * 7e-4;
            worst = worst.max((exp_negative(x) / libm::exp(-x) - 1.0).abs());
            let x = f64::from(i) * 1e-6;
            worst = worst.max((exp_negative(x) - libm::exp(-x)).abs());
        }
        assert!(worst < 4.5e-16, "{worst:e}");
        assert_eq!(exp_negative(0.0), 1.0);
        for x in [708.0, 1e3, 1e300, f64::INFINITY, f64::NAN] {
            assert!(exp_negative(x) < 1e-307 && exp_negative(x) > 0.0);
        }
    }
}
