//! The stiff and extreme cases every method must pass or refuse, each against an f64 oracle: `glintbake stress`.
//!
//! Every method, setting and filter of [`REGISTRY`] goes through every check on every map; one file a check. What a
//! check is given is a [`Target`], what comes of it an [`Outcome`]. Maps, footprints and half vectors depend on fixed
//! seeds alone, so that a result does not depend on the number of threads, and a pass stays a pass.
//!
//! | check | tries | against |
//! |---|---|---|
//! | accuracy | `eval` and `pdf` | the method's own model |
//! | energy | the integral of `pdf` | the model's, and 1 |
//! | sampling | `sample` | the model's pdf, by χ² |
//! | reciprocity | the BRDF with light and view exchanged | itself |
//! | continuity | footprints that slide and grow | the change of their weights |
//! | precision | queries rounded to f32 | the model of the rounded query |
//! | convergence | settings from coarse to exact | the truth, or the model |
//! | refusals | what is no query, no normal, no option | an error that names the cause |

mod accuracy;
mod continuity;
mod convergence;
mod energy;
pub mod footprints;
mod half_vectors;
pub mod maps;
mod numbers;
mod outcome;
mod precision;
pub mod rebuild;
mod reciprocity;
mod refusals;
mod sampling;
pub mod table;
mod target;
mod window;

pub use outcome::{At, Faults, Outcome, Recorder, Verdict};
pub use target::{Place, Places, Target, places};

use crate::measure::subject::{REGISTRY, Subject, Variant, find};
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_format::model::Filter;
use glintbake_runtime::{Package, QueryError, SurfaceNdf};
use maps::NamedMap;
use rayon::prelude::*;
use std::panic::{self, AssertUnwindSafe};

/// How footprints weigh texels.
pub const FILTERS: [Filter; 2] = [Filter::Box, Filter::Gaussian];

/// Beckmann's α of rough methods, from the least they are baked for to the greatest; 0.3536 is σr = 0.25.
pub const ROUGHNESSES: [f64; 5] = [1e-4, 1e-3, 0.03, 0.353_553_390_593_273_8, 1.0];
/// Those of a quick run.
pub const QUICK_ROUGHNESSES: [f64; 2] = [1e-4, 0.353_553_390_593_273_8];
/// The roughness at which settings are tightened.
const LADDER_ROUGHNESS: f64 = 0.03;
/// The least side of a map on which they are, in texels.
const LADDER_SIDE: u32 = 64;

/// A check of one setting of a method on one map.
pub type Check = fn(&Target<'_>) -> Outcome;

/// Every check of a target, by name.
pub const CHECKS: &[(&str, Check)] = &[
    ("accuracy", accuracy::check),
    ("energy", energy::check),
    ("sampling", sampling::check),
    ("reciprocity", reciprocity::check),
    ("continuity", continuity::check),
    ("precision", precision::check),
    ("refusals", refusals::queries),
];

/// Every outcome of `check` on `target`; a panic of the check itself is one, too.
pub fn run_check(name: &'static str, check: Check, target: &Target<'_>) -> Outcome {
    let outcome = panic::catch_unwind(AssertUnwindSafe(|| check(target)));
    let mut outcome = outcome.unwrap_or_else(|_| {
        let mut recorder = Recorder::new(name, "a check must not panic");
        let what = "the check itself".to_owned();
        let at = At {
            what,
            ..At::default()
        };
        let _: Option<()> = recorder.call(|| at.clone(), || panic!("the check itself panicked"));
        recorder.finish()
    });
    target
        .subject
        .method()
        .name()
        .clone_into(&mut outcome.method);
    outcome.variant.clone_from(&target.variant.name);
    outcome.filter = Some(target.filter);
    outcome.map.clone_from(&target.map.name);
    outcome.roughness = target.roughness;
    outcome
}

/// Runs every check of every registered method on `maps`, which `tick` hears of piece by piece.
///
/// Takes memory for the weights of all footprints on all maps, and time in proportion to the number of maps.
pub fn methods_on(
    maps: &[NamedMap],
    roughnesses: &[f64],
    tick: &(dyn Fn(u64, u64) + Sync),
) -> Vec<Outcome> {
    let weighed = weigh(maps);
    let mut pieces = Vec::new();
    for &subject in REGISTRY {
        for (map, places) in maps.iter().zip(&weighed) {
            for roughness in roughnesses_of(subject, roughnesses) {
                pieces.push((subject, map, places, roughness));
            }
        }
    }
    let done = Done::new(pieces.len(), tick);
    let mut outcomes: Vec<Outcome> = pieces
        .par_iter()
        .flat_map_iter(|&(subject, map, places, roughness)| {
            let outcomes = on_map(subject, map, places, roughness);
            done.one();
            outcomes
        })
        .collect();
    outcomes.extend(beyond_targets(maps, roughnesses));
    outcomes
}

/// Runs every check of every instance of `package`, whose file is called `name`.
///
/// # Errors
/// If the package is damaged.
pub fn package(
    name: &str,
    package: &Package<'_>,
    tick: &(dyn Fn(u64, u64) + Sync),
) -> Result<Vec<Outcome>, QueryError> {
    let mut outcomes = Vec::new();
    let instances: Vec<_> = package.instances().collect();
    let total = instances.len() as u64;
    for (place, instance) in (0..).zip(&instances) {
        tick(place, total);
        let subject = find(instance.method);
        let map = NamedMap {
            name: name.to_owned(),
            map: rebuild::normal_map(package.container(), instance)?,
        };
        let places = FILTERS.map(|filter| places(&map, filter));
        let ndf = package.ndf(instance.number)?;
        let mut questions = Vec::new();
        for (filter, places) in FILTERS.into_iter().zip(&places) {
            for variant in subject.variants_of(instance, filter) {
                questions.push((filter, places, variant));
            }
        }
        outcomes.par_extend(
            questions
                .par_iter()
                .flat_map_iter(|(filter, places, variant)| {
                    answer(
                        subject,
                        variant,
                        *filter,
                        instance.roughness,
                        &map,
                        places,
                        Ok(ndf),
                    )
                }),
        );
        let mut recorder = Recorder::new(
            "convergence",
            "settings are compared on maps; give the map itself",
        );
        recorder
            .because("settings are compared by baking each; give the map instead of the package");
        let mut skipped = recorder.finish();
        instance.method.name().clone_into(&mut skipped.method);
        name.clone_into(&mut skipped.map);
        skipped.roughness = instance.roughness;
        outcomes.push(skipped);
    }
    Ok(outcomes)
}

/// The extreme footprints of all maps, by filter.
fn weigh(maps: &[NamedMap]) -> Vec<[Places<'_>; 2]> {
    maps.par_iter()
        .map(|map| FILTERS.map(|filter| places(map, filter)))
        .collect()
}

fn roughnesses_of(subject: &dyn Subject, roughnesses: &[f64]) -> Vec<Option<f64>> {
    if subject.is_rough() {
        roughnesses.iter().copied().map(Some).collect()
    } else {
        vec![None]
    }
}

/// Every check of every setting of `subject`, baked from `map`.
fn on_map(
    subject: &dyn Subject,
    map: &NamedMap,
    places: &[Places<'_>; 2],
    roughness: Option<f64>,
) -> Vec<Outcome> {
    let mut baked: Vec<(MethodRecipe, Result<Vec<u8>, String>)> = Vec::new();
    let mut outcomes = Vec::new();
    for (filter, places) in FILTERS.into_iter().zip(places) {
        for variant in subject.variants(filter) {
            let recipe = variant.recipe_for(roughness.unwrap_or_default());
            let known = baked.iter().position(|(other, _)| *other == recipe);
            let place = known.unwrap_or_else(|| {
                let plan = bake(&map.map, &Recipe::new(vec![recipe.clone()]), None);
                let bytes = plan
                    .map(|plan| plan.to_bytes())
                    .map_err(|error| error.to_string());
                baked.push((recipe, bytes));
                baked.len() - 1
            });
            let ndf = match &baked[place].1 {
                Ok(bytes) => Package::open(bytes)
                    .map_err(QueryError::from)
                    .and_then(|package| package.ndf(1))
                    .map_err(|error| error.to_string()),
                Err(error) => Err(error.clone()),
            };
            outcomes.extend(answer(
                subject, &variant, filter, roughness, map, places, ndf,
            ));
        }
    }
    outcomes
}

/// Every check of `ndf`, asked as `variant` asks.
fn answer(
    subject: &dyn Subject,
    variant: &Variant,
    filter: Filter,
    roughness: Option<f64>,
    map: &NamedMap,
    (places, left_out): &Places<'_>,
    ndf: Result<SurfaceNdf<'_>, String>,
) -> Vec<Outcome> {
    let skipped = |check, reason: String, what: &str| {
        let mut outcome = Recorder::new(check, reason).finish();
        subject.method().name().clone_into(&mut outcome.method);
        outcome.variant.clone_from(&variant.name);
        outcome.filter = Some(filter);
        outcome.map = format!("{}{what}", map.name);
        outcome.roughness = roughness;
        outcome
    };
    let answers =
        match ndf.and_then(|ndf| variant.ask(ndf, filter).map_err(|error| error.to_string())) {
            Ok(answers) => answers,
            Err(error) => return vec![skipped("accuracy", error, "")],
        };
    let target = Target {
        subject,
        variant,
        filter,
        roughness,
        map,
        places,
        answers: &answers,
    };
    let mut outcomes: Vec<_> = CHECKS
        .iter()
        .map(|&(name, check)| run_check(name, check, &target))
        .collect();
    if !left_out.is_empty() {
        let reason = format!(
            "too many texels for the oracle: footprints of {}",
            left_out.join(", ")
        );
        outcomes.push(skipped("accuracy", reason, ", large footprints"));
    }
    outcomes
}

/// What needs no target: ladders of settings, and what is refused before anything is baked.
fn beyond_targets(maps: &[NamedMap], roughnesses: &[f64]) -> Vec<Outcome> {
    let mut ladders = Vec::new();
    for &subject in REGISTRY {
        for filter in FILTERS {
            for ladder in subject.ladders(filter) {
                ladders.push((subject, filter, ladder));
            }
        }
    }
    let map = maps
        .iter()
        .find(|named| named.map.width().min(named.map.height()) >= LADDER_SIDE);
    let nearest = |wanted: f64| {
        let distance = |alpha: f64| libm::fabs(libm::log(alpha / wanted));
        roughnesses.iter().copied().reduce(|best, next| {
            if distance(next) < distance(best) {
                next
            } else {
                best
            }
        })
    };
    let mut outcomes: Vec<_> = ladders
        .par_iter()
        .map(|(subject, filter, ladder)| {
            let alpha = nearest(LADDER_ROUGHNESS).filter(|_| subject.is_rough());
            let mut outcome = match map {
                Some(map) => convergence::check(*subject, ladder, *filter, map, alpha),
                None => Recorder::new(
                    "convergence",
                    format!(
                        "settings are tightened on maps of at least {LADDER_SIDE} texels a side"
                    ),
                )
                .finish(),
            };
            subject.method().name().clone_into(&mut outcome.method);
            ladder.name.clone_into(&mut outcome.variant);
            outcome.filter = Some(*filter);
            outcome.roughness = alpha;
            if let Some(map) = map {
                outcome.map.clone_from(&map.name);
            }
            outcome
        })
        .collect();
    for &subject in REGISTRY {
        outcomes.push(refusals::options(subject));
        outcomes.push(refusals::memory(subject));
    }
    outcomes.push(refusals::texels());
    outcomes
}

/// Counts what is done.
struct Done<'t> {
    done: std::sync::atomic::AtomicU64,
    total: u64,
    tick: &'t (dyn Fn(u64, u64) + Sync),
}

impl<'t> Done<'t> {
    fn new(total: usize, tick: &'t (dyn Fn(u64, u64) + Sync)) -> Self {
        tick(0, total as u64);
        Self {
            done: 0.into(),
            total: total as u64,
            tick,
        }
    }

    fn one(&self) {
        let before = self.done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        (self.tick)(before + 1, self.total);
    }
}
