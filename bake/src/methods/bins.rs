//! What the methods that bin normals have in common: bin map, inverse bin map, index and forest.

use super::Bake;
use crate::build::{bin_map, exact_normals, forest, inverse_bin_map};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::recipe::{LeftOut, MethodRecipe};
use glintbake_format::model::{BinGrid, Filter};
use glintbake_format::records::{
    BIN_MAP, EXACT_NORMALS, FOREST, INDEX, INVERSE_BIN_MAP, Instance, OCCUPIED_BINS,
};

/// The longest side of a map: positions are stored in 16 bits.
const MAX_SIDE: u32 = 65_535;

/// Adds one instance of `recipe` over `map`, binned by `grid`.
pub(super) fn add_instance(
    map: &NormalMap,
    recipe: &MethodRecipe,
    grid: BinGrid,
    roughness: Option<f64>,
    bake: &mut Bake,
) -> Result<(), BakeError> {
    let (width, height) = (map.width(), map.height());
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(BakeError::MapTooLarge { width, height });
    }
    let bin_map = bin_map::build(map, grid);
    let inverse = inverse_bin_map::build(&bin_map, width, height);
    let forest = forest::build(&inverse, recipe.leaf_size);
    let instance = Instance {
        layer: 0,
        number: bake.next_number(),
        method: recipe.method,
        wrap: map.wrap(),
        width,
        height,
        roughness,
        grid,
        leaf_size: recipe.leaf_size,
        filter: Filter::Box,
        index: bin_map.index,
        key_count: bin_map.key_count,
    };
    let mut left_out = |section, reason| {
        bake.left_out.push(LeftOut {
            instance: instance.number,
            section,
            reason,
        });
    };
    match bin_map.keys {
        bin_map::Keys::Narrow(keys) => bake.plan.add(instance.section(BIN_MAP), keys),
        bin_map::Keys::Wide(keys) => bake.plan.add(instance.section(BIN_MAP), keys),
    }
    if bin_map.occupied.is_empty() {
        left_out(
            "BINS",
            "a sparse index would not save 1 %; keys are bin numbers",
        );
    } else {
        bake.plan
            .add(instance.section(OCCUPIED_BINS), bin_map.occupied);
    }
    bake.plan.add(instance.section(INDEX), inverse.offsets);
    bake.plan
        .add(instance.section(INVERSE_BIN_MAP), inverse.positions);
    match forest {
        Some(nodes) => bake.plan.add(instance.section(FOREST), nodes),
        None => left_out("FRST", "no bin holds more texels than a leaf"),
    }
    // Exact normals are places within bins: the finest bins place them best, and once is enough.
    let finest = recipe.roughness.iter().copied().reduce(f64::min);
    if recipe.exact_normals && roughness == finest {
        let normals = exact_normals::build(map, grid);
        bake.plan.add(instance.section(EXACT_NORMALS), normals);
    } else if recipe.exact_normals {
        left_out("EXNM", "stored once, with the instance of the finest bins");
    } else {
        left_out("EXNM", "not asked for; --exact-normals adds it");
    }
    bake.instances.push(instance);
    Ok(())
}

/// Refuses a leaf size of zero.
pub(super) fn check_leaf_size(recipe: &MethodRecipe) -> Result<(), BakeError> {
    if recipe.leaf_size == 0 {
        return Err(BakeError::Option {
            option: "--leaf-size",
            value: "0".to_owned(),
            reason: "a leaf holds at least 1 texel; 10 is the paper's, 32 to 64 is faster"
                .to_owned(),
        });
    }
    Ok(())
}
