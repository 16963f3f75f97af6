//! Normals that lie on a lattice, as those of 8-bit maps do, and flakes too sharp to bridge its steps.

use super::{describe, open};
use crate::args::{OpenArgs, QuerySettings};
use crate::output::Console;
use glintbake_format::model::{
    Binning, Interpolation, LobeLattice, Method, intrinsic_from_beckmann,
};
use glintbake_format::records::{Instance, Structure};
use glintbake_runtime::Ndf;
use serde_json::Value;
use std::fmt::Display;

/// Steps of more standard deviations of a flake than that show: Gaussians at such a distance add up to a ripple of 9 %,
/// 2 exp(-2 π² / 2.5²) of their sum to either side.
const BRIDGED_STEP: f64 = 2.5;

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
        | Structure::Surface {
            interpolation: Interpolation::Linear | Interpolation::CatmullRom,
        } => None,
        Structure::Clusters { .. } | Structure::Lobes(_) | Structure::Surface { .. } => {
            let bridged = BRIDGED_STEP * intrinsic_from_beckmann(alpha);
            (step > bridged).then(|| format!("flakes of roughness {alpha} bridge ({bridged:.5})"))
        }
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
    if asked.method != Method::ClusterTree {
        return;
    }
    // What cannot be read is the business of `verify`: the answer does not depend on it.
    let Ok(package) = open::package(path, bytes) else {
        return;
    };
    let baked = package.instances().any(|baked| baked == *asked);
    if let (false, Ok(metadata)) = (baked, describe::metadata(&package)) {
        warn(console, path.display(), &metadata, asked);
    }
}
