//! The decoded normal map that every structure and the oracle start from.

use super::vectors::CHUNK_TEXELS;
use glintbake_format::model::Wrap;
use rayon::prelude::*;

/// A map of unit normals in tangent space, as points (s, t) of the projected disk.
///
/// Row-major, `width * height` texels; texel (column i, row j) covers [i/W, (i+1)/W) × [j/H, (j+1)/H) of texture
/// space. Every texel is finite and satisfies `s² + t² ≤ 1` when computed in f64. 8 bytes a texel.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    width: u32,
    height: u32,
    wrap: Wrap,
    texels: Vec<[f32; 2]>,
}

impl NormalMap {
    /// A map of `width` × `height` texels from points of the projected disk.
    ///
    /// A point that rounding has left just outside the disk is moved to its rim; decoding (see the decoder)
    /// has refused or repaired everything worse before.
    ///
    /// # Panics
    /// If the number of texels is not `width * height`, or a texel is not finite.
    pub fn new(width: u32, height: u32, wrap: Wrap, mut texels: Vec<[f32; 2]>) -> Self {
        assert_eq!(
            texels.len() as u64,
            u64::from(width) * u64::from(height),
            "a {width} x {height} map needs as many texels"
        );
        texels.par_chunks_mut(CHUNK_TEXELS).for_each(|texels| {
            for texel in texels {
                assert!(
                    texel[0].is_finite() && texel[1].is_finite(),
                    "texels must be finite"
                );
                *texel = inside_disk(*texel);
            }
        });
        Self {
            width,
            height,
            wrap,
            texels,
        }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// How the map continues beyond its border.
    pub fn wrap(&self) -> Wrap {
        self.wrap
    }

    /// All texels, row-major.
    pub fn texels(&self) -> &[[f32; 2]] {
        &self.texels
    }
}

/// The nearest f32 point to `texel` whose squared length, in f64, is at most 1.
fn inside_disk(texel: [f32; 2]) -> [f32; 2] {
    let squared = |[s, t]: [f32; 2]| f64::from(s) * f64::from(s) + f64::from(t) * f64::from(t);
    let mut point = texel;
    let mut shrink = 0.0;
    while squared(point) > 1.0 {
        // Rounding to f32 may step outside again: shrink by one part in 2²³ more until it does not.
        let length = libm::sqrt(squared(point)) + shrink;
        point = point.map(|x| (f64::from(x) / length) as f32);
        shrink = f64::from(f32::EPSILON);
    }
    point
}
