//! Energy: what the pdf integrates to, against the model's and, where no lobe crosses the horizon, against the truth's, 1.

use super::footprints::{COUNTED, POINT};
use super::numbers::Numbers;
use super::outcome::{At, Outcome, Recorder};
use super::target::{Place, Target, at};
use super::window::Window;
use crate::measure::subject::Reference;
use glintbake_bake::oracle::specular_bins::normal_at;
use glintbake_format::model::HalfVector;
use std::f64::consts::TAU;

/// Energy of the truth below which a lobe crosses the horizon.
const WHOLE: f64 = 0.9999;
/// Most that energy may differ from the model's, of it, whatever single densities may; by settings of papers, kept as printed, the
/// more.
const MOST_OFF: f64 = 8e-3;
const MOST_OFF_BY_PAPER: f64 = 0.1;
/// Units of the chart to each side of a lobe, and nodes in a unit: midpoints are exact to 1e-15 for a Gaussian there.
const REACH: f64 = 6.0;
const NODES: u32 = 3;
/// Roughness from which lobes are wide enough for a grid over the hemisphere, and its side.
const WIDE: f64 = 0.3;
const SIDE: u32 = 64;

const REASON: &str = "each lobe integrates to 1 in its own frame: 1e-3 is lost at most where none crosses the horizon (0.1 by a \
                      paper's own setting), and else as much as the model loses";

/// Sums the lobe of one texel, and of many where lobes are wide.
pub(super) fn check(target: &Target<'_>) -> Outcome {
    let mut recorder = Recorder::new("energy", REASON);
    let mut numbers = target.numbers("energy");
    if let Some(place) = target.place(POINT)
        && let Some(nodes) = around_lobe(target, place, &mut numbers)
    {
        sum(target, place, &nodes, &mut recorder);
    }
    if target.roughness.is_some_and(|alpha| alpha >= WIDE)
        && let Some(place) = target.place(COUNTED)
        && target.is_quick(place)
    {
        sum(target, place, &hemisphere(), &mut recorder);
    }
    recorder.finish()
}

/// A half vector and the solid angle it stands for.
type Node = (HalfVector, f64);

/// Nodes over the whole lobe of the texel under `place`.
fn around_lobe(target: &Target<'_>, place: &Place<'_>, numbers: &mut Numbers) -> Option<Vec<Node>> {
    let model = target
        .subject
        .model(target.variant, &place.patch, target.alpha());
    let window = Window::of(target, &place.patch, &*model, REACH, numbers)?;
    let side = (2.0 * REACH) as u32 * NODES;
    Some(window.nodes(side).collect())
}

/// Nodes of equal solid angle over the hemisphere.
fn hemisphere() -> Vec<Node> {
    let middle = |x: u32| (f64::from(x) + 0.5) / f64::from(SIDE);
    let solid_angle = TAU / f64::from(SIDE * SIDE);
    (0..SIDE * SIDE)
        .map(|node| {
            (
                normal_at([middle(node % SIDE), middle(node / SIDE)]),
                solid_angle,
            )
        })
        .collect()
}

fn sum(target: &Target<'_>, place: &Place<'_>, nodes: &[Node], recorder: &mut Recorder) {
    let footprint = &place.patch.footprint;
    let alpha = target.alpha();
    let (subject, variant) = (target.subject, target.variant);
    let of = |reference: &dyn Reference| -> f64 {
        nodes
            .iter()
            .map(|&(h, angle)| reference.pdf(h) * angle)
            .sum()
    };
    let model = of(&*subject.model(variant, &place.patch, alpha));
    let lost = subject.loss(variant);
    // Only who promises to keep the truth's energy needs it.
    let truth = lost.map(|lost| {
        let truth = if subject.is_truth(variant) {
            model
        } else {
            of(&*subject.truth(variant, &place.patch, alpha))
        };
        (lost, truth)
    });
    let mut energy = 0.0;
    for &(h, angle) in nodes {
        let pdf = recorder.ask(
            || at(format!("pdf, {}", place.name), footprint, Some(h)),
            || target.answers.pdf(footprint, h),
        );
        energy += pdf.unwrap_or_default() * angle;
    }
    recorder.energy(energy);
    let what = |what: &str| At {
        what: format!("{what}: {energy}, model {model}, {}", place.name),
        footprint: Some(*footprint),
        half_vector: None,
    };
    let bound = target.bound();
    // What errors of single densities add up to is far less than each of them.
    let most = if variant.is_paper {
        MOST_OFF_BY_PAPER
    } else {
        MOST_OFF
    };
    let allowed = bound.relative.min(most) * model;
    recorder.compare((energy - model).abs(), allowed, || what("energy"));
    if let Some((lost, truth)) = truth
        && truth >= WHOLE
    {
        // The truth's energy is 1, summed over the same nodes.
        recorder.compare((energy - truth).abs(), lost + allowed, || {
            what(&format!("energy lost of {truth}"))
        });
    }
}
