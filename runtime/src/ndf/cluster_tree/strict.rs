//! Sums with a bound of their error.

use super::ClusterTree;
use super::accuracy::Knobs;
use super::lanes::Lanes;
use super::sinks::Sum;
use super::walk::Sink;
use glintbake_format::model::{Filter, HalfVector};

/// A density, and how far it can be from the sum over texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// The density, per steradian.
    pub density: f64,
    /// |density - truth| is at most this.
    pub bound: f64,
}

/// A sum, and what it may be off.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strict {
    sum: Sum,
    error: f64,
}

impl Strict {
    pub fn new() -> Self {
        Self {
            sum: Sum::NONE,
            error: 0.0,
        }
    }

    /// Density and bound of a walk of `ndf` by `knobs`.
    pub fn finish(&self, ndf: &ClusterTree<'_>, knobs: Knobs, half_vector: HalfVector) -> Bounded {
        let peak = ndf.peak();
        let density = self.sum.total * peak;
        if !half_vector.is_on_disk() {
            return Bounded {
                density,
                bound: 0.0,
            };
        }
        // What single precision leaves of normals, of which none is longer than 1, and of half vectors: half a unit of the last
        // place for each of at most 12 operations from the root to a texel, at the steepest slope of the kernel.
        let sigma = glintbake_format::model::intrinsic_from_beckmann(ndf.roughness());
        let places = 0.606_531 * 12.0 * f64::from(f32::EPSILON) / sigma;
        // Exponentials, weights and sums, relative to terms; sums are flushed before they are 2000 terms long.
        let arithmetic = 2e-5 * self.sum.total;
        // Boxes are weighed in double precision here. Of a Gaussian: its tail, what a texel's weight is off the convolution at its
        // middle, and single precision in its exponents.
        let weights = match ndf.filter {
            Filter::Box => 1e-6,
            Filter::Gaussian => libm::exp(-f64::from(knobs.limits.exponent)) + 2e-4,
        };
        Bounded {
            density,
            bound: peak * (self.error + places + arithmetic + weights),
        }
    }
}

impl Sink for Strict {
    const STRICT: bool = true;

    fn error(&mut self, bound: f32) {
        self.error += f64::from(bound) * self.sum.unit;
    }

    fn unit(&mut self, unit: f64) {
        self.sum.unit(unit);
    }

    fn terms(&mut self, terms: &Lanes, weights: &Lanes, s: &Lanes, t: &Lanes) {
        self.sum.terms(terms, weights, s, t);
    }

    fn exact(&mut self, term: f64, weight: f64, offset: [f64; 2]) {
        self.sum.exact(term, weight, offset);
    }

    fn flush(&mut self) {
        self.sum.flush();
    }
}
