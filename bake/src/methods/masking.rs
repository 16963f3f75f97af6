//! What the methods have in common about masking: one table for each map, whichever instance comes first.

use super::Bake;
use crate::build::masking;
use crate::normals::NormalMap;
use crate::recipe::{LeftOut, MethodRecipe};
use glintbake_format::records::{Instance, MASKING};

/// Adds the masking of `map` to `instance`, unless the recipe does without or an earlier instance of the map has it.
pub(super) fn add(map: &NormalMap, recipe: &MethodRecipe, instance: &Instance, bake: &mut Bake) {
    let mut earlier = bake
        .instances
        .iter()
        .filter(|other| other.layer == instance.layer);
    let reason = if !recipe.masking {
        "left out by --no-masking"
    } else if earlier.any(|other| bake.plan.holds(other.section(MASKING))) {
        "stored once, with the first instance of the map"
    } else {
        let table = masking::build(map);
        return bake.plan.add(instance.section(MASKING), table);
    };
    bake.left_out.push(LeftOut {
        instance: instance.number,
        section: "MASK",
        reason,
    });
}
