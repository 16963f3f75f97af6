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
