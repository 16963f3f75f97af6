//! What a sample map shall be like.

use crate::{Kind, SampleError};

/// Longest side of a sample map, in texels: 2 GiB of normals when square, the largest map a package holds.
pub const MAX_SIDE: u32 = 16384;

/// Smallest feature scale: below it every kind is finer than a texel.
pub const MIN_SCALE: f64 = 1.0 / 64.0;

/// Largest feature scale.
pub const MAX_SCALE: f64 = 64.0;

/// Largest density: beyond it a map is covered many times over.
pub const MAX_DENSITY: f64 = 16.0;

/// Size, seed and character of a sample map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Columns, 1 to [`MAX_SIDE`].
    pub width: u32,
    /// Rows, 1 to [`MAX_SIDE`].
    pub height: u32,
    /// Any number; another seed is another map of the same kind.
    pub seed: u64,
    /// Size of features as a multiple of the kind's own (see [`Kind`]), [`MIN_SCALE`] to [`MAX_SCALE`].
    ///
    /// Features are never made finer than about a texel, nor (where they would not repeat) coarser than the tile.
    /// Noise and flat have no features.
    pub scale: f64,
    /// Spread of normals, 0 (flat) to [`Kind::max_roughness`]; [`Kind`] says what the number is.
    pub roughness: f64,
    /// Features per area as a multiple of the kind's own, 0 to [`MAX_DENSITY`]; scratches, dents and leather's pores only.
    pub density: f64,
}

impl Options {
    /// A `size` × `size` map with seed 0, scale 1, density 1 and the roughness that suits `kind`.
    pub const fn new(kind: Kind, size: u32) -> Self {
        Self {
            width: size,
            height: size,
            seed: 0,
            scale: 1.0,
            roughness: kind.default_roughness(),
            density: 1.0,
        }
    }

    /// Whether a map of `kind` can be generated, without generating it.
    ///
    /// # Errors
    /// The first value out of its range: size, then scale, roughness, density. NaN is out of every range. Values that
    /// a kind does not use are checked too.
    pub fn check(&self, kind: Kind) -> Result<(), SampleError> {
        let &Self {
            width,
            height,
            seed: _,
            scale,
            roughness,
            density,
        } = self;
        if width == 0 || height == 0 {
            return Err(SampleError::EmptySize { width, height });
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(SampleError::TooLarge { width, height });
        }
        if !(MIN_SCALE..=MAX_SCALE).contains(&scale) {
            return Err(SampleError::Scale { value: scale });
        }
        let max = kind.max_roughness();
        if !(0.0..=max).contains(&roughness) {
            return Err(SampleError::Roughness {
                value: roughness,
                max,
            });
        }
        if !(0.0..=MAX_DENSITY).contains(&density) {
            return Err(SampleError::Density { value: density });
        }
        Ok(())
    }
}
