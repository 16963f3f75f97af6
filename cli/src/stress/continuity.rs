//! No visible pop: footprints that slide or grow by a ten-thousandth of a texel change the density by as little as their
//! weights do.

use super::numbers::Numbers;
use super::outcome::{Outcome, Recorder};
use super::target::{Target, at};
use crate::measure::subject::Bound;
use glintbake_format::model::{Footprint, HalfVector, Wrap};

/// A step, in texels.
const STEP: f64 = 1e-4;
/// Steps to either side of a border.
const STEPS: i32 = 12;
/// Edges of footprints that slide, in texels.
const EDGES: [[f64; 2]; 4] = [[0.01, 0.01], [1.0, 0.7], [6.0, 5.0], [20.0, 0.05]];

const REASON: &str = "as a share of the kernel's peak: a step changes the weights of a footprint by at most its perimeter x step / \
                      area, and the answer by that and twice its accuracy";

/// Slides over a border of texels, over the seams of the tile, and grows.
pub(super) fn check(target: &Target<'_>) -> Outcome {
    let mut recorder = Recorder::new("continuity", REASON);
    let mut numbers = target.numbers("continuity");
    let bound = target.bound();
    let size = [target.map().width(), target.map().height()];
    let middle =
        size.map(|side| (f64::from(side / 2) / f64::from(side)).max(0.5 / f64::from(side)));
    let within = middle[1] + 0.31 / f64::from(size[1]);
    for (name, border) in [
        ("a border of texels", [middle[0], within]),
        ("the seam in u", [1.0, within]),
        ("the corner of four tiles", [3.0, -2.0]),
    ] {
        for edges in EDGES {
            slide(
                target,
                &bound,
                name,
                border,
                edges,
                &mut numbers,
                &mut recorder,
            );
        }
    }
    grow(target, &bound, &mut recorder);
    recorder.finish()
}

/// Slides a footprint across `border`.
fn slide(
    target: &Target<'_>,
    bound: &Bound,
    name: &str,
    border: [f64; 2],
    edges: [f64; 2],
    numbers: &mut Numbers,
    recorder: &mut Recorder,
) {
    let size = [
        f64::from(target.map().width()),
        f64::from(target.map().height()),
    ];
    let turn = numbers.between(0.0, 1.5);
    let (sine, cosine) = libm::sincos(turn);
    // Mostly along u, so that the seam is crossed and corners are cut.
    let (dv, du) = libm::sincos(numbers.between(-0.5, 0.5));
    let footprint = |step: i32| Footprint {
        centre: [
            border[0] + f64::from(step) * STEP * du / size[0],
            border[1] + f64::from(step) * STEP * dv / size[1],
        ],
        edge_1: [edges[0] * cosine / size[0], edges[0] * sine / size[1]],
        edge_2: [-edges[1] * sine / size[0], edges[1] * cosine / size[1]],
    };
    let change = 2.0 * (edges[0] + edges[1]) * STEP / (edges[0] * edges[1]);
    let peak = target.peak();
    for h in normals_beside(target, border) {
        let mut before: Option<f64> = None;
        for step in -STEPS..=STEPS {
            let footprint = footprint(step);
            let here = || {
                at(
                    format!("slide over {name}, edges {edges:?} texels"),
                    &footprint,
                    Some(h),
                )
            };
            let now = recorder.ask(here, || target.answers.eval(&footprint, h));
            if let (Some(before), Some(now)) = (before, now) {
                let allowed = change + 2.0 * bound.allowed(before.max(now), peak) / peak;
                recorder.compare((now - before).abs() / peak, allowed, here);
            }
            before = now;
        }
    }
}

/// The normals of the texels to the left and to the right of `border`.
fn normals_beside(target: &Target<'_>, border: [f64; 2]) -> [HalfVector; 2] {
    let map = target.map();
    let fold = |x: f64, side: u32| {
        let texel = match map.wrap() {
            Wrap::Repeat => (x - x.floor()) * f64::from(side),
            Wrap::Clamp => x.clamp(0.0, 1.0) * f64::from(side),
        };
        (texel as u32).min(side - 1)
    };
    [-0.5, 0.5].map(|away| {
        let column = fold(border[0] + away / f64::from(map.width()), map.width());
        let row = fold(border[1] + 0.25 / f64::from(map.height()), map.height());
        let texel = map.texels()[row as usize * map.width() as usize + column as usize];
        HalfVector {
            s: f64::from(texel[0]),
            t: f64::from(texel[1]),
        }
    })
}

/// Grows a footprint over all sizes at which look-ups and levels change: what the model does not explain is a pop. One that may be off
/// by the whole peak explains nothing.
fn grow(target: &Target<'_>, bound: &Bound, recorder: &mut Recorder) {
    let Some(first) = target.growing().next() else {
        return;
    };
    if bound.is_of_the_peak() {
        return;
    }
    let [s, t] = first.patch.normal_by_weight(0.5);
    let h = HalfVector { s, t };
    let peak = target.peak();
    let mut before: Option<f64> = None;
    for place in target.growing() {
        let footprint = &place.patch.footprint;
        let model = target
            .subject
            .model(target.variant, &place.patch, target.alpha())
            .ndf(h);
        let here = || at("grow from the size before", footprint, Some(h));
        let answer = recorder.ask(here, || target.answers.eval(footprint, h));
        let unexplained = answer.map(|answer| answer - model);
        if let (Some(before), Some(now)) = (before, unexplained) {
            let allowed = 2.0 * bound.allowed(model, peak) / peak;
            recorder.compare((now - before).abs() / peak, allowed, here);
        }
        before = unexplained;
    }
}
