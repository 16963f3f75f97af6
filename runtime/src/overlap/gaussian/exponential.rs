//! A fast exponential for arguments that are not positive.

/// Arguments beyond this count as this: `e^-700` is about 1e-304, still a normal number.
const GREATEST: f64 = 700.0;

/// 1.5 · 2⁵²: adding it rounds to a whole number, which is then in the low bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// `e^-x` for x ≥ 0 within 1e-10 of its value; beyond 700 as at 700, and so for NaN.
///
/// Branchless and without a call, so that loops over it become vector instructions. `2^y` for `y = -x / ln 2` is the
/// nearest whole power, put together in the bits of a float, times a polynomial of degree 7 for the rest in
/// [-1/2, 1/2]: the one of least relative error, 4.0e-11, by Remez's exchange.
#[inline(always)]
pub(super) fn exp_negative(x: f64) -> f64 {
    let y = x.min(GREATEST) * -core::f64::consts::LOG2_E;
    let shifted = y + ROUNDING;
    let rest = y - (shifted - ROUNDING);
    // Only the low 12 bits survive the shift: the whole number plus the bias, which is in [1, 1023].
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    let square = rest * rest;
    let low = (0.999_999_999_961_682 + 0.693_147_180_728_445_6 * rest)
        + square * (0.240_226_511_981_572_08 + 0.055_504_103_534_532_084 * rest);
    let high = (0.009_618_027_253_711_369 + 0.001_333_392_255_907_752_5 * rest)
        + square * (0.000_154_692_911_308_010_6 + 1.520_192_264_197_556_2e-5 * rest);
    (low + (square * square) * high) * power
}

#[cfg(test)]
mod tests {
    use super::exp_negative;

    #[test]
    fn relative_error_is_below_1e_10() {
        let mut worst: f64 = 0.0;
        for i in 0..=2_000_000 {
            let x = f64::from(i) * 7e-6;
            worst = worst.max((exp_negative(x) / libm::exp(-x) - 1.0).abs());
        }
        for i in 0..=100_000 {
            let x = f64::from(i) * 7e-3;
            worst = worst.max((exp_negative(x) / libm::exp(-x) - 1.0).abs());
        }
        assert!(worst < 1e-10, "{worst}");
        // Without the last term of the polynomial it would be 1e-9 or worse.
        assert!(worst > 1e-12, "{worst}");
    }

    #[test]
    fn it_never_overflows_nor_vanishes() {
        for x in [700.0, 1e3, 1e300, f64::INFINITY, f64::NAN] {
            let value = exp_negative(x);
            assert!((value / libm::exp(-700.0) - 1.0).abs() < 1e-10, "{x}");
        }
        assert!((exp_negative(-1e-12) - 1.0).abs() < 1e-10);
    }
}
