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
