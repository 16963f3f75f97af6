//! A smooth isotropic relief whose spectrum is exact.
//!
//! The snail's shell of \[YHJ*14\], section 7: "an isotropic Gaussian spectrum with randomized phase", by inverse
//! Fourier transform. The amplitude of the wave k is fixed and only its phase φ(k) is random,
//!
//! ```text
//!     |ĥ(k)|² = exp(−σ² |k|²)        ĥ(k) = |ĥ(k)| exp(i φ(k)),  φ uniform
//! ```
//!
//! so every seed has the same power in every wave and, by the theorem of Wiener and Khinchin, exactly the same
//! correlations: heights (or slopes) d texels apart, averaged over the tile, correlate as the spectrum says, near
//! exp(−d²/(4σ²)) for heights. [`waves`](crate::Kind::Waves) draws from the same spectrum with random amplitudes too.

use core::f64::consts::TAU;

use crate::{
    Options,
    fourier::Complex,
    random::{Random, Stream, key},
    slopes::normalise,
    spectral_field::{fill_slopes, wave_vector},
};

/// σ at scale 1, in texels.
///
/// Along a line the heights cross zero every π√2 σ = 18 texels (Rice 1944: π over the RMS wave number 1/(√2 σ)).
const SIGMA: f64 = 4.0;

/// Smallest σ, in texels: there the power at waves of two texels is still 8 % of the longest ones'.
const MIN_SIGMA: f64 = 0.5;

/// Largest σ as a share of the longer side: the longest wave that fits then has 0.58 of the amplitude it would have on
/// a wide tile.
const MAX_SIGMA_PER_TILE: f64 = 1.0 / 6.0;

/// Logarithm of the smallest amplitude that is drawn at all: of 1e-16 nothing would be left in an `f32` slope.
const LEAST_LOG_AMPLITUDE: f64 = -37.0;

/// Fills `normals` with those of a height field of Gaussian power spectrum and random phases, its RMS slope exactly
/// `roughness`.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let size = [options.width, options.height];
    let sigma = sigma(options);
    let key = key(options.seed, Stream::Phase, 0);
    let amplitude = |wave: [i64; 2]| {
        let [kx, ky] = wave_vector(wave, size);
        let log = -0.5 * sigma * sigma * (kx * kx + ky * ky);
        (log > LEAST_LOG_AMPLITUDE).then(|| {
            let phase = TAU * Random::of_wave(key, wave).unit();
            let (sin, cos) = libm::sincos(phase);
            Complex { re: cos, im: sin }.scaled(libm::exp(log))
        })
    };
    fill_slopes(size, amplitude, normals);
    normalise(normals, options.width as usize, options.roughness);
}

fn sigma(options: &Options) -> f64 {
    let longest = f64::from(options.width.max(options.height));
    (SIGMA * options.scale)
        .min(longest * MAX_SIGMA_PER_TILE)
        .max(MIN_SIGMA)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, generate, tests::slopes};

    /// The mean of ∇h·∇h′ at texels (dx, dy) apart, over that at the same texel.
    fn correlation(slopes: &[[f64; 2]], [width, height]: [usize; 2], [dx, dy]: [usize; 2]) -> f64 {
        let at = |x: usize, y: usize| slopes[y % height * width + x % width];
        let sum = |dx: usize, dy: usize| -> f64 {
            (0..width * height)
                .map(|i| {
                    let [x, y] = [i % width, i / width];
                    let [a, b] = [at(x, y), at(x + dx, y + dy)];
                    a[0] * b[0] + a[1] * b[1]
                })
                .sum()
        };
        sum(dx, dy) / sum(0, 0)
    }

    #[test]
    fn slopes_have_the_roughness_and_are_gaussian_and_isotropic() {
        for roughness in [0.01, 0.25, 1.5] {
            let options = Options {
                roughness,
                ..Options::new(Kind::Spectrum, 512)
            };
            let sample = generate(Kind::Spectrum, &options).expect("valid options");
            let slopes = slopes(&sample);
            let mean = |f: &dyn Fn(f64, f64) -> f64| {
                slopes.iter().map(|&[a, b]| f(a, b)).sum::<f64>() / slopes.len() as f64
            };
            let rms = mean(&|a, b| a * a + b * b).sqrt();
            assert!(
                (rms / roughness - 1.0).abs() < 1e-4,
                "{rms} for {roughness}"
            );
            // Second moments have no chance in them: they are sums over the spectrum, which has the square's
            // symmetries.
            let half = 0.5 * rms * rms;
            assert!((mean(&|a, _| a * a) / half - 1.0).abs() < 1e-3);
            assert!((mean(&|a, b| a * b) / half).abs() < 1e-3);
            // 512²/(4π·16) = 1300 independent patches: a standard error of 14 % for kurtosis.
            let kurtosis = mean(&|a, _| a.powi(4)) / mean(&|a, _| a * a).powi(2);
            assert!((kurtosis - 3.0).abs() < 0.4, "{kurtosis}");
        }
    }

    #[test]
    fn slopes_correlate_as_the_spectrum_says_for_every_seed() {
        let size = [160, 96];
        for (seed, scale) in [(0, 1.0), (77, 1.0), (3, 1.5)] {
            let options = Options {
                width: 160,
                height: 96,
                seed,
                scale,
                // Far from the hemisphere's rim f32 normals keep slopes to 1e-7.
                roughness: 0.1,
                ..Options::new(Kind::Spectrum, 1)
            };
            let slopes = slopes(&generate(Kind::Spectrum, &options).expect("valid options"));
            let sigma = SIGMA * scale;
            for [dx, dy] in [[0, 0], [3, 0], [0, 5], [6, 4], [11, 2], [25, 0], [30, 30]] {
                let found = correlation(&slopes, size, [dx, dy]);
                // −∇² of exp(−d²/(4σ²)), over its value at 0: what an endless spectrum has. Its nearest copies, a tile
                // away, add less than 1e-9.
                let q = (dx * dx + dy * dy) as f64 / (4.0 * sigma * sigma);
                let expected = (1.0 - q) * libm::exp(-q);
                assert!(
                    (found - expected).abs() < 1e-4,
                    "({dx}, {dy}) at scale {scale}: {found} for {expected}"
                );
            }
        }
    }

    #[test]
    fn thin_tiles_vary_along_their_length_alone() {
        let options = Options {
            width: 1,
            height: 100,
            ..Options::new(Kind::Spectrum, 1)
        };
        let slopes = slopes(&generate(Kind::Spectrum, &options).expect("valid options"));
        assert!(slopes.iter().all(|slope| slope[0].abs() < 1e-7));
        let squares: f64 = slopes.iter().map(|slope| slope[1] * slope[1]).sum();
        assert!(((squares / 100.0).sqrt() / options.roughness - 1.0).abs() < 1e-4);
    }
}
