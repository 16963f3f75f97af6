//! What the methods that bin normals have in common: the bin map, and what finds the texels of a bin.

use super::{Bake, inverse, masking};
use crate::build::{bin_map, exact_normals};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::progress::Stage;
use crate::recipe::{Chosen, MethodRecipe};
use glintbake_format::model::BinGrid;
use glintbake_format::records::{
    BIN_MAP, BLOCKED_BIN_MAP, Bins, EXACT_NORMALS, Instance, InverseKind, OCCUPIED_BINS, Structure,
};
use glintbake_format::view::KeyLayout;

/// The longest side of a map: positions are stored in 16 bits.
const MAX_SIDE: u32 = 65_535;

/// Adds one instance of `recipe` over `map`, binned by `grid`.
pub(super) fn add_instance(
    map: &NormalMap,
    recipe: &MethodRecipe,
    grid: BinGrid,
    roughness: Option<f64>,
    bake: &mut Bake<'_>,
) -> Result<(), BakeError> {
    let (width, height) = (map.width(), map.height());
    check_sides(map)?;
    bake.begin(Stage::Bins);
    let bin_map = bin_map::build(map, grid);
    bake.begin(Stage::Structures);
    let choice = inverse::choose(&bin_map, grid, recipe, [width, height]);
    let bins = Bins {
        grid,
        inverse: choice.kind,
        leaf_size: match choice.kind {
            InverseKind::Forest => recipe.leaf_size,
            InverseKind::Tiles | InverseKind::None => 0,
        },
        index: bin_map.index,
        key_count: bin_map.key_count,
    };
    let instance = Instance {
        layer: bake.layer,
        number: bake.next_number(),
        method: recipe.method,
        wrap: map.wrap(),
        width,
        height,
        roughness,
        filter: recipe.filter,
        structure: Structure::Bins(bins),
    };
    bake.chosen.push(Chosen {
        instance: instance.number,
        inverse: choice.kind.name(),
        reason: choice.reason.clone(),
    });
    inverse::add(choice, &bin_map, &instance, bins.leaf_size, bake);
    add_bin_map(bin_map, &instance, bake);
    let mut left_out = |section, reason| bake.leave_out(&instance, section, reason);
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
    masking::add(map, recipe, &instance, bake);
    bake.instances.push(instance);
    Ok(())
}

/// Adds the bin map and what its keys mean.
fn add_bin_map(bin_map: bin_map::BinMap, instance: &Instance, bake: &mut Bake) {
    let id = instance.section(match bin_map.layout {
        KeyLayout::Rows { .. } => BIN_MAP,
        KeyLayout::Blocks(_) => BLOCKED_BIN_MAP,
    });
    match bin_map.keys {
        bin_map::Keys::Narrow(keys) => bake.plan.add(id, keys),
        bin_map::Keys::Wide(keys) => bake.plan.add(id, keys),
    }
    if bin_map.occupied.is_empty() {
        let reason = "a sparse index would not save 5 %; keys are bin numbers";
        bake.leave_out(instance, "BINS", reason);
    } else {
        bake.plan
            .add(instance.section(OCCUPIED_BINS), bin_map.occupied);
    }
}

/// Refuses a map larger than the format can say.
pub(super) fn check_sides(map: &NormalMap) -> Result<(), BakeError> {
    let (width, height) = (map.width(), map.height());
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(BakeError::MapTooLarge { width, height });
    }
    Ok(())
}

/// Refuses a leaf size of zero, and levels.
pub(super) fn check_options(recipe: &MethodRecipe) -> Result<(), BakeError> {
    if let Some(level) = recipe.finest_level {
        return Err(BakeError::Option {
            option: "--finest-level",
            value: level.to_string(),
            reason: format!(
                "{} has no levels; leave the option out, or use lean",
                recipe.method.name()
            ),
        });
    }
    if let Some(kernel) = recipe.kernel {
        return Err(BakeError::Option {
            option: "--kernel",
            value: kernel.name().to_owned(),
            reason: format!(
                "{} has one kernel; leave the option out, or use cluster-tree",
                recipe.method.name()
            ),
        });
    }
    if recipe.raster_normals {
        return Err(BakeError::Option {
            option: "--raster-normals",
            value: String::new(),
            reason: format!(
                "{} has no tree to store them beside; leave the option out, or use cluster-tree",
                recipe.method.name()
            ),
        });
    }
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
