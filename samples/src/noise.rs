//! White noise: the map with the least structure a filter could use.

use rayon::prelude::*;

use crate::{
    Options,
    random::{Random, Stream, key},
    slopes::normal,
};

/// Fills `normals` with independent normals of Beckmann slope distribution, α = roughness.
///
/// Both slopes are Gaussian with variance α²/2 (Heitz 2014, appendix), so that the squared slope is exponential with
/// mean α².
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let key = key(options.seed, Stream::Noise, 0);
    let deviation = options.roughness * core::f64::consts::FRAC_1_SQRT_2;
    normals
        .par_chunks_mut(options.width as usize)
        .enumerate()
        .for_each(|(row, texels)| {
            for (column, texel) in texels.iter_mut().enumerate() {
                let pair = Random::at(key, column as u64, row as u64).gaussian_pair();
                *texel = normal(pair.map(|x| x * deviation));
            }
        });
}

#[cfg(test)]
mod tests {
    use crate::{Kind, Options, generate};

    #[test]
    fn squared_slopes_are_exponential_with_mean_alpha_squared() {
        let options = Options {
            roughness: 0.4,
            ..Options::new(Kind::Noise, 128)
        };
        let sample = generate(Kind::Noise, &options).expect("valid options");
        let mut found: Vec<f64> = sample
            .normals
            .iter()
            .map(|&[s, t]| {
                let squared = f64::from(s) * f64::from(s) + f64::from(t) * f64::from(t);
                1.0 - libm::exp(-squared / (1.0 - squared) / 0.16)
            })
            .collect();
        found.sort_by(f64::total_cmp);
        let distance = crate::tests::distance_from_uniform(&found);
        assert!(distance < 1.0, "{distance}");
    }
}
