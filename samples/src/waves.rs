//! A smooth isotropic relief.

use rayon::prelude::*;

use crate::{
    BAND_ROWS, Options,
    gaussian_field::{GaussianField, Stream},
    slopes::normalise,
};

/// Kernel width σ at scale 1, in texels.
///
/// Along a line the heights cross zero every π√2 σ = 36 texels (Rice 1944: π over the RMS wave number 1/(√2 σ)).
const SIGMA: f64 = 8.0;

/// Fills `normals` with those of a Gaussian height field of Gaussian spectrum, its RMS slope exactly `roughness`.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let size = [options.width, options.height];
    let field = GaussianField::new(
        options.seed,
        Stream::Wave,
        0,
        size,
        [SIGMA * options.scale; 2],
    );
    fill_slopes(&[(1.0, field)], options.width as usize, normals);
    normalise(normals, options.width as usize, options.roughness);
}

/// Fills `slopes` with the sum of the fields' slopes, each first scaled to the expected RMS slope given with it.
pub fn fill_slopes(fields: &[(f64, GaussianField)], width: usize, slopes: &mut [[f32; 2]]) {
    slopes
        .par_chunks_mut(BAND_ROWS * width)
        .enumerate()
        .for_each(|(index, band)| {
            let first = index * BAND_ROWS;
            let rows = first..first + band.len() / width;
            let bands: Vec<_> = fields
                .iter()
                .filter(|(_, field)| field.expected_slope() > 0.0)
                .map(|(slope, field)| (slope / field.expected_slope(), field.band(rows.clone())))
                .collect();
            let mut sums = vec![[0.0; 2]; width];
            for (row, texels) in rows.zip(band.chunks_mut(width)) {
                sums.fill([0.0; 2]);
                for (weight, field) in &bands {
                    field.visit_row(row, |column, jet| {
                        for (sum, slope) in sums[column].iter_mut().zip(jet.slope) {
                            *sum += weight * slope;
                        }
                    });
                }
                for (texel, sum) in texels.iter_mut().zip(&sums) {
                    *texel = sum.map(|x| x as f32);
                }
            }
        });
}

#[cfg(test)]
mod tests {
    use crate::{Kind, Options, generate, tests::slopes};

    #[test]
    fn slopes_have_the_roughness_and_are_gaussian_and_isotropic() {
        for roughness in [0.01, 0.25, 1.5] {
            let options = Options {
                roughness,
                scale: 0.5,
                ..Options::new(Kind::Waves, 512)
            };
            let sample = generate(Kind::Waves, &options).expect("valid options");
            let slopes = slopes(&sample);
            let mean = |f: &dyn Fn(f64, f64) -> f64| {
                slopes.iter().map(|&[a, b]| f(a, b)).sum::<f64>() / slopes.len() as f64
            };
            let rms = mean(&|a, b| a * a + b * b).sqrt();
            assert!(
                (rms / roughness - 1.0).abs() < 1e-4,
                "{rms} for {roughness}"
            );
            let half = 0.5 * rms * rms;
            // 512²/(4π·16) = 1300 independent patches: standard errors of 4 % for variances, 14 % for kurtosis.
            assert!((mean(&|a, _| a * a) / half - 1.0).abs() < 0.12);
            assert!((mean(&|a, b| a * b) / half).abs() < 0.12);
            let kurtosis = mean(&|a, _| a.powi(4)) / mean(&|a, _| a * a).powi(2);
            assert!((kurtosis - 3.0).abs() < 0.4, "{kurtosis}");
        }
    }
}
