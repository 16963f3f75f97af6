//! The Beckmann kernel against its integral and its closed values.

use super::super::direction::{direction, dot};
use super::Random;
use crate::oracle::beckmann;
use core::f64::consts::{PI, TAU};

fn unit([x, y, z]: [f64; 3]) -> [f64; 3] {
    let length = libm::sqrt(x * x + y * y + z * z);
    [x / length, y / length, z / length]
}

/// Two unit vectors that complete `m` to a frame.
fn frame(m: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let helper = if m[0].abs() < 0.6 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let first = unit(cross(m, helper));
    (first, cross(m, first))
}

/// The direction at angle `theta` from `m`, and at `azimuth` around it.
fn around(m: [f64; 3], theta: f64, azimuth: f64) -> [f64; 3] {
    let (first, second) = frame(m);
    let (along, across) = (libm::cos(theta), libm::sin(theta));
    let (x, y) = (across * libm::cos(azimuth), across * libm::sin(azimuth));
    [0, 1, 2].map(|i| along * m[i] + x * first[i] + y * second[i])
}

#[test]
fn projected_density_integrates_to_one() {
    for m in [
        [0.0, 0.0, 1.0],
        direction(0.3, -0.6),
        direction(-1.0, 0.0),
        direction(0.6, 0.8),
    ] {
        for alpha in [1e-5, 1e-3, 0.04, 0.3, 1.0] {
            // Midpoint rule over θ up to where the density is below 1e-27 of its peak, and over azimuth.
            let widest = libm::atan(8.0 * alpha);
            let (rings, sectors) = (4000, 6);
            let step = widest / f64::from(rings);
            let mut integral = 0.0;
            for ring in 0..rings {
                let theta = (f64::from(ring) + 0.5) * step;
                for sector in 0..sectors {
                    let h = around(m, theta, TAU * f64::from(sector) / f64::from(sectors));
                    let solid_angle = libm::sin(theta) * step * TAU / f64::from(sectors);
                    integral += beckmann(h, m, alpha) * dot(h, m) * solid_angle;
                }
            }
            assert!(
                (integral - 1.0).abs() < 2e-6,
                "{integral} for alpha {alpha} about {m:?}"
            );
        }
    }
}

#[test]
fn values_are_those_of_the_angle() {
    let mut random = Random(31);
    for alpha in [1e-5, 1e-4, 1e-2, 0.3] {
        for _ in 0..200 {
            let azimuth = random.between(0.0, TAU);
            let m = around([0.0, 0.0, 1.0], random.between(0.0, PI / 2.0), azimuth);
            let theta = libm::atan(alpha * random.between(0.0, 4.0));
            let h = around(m, theta, random.between(0.0, TAU));
            let (tangent, cosine) = (libm::tan(theta), libm::cos(theta));
            let expected = libm::exp(-tangent * tangent / (alpha * alpha))
                / (PI * alpha * alpha * cosine * cosine * cosine * cosine);
            // The components of h are rounded to 1e-16, an angle of 1e-11 α at α = 1e-5, times 2 tan θ / α.
            let error = (beckmann(h, m, alpha) / expected - 1.0).abs();
            assert!(error < 1e-14 + 3e-15 / alpha, "{error} at alpha {alpha}");
        }
    }
}

#[test]
fn tiny_angles_lose_nothing() {
    // Points of the disk whose distance is exact: near the pole tan θ is that distance to second order.
    let alpha = 1e-5;
    let m = direction(0.0, 0.0);
    for offset in [1e-9, 1e-7, 1e-6, 3e-5] {
        let h = direction(offset, 0.0);
        let tangent_squared = offset * offset / (1.0 - offset * offset);
        let cosine_4 = (1.0 - offset * offset) * (1.0 - offset * offset);
        let expected =
            libm::exp(-tangent_squared / (alpha * alpha)) / (PI * alpha * alpha * cosine_4);
        assert!((beckmann(h, m, alpha) / expected - 1.0).abs() < 1e-14);
    }
    // And tilted, 3 α apart along t, where f64's 1 - cos²θ has one digit left.
    let (s, t) = (0.6, 0.0);
    let (h, m) = (direction(s, t + 3e-5), direction(s, t));
    // sin²θ = |Δ|² - |Δ|⁴/4 with the chord Δ: its z part is (z² - z'²) / (z + z') with z² - z'² = t'² - t².
    let (z, z_moved) = (0.8, libm::sqrt(0.64 - 9e-10));
    let dz = -9e-10 / (z + z_moved);
    let chord = 9e-10 + dz * dz;
    let sine_squared = chord - chord * chord / 4.0;
    let cosine = 1.0 - chord / 2.0;
    let exponent = sine_squared / (cosine * cosine * alpha * alpha);
    let expected = libm::exp(-exponent) / (PI * alpha * alpha * cosine * cosine * cosine * cosine);
    let error = (beckmann(h, m, alpha) / expected - 1.0).abs();
    assert!(error < 1e-9, "{error}");
}

#[test]
fn at_a_right_angle_and_behind_there_is_nothing() {
    let m = [0.0, 0.0, 1.0];
    for alpha in [1e-5, 0.1, 1.0, 1e3] {
        for h in [[1.0, 0.0, 0.0], [0.6, 0.0, -0.8], [0.0, 0.0, -1.0]] {
            assert_eq!(beckmann(h, m, alpha), 0.0);
        }
        for cosine in [1e-3, 1e-100, 1e-160, 5e-324] {
            let density = beckmann([1.0, 0.0, cosine], m, alpha);
            assert!(density.is_finite() && density >= 0.0, "{density}");
        }
    }
}

#[test]
fn directions_at_the_rim_are_right_to_the_last_digits() {
    let mut random = Random(32);
    for _ in 0..2000 {
        let inwards = libm::exp(random.between(-36.0, 0.0));
        let [s, t] = random.vector(1.0 - inwards);
        // Multiples of 2⁻⁶⁰, so that 1 - s² - t² is a whole number of 2⁻¹²⁰, counted exactly.
        let [s_count, t_count] = [s, t].map(|x| (x * libm::exp2(60.0)) as i128);
        let [s, t] = [s_count, t_count].map(|x| x as f64 * libm::exp2(-60.0));
        let rest = (1i128 << 120) - s_count * s_count - t_count * t_count;
        let [x, y, z] = direction(s, t);
        if rest >= 0 {
            let expected = libm::sqrt(rest as f64) * libm::exp2(-60.0);
            assert_eq!([x, y], [s, t]);
            assert!((z - expected).abs() <= 3e-16 * expected, "{z} {expected}");
        } else {
            assert!(z == 0.0 && (dot([x, y, 0.0], [x, y, 0.0]) - 1.0).abs() < 5e-16);
        }
    }
    assert_eq!(direction(3.0, 4.0), [0.6, 0.8, 0.0]);
}
