//! Wind waves on deep water.
//!
//! A Gaussian sea, frozen: the amplitude of each wave is normal with the variance that oceanographers measured. In
//! units of the peak, ω/ωp = √x with x = |k|/kp (deep water: ω² = g |k|), and θ the angle from the wind, which blows
//! along +u:
//!
//! ```text
//!     S(ω) ∝ ω⁻⁵ exp(−5/4 (ω/ωp)⁻⁴) γ^r       r = exp(−(ω/ωp − 1)²/(2 b²)), γ = 3.3, b = 0.07 (ω ≤ ωp) or 0.09
//!     D(θ) = Q(s) cos²ˢ(θ/2)                  s = 6.97 (ω/ωp)^4.06 (ω ≤ ωp) or 9.77 (ω/ωp)^−2.33
//!     E|ĥ(k)|² ∝ S(ω) (dω/d|k|)/|k| · (D(θ) + D(θ + π))/2 · exp(−(|k| ℓ)²)
//! ```
//!
//! S is the spectrum of the Joint North Sea Wave Project (Hasselmann et al. 1973; with γ = 1 that of Pierson and
//! Moskowitz 1964). D is Longuet-Higgins', Cartwright's and Smith's (1963), Q(s) = Γ(s + 1)/(2√π Γ(s + ½)) makes its
//! integral 1, and s is measured by Hasselmann, Dunckel and Ewing (1980), at 1.17 times the wind needed for waves of
//! the peak's speed; all as collected by Horvath 2015. A picture of the heights does not tell which way a wave runs,
//! hence the mean of D and its opposite. Slopes fall off so slowly with |k| that they need an end: the factor with ℓ
//! fades waves shorter than [`SHORTEST`], as in Tessendorf 2001.

use core::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use crate::{
    Options,
    fourier::Complex,
    random::{Random, Stream, key},
    slopes::normalise,
    spectral_field::{fill_slopes, wave_vector},
};

/// Length of the waves at the peak of the spectrum of heights, at scale 1, in texels.
const PEAK_LENGTH: f64 = 128.0;

/// Smallest peak length, in texels: twice the length that short waves fade at.
const MIN_PEAK_LENGTH: f64 = 2.0 * SHORTEST;

/// Largest peak length as a share of the longer side: a tile shows some waves, not half a one.
const MAX_PEAK_LENGTH_PER_TILE: f64 = 0.25;

/// Length of the waves that are faded to 1/e of their power, in texels: 2πℓ. At four texels 2 % are left.
const SHORTEST: f64 = 8.0;

/// γ and the two widths b of the peak.
const PEAK_ENHANCEMENT: f64 = 3.3;
const PEAK_WIDTHS: [f64; 2] = [0.07, 0.09];

/// Fills `normals` with those of a sea under wind along +u, its RMS slope exactly `roughness`.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let size = [options.width, options.height];
    let sea = Sea::new(options);
    let key = key(options.seed, Stream::Swell, 0);
    let amplitude = |wave: [i64; 2]| {
        let deviation = sea.power(wave_vector(wave, size)).sqrt() * FRAC_1_SQRT_2;
        let [re, im] = Random::of_wave(key, wave).gaussian_pair();
        Some(Complex { re, im }.scaled(deviation))
    };
    fill_slopes(size, amplitude, normals);
    normalise(normals, options.width as usize, options.roughness);
}

/// A sea state.
struct Sea {
    /// kp, in radians per texel.
    peak: f64,
}

impl Sea {
    fn new(options: &Options) -> Self {
        let longest = f64::from(options.width.max(options.height));
        let length = (PEAK_LENGTH * options.scale)
            .min(longest * MAX_PEAK_LENGTH_PER_TILE)
            .max(MIN_PEAK_LENGTH);
        Self { peak: TAU / length }
    }

    /// E|ĥ(k)|² of wave vector `k` ≠ 0 in radians per texel, up to a factor common to all.
    fn power(&self, k: [f64; 2]) -> f64 {
        let length = (k[0] * k[0] + k[1] * k[1]).sqrt();
        let x = length / self.peak;
        // ω/ωp.
        let frequency = x.sqrt();
        let fade = length * (SHORTEST / TAU);
        let width = PEAK_WIDTHS[usize::from(frequency > 1.0)];
        let from_peak = (frequency - 1.0) / width;
        let enhanced = libm::exp(-0.5 * from_peak * from_peak);
        let log = enhanced * libm::log(PEAK_ENHANCEMENT) - 1.25 / (x * x) - fade * fade;
        // ω⁻⁵ (dω/d|k|)/|k| = x^(−5/2) · x^(−1/2)/2 · x⁻¹.
        libm::exp(log) / (x * x * x * x) * spreading(frequency, k[0] / length)
    }
}

/// (D(θ) + D(θ + π))/2 at ω/ωp = `frequency` and cos θ = `cosine`.
fn spreading(frequency: f64, cosine: f64) -> f64 {
    let s = if frequency <= 1.0 {
        6.97 * libm::pow(frequency, 4.06)
    } else {
        9.77 * libm::pow(frequency, -2.33)
    };
    let q = libm::tgamma(s + 1.0) / (2.0 * PI.sqrt() * libm::tgamma(s + 0.5));
    // cos²(θ/2) = (1 + cos θ)/2; rounding may put |cos θ| above 1.
    let half = |cosine: f64| libm::pow((0.5 + 0.5 * cosine).clamp(0.0, 1.0), s);
    0.5 * q * (half(cosine) + half(-cosine))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, generate, tests::slopes};

    /// ∫ f over the circle, by the trapezoidal rule.
    fn around(f: impl Fn(f64) -> f64) -> f64 {
        let count = 2000;
        (0..count)
            .map(|i| f(TAU * f64::from(i) / f64::from(count)))
            .sum::<f64>()
            * TAU
            / f64::from(count)
    }

    #[test]
    fn spreading_has_integral_one_and_is_narrowest_at_the_peak() {
        for frequency in [0.5, 0.7, 0.9, 1.0, 1.1, 2.0, 3.5] {
            let total = around(|angle| spreading(frequency, libm::cos(angle)));
            assert!((total - 1.0).abs() < 1e-5, "{frequency}: {total}");
        }
        let across = |frequency| spreading(frequency, 0.0) / spreading(frequency, 1.0);
        assert!(across(1.0) < 0.02 && across(0.5) > 0.2 && across(4.0) > 0.5);
    }

    #[test]
    fn frequencies_have_the_spectrum_of_jonswap() {
        let sea = Sea { peak: 0.04 };
        // Hasselmann et al. 1973, in ω/ωp, as printed.
        let jonswap = |w: f64| {
            let b = if w <= 1.0 { 0.07 } else { 0.09 };
            let r = libm::exp(-(w - 1.0).powi(2) / (2.0 * b * b));
            w.powi(-5) * libm::exp(-1.25 * w.powi(-4)) * libm::pow(3.3, r)
        };
        // ∫ power d²k = ∫ power |k| dθ (d|k|/dω) dω, |k| = kp (ω/ωp)².
        let found = |w: f64| {
            let k = sea.peak * w * w;
            let fade = libm::exp((k * SHORTEST / TAU).powi(2));
            let ring = around(|angle| sea.power([k * libm::cos(angle), k * libm::sin(angle)]));
            ring * k * w * fade
        };
        let at_peak = found(1.0) / jonswap(1.0);
        for w in [0.6, 0.8, 0.93, 1.0, 1.05, 1.2, 2.0, 3.5] {
            let ratio = found(w) / jonswap(w) / at_peak;
            assert!((ratio - 1.0).abs() < 1e-6, "{w}: {ratio}");
        }
    }

    #[test]
    fn slopes_covary_as_the_spectrum_says() {
        let options = Options {
            scale: 0.125,
            roughness: 0.2,
            ..Options::new(Kind::Ocean, 512)
        };
        let slopes = slopes(&generate(Kind::Ocean, &options).expect("valid options"));
        let found = |axis: usize, [dx, dy]: [usize; 2]| {
            let sum: f64 = (0..512 * 512)
                .map(|i| {
                    let moved = (i / 512 + dy) % 512 * 512 + (i % 512 + dx) % 512;
                    slopes[i][axis] * slopes[moved][axis]
                })
                .sum();
            sum / (512.0 * 512.0)
        };
        let sea = Sea::new(&options);
        assert!((TAU / sea.peak - 16.0).abs() < 1e-9);
        let waves: Vec<_> = (-255..=255)
            .flat_map(|n| (-255..=255).map(move |m| [m, n]))
            .filter(|&wave| wave != [0, 0])
            .map(|wave| wave_vector(wave, [512; 2]))
            .map(|k| (k, sea.power(k)))
            .collect();
        let expected = |axis: usize, offset: [usize; 2]| -> f64 {
            let term = |(k, power): &([f64; 2], f64)| {
                let phase = k[0] * offset[0] as f64 + k[1] * offset[1] as f64;
                power * k[axis] * k[axis] * libm::cos(phase)
            };
            waves.iter().map(term).sum()
        };
        let total = expected(0, [0, 0]) + expected(1, [0, 0]);
        for axis in [0, 1] {
            for offset in [[0, 0], [4, 0], [8, 0], [16, 0], [0, 8], [5, 5]] {
                let found = found(axis, offset) / 0.04;
                let expected = expected(axis, offset) / total;
                // Waves of the peak, 16 texels long and some 40 wide, fit into the tile 400 times: an error of 5 % of
                // the variance of theirs, which is under half the whole.
                assert!(
                    (found - expected).abs() < 0.06,
                    "axis {axis}, {offset:?}: {found} for {expected}"
                );
            }
        }
        // Waves run along u.
        assert!(found(0, [0, 0]) > 1.3 * found(1, [0, 0]));
    }

    #[test]
    fn slopes_have_the_roughness() {
        for (width, height) in [(300, 200), (1, 100), (100, 1)] {
            let options = Options {
                width,
                height,
                ..Options::new(Kind::Ocean, 1)
            };
            let slopes = slopes(&generate(Kind::Ocean, &options).expect("valid options"));
            let squares: f64 = slopes.iter().map(|[a, b]| a * a + b * b).sum();
            let rms = (squares / slopes.len() as f64).sqrt();
            assert!((rms / options.roughness - 1.0).abs() < 1e-4, "{rms}");
        }
    }
}
