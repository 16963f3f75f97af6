//! A normal map from what a package holds of it.

mod leaves;
mod lobes;
mod mip_lobes;
pub mod ndf_maps;
mod surface;

use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{BinGrid, HalfVector, LobeLattice};
use glintbake_format::records::Structure;
use glintbake_format::view::{BinTables, ExactNormals, Pyramid};
use glintbake_format::{Container, Fault, Finding};
use glintbake_runtime::Instance;

/// How far inside its bin, as a share of it, a normal is moved that stands for a bin across the rim: the least of these that
/// keeps it in its bin.
const INSETS: [f64; 4] = [0.25, 1.0 / 64.0, 1.0 / 1024.0, 1.0 / 65_536.0];

/// The map that `instance` of `container` was baked from, as far as the package holds it.
///
/// With exact normals, each texel's own, to 2^-16 of a bin and f32. Without, a normal of each texel's bin: its middle, or the
/// point nearest to the pole where the middle is beyond the rim. Its bin is the texel's bin again, so that a model over
/// bins is that of the original map; a model of each texel's own normal is not. Of a pyramid the means of its level 0, to
/// what they are stored in; `None` if it begins above that, for then it holds no texel's normal. Of a cluster tree the normals of
/// its leaves, and of lobes, one a texel, theirs, which are what they answer for; `None` of four a texel, which lie between texels. Of a surface the normals
/// themselves, of MIP lobes those of every texel of the quilted surface, and of NDF maps the example, if the surface is nothing but
/// copies of it side by side.
///
/// # Errors
/// If sections are missing or damaged, or a bin holds no direction.
pub fn normal_map(
    container: &Container<'_>,
    instance: &Instance,
) -> Result<Option<NormalMap>, Finding> {
    let texels = match instance.structure {
        Structure::Bins(bins) => Some(from_bins(container, instance, bins.grid)?),
        Structure::Pyramid { finest_level: 0 } => Some(from_means(container, instance)?),
        Structure::Pyramid { .. } => None,
        Structure::Clusters { .. } => Some(leaves::from_leaves(container, instance)?),
        Structure::Lobes(LobeLattice { per_side: 1, .. }) => {
            Some(lobes::from_lobes(container, instance)?)
        }
        Structure::Lobes(_) => None,
        Structure::MipLobes(_) => Some(mip_lobes::from_sample(container, instance)?),
        Structure::NdfMaps(_) => ndf_maps::plain(container, instance)?,
        Structure::Surface { .. } => Some(surface::from_surface(container, instance)?),
    };
    let Instance {
        width,
        height,
        wrap,
        ..
    } = *instance;
    Ok(texels.map(|texels| NormalMap::new(width, height, wrap, texels)))
}

/// The means of level 0.
fn from_means(container: &Container<'_>, instance: &Instance) -> Result<Vec<[f32; 2]>, Finding> {
    let level = Pyramid::of_map(container, instance)?.level(0);
    let mut texels = Vec::with_capacity(instance.texel_count() as usize);
    for row in 0..instance.height {
        for column in 0..instance.width {
            texels.push(level.cell(column, row)?.mean.map(|mean| mean as f32));
        }
    }
    Ok(texels)
}

/// Exact normals, or normals of bins.
fn from_bins(
    container: &Container<'_>,
    instance: &Instance,
    grid: BinGrid,
) -> Result<Vec<[f32; 2]>, Finding> {
    let tables = BinTables::open(container, instance)?;
    let exact = exact_normals(container, instance)?;
    let mut texels = Vec::with_capacity(instance.texel_count() as usize);
    for row in 0..instance.height {
        for column in 0..instance.width {
            let bin = tables.bin_of_texel(column, row)?;
            let texel = match &exact {
                Some(exact) => {
                    let normal = exact.normal(column, row)?;
                    Some([normal.s as f32, normal.t as f32])
                }
                None => normal_of_bin(grid, bin),
            };
            texels.push(texel.ok_or(Finding::new(Fault::KeyRange).at(u64::from(bin)))?);
        }
    }
    Ok(texels)
}

/// The exact normals that `instance` itself, or another of its map, stores.
fn exact_normals<'a>(
    container: &Container<'a>,
    instance: &Instance,
) -> Result<Option<ExactNormals<'a>>, Finding> {
    for other in container.instances() {
        let other = other?;
        let is_of_map = (other.layer, other.method) == (instance.layer, instance.method)
            && (other.width, other.height) == (instance.width, instance.height);
        if is_of_map && let Some(normals) = ExactNormals::open(container, &other)? {
            return Ok(Some(normals));
        }
    }
    Ok(None)
}

/// A point of the disk, in f32, whose bin is number `bin`.
fn normal_of_bin(grid: BinGrid, bin: u32) -> Option<[f32; 2]> {
    let (column, row) = grid.column_row(bin);
    let middle = grid.normal_in_bin(column, row, 0.5, 0.5);
    let nearest_to_pole = |place: u32, inset: f64| {
        let side = f64::from(grid.resolution());
        let (low, high) = (f64::from(place), f64::from(place) + 1.0);
        (0.5 * side).clamp(low + inset, high - inset) - low
    };
    let candidates = INSETS.map(|inset| {
        grid.normal_in_bin(
            column,
            row,
            nearest_to_pole(column, inset),
            nearest_to_pole(row, inset),
        )
    });
    std::iter::once(middle)
        .chain(candidates)
        .find_map(|normal| {
            let texel = [normal.s as f32, normal.t as f32];
            let stored = HalfVector {
                s: f64::from(texel[0]),
                t: f64::from(texel[1]),
            };
            (stored.is_on_disk() && grid.bin_of(stored) == (column, row)).then_some(texel)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::model::{Binning, disk_grid_resolution};

    #[test]
    fn every_bin_that_holds_a_direction_gets_one_of_its_own() {
        for (binning, resolution) in [
            (Binning::DiskGrid, disk_grid_resolution(0.3)),
            (Binning::DiskGrid, disk_grid_resolution(0.03)),
            (Binning::EqualSolidAngle, 31),
        ] {
            let grid = BinGrid::new(binning, resolution).expect("in range");
            for step in 0..20_000_u32 {
                let (turn, height) = (0.1 * f64::from(step), f64::from(step % 997) / 997.0);
                let normal = HalfVector {
                    s: height * libm::cos(turn),
                    t: height * libm::sin(turn),
                };
                let (column, row) = grid.bin_of(normal);
                let found = normal_of_bin(grid, grid.number(column, row)).expect("it has one");
                let found = HalfVector {
                    s: f64::from(found[0]),
                    t: f64::from(found[1]),
                };
                assert_eq!(grid.bin_of(found), (column, row));
            }
        }
    }
}
