//! Every method, setting and filter through every check, in parallel and in a fixed order.

use super::maps::NamedMap;
use super::outcome::Outcome;
use super::target::{Ground, Target};
use super::{CHECKS, FILTERS, convergence, materials, refusals, run_check};
use crate::measure::subject::{REGISTRY, Subject, Variant, find};
use crate::rebuild;
use glintbake_bake::{BakeError, MethodRecipe, Recipe, bake};
use glintbake_runtime::{Instance, Material, Package, QueryError, SurfaceNdf};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// The roughness at which settings are tightened.
const LADDER_ROUGHNESS: f64 = 0.03;

/// Hears how many pieces are done, of how many.
pub type Tick<'t> = &'t (dyn Fn(u64, u64) + Sync);

/// Runs every check of every registered method on `maps`, which are baked in memory; rough methods for each of
/// `roughnesses`.
///
/// Takes memory for the weights of all footprints on all maps, and time in proportion to the number of maps.
pub fn on_maps(maps: &[NamedMap], roughnesses: &[f64], tick: Tick<'_>) -> Vec<Outcome> {
    let grounds: Vec<_> = maps
        .par_iter()
        .flat_map_iter(|map| FILTERS.map(|filter| Ground::new(map, filter)))
        .collect();
    let mut pieces = Vec::new();
    for &subject in REGISTRY {
        let of_subject: Vec<_> = if subject.is_rough() {
            roughnesses.iter().copied().map(Some).collect()
        } else {
            vec![None]
        };
        for ground in &grounds {
            pieces.extend(of_subject.iter().map(|&alpha| (subject, ground, alpha)));
        }
    }
    let (done, total) = (AtomicU64::new(0), pieces.len() as u64);
    let mut outcomes: Vec<Outcome> = pieces
        .par_iter()
        .flat_map_iter(|&(subject, ground, roughness)| {
            let outcomes = on_ground(subject, ground, roughness);
            tick(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            outcomes
        })
        .collect();
    outcomes.extend(ladders(maps, roughnesses));
    for &subject in REGISTRY {
        outcomes.push(refusals::options(subject));
        outcomes.push(refusals::memory(subject));
    }
    outcomes.push(refusals::texels());
    outcomes
}

/// Runs every check of every instance of `package`, whose file is called `name`, on the map that it holds: see
/// [`rebuild::normal_map`].
///
/// # Errors
/// If the package is damaged.
pub fn on_package(
    name: &str,
    package: &Package<'_>,
    tick: Tick<'_>,
) -> Result<Vec<Outcome>, QueryError> {
    let mut outcomes = Vec::new();
    let instances: Vec<_> = package.instances().collect();
    for (place, instance) in (0..).zip(&instances) {
        tick(place, instances.len() as u64);
        outcomes.extend(on_instance(name, package, instance)?);
    }
    match Material::open(package.container()) {
        Ok(material) => outcomes.extend(materials::check(name, &material)),
        Err(QueryError::NotBaked { .. }) => {}
        Err(error) => return Err(error),
    }
    Ok(outcomes)
}

fn on_instance(
    name: &str,
    package: &Package<'_>,
    instance: &Instance,
) -> Result<Vec<Outcome>, QueryError> {
    let subject = find(instance.method);
    let skip = |check, reason| {
        let mut outcome = Outcome::skipped(check, reason).of(subject, instance.roughness);
        name.clone_into(&mut outcome.map);
        outcome
    };
    let Some(map) = rebuild::normal_map(package.container(), instance)? else {
        let reason = "the package holds no texel's normal to hold answers to; give the map instead of the package";
        let checks = CHECKS.iter().map(|&(check, _)| skip(check, reason));
        return Ok(checks.collect());
    };
    let map = NamedMap {
        name: name.to_owned(),
        map,
    };
    let ndf = package.ndf(instance.number)?;
    let grounds = FILTERS.map(|filter| Ground::new(&map, filter));
    let mut questions = Vec::new();
    let mut outcomes = Vec::new();
    for ground in &grounds {
        let variants = subject.variants_of(instance, ground.filter);
        if variants.is_empty() {
            outcomes.push(unanswered(subject, instance.roughness, ground, ndf));
        }
        questions.extend(variants.into_iter().map(|variant| (ground, variant)));
    }
    outcomes.par_extend(questions.par_iter().flat_map_iter(|(ground, variant)| {
        answer(subject, variant, instance.roughness, ground, ndf)
    }));
    let reason = "each setting is baked for it; give the map instead of the package";
    outcomes.push(skip("convergence", reason));
    Ok(outcomes)
}

/// Every check of every setting of `subject`, baked from the map of `ground`; of one that does not answer for its footprints, that
/// it says so.
fn on_ground(subject: &dyn Subject, ground: &Ground<'_>, roughness: Option<f64>) -> Vec<Outcome> {
    let mut baked: Vec<(MethodRecipe, Result<Vec<u8>, BakeError>)> = Vec::new();
    let mut outcomes = Vec::new();
    let variants = subject.variants(ground.filter);
    if variants.is_empty() {
        let roughnesses: Vec<_> = roughness.into_iter().collect();
        let recipe = MethodRecipe::new(subject.method(), &roughnesses);
        let outcome = match bake(&ground.map.map, &Recipe::new(vec![recipe]), None) {
            Ok(plan) => {
                let bytes = plan.to_bytes();
                let ndf = Package::open(&bytes)
                    .map_err(QueryError::from)
                    .and_then(|package| package.ndf(1));
                match ndf {
                    Ok(ndf) => unanswered(subject, roughness, ground, ndf),
                    Err(error) => Outcome::failed("refusals", error.to_string()),
                }
            }
            // Such as a map that does not repeat.
            Err(error @ BakeError::Option { .. }) => Outcome {
                filter: Some(ground.filter),
                map: ground.map.name.clone(),
                ..Outcome::refused("refusals", error.to_string()).of(subject, roughness)
            },
            Err(error) => Outcome::failed("refusals", error.to_string()),
        };
        outcomes.push(outcome);
    }
    for variant in variants {
        let recipe = variant.recipe_for(roughness.unwrap_or_default());
        let known = baked.iter().position(|(other, _)| *other == recipe);
        let place = known.unwrap_or_else(|| {
            let plan = bake(&ground.map.map, &Recipe::new(vec![recipe.clone()]), None);
            baked.push((recipe, plan.map(|plan| plan.to_bytes())));
            baked.len() - 1
        });
        let answers = match &baked[place].1 {
            Ok(bytes) => Package::open(bytes)
                .map_err(QueryError::from)
                .and_then(|package| Ok((package.ndf(1)?, held(subject, ground, &package)?)))
                .map_err(|error| Outcome::failed("accuracy", error.to_string())),
            // Such as a level that a map this small does not have.
            Err(error @ BakeError::Option { .. }) => {
                Err(Outcome::refused("refusals", error.to_string()))
            }
            Err(error) => Err(Outcome::failed("accuracy", error.to_string())),
        };
        match answers {
            Ok((ndf, held)) => {
                let held = held.as_ref().map(|map| ground.with_map(map));
                let ground = held.as_ref().unwrap_or(ground);
                outcomes.extend(answer(subject, &variant, roughness, ground, ndf));
            }
            Err(outcome) => outcomes.push(named(outcome, subject, &variant, roughness, ground)),
        }
    }
    outcomes
}

/// That `ndf` says of footprints as those of `ground` that it does not answer for them.
fn unanswered(
    subject: &dyn Subject,
    roughness: Option<f64>,
    ground: &Ground<'_>,
    ndf: SurfaceNdf<'_>,
) -> Outcome {
    Outcome {
        filter: Some(ground.filter),
        map: ground.map.name.clone(),
        ..refusals::filter(&ndf.with_filter(ground.filter), ground).of(subject, roughness)
    }
}

/// The map that answers of `package`, which holds one instance of the map of `ground`, are held to in its place, if
/// [`subject` rounds normals](Subject::rounds_normals).
///
/// # Errors
/// If the package is damaged.
pub fn held(
    subject: &dyn Subject,
    ground: &Ground<'_>,
    package: &Package<'_>,
) -> Result<Option<NamedMap>, QueryError> {
    let Some(instance) = package.instances().next() else {
        return Ok(None);
    };
    if !subject.rounds_normals() {
        return Ok(None);
    }
    let map = rebuild::normal_map(package.container(), &instance)?;
    Ok(map.map(|map| NamedMap {
        name: ground.map.name.clone(),
        map,
    }))
}

/// Every check of `ndf`, asked as `variant` asks.
fn answer(
    subject: &dyn Subject,
    variant: &Variant,
    roughness: Option<f64>,
    ground: &Ground<'_>,
    ndf: SurfaceNdf<'_>,
) -> Vec<Outcome> {
    let answers = match variant.ask(ndf, ground.filter) {
        Ok(answers) => answers,
        Err(error) => {
            let outcome = match error {
                QueryError::NotBaked { .. } => Outcome::skipped("accuracy", error.to_string()),
                _ => Outcome::failed("accuracy", error.to_string()),
            };
            return vec![named(outcome, subject, variant, roughness, ground)];
        }
    };
    let target = Target {
        subject,
        variant,
        roughness,
        ground,
        answers: &answers,
    };
    let mut outcomes: Vec<_> = CHECKS
        .iter()
        .map(|&(name, check)| run_check(name, check, &target))
        .collect();
    let left_out = [ground.left_out.clone(), target.left_out()].concat();
    if !left_out.is_empty() {
        let reason = format!(
            "too many texels for the oracle: footprints of {}",
            left_out.join(", ")
        );
        let skipped = Outcome::skipped("accuracy", reason);
        let mut skipped = named(skipped, subject, variant, roughness, ground);
        skipped.map += ", large footprints";
        outcomes.push(skipped);
    }
    outcomes
}

fn named(
    outcome: Outcome,
    subject: &dyn Subject,
    variant: &Variant,
    roughness: Option<f64>,
    ground: &Ground<'_>,
) -> Outcome {
    Outcome {
        variant: variant.name.clone(),
        filter: Some(ground.filter),
        map: ground.map.name.clone(),
        ..outcome.of(subject, roughness)
    }
}

/// The ladders of settings of every method, on the first map that suits it.
fn ladders(maps: &[NamedMap], roughnesses: &[f64]) -> Vec<Outcome> {
    let mut ladders = Vec::new();
    for &subject in REGISTRY {
        for filter in FILTERS {
            let of_filter = subject.ladders(filter).into_iter();
            ladders.extend(of_filter.map(|ladder| (subject, filter, ladder)));
        }
    }
    let distance = |alpha: f64| libm::fabs(libm::log(alpha / LADDER_ROUGHNESS));
    let alphas = roughnesses.iter().copied();
    let nearest = alphas.min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    ladders
        .par_iter()
        .map(|(subject, filter, ladder)| {
            let alpha = nearest.filter(|_| subject.is_rough());
            let suits = |named: &&NamedMap| subject.suits_ladders(&named.map);
            let outcome = match maps.iter().find(suits) {
                Some(map) => Outcome {
                    map: map.name.clone(),
                    ..convergence::check(*subject, ladder, *filter, map, alpha)
                },
                None => Outcome::skipped(
                    "convergence",
                    "settings are compared on maps of 64 texels a side or more, of ndf-maps on examples of 16 or 32",
                ),
            };
            Outcome {
                variant: ladder.name.to_owned(),
                filter: Some(*filter),
                ..outcome.of(*subject, alpha)
            }
        })
        .collect()
}
