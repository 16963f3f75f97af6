//! Errors fall as settings tighten, down to none at the last.

use super::maps::NamedMap;
use super::numbers::Numbers;
use super::outcome::{At, Outcome, Recorder};
use super::target::at;
use crate::measure::subject::{Against, Ladder, Patch, Subject, Variant};
use glintbake_bake::{Recipe, bake};
use glintbake_format::model::{Filter, Footprint, HalfVector};
use glintbake_runtime::{Ndf, Package};

/// Edges of the footprints, in texels.
const EDGES: [f64; 3] = [12.0, 30.0, 70.0];
/// Half vectors under each.
const HALF_VECTORS: usize = 24;

/// What errors are summed over.
struct Query<'m> {
    patch: Patch<'m>,
    half_vectors: Vec<HalfVector>,
}

/// The errors of every rung of `ladder` on `map`, against the rung before.
pub(super) fn check(
    subject: &dyn Subject,
    ladder: &Ladder,
    filter: Filter,
    map: &NamedMap,
    roughness: Option<f64>,
) -> Outcome {
    let reason = format!(
        "relative L1 error against the {} as {} tightens: no more than {} times the rung before, and {:e} at the last",
        match ladder.against {
            Against::Truth => "truth",
            Against::Model => "model",
        },
        ladder.name,
        ladder.slack,
        ladder.exact
    );
    let mut recorder = Recorder::new("convergence", reason);
    let queries = queries(map, filter, roughness);
    let mut expected = Vec::new();
    let mut before: Option<f64> = None;
    for (place, rung) in ladder.rungs.iter().enumerate() {
        let recipe = Recipe::new(vec![rung.recipe_for(roughness.unwrap_or_default())]);
        let here = || At {
            what: format!("{} {}", ladder.name, rung.name),
            ..At::default()
        };
        let bytes = match bake(&map.map, &recipe, None) {
            Ok(plan) => plan.to_bytes(),
            Err(error) => {
                recorder.fault(&here(), &error.to_string());
                return recorder.finish();
            }
        };
        let answers = recorder.call(here, || rung.ask(Package::open(&bytes)?.ndf(1)?, filter));
        let Some(answers) = answers else {
            return recorder.finish();
        };
        // Rungs that differ in nothing but how closely they are answered have one reference, which may take quadrature.
        if place == 0 || !rung.asks_the_same_as(&ladder.rungs[place - 1]) {
            expected = references(subject, rung, ladder.against, &queries, roughness);
        }
        let (mut difference, mut total) = (0.0, 0.0);
        for (query, expected) in queries.iter().zip(&expected) {
            let footprint = &query.patch.footprint;
            for (&h, expected) in query.half_vectors.iter().zip(expected) {
                let ask = || at(here().what, footprint, Some(h));
                let got = recorder.ask(ask, || answers.eval(footprint, h));
                difference += (got.unwrap_or_default() - expected).abs();
                total += expected;
            }
        }
        let error = difference / total;
        let what = || At {
            what: format!("{} {}: relative L1 error {error:e}", ladder.name, rung.name),
            ..At::default()
        };
        if let Some(before) = before {
            // Below what counts as none, rounding may go up and down.
            recorder.compare(error, (ladder.slack * before).max(ladder.exact), what);
        }
        if place + 1 == ladder.rungs.len() {
            recorder.compare(error, ladder.exact, what);
        }
        before = Some(error);
    }
    recorder.finish()
}

/// What `rung` is held to, for every query.
fn references(
    subject: &dyn Subject,
    rung: &Variant,
    against: Against,
    queries: &[Query<'_>],
    roughness: Option<f64>,
) -> Vec<Vec<f64>> {
    let alpha = roughness.unwrap_or_default();
    let of_query = |query: &Query<'_>| {
        let reference = match against {
            Against::Truth => subject.truth(rung, &query.patch, alpha),
            Against::Model => subject.model(rung, &query.patch, alpha),
        };
        let half_vectors = query.half_vectors.iter();
        half_vectors.map(|&h| reference.ndf(h)).collect()
    };
    queries.iter().map(of_query).collect()
}

/// Footprints and half vectors, the same for every rung.
fn queries<'m>(map: &'m NamedMap, filter: Filter, roughness: Option<f64>) -> Vec<Query<'m>> {
    let mut numbers = Numbers::of(&["convergence", &map.name]);
    let spread = roughness.unwrap_or(0.02);
    EDGES
        .iter()
        .map(|&edge| {
            let centre = [numbers.uniform(), numbers.uniform()];
            let footprint = Footprint::square(centre, edge, map.map.width(), map.map.height());
            let patch = Patch::new(&map.map, &footprint, filter);
            let half_vectors = (0..HALF_VECTORS)
                .map(|_| {
                    let [s, t] = patch.normal_by_weight(numbers.uniform());
                    HalfVector {
                        s: s + spread * numbers.between(-1.0, 1.0),
                        t: t + spread * numbers.between(-1.0, 1.0),
                    }
                })
                .collect();
            Query {
                patch,
                half_vectors,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::subject::REGISTRY;
    use crate::stress::{Verdict, maps};

    #[test]
    fn a_ladder_that_leads_away_from_the_truth_fails() {
        let maps = maps::built_in(true);
        let map = maps.last().expect("a map of waves");
        let mut ladders = 0;
        for &subject in REGISTRY {
            for mut ladder in subject.ladders(Filter::Gaussian) {
                let alpha = subject.is_rough().then_some(0.03);
                ladder.rungs.reverse();
                let outcome = check(subject, &ladder, Filter::Gaussian, map, alpha);
                assert_eq!(outcome.verdict, Verdict::Fail, "{outcome:?}");
                assert!(outcome.error > outcome.bound && outcome.faults.count() == 0);
                ladders += 1;
            }
        }
        assert!(ladders > 2, "only {ladders} ladders");
    }
}
