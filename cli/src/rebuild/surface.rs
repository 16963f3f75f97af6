//! A normal map from a surface.

use glintbake_format::view::Normals;
use glintbake_format::{Container, Finding};
use glintbake_runtime::Instance;

/// The normals at the middles of texels, which are the map's own.
pub(super) fn from_surface(
    container: &Container<'_>,
    instance: &Instance,
) -> Result<Vec<[f32; 2]>, Finding> {
    let normals = Normals::of_map(container, instance)?;
    let texels = normals.normals.iter();
    Ok(texels
        .map(|normal| normal.point().map(|component| component as f32))
        .collect())
}
