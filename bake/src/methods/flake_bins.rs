//! `flake-bins`: bins of the projected disk for a given roughness, \[AWKK21\].

use super::{Bake, BakeMethod, bins};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::recipe::MethodRecipe;
use glintbake_format::model::{BinGrid, Binning, Method, disk_grid_resolution};

pub(super) struct FlakeBins;

/// Smallest Beckmann roughness: below it eq. 16 wants more bins than 16-bit columns and rows can name.
const LEAST_ROUGHNESS: f64 = 1e-4;
/// Largest Beckmann roughness: the paper's neighbourhood covers the lobe up to there.
const MOST_ROUGHNESS: f64 = 1.0;

impl BakeMethod for FlakeBins {
    fn method(&self) -> Method {
        Method::FlakeBins
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        bins::check_leaf_size(recipe)?;
        if recipe.bins.is_some() {
            return Err(BakeError::Option {
                option: "--bins",
                value: format!("{:?}", recipe.bins.unwrap_or_default()),
                reason: "flake-bins derives its bins from the roughness; leave the option out"
                    .to_owned(),
            });
        }
        if recipe.roughness.is_empty() {
            return Err(BakeError::Option {
                option: "--roughness",
                value: String::new(),
                reason:
                    "flake-bins is baked for given roughnesses; name at least one, such as 0.01"
                        .to_owned(),
            });
        }
        for (place, &alpha) in recipe.roughness.iter().enumerate() {
            let reason = if !(LEAST_ROUGHNESS..=MOST_ROUGHNESS).contains(&alpha) {
                format!(
                    "Beckmann roughness must lie between {LEAST_ROUGHNESS} and {MOST_ROUGHNESS}"
                )
            } else if recipe.roughness[..place].contains(&alpha) {
                "the same roughness is named twice".to_owned()
            } else {
                continue;
            };
            return Err(BakeError::Option {
                option: "--roughness",
                value: alpha.to_string(),
                reason,
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
        for &alpha in &recipe.roughness {
            let grid = BinGrid::new(Binning::DiskGrid, disk_grid_resolution(alpha))
                .expect("the checked range of roughness keeps the resolution within the grid's");
            bins::add_instance(map, recipe, grid, Some(alpha), bake)?;
        }
        Ok(())
    }
}
