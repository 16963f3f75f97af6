//! The normal distribution function.

use super::exponential::exp_negative;

/// √(2π).
pub(super) const SQRT_TAU: f64 = 2.506_628_274_631_000_7;

/// Φ, the share of a unit Gaussian below z, within 1e-10 of the smaller of it and its complement for |z| < 6 and
/// within 1e-16 beyond; in [0, 1].
#[inline]
pub(super) fn normal(z: f64) -> f64 {
    let distance = z.abs();
    let tail = exp_negative(0.5 * distance * distance) * tail_ratio(distance);
    if z > 0.0 { 1.0 - tail } else { tail }
}

/// `Φ(-z) / exp(-z²/2)` for z ≥ 0.
///
/// The quotient of polynomials 5666 of Hart and others (1968, "Computer Approximations"), as given by West (2005,
/// "Better approximations to cumulative normal functions"). Right to 1e-15 below 5 and 1e-7 at 10.
#[inline]
pub(super) fn tail_ratio(z: f64) -> f64 {
    const ABOVE: [f64; 7] = [
        3.526_249_659_989_11e-2,
        0.700_383_064_443_688,
        6.373_962_203_531_65,
        33.912_866_078_383,
        112.079_291_497_871,
        221.213_596_169_931,
        220.206_867_912_376,
    ];
    const BELOW: [f64; 8] = [
        8.838_834_764_831_84e-2,
        1.755_667_163_182_64,
        16.064_177_579_207,
        86.780_732_202_946_1,
        296.564_248_779_674,
        637.333_633_378_831,
        793.826_512_519_948,
        440.413_735_824_752,
    ];
    let polynomial = |coefficients: &[f64]| {
        coefficients
            .iter()
            .fold(0.0, |sum, coefficient| sum * z + coefficient)
    };
    polynomial(&ABOVE) / polynomial(&BELOW)
}

#[cfg(test)]
mod tests {
    use super::{SQRT_TAU, normal};
    use core::f64::consts::{FRAC_1_SQRT_2, TAU};

    #[test]
    fn it_agrees_with_the_error_function() {
        for i in -4000..=4000 {
            let z = f64::from(i) * 0.01;
            let exact = 0.5 * libm::erfc(-z * FRAC_1_SQRT_2);
            let small = exact.min(0.5 * libm::erfc(z * FRAC_1_SQRT_2));
            let error = (normal(z) - exact).abs();
            assert!(error <= 1e-10 * small + 2e-16, "{error:e} at {z}");
            assert!((0.0..=1.0).contains(&normal(z)));
        }
        assert_eq!(normal(40.0), 1.0);
        assert!(normal(-40.0) < 1e-300);
        assert!((SQRT_TAU * SQRT_TAU / TAU - 1.0).abs() < 1e-15);
    }
}
