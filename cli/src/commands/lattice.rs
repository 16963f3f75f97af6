//! Flakes too sharp for a package's normals: those of 8-bit maps lie on a lattice, and those of lobes are rounded.

use super::{describe, open};
use crate::args::{OpenArgs, QuerySettings};
use crate::output::Console;
use glintbake_format::model::{Binning, Interpolation, LobeLattice, intrinsic_from_beckmann};
use glintbake_format::records::{Instance, Structure};
use glintbake_runtime::{Ndf, Package, SurfaceNdf};
use serde_json::Value;
use std::fmt::Display;

/// Steps of more standard deviations of a flake than that show: Gaussians at such a distance add up to a ripple of 9 %,
/// 2 exp(-2 π² / 2.5²) of their sum to either side.
const BRIDGED_STEP: f64 = 2.5;

/// Lobes are rounded for the least roughness of the bake; what that does to a density grows as roughness falls, and shows from
/// this part of it on: merging within the default, then by 0.5 % of a lobe's peak.
const ROUNDED_SHARE: f64 = 0.1;

/// Warns if `instance`, whose map is called `name` and has `metadata`, is sharper than the lattice of the map's normals:
/// the surface then glints in rows.
pub(super) fn warn(console: &Console, name: impl Display, metadata: &Value, instance: &Instance) {
    let step = metadata.pointer("/statistics/lattice/step");
    let (Some(step), Some(alpha)) = (step.and_then(Value::as_f64), instance.roughness) else {
        return;
    };
    let finer = match instance.structure {
        Structure::Bins(bins) if bins.grid.binning() == Binning::DiskGrid => {
            let bin = 2.0 / f64::from(bins.grid.resolution());
            (step > bin).then(|| format!("the bins of roughness {alpha} ({bin:.5})"))
        }
        // Interpolated normals lie between the steps, but for what is not.
        Structure::Lobes(LobeLattice { curved: true, .. })
        | Structure::MipLobes(_)
        | Structure::Surface {
            interpolation: Interpolation::Linear | Interpolation::CatmullRom,
        } => None,
        Structure::Clusters { .. } | Structure::Lobes(_) | Structure::Surface { .. } => {
            let bridged = BRIDGED_STEP * intrinsic_from_beckmann(alpha);
            (step > bridged).then(|| format!("flakes of roughness {alpha} bridge ({bridged:.5})"))
        }
        // Normals between texels lie between the steps.
        Structure::NdfMaps(_) => None,
        Structure::Bins(_) | Structure::Pyramid { .. } => None,
    };
    if let Some(finer) = finer {
        console.warn(format_args!(
            "{name}: its normals lie on a lattice of step {step:.5}, coarser than {finer}: glints will line up in rows. \
             Use a 16-bit or float map, or a roughness of 0.01 or more"
        ));
    }
}

/// Warns as [`warn`] of a roughness that the package was not baked with, and so nobody has been warned of.
pub(super) fn warn_of_query(
    console: &Console,
    arguments: &OpenArgs,
    chosen: &QuerySettings<'_>,
    bytes: &[u8],
) {
    let path = &arguments.package;
    let asked = chosen.ndf.instance();
    if SurfaceNdf::roughness_range(asked.method).is_none() {
        return;
    }
    // What cannot be read is the business of `verify`: the answer does not depend on it.
    let Ok(package) = open::package(path, bytes) else {
        return;
    };
    if let Structure::Lobes(_) = asked.structure {
        warn_of_rounding(console, path.display(), &package, asked);
    }
    let baked = package.instances().any(|baked| baked == *asked);
    if let (false, Ok(metadata)) = (baked, describe::metadata(&package)) {
        warn(console, path.display(), &metadata, asked);
    }
}

/// Warns if the lobes of `package`, which is called `name`, were rounded for flakes much blunter than those of `asked`.
fn warn_of_rounding(
    console: &Console,
    name: impl Display,
    package: &Package<'_>,
    asked: &Instance,
) {
    let of_lobes = package
        .instances()
        .filter(|baked| baked.method == asked.method);
    let least = of_lobes
        .filter_map(|baked| baked.roughness)
        .fold(f64::INFINITY, f64::min);
    if let Some(alpha) = asked.roughness
        && alpha < ROUNDED_SHARE * least
    {
        console.warn(format_args!(
            "{name}: its lobes are rounded for a roughness of {least}, more than ten times {alpha}: densities may be off by \
             more than half a percent of a lobe's peak. Bake with --roughness {alpha}"
        ));
    }
}
