//! Densities and pdfs against the method's own model in f64.

use super::half_vectors;
use super::outcome::{Outcome, Recorder};
use super::target::{Target, at};
use crate::measure::subject::Bound;
use glintbake_format::model::HalfVector;

/// What rounding a coordinate to f64 may move, four times over: two derivations of a bin may differ by it.
const ULPS: f64 = 4.0 * f64::EPSILON;

/// Asks every half vector under every footprint.
pub(super) fn check(target: &Target<'_>) -> Outcome {
    let bound = target.bound();
    let mut recorder = Recorder::new("accuracy", bound.reason.clone());
    let mut numbers = target.numbers("accuracy");
    let peak = target.peak();
    for place in target.places() {
        let footprint = &place.patch.footprint;
        let model = target
            .subject
            .model(target.variant, &place.patch, target.alpha());
        let half_vectors =
            half_vectors::extreme(&place.patch, &*model, target.width(), &mut numbers);
        for h in half_vectors {
            let ndf = recorder.ask(
                || at(format!("eval, {}", place.name), footprint, Some(h)),
                || target.answers.eval(footprint, h),
            );
            if let Some(got) = ndf {
                let error = error(&bound, got, peak, |h| model.ndf(h), h);
                recorder.compare(error, bound.relative, || {
                    at(format!("eval, {}", place.name), footprint, Some(h))
                });
            }
            let pdf = recorder.ask(
                || at(format!("pdf, {}", place.name), footprint, Some(h)),
                || target.answers.pdf(footprint, h),
            );
            if let Some(got) = pdf {
                let error = error(&bound, got, peak, |h| model.pdf(h), h);
                recorder.compare(error, bound.relative, || {
                    at(format!("pdf, {}", place.name), footprint, Some(h))
                });
            }
        }
    }
    recorder.finish()
}

/// How far `got` is from what `expected` says of half vectors within rounding of `h`.
pub(super) fn error(
    bound: &Bound,
    got: f64,
    peak: f64,
    expected: impl Fn(HalfVector) -> f64,
    h: HalfVector,
) -> f64 {
    let mut least = bound.error(got, expected(h), peak);
    if least <= bound.relative {
        return least;
    }
    for (s, t) in [
        (1.0, 0.0),
        (-1.0, 0.0),
        (0.0, 1.0),
        (0.0, -1.0),
        (1.0, 1.0),
        (-1.0, -1.0),
    ] {
        let moved = HalfVector {
            s: h.s + s * ULPS,
            t: h.t + t * ULPS,
        };
        least = least.min(bound.error(got, expected(moved), peak));
    }
    least
}
