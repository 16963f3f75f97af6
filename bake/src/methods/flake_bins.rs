//! `flake-bins`: bins of the projected disk for a given roughness, \[AWKK21\].

use super::{Bake, BakeMethod, bins, roughness};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::recipe::MethodRecipe;
use glintbake_format::model::{BinGrid, Binning, Method, disk_grid_resolution};

pub(super) struct FlakeBins;

impl BakeMethod for FlakeBins {
    fn method(&self) -> Method {
        Method::FlakeBins
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        bins::check_options(recipe)?;
        if recipe.bins.is_some() {
            return Err(BakeError::Option {
                option: "--bins",
                value: format!("{:?}", recipe.bins.unwrap_or_default()),
                reason: "flake-bins derives its bins from the roughness; leave the option out"
                    .to_owned(),
            });
        }
        roughness::check(recipe)
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
