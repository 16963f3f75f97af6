//! Light and view exchanged: the BRDF is the same, finite and never negative, from the pole to the horizon.

use super::numbers::Numbers;
use super::outcome::{Outcome, Recorder};
use super::target::{Place, Target, at};
use glintbake_format::model::HalfVector;
use glintbake_runtime::microfacet::brdf::{self, MaskingPlacement};
use glintbake_runtime::microfacet::fresnel::Fresnel;
use std::f64::consts::TAU;

/// Cosines of light and view to the surface.
const COSINES: [f64; 6] = [1.0, 0.6, 0.1, 1e-3, 1e-6, 1e-12];

const MATERIALS: [Fresnel; 3] = [
    Fresnel::Perfect,
    Fresnel::Dielectric { eta: 1.5 },
    Fresnel::Conductor {
        eta: 0.2,
        kappa: 3.9,
    },
];

/// Difference allowed, relative: rounding of cosines, which Fresnel's terms multiply by less than 100.
const BOUND: f64 = 1e-9;

const REASON: &str =
    "every factor is symmetric in light and view: rounding of two cosines is all that may differ";

/// Exchanges pairs about half vectors of each footprint, and pairs at the horizon.
pub(super) fn check(target: &Target<'_>) -> Outcome {
    let mut recorder = Recorder::new("reciprocity", REASON);
    let mut numbers = target.numbers("reciprocity");
    for place in target.places() {
        let model = target
            .subject
            .model(target.variant, &place.patch, target.alpha());
        for cosine in COSINES {
            let first = direction(cosine, numbers.uniform());
            // Opposite at as low a height, so that the half vector is the pole whatever the height.
            let opposite = [-first[0], -first[1], first[2]];
            exchange(target, place, first, opposite, &mut numbers, &mut recorder);
            // About a half vector where there is density.
            if let Some(h) = model.draw(&place.patch, numbers.four()) {
                let second = reflected(first, h);
                if second[2] > 0.0 {
                    exchange(target, place, first, second, &mut numbers, &mut recorder);
                }
            }
        }
    }
    recorder.finish()
}

fn exchange(
    target: &Target<'_>,
    place: &Place<'_>,
    first: [f64; 3],
    second: [f64; 3],
    numbers: &mut Numbers,
    recorder: &mut Recorder,
) {
    let footprint = &place.patch.footprint;
    let here = || {
        at(
            format!("brdf, light {first:?}, view {second:?}, {}", place.name),
            footprint,
            None,
        )
    };
    let material = MATERIALS[(numbers.uniform() * MATERIALS.len() as f64) as usize];
    for masking in [MaskingPlacement::Inside, MaskingPlacement::Factored] {
        let mut value = |light, view| {
            recorder.ask(here, || {
                brdf::eval_with(target.answers, footprint, light, view, material, masking)
            })
        };
        if let (Some(there), Some(back)) = (value(first, second), value(second, first)) {
            let greater = there.max(back);
            let error = if greater > 0.0 {
                (there - back).abs() / greater
            } else {
                0.0
            };
            recorder.compare(error, BOUND, here);
        }
    }
}

fn direction(cosine: f64, turn: f64) -> [f64; 3] {
    let sine = (1.0 - cosine * cosine).sqrt();
    let (y, x) = libm::sincos(TAU * turn);
    [sine * x, sine * y, cosine]
}

/// `direction` mirrored about `half_vector`.
fn reflected(direction: [f64; 3], half_vector: HalfVector) -> [f64; 3] {
    let h = half_vector.direction();
    let cosine = direction[0] * h[0] + direction[1] * h[1] + direction[2] * h[2];
    [0, 1, 2].map(|axis| 2.0 * cosine * h[axis] - direction[axis])
}
