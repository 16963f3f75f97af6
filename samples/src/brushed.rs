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
        length: 24.0,
        thickness: 0.5,
        slope: 1.0,
    },
    Octave {
        length: 48.0,
        thickness: 1.0,
        slope: 0.8,
    },
    Octave {
        length: 64.0,
        thickness: 2.0,
        slope: 0.6,
    },
    Octave {
        length: 64.0,
        thickness: 4.0,
        slope: 0.4,
    },
];

/// Fills `normals` with those of a Gaussian height field of long streaks, its RMS slope exactly `roughness`.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let fields = fields(options);
    fill_slopes(&fields, options.width as usize, normals);
    normalise(normals, options.width as usize, options.roughness);
}

/// The fields of streaks, each with the RMS slope it has in their sum, relative to the others'.
pub fn fields(options: &Options) -> Vec<(f64, GaussianField)> {
    let size = [options.width, options.height];
    OCTAVES
        .iter()
        .zip(0..)
        .map(|(octave, part)| {
            let sigma = [octave.length, octave.thickness].map(|sigma| sigma * options.scale);
            let field = GaussianField::new(options.seed, Stream::Streak, part, size, sigma);
            (octave.slope, field)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::{Kind, Options, generate, tests::slopes};

    #[test]
    fn slopes_are_gaussian_and_spread_along_t() {
        let sample = generate(Kind::Brushed, &Options::new(Kind::Brushed, 512)).expect("valid");
        let slopes = slopes(&sample);
        let moment = |axis: usize, power: i32| {
            let sum: f64 = slopes.iter().map(|slope| slope[axis].powi(power)).sum();
            sum / slopes.len() as f64
        };
        assert!(
            moment(1, 2) > 400.0 * moment(0, 2),
            "20 times as wide along t"
        );
        let kurtosis = moment(1, 4) / (moment(1, 2) * moment(1, 2));
        // About 512²/(2π·24·0.5) = 3500 independent patches of the finest octave: standard error √(24/3500) = 0.08.
        assert!((kurtosis - 3.0).abs() < 0.3, "{kurtosis}");
    }
}
