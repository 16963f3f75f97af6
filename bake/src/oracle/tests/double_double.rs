//! The 106-bit numbers against integers that can be counted exactly.

use super::super::double_double::DoubleDouble;
use super::Random;

/// `high + low` from an integer below 2¹⁰⁶.
fn from_integer(integer: i128) -> DoubleDouble {
    let high = integer as f64;
    DoubleDouble::from(high) + DoubleDouble::from((integer - high as i128) as f64)
}

fn integer(random: &mut Random, bits: i32) -> i128 {
    let sign = if random.unit() < 0.5 { -1 } else { 1 };
    let high = (random.unit() * libm::exp2(f64::from(bits))) as i128;
    // Digits below the first 53, so that both halves are at work.
    sign * (high + (random.unit() * libm::exp2(f64::from(bits - 53))) as i128)
}

#[test]
fn products_of_two_f64_are_exact() {
    let mut random = Random(1);
    for _ in 0..1000 {
        let (a, b) = (integer(&mut random, 53), integer(&mut random, 53));
        let product = DoubleDouble::product(a as f64, b as f64);
        assert_eq!(product, from_integer(a as f64 as i128 * (b as f64 as i128)));
    }
}

#[test]
fn sums_that_cancel_keep_their_digits() {
    let mut random = Random(2);
    for _ in 0..1000 {
        let a = integer(&mut random, 104);
        let b = integer(&mut random, 40) - a;
        assert_eq!(from_integer(a) + from_integer(b), from_integer(a + b));
    }
}

#[test]
fn products_and_quotients_are_right_to_thirty_digits() {
    let mut random = Random(3);
    let mut worst: f64 = 0.0;
    for _ in 0..1000 {
        let (a, b) = (integer(&mut random, 60), integer(&mut random, 60));
        let product = from_integer(a) * from_integer(b);
        worst = worst.max(((product - from_integer(a * b)) / product).value().abs());
        let quotient = from_integer(a * b) / from_integer(b);
        worst = worst.max(((quotient - from_integer(a)) / quotient).value().abs());
    }
    assert!(worst < 1e-30, "relative error {worst}");
}

#[test]
fn order_is_that_of_the_values() {
    let tiny = DoubleDouble::from(1e-20);
    let one = DoubleDouble::from(1.0);
    assert!(one - tiny < one && one < one + tiny);
    assert!(-one - tiny < -one);
    assert_eq!((-one - tiny).abs(), one + tiny);
}
