//! `glintbake stress`: no method fails on the built-in maps, and whoever answers wrongly does.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::{Recipe, bake};
use glintbake_cli::measure::subject::{Patch, REGISTRY, Reference, Subject, Variant};
use glintbake_cli::stress::maps::{NamedMap, built_in};
use glintbake_cli::stress::{
    CHECKS, Ground, Outcome, QUICK_ROUGHNESSES, Target, Verdict, held, on_maps, run_check, table,
};
use glintbake_format::model::{Filter, Footprint, HalfVector, Method, Wrap};
use glintbake_runtime::microfacet::Masking;
use glintbake_runtime::{Facet, Instance, Ndf, Package, QueryError};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

#[test]
fn no_method_fails_on_the_built_in_maps() {
    let pieces = AtomicU64::new(0);
    let outcomes = on_maps(&built_in(true), &QUICK_ROUGHNESSES, &|done, total| {
        assert!(done <= total);
        pieces.fetch_add(1, Ordering::Relaxed);
    });
    assert!(pieces.into_inner() > 0, "progress is told");
    let remarks = table::remarks(&outcomes);
    let failed = remarks.iter().filter(|line| line.starts_with("FAIL"));
    assert_eq!(failed.count(), 0, "{remarks:#?}");
    for subject in REGISTRY {
        let method = subject.method().name();
        for (check, _) in CHECKS {
            for filter in [Filter::Box, Filter::Gaussian] {
                let tried = outcomes.iter().any(|outcome| {
                    outcome.method == method
                        && outcome.check == *check
                        && outcome.filter == Some(filter)
                        && outcome.verdict != Verdict::Skipped
                });
                // Who does not answer for such footprints has to say so.
                let is_due = !subject.variants(filter).is_empty() || *check == "refusals";
                assert_eq!(tried, is_due, "{check} of {method} under {}", filter.name());
            }
        }
    }
    let widest = table::lines(&outcomes)
        .iter()
        .map(|line| line.chars().count())
        .max();
    assert!(widest.is_some_and(|columns| columns <= 100), "{widest:?}");
}

/// How answers are falsified.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lie {
    None,
    NotANumber,
    Negative,
    Panic,
    Damage,
    /// By four times what the method states.
    SlightlyOff,
    LostEnergy,
    MovedSamples,
    NeverNothing,
    Jump,
    PopAsItGrows,
    SinglePrecision,
    Inexchangeable,
    AnswersNonsense,
}

/// What answers, but for a lie.
struct Liar<'a> {
    honest: &'a (dyn Ndf + Sync),
    lie: Lie,
    /// Slightly, as a share.
    slightly: f64,
    /// More than any footprint's answer may be off, however low its density.
    pop: f64,
    odd: AtomicBool,
}

impl Liar<'_> {
    fn falsify(
        &self,
        footprint: &Footprint,
        h: HalfVector,
        honest: f64,
    ) -> Result<f64, QueryError> {
        let is_single = |x: f64| f64::from(x as f32) == x;
        Ok(match self.lie {
            Lie::NotANumber => f64::NAN,
            Lie::Negative => -honest - 1e-300,
            Lie::Panic => panic!("a lie"),
            Lie::Damage => return Err(QueryError::NoSuchInstance(7)),
            Lie::SlightlyOff => honest * (1.0 + self.slightly),
            Lie::Jump if footprint.centre[0] >= 1.0 => honest * 1.1,
            Lie::PopAsItGrows if footprint.edge_1[0] > 0.5 => honest * 1.1 + self.pop,
            Lie::SinglePrecision if is_single(h.s) && is_single(h.t) => {
                honest * (1.0 + self.slightly)
            }
            _ => honest,
        })
    }
}

impl Ndf for Liar<'_> {
    fn instance(&self) -> &Instance {
        self.honest.instance()
    }

    fn masking(&self) -> Masking<'_> {
        self.honest.masking()
    }

    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        let odd = self.lie == Lie::Inexchangeable && self.odd.fetch_xor(true, Ordering::Relaxed);
        self.honest.facets(footprint, half_vector, &mut |facet| {
            visit(Facet {
                weight: if odd { 0.999 } else { 1.0 } * facet.weight,
                ..facet
            });
        })
    }

    fn eval(&self, footprint: &Footprint, h: HalfVector) -> Result<f64, QueryError> {
        match self.honest.eval(footprint, h) {
            Err(_) if self.lie == Lie::AnswersNonsense => Ok(0.0),
            honest => self.falsify(footprint, h, honest?),
        }
    }

    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        let drawn = self.honest.sample(footprint, uniform)?;
        Ok(match self.lie {
            Lie::MovedSamples => drawn.map(|h| HalfVector { s: 0.97 * h.s, ..h }),
            Lie::NeverNothing => drawn.or(self.honest.sample(footprint, [0.1; 4])?),
            _ => drawn,
        })
    }

    fn pdf(&self, footprint: &Footprint, h: HalfVector) -> Result<f64, QueryError> {
        let honest = self.honest.pdf(footprint, h)?;
        match self.lie {
            Lie::LostEnergy => Ok(0.99 * honest),
            _ => self.falsify(footprint, h, honest),
        }
    }
}

fn map(name: &str) -> NamedMap {
    let mut maps = built_in(true).into_iter();
    maps.find(|map| map.name.starts_with(name)).expect(name)
}

/// A filter that `subject` answers for.
fn filter_of(subject: &dyn Subject) -> Filter {
    if subject.variants(Filter::Box).is_empty() {
        Filter::Gaussian
    } else {
        Filter::Box
    }
}

/// The first variant of `subject`; of `mip-lobes` the last, as what clusters blur may be as much as a lie.
fn variant_of(subject: &dyn Subject) -> Variant {
    let mut variants = subject.variants(filter_of(subject));
    let place = match subject.method() {
        Method::MipLobes => variants.len() - 1,
        _ => 0,
    };
    variants.swap_remove(place)
}

/// Texels along a side of what `ndf-maps` is tried on.
const EXAMPLE: usize = 8;

/// The built-in map called `name`, as one that repeats for methods that need it.
fn map_for(subject: &dyn Subject, name: &str) -> NamedMap {
    let named = map(name);
    if subject.method() == Method::NdfMaps {
        // A square of a power of two.
        let width = named.map.width() as usize;
        let texels = (0..EXAMPLE * EXAMPLE)
            .map(|place| {
                named.map.texels()[place / EXAMPLE % named.map.height() as usize * width
                    + place % EXAMPLE % width]
            })
            .collect();
        let map = NormalMap::new(EXAMPLE as u32, EXAMPLE as u32, Wrap::Repeat, texels);
        return NamedMap { map, ..named };
    }
    if subject.method() != Method::MipLobes {
        return named;
    }
    let texels = named.map.texels().to_vec();
    let map = NormalMap::new(named.map.width(), named.map.height(), Wrap::Repeat, texels);
    NamedMap { map, ..named }
}

/// What comes of every check of `subject` baked from `map`, or of one alone, its answers falsified by `lie`.
fn outcomes_of(
    subject: &dyn Subject,
    map: &NamedMap,
    variant: &Variant,
    lie: Lie,
    only: Option<&str>,
) -> Vec<Outcome> {
    let alpha = 0.03;
    let filter = filter_of(subject);
    let ground = Ground::new(map, filter);
    let plan = bake(
        &map.map,
        &Recipe::new(vec![variant.recipe_for(alpha)]),
        None,
    );
    let bytes = plan.expect("variants can be baked").to_bytes();
    let package = Package::open(&bytes).unwrap();
    let ndf = package.ndf(1).unwrap();
    let held = held(subject, &ground, &package).unwrap();
    let ground = held
        .as_ref()
        .map_or_else(|| ground.clone(), |map| ground.with_map(map));
    let honest = variant.ask(ndf, filter).expect("variants can be asked");
    let bound = subject.bound(variant, filter, &ground.map.map, alpha);
    let liar = Liar {
        honest: &honest,
        lie,
        slightly: 4.0 * bound.relative,
        pop: 4.0 * bound.allowed(0.0, subject.peak(variant, alpha)),
        odd: AtomicBool::new(false),
    };
    let target = Target {
        subject,
        variant,
        roughness: subject.is_rough().then_some(alpha),
        ground: &ground,
        answers: &liar,
    };
    CHECKS
        .iter()
        .filter(|(name, _)| only.is_none_or(|only| only == *name))
        .map(|&(name, check)| run_check(name, check, &target))
        .collect()
}

fn failed(outcomes: &[Outcome]) -> Vec<&'static str> {
    let failed = outcomes
        .iter()
        .filter(|outcome| outcome.verdict == Verdict::Fail);
    failed.map(|outcome| outcome.check).collect()
}

#[test]
fn every_lie_is_found_by_the_check_made_for_it() {
    // Reports of the panics that are part of it would drown the test's own.
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if panic.payload().downcast_ref() != Some(&"a lie") {
            report(panic);
        }
    }));
    for &subject in REGISTRY {
        for (lie, check, name) in [
            (Lie::NotANumber, "accuracy", "noise"),
            (Lie::Negative, "accuracy", "noise"),
            (Lie::Panic, "accuracy", "noise"),
            (Lie::Damage, "precision", "noise"),
            (Lie::SlightlyOff, "accuracy", "noise"),
            (Lie::LostEnergy, "energy", "noise"),
            (Lie::MovedSamples, "sampling", "noise"),
            (Lie::Jump, "continuity", "noise"),
            (Lie::PopAsItGrows, "continuity", "waves"),
            (Lie::SinglePrecision, "precision", "noise"),
            (Lie::Inexchangeable, "reciprocity", "noise"),
            (Lie::AnswersNonsense, "refusals", "noise"),
        ] {
            if lie == Lie::PopAsItGrows
                && matches!(subject.method(), Method::Analytic | Method::NdfMaps)
            {
                // Half a tile of these waves is left out: quadrature would take too long.
                continue;
            }
            if lie == Lie::Jump && subject.method() == Method::NdfMaps {
                // Where tiles begin to be divided an honest answer jumps by as much.
                continue;
            }
            let name = match (lie, subject.method()) {
                // Lobes between texels of noise are as steep as it, and what jumps is small beside a peak.
                (Lie::Jump, Method::MipLobes) => "waves",
                _ => name,
            };
            let variant = &variant_of(subject);
            let outcomes = outcomes_of(subject, &map_for(subject, name), variant, lie, Some(check));
            let what = format!("{} {lie:?}: {outcomes:#?}", subject.method().name());
            assert!(failed(&outcomes).contains(&check), "{what}");
            let of_check = outcomes.iter().find(|outcome| outcome.check == check);
            let faults = of_check.expect("every check has an outcome").faults;
            let counted = match lie {
                Lie::NotANumber => faults.not_finite,
                Lie::Negative => faults.negative,
                Lie::Panic => faults.panics,
                Lie::Damage | Lie::AnswersNonsense => faults.errors,
                // Moved out of its bin, what is drawn has no density at all.
                Lie::MovedSamples => 1,
                _ => u64::from(faults.count() == 0),
            };
            assert!(counted > 0, "{what}");
        }
    }
}

#[test]
fn who_does_not_lie_is_not_found() {
    for &subject in REGISTRY {
        let variant = &variant_of(subject);
        let outcomes = outcomes_of(
            subject,
            &map_for(subject, "noise"),
            variant,
            Lie::None,
            None,
        );
        assert_eq!(failed(&outcomes), [""; 0], "{outcomes:#?}");
    }
}

#[test]
fn a_sampler_that_hides_what_a_setting_loses_is_found() {
    let lossy = REGISTRY.iter().flat_map(|&subject| {
        let variants = subject.variants(Filter::Box).into_iter();
        variants.map(move |variant| (subject, variant))
    });
    let mut seen = 0;
    // Kernels on the disk lose what crosses its rim, which is no lie.
    let is_lossy = |(subject, variant): &(&dyn Subject, Variant)| {
        variant.is_paper && subject.loss(variant).is_some()
    };
    for (subject, variant) in lossy.filter(is_lossy) {
        let outcomes = outcomes_of(subject, &map("noise"), &variant, Lie::NeverNothing, None);
        assert!(failed(&outcomes).contains(&"sampling"), "{outcomes:#?}");
        seen += 1;
    }
    assert!(seen > 0, "no setting of a paper is lossy");
}

/// A method whose model is a bit greater than its answers.
struct Misjudged(&'static dyn Subject);

struct Greater(Box<dyn Reference>);

impl Reference for Greater {
    fn ndf(&self, h: HalfVector) -> f64 {
        1.0001 * self.0.ndf(h)
    }

    fn pdf(&self, h: HalfVector) -> f64 {
        1.0001 * self.0.pdf(h)
    }

    fn draw(&self, patch: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        self.0.draw(patch, uniform)
    }
}

impl Subject for Misjudged {
    fn method(&self) -> Method {
        self.0.method()
    }

    fn is_rough(&self) -> bool {
        self.0.is_rough()
    }

    fn variants(&self, filter: Filter) -> Vec<Variant> {
        self.0.variants(filter)
    }

    fn is_truth(&self, variant: &Variant) -> bool {
        self.0.is_truth(variant)
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        Box::new(Greater(self.0.model(variant, patch, roughness)))
    }

    fn truth(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        self.0.truth(variant, patch, roughness)
    }
}

#[test]
fn answers_are_held_against_the_model_of_the_method() {
    let subject = REGISTRY[0];
    let variant = &subject.variants(Filter::Box)[0];
    let outcomes = outcomes_of(&Misjudged(subject), &map("noise"), variant, Lie::None, None);
    let failed = failed(&outcomes);
    assert!(
        failed.contains(&"accuracy") && failed.contains(&"energy"),
        "{outcomes:#?}"
    );
}
