//! The truth of a surface between texels: the integral over it, \[YHJ*14\] eq. 6.

use super::{Patch, Reference};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::analytic::Prepared;
use glintbake_format::model::{HalfVector, Interpolation, intrinsic_from_beckmann};

/// Seconds that two triangles take: that are far from the half vector, near it and smooth, and more for each deviation σr that
/// their normals are apart, up to a number of these.
const SECONDS_FAR: f64 = 1e-8;
const SECONDS_NEAR: f64 = 4e-6;
const SECONDS_STEEP: f64 = 1e-6;
const STEEPEST: f64 = 20.0;
/// Seconds that the few take that a point lies on, which are cut at each deviation of its own.
const SECONDS_OF_POINT: f64 = 1e-3;
/// Deviations σr within which triangles are near.
const NEAR: f64 = 10.0;
/// Squares of a map that are looked at for an estimate.
const LOOKED_AT: usize = 128;

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

/// Seconds that [`truth`] takes for a half vector that `map` has light for, about, under a footprint of `texels` texels.
pub(super) fn seconds(
    interpolation: Interpolation,
    map: &NormalMap,
    texels: f64,
    roughness: f64,
) -> f64 {
    let squares = match interpolation {
        // Weighed once, then summed.
        Interpolation::None => return 0.0,
        Interpolation::Linear => texels,
        Interpolation::CatmullRom => 16.0 * texels,
    };
    let sigma = intrinsic_from_beckmann(roughness);
    let normals = map.texels();
    let normal = |at: usize| normals[at % normals.len()].map(f64::from);
    let width = map.width() as usize;
    // Odd, so that not every column looked at is the same.
    let step = normals.len().div_ceil(LOOKED_AT) | 1;
    let places: Vec<usize> = (0..normals.len()).step_by(step).collect();
    let mut sum = 0.0;
    for &place in &places {
        let corners = [0, 1, width, width + 1].map(|to| normal(place + to));
        let [s, t] = [0, 1].map(|axis: usize| {
            let values = corners.map(|corner| corner[axis]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            [low - NEAR * sigma, high + NEAR * sigma]
        });
        let is_near = |&&at: &&usize| {
            let [x, y] = normal(at);
            (s[0]..=s[1]).contains(&x) && (t[0]..=t[1]).contains(&y)
        };
        let near = places.iter().filter(is_near).count() as f64 / places.len() as f64;
        let apart = (s[1] - s[0]).max(t[1] - t[0]) / sigma - 2.0 * NEAR;
        let steep = SECONDS_STEEP * apart.clamp(0.0, STEEPEST);
        sum += SECONDS_FAR + near * (SECONDS_NEAR + steep);
    }
    SECONDS_OF_POINT + squares * sum / places.len() as f64
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
