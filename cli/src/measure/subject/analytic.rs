//! `analytic`: the integral over a surface of normals, by each interpolation, and by the paper's form of it.

use super::interpolated;
use super::{Against, Bound, Ladder, Patch, Reference, Subject, Variant, disk_peak, find};
use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Interpolation, Method};
use glintbake_format::records::Structure;
use glintbake_runtime::Instance;

pub(super) struct Analytic;

/// Interpolations worth comparing, the default first.
const INTERPOLATIONS: [Interpolation; 3] = [
    Interpolation::Linear,
    Interpolation::CatmullRom,
    Interpolation::None,
];

/// Reaches from coarse to the default.
const REACHES: [f64; 4] = [2.0, 3.0, 4.0, 5.5];

impl Subject for Analytic {
    fn method(&self) -> Method {
        Method::Analytic
    }

    fn is_rough(&self) -> bool {
        true
    }

    fn variants(&self, filter: Filter) -> Vec<Variant> {
        if filter == Filter::Box {
            return Vec::new();
        }
        let mut variants = INTERPOLATIONS
            .map(|interpolation| variant(interpolation, false))
            .to_vec();
        variants.insert(1, variant(Interpolation::Linear, true));
        variants
    }

    /// The model is the integral itself: what a variant leaves out or approximates is its error.
    fn is_truth(&self, _: &Variant) -> bool {
        true
    }

    fn surface(&self, variant: &Variant) -> Interpolation {
        variant
            .recipe
            .interpolation
            .unwrap_or(Interpolation::Linear)
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        self.truth(variant, patch, roughness)
    }

    /// Flat texels are those of the methods that weigh them.
    fn truth(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        match self.surface(variant) {
            Interpolation::None => {
                let lean = find(Method::Lean);
                lean.truth(&lean.variants(patch.filter)[0], patch, roughness)
            }
            surface => interpolated::truth(surface, patch, roughness),
        }
    }

    fn seconds(
        &self,
        variant: &Variant,
        map: &NormalMap,
        texels: f64,
        roughness: f64,
        _: Against,
    ) -> f64 {
        interpolated::seconds(self.surface(variant), map, texels, roughness)
    }

    fn variants_of(&self, instance: &Instance, filter: Filter) -> Vec<Variant> {
        match (instance.structure, filter) {
            (Structure::Surface { interpolation }, Filter::Gaussian) => [false, true]
                .map(|is_paper| variant(interpolation, is_paper))
                .into(),
            _ => Vec::new(),
        }
    }

    fn peak(&self, _: &Variant, roughness: f64) -> f64 {
        disk_peak(roughness)
    }

    fn bound(&self, variant: &Variant, _: Filter, _: &NormalMap, _: f64) -> Bound {
        if variant.is_paper {
            return Bound {
                relative: 0.25,
                floor: 0.1,
                reason: "error functions of the paper are six quadratics, and end at 3 deviations"
                    .to_owned(),
            };
        }
        Bound {
            relative: 1e-4,
            floor: 0.1,
            reason: "triangles are integrated to 1e-8; both Gaussians end at 5.5 deviations, which leaves out 4e-6 of all, \
                     and weigh copies alike from 0.75 tile, to 3e-5"
                .to_owned(),
        }
    }

    fn ladders(&self, filter: Filter) -> Vec<Ladder> {
        if filter == Filter::Box {
            return Vec::new();
        }
        let rungs = REACHES.map(|reach| Variant {
            name: format!("reach {reach}"),
            tolerance: Some(reach),
            ..variant(Interpolation::Linear, false)
        });
        vec![Ladder {
            name: "reach",
            rungs: rungs.into(),
            against: Against::Model,
            exact: 1e-4,
            slack: 1.05,
        }]
    }
}

/// The surface by `interpolation`, triangles integrated accurately, or as the paper does.
fn variant(interpolation: Interpolation, is_paper: bool) -> Variant {
    let name = match interpolation {
        _ if is_paper => "paper",
        other => other.name(),
    };
    Variant {
        name: name.to_owned(),
        is_paper,
        recipe: MethodRecipe {
            interpolation: Some(interpolation),
            ..MethodRecipe::new(Method::Analytic, &[])
        },
        setting: None,
        tolerance: None,
    }
}
