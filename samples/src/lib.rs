//! Seeded, tileable normal maps that look like the materials glints come from.
//!
//! Every map repeats seamlessly in both directions, and the same [`Kind`] and [`Options`] give the same bytes on
//! every platform and for any number of threads: random numbers come from a hash of the feature they belong to
//! (so no texel depends on the order of work) and transcendental functions from `libm`.
//!
//! ```
//! use glintbake_samples::{Kind, Options, generate};
//!
//! let options = Options { width: 96, seed: 7, ..Options::new(Kind::Flakes, 64) };
//! let sample = generate(Kind::Flakes, &options)?;
//! assert_eq!(sample.normals.len(), 96 * 64);
//! let [s, t] = sample.normals[0];
//! assert!(s * s + t * t < 1.0);
//! # Ok::<(), glintbake_samples::SampleError>(())
//! ```
//!
//! # Space and sign
//!
//! Texel (column i, row j) is evaluated at its centre (i + ½, j + ½), in texels; rows run *down* the picture. Heights
//! h are in texels, so slopes have no unit. Normals are points (s, t) of the projected disk, +s right and +t *up*
//! the picture (OpenGL). The upward unit normal of z = h(x, up) is ∝ (−∂h/∂x, −∂h/∂up, 1), and up = −row, hence
//!
//! ```text
//!     (s, t) = (−∂h/∂column, +∂h/∂row) / √(1 + (∂h/∂column)² + (∂h/∂row)²)
//! ```
//!
//! A bump's upper flank (smaller rows, where h grows with the row) has t > 0: green is bright at its top.
//!
//! # Limits
//!
//! A texel is the value at its centre, not an average: features finer than two texels alias, as they do in a map
//! rendered without filtering. Sides go up to [`MAX_SIDE`]; the generators need little beyond the 8 bytes a texel they
//! return: the kinds built from heights a few bands of rows, `spectrum` and `ocean` one more byte a texel, `voronoi`
//! about 100 bytes a flake.
#![deny(missing_docs)]

mod brushed;
mod cells;
mod dents;
mod disk;
mod error;
mod flakes;
mod fourier;
mod gaussian_field;
mod gtr;
mod hollow;
mod kind;
mod leather;
mod noise;
mod ocean;
mod options;
mod poisson_disk;
mod random;
mod sample;
mod scratches;
mod slopes;
mod spectral_field;
mod spectrum;
mod voronoi;
mod waves;

#[cfg(test)]
mod tests;

pub use error::SampleError;
pub use flakes::FLAKE_GAMMA;
pub use gtr::Gtr;
pub use kind::{KINDS, Kind};
pub use options::{MAX_DENSITY, MAX_SCALE, MAX_SIDE, MIN_SCALE, Options};
pub use sample::Sample;

/// The normal map of `kind` that `options` describe, wholly determined by the two.
///
/// Runs on the current rayon pool in bands of rows whose height never depends on the number of threads.
///
/// # Errors
/// What [`Options::check`] finds, or [`SampleError::OutOfMemory`].
pub fn generate(kind: Kind, options: &Options) -> Result<Sample, SampleError> {
    options.check(kind)?;
    let texel_count = options.width as usize * options.height as usize;
    let mut normals = Vec::new();
    normals
        .try_reserve_exact(texel_count)
        .map_err(|_| SampleError::OutOfMemory { texel_count })?;
    normals.resize(texel_count, [0.0; 2]);
    match kind {
        Kind::Flakes => flakes::fill(options, &mut normals),
        Kind::Voronoi => voronoi::fill(options, &mut normals),
        Kind::Scratches => scratches::fill(options, &mut normals),
        Kind::Brushed => brushed::fill(options, &mut normals),
        Kind::Dents => dents::fill(options, &mut normals),
        Kind::Waves => waves::fill(options, &mut normals),
        Kind::Spectrum => spectrum::fill(options, &mut normals),
        Kind::Ocean => ocean::fill(options, &mut normals),
        Kind::Leather => leather::fill(options, &mut normals),
        Kind::Flat => {}
        Kind::Noise => noise::fill(options, &mut normals),
    }
    Ok(Sample {
        width: options.width,
        height: options.height,
        normals,
    })
}

/// Rows in one unit of parallel work: enough that the lattice rows shared by neighbours are a small part of it.
const BAND_ROWS: usize = 64;
