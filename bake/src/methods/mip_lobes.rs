//! `mip-lobes`: clustered lobes, level by level, over a surface quilted from a sample, \[TZX22\].

use super::{Bake, BakeMethod, bins, masking, options, roughness};
use crate::build::mip_lobes;
use crate::build::quilt::{self, QuiltOptions};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::progress::Stage;
use crate::recipe::{DEFAULT_CLUSTERS, MethodRecipe, QuiltRecipe, Quilted};
use glintbake_format::model::{LobeLattice, MIP_LANES, Method, MipLayout, QuiltLayout, Wrap};
use glintbake_format::records::{
    Instance, MIP_BLOCKS, MIP_INDEX, NORMALS, QUILT_CUTS, QUILT_ORIGINS, Structure, SurfaceNormal,
};
use rayon::prelude::*;
use zerocopy::little_endian::U16;

pub(super) struct MipLobes;

/// Least side of a sample that is quilted: a patch of it.
const LEAST_SAMPLE: u32 = 8;

/// The most places along a side of the sample where blocks may begin, unless they would be nearer than [`LEAST_GRID`]: a thousand
/// blocks to choose from.
const PLACES: u32 = 32;

/// Least texels from one such place to the next: cells of that side lie wholly in blocks.
const LEAST_GRID: u32 = 8;

/// How much more the normals of texels count than their slopes, where blocks meet \[TZX22\] §5.1.1.
const ALPHA: f64 = 0.9;

/// Four lobes a texel, as in \[TZX22\] §5.1.1.
const DEFAULT_LATTICE: LobeLattice = LobeLattice {
    curved: true,
    per_side: 2,
};

fn refused(option: &'static str, value: impl ToString, reason: String) -> BakeError {
    BakeError::Option {
        option,
        value: value.to_string(),
        reason,
    }
}

impl BakeMethod for MipLobes {
    fn method(&self) -> Method {
        Method::MipLobes
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        options::check(recipe)?;
        options::check_gaussian(recipe)?;
        if let Some(lattice) = recipe.lattice
            && !lattice.curved
        {
            let reason =
                "clusters have slopes of their own; give curved, curved-4, or --method lobes";
            return Err(refused("--lobes", lattice.name(), reason.to_owned()));
        }
        if let Some(clusters) = recipe.clusters
            && !(clusters % MIP_LANES as u32 == 0 && (16..=128).contains(&clusters))
        {
            let reason = "it must be a multiple of 16 from 16 to 128";
            return Err(refused("--clusters", clusters, reason.to_owned()));
        }
        if let Some(quilt) = &recipe.quilt {
            check_quilt(quilt)?;
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
        let layout = layout_of(map, recipe)?;
        let roughness = roughness::or_default(recipe);
        for (place, &alpha) in roughness.iter().enumerate() {
            let instance = Instance {
                layer: bake.layer,
                number: bake.next_number(),
                method: Method::MipLobes,
                wrap: Wrap::Repeat,
                width: layout.size[0],
                height: layout.size[1],
                roughness: Some(alpha),
                filter: recipe.filter,
                structure: Structure::MipLobes(layout),
            };
            bake.begin(Stage::Structures);
            if place == 0 {
                add(map, recipe, &layout, &instance, bake);
            } else {
                let reason = "stored once, with the first roughness: lobes serve them all";
                bake.leave_out(&instance, "MLOB", reason);
            }
            masking::add(map, recipe, &instance, bake);
            bake.instances.push(instance);
        }
        Ok(())
    }
}

/// What can be said of a quilt without its sample.
fn check_quilt(quilt: &QuiltRecipe) -> Result<(), BakeError> {
    let QuiltRecipe {
        target,
        patch,
        overlap,
        tolerance,
        ..
    } = *quilt;
    if let Some(patch) = patch
        && !(patch.is_power_of_two() && (8..=4096).contains(&patch))
    {
        let reason = "it must be a power of two from 8 to 4096".to_owned();
        return Err(refused("--patch", patch, reason));
    }
    if let Some(patch) = patch
        && 2 * u64::from(overlap) > u64::from(patch)
    {
        let reason = format!(
            "blocks of patches of {patch} texels may share up to half as many with the next"
        );
        return Err(refused("--overlap", overlap, reason));
    }
    if overlap > 255 {
        return Err(refused(
            "--overlap",
            overlap,
            "it may be up to 255".to_owned(),
        ));
    }
    if !(0.0..=1e3).contains(&tolerance) {
        let reason =
            "the share of the difference between two texels anywhere lies between 0 and 1000";
        return Err(refused("--quilt-error", tolerance, reason.to_owned()));
    }
    if target.iter().any(|side| !(1..=65535).contains(side)) {
        let reason = "sides of a surface have 1 to 65535 texels".to_owned();
        return Err(refused("--target", written(target), reason));
    }
    Ok(())
}

/// A size as it is given.
fn written([width, height]: [u32; 2]) -> String {
    if width == height {
        width.to_string()
    } else {
        format!("{width}x{height}")
    }
}

/// The layout of the MIP lobes that `recipe` asks of `map`.
fn layout_of(map: &NormalMap, recipe: &MethodRecipe) -> Result<MipLayout, BakeError> {
    let per_side = recipe.lattice.unwrap_or(DEFAULT_LATTICE).per_side;
    let clusters = recipe.clusters.unwrap_or(DEFAULT_CLUSTERS);
    let blocks = (clusters / MIP_LANES as u32) as u8;
    let sample = [map.width(), map.height()];
    let quilted = recipe.quilt.filter(|quilt| quilt.target != sample);
    let Some(quilt) = quilted else {
        if map.wrap() == Wrap::Clamp {
            let reason = "mip-lobes are of surfaces that repeat; quilt one with --target, or use --method lobes";
            return Err(refused("--wrap", "clamp", reason.to_owned()));
        }
        return Ok(MipLayout {
            size: sample,
            per_side,
            first_level: mip_lobes::first_level(per_side, blocks, 0),
            blocks,
            quilt: None,
        });
    };
    let layout = quilt_layout(sample, &quilt)?;
    let first_level = mip_lobes::first_level(per_side, blocks, quilt.overlap);
    if first_level > layout.patch_log {
        let reason = format!(
            "cells with at least four times as many lobes, and no smaller than the overlap, are larger than patches of {} texels; give \
             fewer, or larger patches",
            layout.patch()
        );
        return Err(refused("--clusters", clusters, reason));
    }
    Ok(MipLayout {
        size: quilt.target,
        per_side,
        first_level,
        blocks,
        quilt: Some(layout),
    })
}

/// The layout of a quilt of a sample of `sample` texels.
fn quilt_layout(sample: [u32; 2], quilt: &QuiltRecipe) -> Result<QuiltLayout, BakeError> {
    let least = sample[0].min(sample[1]);
    let [columns, rows] = sample;
    if least < LEAST_SAMPLE {
        let reason = format!(
            "the sample has {columns} x {rows} texels; quilts need one of at least {LEAST_SAMPLE} a side"
        );
        return Err(refused("--target", written(quilt.target), reason));
    }
    let patch = quilt.patch_of(sample);
    if patch + quilt.overlap > least {
        let reason = format!(
            "blocks of {patch} + {} texels are larger than the sample, which has {columns} x {rows}; give a smaller patch",
            quilt.overlap
        );
        return Err(refused("--patch", patch, reason));
    }
    if 2 * quilt.overlap > patch {
        let reason = format!(
            "blocks of patches of {patch} texels may share up to half as many with the next"
        );
        return Err(refused("--overlap", quilt.overlap, reason));
    }
    if quilt.target.iter().any(|side| side % patch != 0) {
        let [x, y] = quilt
            .target
            .map(|side| side.div_ceil(patch).min(65535 / patch) * patch);
        let reason = format!(
            "sides must be multiples of the patch, {patch}: give {}",
            written([x, y])
        );
        return Err(refused("--target", written(quilt.target), reason));
    }
    let most = sample[0].max(sample[1]);
    let grid = most
        .div_ceil(PLACES)
        .next_power_of_two()
        .max(LEAST_GRID)
        .min(patch);
    let logs = [patch, grid].map(|side| side.trailing_zeros() as u8);
    let layout = QuiltLayout::new(quilt.target, sample, logs[0], quilt.overlap as u8, logs[1]);
    Ok(layout.expect("every number was checked"))
}

/// Adds the sections, and says which are not there.
fn add(
    map: &NormalMap,
    recipe: &MethodRecipe,
    layout: &MipLayout,
    instance: &Instance,
    bake: &mut Bake<'_>,
) {
    let normals: Vec<SurfaceNormal> = map
        .texels()
        .par_iter()
        .map(|&texel| SurfaceNormal::new(texel))
        .collect();
    bake.plan.add(instance.section(NORMALS), normals);
    let mut origins = Vec::new();
    match (layout.quilt, &recipe.quilt) {
        (Some(quilt), Some(asked)) => {
            let made = quilt::build(
                map,
                &QuiltOptions {
                    layout: quilt,
                    alpha: ALPHA,
                    tolerance: asked.tolerance,
                    seed: asked.seed,
                },
            );
            let stored: Vec<[U16; 2]> = made
                .origins
                .iter()
                .map(|origin| origin.map(U16::new))
                .collect();
            bake.plan.add(instance.section(QUILT_ORIGINS), stored);
            bake.plan.add(instance.section(QUILT_CUTS), made.cuts);
            bake.quilted.push(Quilted {
                instance: instance.number,
                patches: made.origins.len(),
                patch: quilt.patch(),
                forced: made.forced,
                tolerance: asked.tolerance,
                mean_error: made.mean_error,
            });
            origins = made.origins;
        }
        _ => {
            let reason = "the surface is the map itself";
            bake.leave_out(instance, "QORG", reason);
        }
    }
    let lobes = mip_lobes::build(map, layout, &origins);
    if layout.quilt.is_some() {
        bake.plan.add(instance.section(MIP_INDEX), lobes.index);
    }
    if lobes.blocks.is_empty() {
        let reason = "the map has fewer lobes than four times the clusters of a cell";
        bake.leave_out(instance, "MLOB", reason);
    } else {
        bake.plan.add(instance.section(MIP_BLOCKS), lobes.blocks);
    }
}
