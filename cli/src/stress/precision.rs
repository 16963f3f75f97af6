//! f32 against f64: queries rounded to f32 move the answer by as much as they move the model, and no more.

use super::outcome::{Outcome, Recorder};
use super::target::{Target, at};
use super::{accuracy, half_vectors};
use glintbake_format::model::HalfVector;

const REASON: &str = "a query rounded to f32 is another query: the answer moves as far as the model does, by the query's own \
                      conditioning, and no further";

/// Asks with footprint and half vector rounded to f32.
pub(super) fn check(target: &Target<'_>) -> Outcome {
    let mut recorder = Recorder::new("precision", REASON);
    let mut numbers = target.numbers("precision");
    let bound = target.bound();
    let peak = target.peak();
    for place in target.rounded() {
        let footprint = &place.patch.footprint;
        let model = target
            .subject
            .model(target.variant, &place.patch, target.alpha());
        for h in half_vectors::extreme(&place.patch, &*model, target.width(), &mut numbers) {
            let h = HalfVector {
                s: f64::from(h.s as f32),
                t: f64::from(h.t as f32),
            };
            let here = || at(format!("eval in f32, {}", place.name), footprint, Some(h));
            if let Some(got) = recorder.ask(here, || target.answers.eval(footprint, h)) {
                let error = accuracy::error(&bound, got, peak, |h| model.ndf(h), h);
                recorder.compare(error, bound.relative, here);
            }
        }
    }
    recorder.finish()
}
