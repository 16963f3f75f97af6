//! Layered materials: what a renderer relies on, whatever the layers are.
//!
//! Values come from the suite's oracle alone, which has no package to take the normals of; here are the checks that need none.

use super::numbers::Numbers;
use super::outcome::{At, Outcome, Recorder};
use glintbake_format::model::Footprint;
use glintbake_runtime::{Material, QueryError};
use std::f64::consts::TAU;

/// Cosines of light and view to the surface.
const COSINES: [f64; 6] = [1.0, 0.6, 0.1, 1e-3, 1e-6, 1e-12];

/// Cosines of views that the furnace is looked at from: below, single values may be large where flakes are rough, see
/// docs/DEVIATIONS.md.
const FURNACE: [f64; 4] = [1.0, 0.7, 0.4, 0.2];

/// Samples of each view.
const SAMPLES: u32 = 2000;

/// Sides of footprints in unit squares of the material.
const SIDES: [f64; 6] = [0.0, 1e-7, 1e-4, 0.01, 0.3, 2.0];

/// Every check of `material`, which lies in the package called `name`.
pub(super) fn check(name: &str, material: &Material<'_>) -> Vec<Outcome> {
    let outcomes = [
        reciprocity(name, material),
        energy(name, material),
        sampling(name, material),
        continuity(name, material),
    ];
    outcomes
        .into_iter()
        .map(|mut outcome| {
            "material".clone_into(&mut outcome.method);
            name.clone_into(&mut outcome.map);
            outcome
        })
        .collect()
}

/// Squares and needles of every size, anywhere.
fn footprints(numbers: &mut Numbers) -> Vec<Footprint> {
    let mut any = |side: f64, ratio: f64| {
        let (y, x) = libm::sincos(TAU * numbers.uniform());
        Footprint {
            centre: [numbers.uniform() * 9.0 - 4.0, numbers.uniform()],
            edge_1: [x * side, y * side],
            edge_2: [-y * side * ratio, x * side * ratio],
        }
    };
    let pairs = SIDES.iter().flat_map(|&side| [(side, 1.0), (side, 1e-3)]);
    pairs.map(|(side, ratio)| any(side, ratio)).collect()
}

fn reciprocity(name: &str, material: &Material<'_>) -> Outcome {
    let reason =
        "every factor is symmetric in light and view: rounding of cosines is all that may differ";
    let mut recorder = Recorder::new("reciprocity", reason);
    let mut numbers = Numbers::of(&[name, "material", "reciprocity"]);
    for footprint in footprints(&mut numbers) {
        for cosine in COSINES {
            let light = direction(cosine, numbers.uniform());
            let view = direction(
                COSINES[(numbers.uniform() * 6.0) as usize],
                numbers.uniform(),
            );
            let here = || {
                at(
                    format!("material, light {light:?}, view {view:?}"),
                    footprint,
                )
            };
            for colour in 0..3 {
                let mut value = |light, view| {
                    let ask =
                        || Ok::<_, QueryError>(material.eval(&footprint, light, view)?[colour]);
                    recorder.ask(here, ask)
                };
                if let (Some(there), Some(back)) = (value(light, view), value(view, light)) {
                    let greater = there.max(back).max(f64::MIN_POSITIVE);
                    recorder.compare((there - back).abs() / greater, 1e-9, here);
                }
            }
        }
    }
    recorder.finish()
}

fn energy(name: &str, material: &Material<'_>) -> Outcome {
    let reason = "of light from everywhere no more leaves than arrives, but for the noise of its samples and what bins move";
    let mut recorder = Recorder::new("energy", reason);
    let mut numbers = Numbers::of(&[name, "material", "energy"]);
    let whole = Footprint {
        centre: [0.5; 2],
        edge_1: [1.0, 0.0],
        edge_2: [0.0, 1.0],
    };
    for cosine in FURNACE {
        let view = direction(cosine, numbers.uniform());
        let here = || at(format!("white furnace, view {view:?}"), whole);
        let mut sum = [0.0; 3];
        for index in 0..SAMPLES {
            let mut uniform = numbers.four();
            uniform[0] = (f64::from(index) + uniform[0]) / f64::from(SAMPLES);
            let drawn = recorder.call(here, || material.sample(&whole, view, uniform));
            if let Some(Some(light)) = drawn
                && let Some(f) = recorder.call(here, || material.eval(&whole, light, view))
                && let Some(pdf) = recorder.ask(here, || material.pdf(&whole, light, view))
            {
                for (sum, f) in sum.iter_mut().zip(f) {
                    *sum += f * light[2] / (pdf * f64::from(SAMPLES));
                }
            }
        }
        for albedo in sum {
            recorder.energy(albedo);
            recorder.compare((albedo - 1.0).max(0.0), 0.03, here);
        }
    }
    recorder.finish()
}

fn sampling(name: &str, material: &Material<'_>) -> Outcome {
    let reason = "what is drawn is a unit vector above the horizon that has a density";
    let mut recorder = Recorder::new("sampling", reason);
    let mut numbers = Numbers::of(&[name, "material", "sampling"]);
    for footprint in footprints(&mut numbers) {
        for cosine in COSINES {
            let view = direction(cosine, numbers.uniform());
            let uniform = numbers.four();
            let here = || {
                at(
                    format!("material, view {view:?}, numbers {uniform:?}"),
                    footprint,
                )
            };
            let drawn = recorder.call(here, || material.sample(&footprint, view, uniform));
            let Some(Some(light)) = drawn else { continue };
            let length: f64 = light.iter().map(|x| x * x).sum();
            recorder.compare((length - 1.0).abs(), 1e-9, here);
            let density = recorder.ask(here, || material.pdf(&footprint, light, view));
            // Of a half vector at the rim, rounding may leave none.
            if density == Some(0.0) && light[2] > 1e-6 && view[2] > 1e-6 {
                recorder.fault(&here(), "what was drawn has no density");
            }
        }
    }
    recorder.finish()
}

fn continuity(name: &str, material: &Material<'_>) -> Outcome {
    let reason = "a bilinear map changes by at most 1 for each texel that a footprint slides along either axis";
    let mut recorder = Recorder::new("continuity", reason);
    let mut numbers = Numbers::of(&[name, "material", "continuity"]);
    for layer in material.layers() {
        let Some(map) = layer.record().opacity_map else {
            continue;
        };
        let size = map.levels.map_size().map(f64::from);
        // A hundredth of a texel.
        let step = [0.01 / size[0], 0.01 / size[1]];
        for start in footprints(&mut numbers) {
            let mut last = None;
            for number in 0..64 {
                let slid = f64::from(number);
                let footprint = Footprint {
                    centre: [
                        start.centre[0] + slid * step[0],
                        start.centre[1] + slid * step[1],
                    ],
                    ..start
                };
                let here = || at("opacity of a sliding footprint".to_owned(), footprint);
                let opacity = recorder.ask(here, || layer.opacity(&footprint));
                if let (Some(opacity), Some(last)) = (opacity, last) {
                    let change: f64 = opacity - last;
                    recorder.compare(change.abs(), 0.02 + 1e-6, here);
                }
                last = opacity;
            }
        }
    }
    recorder.finish()
}

fn at(what: String, footprint: Footprint) -> At {
    At {
        what,
        footprint: Some(footprint),
        half_vector: None,
    }
}

fn direction(cosine: f64, turn: f64) -> [f64; 3] {
    let sine = (1.0 - cosine * cosine).sqrt();
    let (y, x) = libm::sincos(TAU * turn);
    [sine * x, sine * y, cosine]
}
