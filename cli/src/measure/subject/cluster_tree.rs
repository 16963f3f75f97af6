//! `cluster-tree`: moments of clusters, within several errors.

use super::{Patch, Reference, Subject, Variant, find};
use glintbake_bake::MethodRecipe;
use glintbake_format::model::{Filter, Method, Neighbourhood};
use glintbake_runtime::{Accuracy, Setting};

pub(super) struct ClusterTree;

/// Errors worth comparing, the default first.
const EPS: [f64; 3] = [Accuracy::DEFAULT, 1e-2, 1e-4];

impl Subject for ClusterTree {
    fn method(&self) -> Method {
        Method::ClusterTree
    }

    fn is_rough(&self) -> bool {
        true
    }

    fn variants(&self, _: Filter) -> Vec<Variant> {
        EPS.map(|eps| Variant {
            name: format!("eps {eps}"),
            is_paper: false,
            recipe: MethodRecipe::new(self.method(), &[]),
            setting: None,
            tolerance: Some(eps),
        })
        .to_vec()
    }

    /// The model is the sum over texels itself: what a variant leaves out or approximates is its error.
    fn is_truth(&self, _: &Variant) -> bool {
        true
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        self.truth(variant, patch, roughness)
    }

    /// The kernel's truth is that of `flake-bins`.
    fn truth(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        let flakes = find(Method::FlakeBins);
        let exact = Variant {
            name: "exact".to_owned(),
            is_paper: false,
            recipe: variant.recipe.clone(),
            setting: Some(Setting::Binned(Neighbourhood::Bins45)),
            tolerance: None,
        };
        flakes.truth(&exact, patch, roughness)
    }
}
