//! `specular-bins`: bins of equal solid angle for mirror flakes, \[ABKK20\].

use super::{Bake, BakeMethod, bins};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::recipe::MethodRecipe;
use glintbake_format::model::{BinGrid, Binning, Method};

pub(super) struct SpecularBins;

/// Bins a side where none are named: the car paint of \[ABKK20\] figure 1.
const DEFAULT_BINS: u32 = 127;

impl BakeMethod for SpecularBins {
    fn method(&self) -> Method {
        Method::SpecularBins
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        bins::check_options(recipe)?;
        if let Some(alpha) = recipe.roughness.first() {
            return Err(BakeError::Option {
                option: "--roughness",
                value: alpha.to_string(),
                reason: "specular-bins has mirror flakes; leave the option out, or use flake-bins"
                    .to_owned(),
            });
        }
        if recipe.exact_normals {
            return Err(BakeError::Option {
                option: "--exact-normals",
                value: String::new(),
                reason: "mirror flakes have no density to evaluate exactly; use flake-bins"
                    .to_owned(),
            });
        }
        if BinGrid::new(Binning::EqualSolidAngle, bins_per_side(recipe)).is_none() {
            return Err(BakeError::Option {
                option: "--bins",
                value: bins_per_side(recipe).to_string(),
                reason: format!(
                    "bins a side must lie between 1 and {}",
                    BinGrid::MAX_RESOLUTION
                ),
            });
        }
        Ok(())
    }

    fn bake(
        &self,
        map: &NormalMap,
        recipe: &MethodRecipe,
        bake: &mut Bake<'_>,
    ) -> Result<(), BakeError> {
        let grid = BinGrid::new(Binning::EqualSolidAngle, bins_per_side(recipe))
            .expect("checked before baking");
        bins::add_instance(map, recipe, grid, None, bake)
    }
}

fn bins_per_side(recipe: &MethodRecipe) -> u32 {
    recipe.bins.unwrap_or(DEFAULT_BINS)
}
