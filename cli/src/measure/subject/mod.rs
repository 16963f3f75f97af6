//! What can be measured: each method with its variants, its own model and the truth of its kernel.
//!
//! A method joins reports and stress checks by one file here and one row of [`REGISTRY`].

mod analytic;
mod chart;
mod cluster_tree;
mod draw;
mod flake_bins;
mod interpolated;
mod lean;
mod limits;
mod lobes;
mod mip_lobes;
mod ndf_maps;
mod specular_bins;

pub use chart::Chart;
pub(super) use draw::standard_normal;
pub use limits::{Against, Bound, Ladder};

use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::{TexelWeight, texel_weights};
use glintbake_format::model::{Filter, Footprint, HalfVector, Interpolation, Kernel, Method};
use glintbake_runtime::{
    Accuracy, Instance, NdfMaps, QueryError, Setting, SurfaceNdf, TriangleForm,
};
use std::f64::consts::PI;

/// Every method, in the order of its code.
pub const REGISTRY: &[&dyn Subject] = &[
    &flake_bins::FlakeBins,
    &specular_bins::SpecularBins,
    &lean::Lean,
    &cluster_tree::ClusterTree,
    &lobes::Lobes,
    &analytic::Analytic,
    &mip_lobes::MipLobes,
    &ndf_maps::NdfMaps,
];

/// The subject of `method`.
///
/// # Panics
/// If a method of the format is not in the registry, which a test rules out.
pub fn find(method: Method) -> &'static dyn Subject {
    REGISTRY
        .iter()
        .copied()
        .find(|subject| subject.method() == method)
        .expect("every method of the format is in the registry")
}

/// A method as reports and stress checks see it.
pub trait Subject: Sync {
    /// The method this is.
    fn method(&self) -> Method;

    /// Whether the method is baked for roughnesses.
    fn is_rough(&self) -> bool;

    /// The settings worth comparing, the default first, for footprints weighed by `filter`; none if the method does not answer
    /// for such footprints.
    fn variants(&self, filter: Filter) -> Vec<Variant>;

    /// Whether the model of `variant` is the truth itself.
    fn is_truth(&self, variant: &Variant) -> bool;

    /// What the method would answer under `patch` if it did its own sum without any error: its model, in f64.
    ///
    /// `roughness` is Beckmann's α; methods that are not rough ignore it.
    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference>;

    /// What the truth of `variant` takes the map for: answers compare within one surface, as within one kernel.
    fn surface(&self, variant: &Variant) -> Interpolation {
        let _ = variant;
        Interpolation::None
    }

    /// The common truth of the method's kernel and [`surface`](Self::surface) under `patch`: of texels, every one with its own
    /// normal.
    fn truth(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference>;

    /// Seconds that the model or the truth of `variant` takes for a half vector, about, under a footprint on `map` for which it
    /// [visits](super::visited::texels_visited) so many `texels`; 0 if all it does is a sum over texels.
    fn seconds(
        &self,
        variant: &Variant,
        map: &NormalMap,
        texels: f64,
        roughness: f64,
        of: Against,
    ) -> f64 {
        let _ = (variant, map, texels, roughness, of);
        0.0
    }

    /// The settings of [`variants`](Self::variants) that `instance`, which is baked already, can be asked for.
    fn variants_of(&self, instance: &Instance, filter: Filter) -> Vec<Variant> {
        let _ = instance;
        one_of_each_question(self.variants(filter))
    }

    /// Whether packages round normals by so much that narrow lobes move: answers are then held to the sum over what the
    /// package holds of them.
    fn rounds_normals(&self) -> bool {
        false
    }

    /// The greatest density that a normal of the method's kernel gives a half vector, about.
    fn peak(&self, variant: &Variant, roughness: f64) -> f64 {
        let _ = variant;
        // Beckmann's 1 / cos⁴ makes up for its exponential up to a tangent of 1, for α near 1.
        1.5 / (PI * roughness * roughness)
    }

    /// How far answers under `filter` may be from the model, for normals of `map`.
    fn bound(&self, variant: &Variant, filter: Filter, map: &NormalMap, roughness: f64) -> Bound {
        let _ = (map, roughness);
        bound_of_weights(filter, variant.tolerance)
    }

    /// How much less the model's pdf may integrate to than 1 where no texel's lobe crosses the horizon; `None` if the model
    /// has wider lobes than texels, which cross it all the same: what they lose is the probability of no vector.
    fn loss(&self, variant: &Variant) -> Option<f64> {
        Some(if variant.is_paper {
            LOST_BY_PAPER
        } else {
            LOST
        })
    }

    /// Whether samples of `variant` are drawn by the model though answers are rougher: they are then held to it, whatever time
    /// that takes.
    fn draws_by_model(&self, variant: &Variant) -> bool {
        let _ = variant;
        false
    }

    /// Coordinates in which the lobe or bin of the normal `centre` is a few units wide.
    fn chart(&self, variant: &Variant, centre: HalfVector, roughness: f64) -> Chart {
        let _ = variant;
        Chart::slopes(centre, roughness)
    }

    /// Settings in order of their error, under footprints weighed by `filter`; by default the tolerance of Gaussians.
    fn ladders(&self, filter: Filter) -> Vec<Ladder> {
        match filter {
            Filter::Box => Vec::new(),
            Filter::Gaussian => vec![tolerance_ladder(self.variants(filter))],
        }
    }

    /// Whether errors on `map` are large enough to fall as settings tighten: most small maps have none.
    fn suits_ladders(&self, map: &NormalMap) -> bool {
        map.width().min(map.height()) >= 64
    }
}

/// The greatest density of a Gaussian of α / √2 on the disk.
fn disk_peak(roughness: f64) -> f64 {
    1.0 / (PI * roughness * roughness)
}

/// Why a method without [variants](Subject::variants) for `filter` is not asked.
pub fn unanswered(method: Method, filter: Filter) -> String {
    format!(
        "{} does not answer for {} footprints",
        method.name(),
        filter.name()
    )
}

/// The name of what a truth takes the map for, as [`Subject::surface`] says: of texels that are flat, `texels`.
pub const fn surface_name(surface: Interpolation) -> &'static str {
    match surface {
        Interpolation::None => "texels",
        Interpolation::Linear | Interpolation::CatmullRom => surface.name(),
    }
}

/// Energy that a model may lose: what 45 bins lose below α = 0.2 is a tenth of it.
const LOST: f64 = 1e-3;
/// What settings of a paper may lose, which are kept as printed: 21 bins lose 1 % of a needle, and 9.6 % at α = 1.
const LOST_BY_PAPER: f64 = 0.1;

/// `variants` without those that ask as one before does.
fn one_of_each_question(variants: Vec<Variant>) -> Vec<Variant> {
    let mut kept: Vec<Variant> = Vec::new();
    for variant in variants {
        let asks = |other: &Variant| (other.setting, other.tolerance);
        if kept.iter().all(|other| asks(other) != asks(&variant)) {
            kept.push(variant);
        }
    }
    kept
}

/// The bound of a method whose only errors are those of its weights.
fn bound_of_weights(filter: Filter, tolerance: Option<f64>) -> Bound {
    match (filter, tolerance) {
        (Filter::Box, _) => Bound {
            relative: 1e-5,
            floor: 1e-6,
            reason: "the model's own sum, in f64: rounding of weights and exponentials, and of half vectors by 4 ulp"
                .to_owned(),
        },
        (Filter::Gaussian, Some(0.0)) => Bound {
            relative: 1e-4,
            floor: 0.2,
            reason: "Gaussians end at 4.8 standard deviations, which leaves out 1e-5 of the weight".to_owned(),
        },
        (Filter::Gaussian, _) => Bound {
            relative: 6e-3,
            floor: 0.05,
            reason: "texels are weighed together within the tolerance: 0.6 % of the density on average, more at a \
                     single half vector"
                .to_owned(),
        },
    }
}

/// The tolerance of the first of `variants` tightened.
fn tolerance_ladder(variants: Vec<Variant>) -> Ladder {
    let rungs = [0.5, 0.125, 0.03, 0.0].map(|tolerance| Variant {
        name: format!("tolerance {tolerance}"),
        tolerance: Some(tolerance),
        ..variants[0].clone()
    });
    Ladder {
        name: "tolerance",
        rungs: rungs.into(),
        against: Against::Model,
        exact: 1e-4,
        slack: 1.25,
    }
}

/// A setting of a method: how it is baked, and how it is asked.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Its name among those of the method, such as `bins-45`.
    pub name: String,
    /// Whether this is what a paper prints, rather than what is recommended.
    pub is_paper: bool,
    /// How it is baked, without roughness.
    pub recipe: MethodRecipe,
    /// The setting of queries, if the method has any.
    pub setting: Option<Setting>,
    /// The tolerance of Gaussian footprints, the eps of `cluster-tree`, the reach of `analytic`, the level bias
    /// of `mip-lobes`, or the tolerance of `ndf-maps`, if it is not the default.
    pub tolerance: Option<f64>,
}

impl Variant {
    /// The kernel that it answers with.
    pub fn kernel(&self) -> Kernel {
        let of_method = self.recipe.method.kernel();
        self.recipe.kernel.unwrap_or(of_method)
    }

    /// Whether `other` differs in name and tolerance alone: models and truths are the same.
    pub fn asks_the_same_as(&self, other: &Self) -> bool {
        (&self.recipe, self.setting, self.is_paper)
            == (&other.recipe, other.setting, other.is_paper)
    }

    /// The recipe for the roughness α `roughness`.
    pub fn recipe_for(&self, roughness: f64) -> MethodRecipe {
        MethodRecipe {
            roughness: if find(self.recipe.method).is_rough() {
                vec![roughness]
            } else {
                Vec::new()
            },
            ..self.recipe.clone()
        }
    }

    /// `ndf`, baked by [`recipe_for`](Self::recipe_for), asked as this variant asks, with footprints weighed by `filter`.
    ///
    /// # Errors
    /// As [`SurfaceNdf::with_setting`].
    pub fn ask<'a>(
        &self,
        ndf: SurfaceNdf<'a>,
        filter: Filter,
    ) -> Result<SurfaceNdf<'a>, QueryError> {
        let ndf = match (ndf.with_filter(filter), self.tolerance) {
            (SurfaceNdf::ClusterTree(ndf), eps) => {
                let eps = eps.unwrap_or(Accuracy::DEFAULT);
                let ndf = ndf.with_kernel(self.kernel())?;
                SurfaceNdf::ClusterTree(ndf.with_accuracy(Accuracy::Fast(eps)))
            }
            (SurfaceNdf::Lobes(ndf), _) => SurfaceNdf::Lobes(ndf.with_raw_sum(self.is_paper)),
            (SurfaceNdf::MipLobes(ndf), bias) => {
                let ndf = ndf.with_levels_by_area(self.is_paper);
                SurfaceNdf::MipLobes(ndf.with_level_bias(bias.unwrap_or(0.0))?)
            }
            (SurfaceNdf::NdfMaps(ndf), tolerance) => {
                let tolerance = tolerance.unwrap_or(NdfMaps::DEFAULT_TOLERANCE);
                SurfaceNdf::NdfMaps(ndf.with_tolerance(tolerance)?)
            }
            (SurfaceNdf::Analytic(ndf), reach) => {
                let ndf = reach.map_or(ndf, |reach| ndf.with_reach(reach));
                let form = if self.is_paper {
                    TriangleForm::Paper
                } else {
                    TriangleForm::Accurate
                };
                SurfaceNdf::Analytic(ndf.with_form(form))
            }
            (ndf, Some(tolerance)) => ndf.with_tolerance(tolerance),
            (ndf, None) => ndf,
        };
        match self.setting {
            Some(setting) => ndf.with_setting(setting),
            None => Ok(ndf),
        }
    }
}

/// A footprint on a map with the weights of its texels, from the oracle.
#[derive(Clone, Debug)]
pub struct Patch<'m> {
    /// The map.
    pub map: &'m NormalMap,
    /// The footprint.
    pub footprint: Footprint,
    /// How it weighs texels.
    pub filter: Filter,
    /// Every texel with weight, row-major, adding up to 1.
    pub weights: Vec<TexelWeight>,
}

impl<'m> Patch<'m> {
    /// The patch of `map` under `footprint`. Costs one clipped polygon or integral for each texel.
    ///
    /// # Panics
    /// As [`texel_weights`].
    pub fn new(map: &'m NormalMap, footprint: &Footprint, filter: Filter) -> Self {
        Self {
            map,
            footprint: *footprint,
            filter,
            weights: texel_weights(map, footprint, filter),
        }
    }

    /// The point of the disk of the texel that `uniform` in [0, 1) chooses by weight.
    pub fn normal_by_weight(&self, uniform: f64) -> [f64; 2] {
        let mut left = uniform;
        // Rounding may leave a little beyond the last texel, which then takes it.
        let mut chosen = None;
        for texel in &self.weights {
            chosen = Some(texel);
            left -= texel.weight;
            if left < 0.0 {
                break;
            }
        }
        let texel = chosen.expect("a footprint lies on at least one texel");
        let index = texel.row as usize * self.map.width() as usize + texel.column as usize;
        self.map.texels()[index].map(f64::from)
    }
}

/// What is true under one footprint, by some definition of it: densities in f64, shared with no fast path.
pub trait Reference: Send + Sync {
    /// The density `D` at `half_vector`, per steradian; 0 outside the disk.
    fn ndf(&self, half_vector: HalfVector) -> f64;

    /// The density, per solid angle of the half vector, with which a sampler of this distribution draws `half_vector`.
    fn pdf(&self, half_vector: HalfVector) -> f64;

    /// A half vector drawn with density [`pdf`](Self::pdf) by four numbers in [0, 1), or `None` with the probability
    /// that it leaves over. Not the runtime's sampler. `patch` is the one the reference was made for.
    fn draw(&self, patch: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector>;
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_bake::default_filter;
    use glintbake_format::model::METHODS;

    #[test]
    fn every_method_of_the_format_is_one_subject_with_variants() {
        for &method in METHODS {
            let subjects = REGISTRY.iter().filter(|subject| subject.method() == method);
            assert_eq!(subjects.count(), 1, "{}", method.name());
            for filter in [Filter::Box, Filter::Gaussian] {
                let variants = find(method).variants(filter);
                let has_one = matches!(method, Method::NdfMaps);
                let answers =
                    default_filter(method) == filter || (filter == Filter::Gaussian && !has_one);
                assert_eq!(!variants.is_empty(), answers, "{}", method.name());
                for (place, variant) in variants.iter().enumerate() {
                    let before = &variants[..place];
                    assert!(before.iter().all(|other| other.name != variant.name));
                    assert_eq!(variant.recipe.method, method);
                }
            }
        }
    }
}
