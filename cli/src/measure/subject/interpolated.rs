//! The truth of a surface between texels: the integral over it, \[YHJ*14\] eq. 6.

use super::{Patch, Reference};
use glintbake_bake::oracle::analytic::Prepared;
use glintbake_format::model::{HalfVector, Interpolation, intrinsic_from_beckmann};

/// Seconds that two triangles take whose normals are near the half vector.
const SECONDS_A_SQUARE: f64 = 4e-6;
/// Deviations σr within which they are near.
const NEAR: f64 = 10.0;

/// The truth of the surface of `patch` under its Gaussian.
pub(super) fn truth(
    interpolation: Interpolation,
    patch: &Patch<'_>,
    roughness: f64,
) -> Box<dyn Reference> {
    Box::new(Integral {
        roughness,
        prepared: Prepared::new(patch.map, &patch.footprint, interpolation),
    })
}

/// Seconds that [`truth`] takes for each texel under a footprint, about: normals are taken to be spread over the disk.
pub(super) fn seconds_a_texel(interpolation: Interpolation, roughness: f64) -> f64 {
    let squares = match interpolation {
        // Weighed once, then summed.
        Interpolation::None => return 0.0,
        Interpolation::Linear => 1.0,
        Interpolation::CatmullRom => 16.0,
    };
    let near = (NEAR * intrinsic_from_beckmann(roughness)).min(1.0);
    squares * near * SECONDS_A_SQUARE
}

struct Integral {
    roughness: f64,
    prepared: Prepared,
}

impl Reference for Integral {
    fn ndf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.ndf(half_vector, self.roughness)
    }

    fn pdf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.pdf(half_vector, self.roughness)
    }

    fn draw(&self, _: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        self.prepared.draw(self.roughness, uniform)
    }
}
