//! The truth of a surface between texels: the integral over it, \[YHJ*14\] eq. 6.

use super::{Patch, Reference};
use glintbake_bake::oracle::analytic::Prepared;
use glintbake_format::model::{HalfVector, Interpolation};

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
