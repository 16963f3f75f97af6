//! What terms go to: a sum, or a visitor of facets.

use super::lanes::{LANES, Lanes};
use super::walk::Sink;
use crate::ndf::Facet;
use glintbake_format::model::HalfVector;

/// A sum of terms: in single precision by lane for a while, then in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    pub unit: f64,
    pub lanes: Lanes,
    pub total: f64,
}

impl Sum {
    pub const NONE: Self = Self {
        unit: 1.0,
        lanes: [0.0; LANES],
        total: 0.0,
    };
}

impl Sink for Sum {
    #[inline(always)]
    fn unit(&mut self, unit: f64) {
        self.unit = unit;
    }

    #[inline(always)]
    fn terms(&mut self, terms: &Lanes, _: &Lanes, _: &Lanes, _: &Lanes) {
        for (sum, term) in self.lanes.iter_mut().zip(terms) {
            *sum += term;
        }
    }

    fn exact(&mut self, term: f64, _: f64, _: [f64; 2]) {
        self.total += term;
    }

    fn flush(&mut self) {
        let lanes: f64 = self.lanes.iter().map(|&sum| f64::from(sum)).sum();
        self.total += lanes * self.unit;
        self.lanes = [0.0; LANES];
    }
}

/// Terms as facets.
pub(super) struct Visit<'v> {
    pub visit: &'v mut dyn FnMut(Facet),
    pub half_vector: HalfVector,
    pub sigma: f64,
    pub peak: f64,
    pub unit: f64,
}

impl Visit<'_> {
    fn facet(&mut self, term: f64, weight: f64, offset: [f64; 2]) {
        if term > 0.0 && weight > 0.0 {
            let normal = HalfVector {
                s: self.half_vector.s + offset[0] * self.sigma,
                t: self.half_vector.t + offset[1] * self.sigma,
            };
            (self.visit)(Facet {
                normal: normal.direction(),
                density: term / weight * self.peak,
                weight,
            });
        }
    }
}

impl Sink for Visit<'_> {
    fn unit(&mut self, unit: f64) {
        self.unit = unit;
    }

    fn terms(&mut self, terms: &Lanes, weights: &Lanes, s: &Lanes, t: &Lanes) {
        let normals = s.iter().zip(t);
        for ((&term, &weight), (&s, &t)) in terms.iter().zip(weights).zip(normals) {
            let unit = self.unit;
            let offset = [f64::from(s), f64::from(t)];
            self.facet(f64::from(term) * unit, f64::from(weight) * unit, offset);
        }
    }

    fn exact(&mut self, term: f64, weight: f64, offset: [f64; 2]) {
        self.facet(term, weight, offset);
    }

    fn flush(&mut self) {}
}
