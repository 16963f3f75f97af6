//! `ndf-maps`: NDF images of the tiles of a tiny example, whose copies make up a surface, \[XTXW24\].

use super::{Bake, BakeMethod, bins, masking, options, roughness};
use crate::build::ndf_maps::{self, Built, Copies, ImageOptions};
use crate::error::BakeError;
use crate::noise::fault_of;
use crate::normals::NormalMap;
use crate::progress::Stage;
use crate::recipe::{DEFAULT_NDF_PITCH, MethodRecipe, NdfCopies, NdfMapRecipe, NdfMapped};
use glintbake_format::model::{
    Filter, Method, NdfMapLayout, NdfPixels, Wrap, beckmann_from_intrinsic, intrinsic_from_beckmann,
};
use glintbake_format::records::{
    Instance, NDF_COPIES, NDF_GRID, NDF_IMAGES, NDF_NEIGHBOURS, NDF_PIXELS, NDF_ROOT, NORMALS,
    Structure, SurfaceNormal,
};

pub(super) struct NdfMaps;

/// The least and the greatest pitch of splines: finer gains nothing, and a coarser one leaves nothing of the kernel.
const PITCHES: core::ops::RangeInclusive<f64> = 0.25..=1.5;

fn refused(option: &'static str, value: impl ToString, reason: impl Into<String>) -> BakeError {
    BakeError::Option {
        option,
        value: value.to_string(),
        reason: reason.into(),
    }
}

impl BakeMethod for NdfMaps {
    fn method(&self) -> Method {
        Method::NdfMaps
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        options::check(recipe)?;
        if recipe.filter != Filter::Box {
            let reason = "ndf-maps is made for boxes; leave the option out, or use mip-lobes for Gaussian footprints";
            return Err(refused("--filter", recipe.filter.name(), reason));
        }
        if let Some(asked) = &recipe.ndf_maps {
            check_asked(asked)?;
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
        let asked = recipe.ndf_maps.clone().unwrap_or_default();
        let layout = layout_of(map, &asked)?;
        for &alpha in roughness::or_default(recipe) {
            let instance = Instance {
                layer: bake.layer,
                number: bake.next_number(),
                method: Method::NdfMaps,
                wrap: map.wrap(),
                width: layout.size,
                height: layout.size,
                roughness: Some(alpha),
                filter: Filter::Box,
                structure: Structure::NdfMaps(layout),
            };
            bake.begin(Stage::Structures);
            let built = build(map, &layout, &asked, alpha)?;
            add(map, &asked, built, &instance, bake);
            masking::add(map, recipe, &instance, bake);
            bake.instances.push(instance);
        }
        Ok(())
    }
}

/// What can be said of a surface without its example.
fn check_asked(asked: &NdfMapRecipe) -> Result<(), BakeError> {
    if let Some(pitch) = asked.pitch
        && !PITCHES.contains(&pitch)
    {
        let reason = format!(
            "pixels lie {} to {} standard deviations of the kernel apart",
            PITCHES.start(),
            PITCHES.end()
        );
        return Err(refused("--ndf-pitch", pitch, reason));
    }
    if let Some(side) = asked.paper_pixels
        && !(side.is_multiple_of(2) && (16..=2048).contains(&side))
    {
        let reason =
            "images have an even number of pixels a side, 16 to 2048; the paper has 128 and 256";
        return Err(refused("--ndf-pixels", side, reason));
    }
    let [s, t] = asked.ground;
    // So that NaN is refused.
    let is_on_disk = s * s + t * t < 1.0;
    if !is_on_disk {
        let reason = "the ground's normal is a point (s, t) of the unit disk, as in 0,0";
        return Err(refused("--ground", format!("{s},{t}"), reason));
    }
    if let NdfCopies::Tiled(transform) = &asked.copies
        && let Some(reason) = fault_of(transform.matrix())
    {
        return Err(refused("--transform", "", reason));
    }
    Ok(())
}

/// The layout of the NDF maps that `asked` asks of `map`.
fn layout_of(map: &NormalMap, asked: &NdfMapRecipe) -> Result<NdfMapLayout, BakeError> {
    let [width, height] = [map.width(), map.height()];
    let is_example = width == height && width.is_power_of_two() && (2..=32).contains(&width);
    if !is_example {
        let reason = format!(
            "its examples are squares of 2, 4, 8, 16 or 32 texels a side, and the map has {width} x {height}; cut one out of it, or \
             use mip-lobes, which quilts samples of any size"
        );
        return Err(refused("--method", "ndf-maps", reason));
    }
    let is_scattered = matches!(asked.copies, NdfCopies::Scattered(_));
    let size = match asked.size {
        Some(size) => size,
        None if is_scattered => {
            let reason = "give the texels along a side of the surface that the noise map is for, as in --size 1024";
            return Err(refused("--size", "", reason));
        }
        None => width,
    };
    if !(width..=65535).contains(&size) {
        let reason =
            format!("a surface has as many texels a side as its example, {width}, to 65535");
        return Err(refused("--size", size, reason));
    }
    let layout = NdfMapLayout {
        size,
        example_log: width.trailing_zeros() as u8,
        pixels: match asked.paper_pixels {
            None => NdfPixels::Splines,
            Some(_) => NdfPixels::Points,
        },
        is_scattered,
        scales_slopes: asked.scales_slopes,
    };
    if !is_scattered && map.wrap() == Wrap::Clamp {
        let reason = "tiles of an example that does not repeat end at each other's borders; leave the option out, or scatter it with --noise";
        return Err(refused("--wrap", "clamp", reason));
    }
    Ok(layout)
}

/// The sections for Beckmann roughness `alpha`.
fn build(
    map: &NormalMap,
    layout: &NdfMapLayout,
    asked: &NdfMapRecipe,
    alpha: f64,
) -> Result<Built, BakeError> {
    let ground = asked.ground_roughness.unwrap_or(alpha);
    if !(alpha..=10.0).contains(&ground) {
        let reason = format!("the ground is as rough as the kernel, {alpha}, or rougher, to 10");
        return Err(refused("--ground-roughness", ground, reason));
    }
    let options = ImageOptions {
        sigma: intrinsic_from_beckmann(alpha),
        pitch: asked.pitch.unwrap_or(DEFAULT_NDF_PITCH),
        side: asked.paper_pixels.unwrap_or(0),
        ground: asked.ground,
        ground_deviation: intrinsic_from_beckmann(ground),
    };
    let copies = match &asked.copies {
        NdfCopies::Tiled(transform) => Copies::Tiled(transform.matrix()),
        NdfCopies::Scattered(noise) => Copies::Scattered(&noise.copies),
    };
    let built = ndf_maps::build(map, layout, copies, &options)?;
    if built.pixels.len() > u32::MAX as usize {
        let sigma = beckmann_from_intrinsic(options.sigma);
        let reason = "the NDF images would have more than 2^32 pixels; give a greater roughness";
        return Err(refused("--roughness", sigma, reason));
    }
    Ok(built)
}

/// Adds the sections, and says which are not there.
fn add(
    map: &NormalMap,
    asked: &NdfMapRecipe,
    built: Built,
    instance: &Instance,
    bake: &mut Bake<'_>,
) {
    let normals: Vec<SurfaceNormal> = map
        .texels()
        .iter()
        .map(|&at| SurfaceNormal::new(at))
        .collect();
    let asked_for = match &asked.copies {
        NdfCopies::Tiled(_) => 1,
        NdfCopies::Scattered(noise) => noise.copies.len(),
    };
    bake.ndf_mapped.push(NdfMapped {
        instance: instance.number,
        copies: built.copies.len(),
        hidden: asked_for - built.copies.len(),
        covered: built.root.covered.get(),
        pixels: built.pixels.len(),
    });
    bake.plan.add(instance.section(NORMALS), normals);
    bake.plan.add(instance.section(NDF_ROOT), vec![built.root]);
    bake.plan.add(instance.section(NDF_IMAGES), built.images);
    bake.plan.add(instance.section(NDF_PIXELS), built.pixels);
    bake.plan.add(instance.section(NDF_COPIES), built.copies);
    if built.grid.is_empty() {
        bake.leave_out(instance, "NDFG", "copies are tiled");
    } else {
        bake.plan.add(instance.section(NDF_GRID), built.grid);
    }
    if built.neighbours.is_empty() {
        bake.leave_out(instance, "NDFN", "no copies overlap");
    } else {
        bake.plan
            .add(instance.section(NDF_NEIGHBOURS), built.neighbours);
    }
}
