//! Recipes: what each method puts into a package. One file per method, of the method's name.

mod analytic;
mod bins;
mod cluster_tree;
mod flake_bins;
mod inverse;
mod lean;
mod lobes;
mod masking;
mod mip_lobes;
mod ndf_maps;
mod options;
mod roughness;
mod specular_bins;

use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::package::PackagePlan;
use crate::progress::{Progress, Stage};
use crate::recipe::{Chosen, LeftOut, MethodRecipe, NdfMapped, Quilted};
use glintbake_format::model::Method;
use glintbake_format::records::Instance;

pub use options::check_later;

/// What a method can be baked with.
pub trait BakeMethod: Sync {
    /// The method this is.
    fn method(&self) -> Method;

    /// Refuses options that are out of range or that the method does not have.
    ///
    /// # Errors
    /// [`BakeError::Option`].
    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError>;

    /// Bakes `map` by `recipe`, adding sections to `bake.plan` and one [`Instance`] per value of the recipe.
    ///
    /// # Errors
    /// [`BakeError`] if the map does not fit the format.
    fn bake(
        &self,
        map: &NormalMap,
        recipe: &MethodRecipe,
        bake: &mut Bake<'_>,
    ) -> Result<(), BakeError>;
}

/// Every method that can be baked.
pub const REGISTRY: &[&dyn BakeMethod] = &[
    &flake_bins::FlakeBins,
    &specular_bins::SpecularBins,
    &lean::Lean,
    &cluster_tree::ClusterTree,
    &lobes::Lobes,
    &analytic::Analytic,
    &mip_lobes::MipLobes,
    &ndf_maps::NdfMaps,
];

/// The baker of `method`.
pub fn find(method: Method) -> Option<&'static dyn BakeMethod> {
    REGISTRY
        .iter()
        .copied()
        .find(|baker| baker.method() == method)
}

/// A package in the making.
pub struct Bake<'a> {
    /// The layer of the material that is being baked, 0 of packages without one.
    pub layer: u16,
    /// The sections so far.
    pub plan: PackagePlan,
    /// The instances so far.
    pub instances: Vec<Instance>,
    /// What was left out, and why.
    pub left_out: Vec<LeftOut>,
    /// What was chosen, and why.
    pub chosen: Vec<Chosen>,
    /// How well the blocks of quilts meet.
    pub quilted: Vec<Quilted>,
    /// What surfaces of copies have come to.
    pub ndf_mapped: Vec<NdfMapped>,
    /// Who hears how far it has come.
    pub progress: &'a dyn Progress,
    /// How many instances there will be.
    pub instance_count: u64,
}

impl Bake<'_> {
    /// Tells that the next instance has come to `stage`.
    pub fn begin(&self, stage: Stage) {
        let done = self.instances.len() as u64;
        self.progress.report(stage, done, self.instance_count);
    }

    /// The number of the next instance.
    pub fn next_number(&self) -> u16 {
        self.instances.len() as u16 + 1
    }

    /// Notes that `instance` has no section called `section`, and why.
    pub fn leave_out(&mut self, instance: &Instance, section: &'static str, reason: &'static str) {
        self.left_out.push(LeftOut {
            instance: instance.number,
            section,
            reason,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::model::METHODS;

    #[test]
    fn every_method_of_the_format_has_one_baker() {
        for &method in METHODS {
            let bakers = REGISTRY.iter().filter(|baker| baker.method() == method);
            assert_eq!(bakers.count(), 1, "{}", method.name());
        }
    }
}
