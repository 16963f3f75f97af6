//! Metal brushed along u.

use crate::{
    Options,
    gaussian_field::{GaussianField, Stream},
    slopes::normalise,
    waves::fill_slopes,
};

/// One octave of streaks.
struct Octave {
    /// Kernel width along a streak at scale 1, in texels.
    length: f64,
    /// Kernel width across it.
    thickness: f64,
    /// Its RMS slope relative to the others'.
    slope: f64,
}

/// From single hairs to broad bands. Each octave twice as thick as the one before; slopes fall more slowly than
/// thickness grows, so that heights are fractal; the longest streaks are the middle ones, as a brush leaves them.
const OCTAVES: &[Octave] = &[
    Octave {
        length: 40.0,
        thickness: 0.5,
        slope: 1.0,
    },
    Octave {
        length: 90.0,
        thickness: 1.0,
        slope: 0.8,
    },
    Octave {
        length: 120.0,
        thickness: 2.0,
        slope: 0.6,
    },
    Octave {
        length: 120.0,
        thickness: 4.0,
        slope: 0.4,
    },
];

/// Fills `normals` with those of a Gaussian height field of long streaks, its RMS slope exactly `roughness`.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let size = [options.width, options.height];
    let fields: Vec<_> = OCTAVES
        .iter()
        .zip(0..)
        .map(|(octave, part)| {
            let sigma = [octave.length, octave.thickness].map(|sigma| sigma * options.scale);
            let field = GaussianField::new(options.seed, Stream::Streak, part, size, sigma);
            (octave.slope, field)
        })
        .collect();
    fill_slopes(&fields, options.width as usize, normals);
    normalise(normals, options.width as usize, options.roughness);
}
