//! `lobes`: Gaussians of position and normal, \[YHMR16\].

use super::{Bake, BakeMethod, bins, masking, options, roughness};
use crate::build::lobes::{self, Precision};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::progress::Stage;
use crate::recipe::{DEFAULT_MERGE_ERROR, MethodRecipe};
use glintbake_format::model::{LobeLattice, Method, intrinsic_from_beckmann};
use glintbake_format::records::{
    Instance, LOBE_INDEX, LOBE_MOMENTS, LOBE_SPREADS, LOBES, PYRAMID_NODES, PYRAMID_ROOT,
    Structure, WIDE_LOBES,
};

pub(super) struct Lobes;

/// Most that merging may be allowed: beyond, a lobe is no longer where it was.
const MOST_MERGE_ERROR: f64 = 0.5;

impl BakeMethod for Lobes {
    fn method(&self) -> Method {
        Method::Lobes
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        options::check(recipe)?;
        options::check_gaussian(recipe)?;
        if let Some(error) = recipe.merge_error
            && !(0.0..=MOST_MERGE_ERROR).contains(&error)
        {
            return Err(BakeError::Option {
                option: "--merge-error",
                value: error.to_string(),
                reason: format!(
                    "the share of a lobe's peak that merging may change lies between 0 and {MOST_MERGE_ERROR}"
                ),
            });
        }
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
        let lattice = recipe.lattice.unwrap_or(LobeLattice {
            curved: true,
            per_side: 1,
        });
        for (place, &alpha) in roughness.iter().enumerate() {
            let instance = Instance {
                layer: bake.layer,
                number: bake.next_number(),
                method: Method::Lobes,
                wrap: map.wrap(),
                width: map.width(),
                height: map.height(),
                roughness: Some(alpha),
                filter: recipe.filter,
                structure: Structure::Lobes(lattice),
            };
            bake.begin(Stage::Structures);
            if place == 0 {
                let least = roughness.iter().copied().fold(f64::INFINITY, f64::min);
                let precision = Precision {
                    sigma: intrinsic_from_beckmann(least),
                    merge_error: recipe.merge_error.unwrap_or(DEFAULT_MERGE_ERROR),
                };
                add(map, lattice, precision, &instance, bake);
            } else {
                let reason = "stored once, with the first roughness: lobes serve them all";
                bake.leave_out(&instance, "LOBE", reason);
            }
            masking::add(map, recipe, &instance, bake);
            bake.instances.push(instance);
        }
        Ok(())
    }
}

/// Adds the lobes' sections, and says which are not there.
fn add(
    map: &NormalMap,
    lattice: LobeLattice,
    precision: Precision,
    instance: &Instance,
    bake: &mut Bake<'_>,
) {
    let lobes = lobes::build(map, lattice, precision);
    bake.plan.add(instance.section(PYRAMID_ROOT), lobes.root);
    bake.plan.add(instance.section(PYRAMID_NODES), lobes.nodes);
    bake.plan.add(instance.section(LOBE_INDEX), lobes.index);
    bake.plan.add(instance.section(LOBE_MOMENTS), lobes.moments);
    if !lobes.spreads.is_empty() {
        bake.plan.add(instance.section(LOBE_SPREADS), lobes.spreads);
    }
    match (lobes.curved.is_empty(), lobes.flat.is_empty()) {
        (false, _) => bake.plan.add(instance.section(LOBES), lobes.curved),
        (true, false) => bake.plan.add(instance.section(LOBES), lobes.flat),
        (true, true) => {
            let reason = "no block is stored in 16 bits: all are merged, or wide";
            bake.leave_out(instance, "LOBE", reason);
        }
    }
    match (lobes.wide_curved.is_empty(), lobes.wide_flat.is_empty()) {
        (false, _) => bake
            .plan
            .add(instance.section(WIDE_LOBES), lobes.wide_curved),
        (true, false) => bake.plan.add(instance.section(WIDE_LOBES), lobes.wide_flat),
        (true, true) => {
            let reason = "no block would be rounded by too much";
            bake.leave_out(instance, "LOBW", reason);
        }
    }
    if !lattice.curved {
        let reason = "lobes are flat";
        bake.leave_out(instance, "LOSD", reason);
    }
}
