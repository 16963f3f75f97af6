//! The stiff and extreme cases every method must pass or refuse, each against an f64 oracle: `glintbake stress`.
//!
//! Every method, setting and filter of [`REGISTRY`](crate::measure::subject::REGISTRY) goes through every check on every map; one file a check. What a
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
//! | reciprocity, energy, sampling, continuity of a layered material | its BRDF, sampler and opacity maps | themselves |
//! | refusals | what is no query, no normal, no option | an error that names the cause |

mod accuracy;
mod continuity;
mod convergence;
mod energy;
mod engine;
mod footprints;
mod half_vectors;
pub mod maps;
mod materials;
mod numbers;
mod outcome;
mod precision;
mod reciprocity;
mod refusals;
mod sampling;
pub mod table;
mod target;
mod window;

pub use engine::{held, on_maps, on_package};
pub use outcome::{At, Faults, Outcome, Recorder, Verdict};
pub use target::{Ground, Place, Target};

use glintbake_format::model::Filter;
use std::panic::{self, AssertUnwindSafe};

/// How footprints weigh texels.
pub const FILTERS: [Filter; 2] = [Filter::Box, Filter::Gaussian];

/// Beckmann's α of rough methods, from the least they are baked for to the greatest; 0.3536 is σr = 0.25.
pub const ROUGHNESSES: [f64; 5] = [1e-4, 1e-3, 0.03, 0.353_553_390_593_273_8, 1.0];
/// Those of a quick run.
pub const QUICK_ROUGHNESSES: [f64; 2] = [1e-4, 0.353_553_390_593_273_8];

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

/// What comes of `check`, called `name`, on `target`; a panic of the check itself is a failure of it.
pub fn run_check(name: &'static str, check: Check, target: &Target<'_>) -> Outcome {
    let outcome = panic::catch_unwind(AssertUnwindSafe(|| check(target)));
    let outcome = outcome.unwrap_or_else(|_| Outcome::failed(name, "the check itself panicked"));
    let mut outcome = outcome.of(target.subject, target.roughness);
    outcome.variant.clone_from(&target.variant.name);
    outcome.filter = Some(target.ground.filter);
    outcome.map.clone_from(&target.ground.map.name);
    outcome
}
