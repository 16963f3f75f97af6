//! `analytic`: the integral over a piecewise-linear surface of normals, \[YHJ*14\].

use super::{Bake, BakeMethod, bins, masking, options, roughness};
use crate::build::{global_ndf, surface};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::progress::Stage;
use crate::recipe::MethodRecipe;
use glintbake_format::model::{Interpolation, Method, intrinsic_from_beckmann};
use glintbake_format::records::{
    GLOBAL_NDF, GLOBAL_ROOT, Instance, NORMALS, PYRAMID_NODES, PYRAMID_ROOT, Structure,
};

pub(super) struct Analytic;

/// The interpolation of a recipe that names none: the paper's simplest.
const DEFAULT_INTERPOLATION: Interpolation = Interpolation::Linear;

impl BakeMethod for Analytic {
    fn method(&self) -> Method {
        Method::Analytic
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        options::check(recipe)?;
        options::check_gaussian(recipe)?;
        roughness::check_range(recipe)
    }

    fn bake(
        &self,
        map: &NormalMap,
        recipe: &MethodRecipe,
        bake: &mut Bake<'_>,
    ) -> Result<(), BakeError> {
        bins::check_sides(map)?;
        let roughness = roughness::or_default(recipe);
        let interpolation = recipe.interpolation.unwrap_or(DEFAULT_INTERPOLATION);
        for (place, &alpha) in roughness.iter().enumerate() {
            let instance = Instance {
                layer: bake.layer,
                number: bake.next_number(),
                method: Method::Analytic,
                wrap: map.wrap(),
                width: map.width(),
                height: map.height(),
                roughness: Some(alpha),
                filter: recipe.filter,
                structure: Structure::Surface { interpolation },
            };
            bake.begin(Stage::Structures);
            if place == 0 {
                let surface = surface::build(map, interpolation);
                bake.plan.add(instance.section(NORMALS), surface.normals);
                bake.plan.add(instance.section(PYRAMID_ROOT), surface.root);
                bake.plan
                    .add(instance.section(PYRAMID_NODES), surface.nodes);
            } else {
                let reason = "stored once, with the first roughness: the surface serves them all";
                bake.leave_out(&instance, "NRML", reason);
            }
            let sigma = intrinsic_from_beckmann(alpha);
            let global = global_ndf::build(map, interpolation, sigma);
            bake.plan.add(instance.section(GLOBAL_ROOT), global.root);
            bake.plan.add(instance.section(GLOBAL_NDF), global.sums);
            masking::add(map, recipe, &instance, bake);
            bake.instances.push(instance);
        }
        Ok(())
    }
}
