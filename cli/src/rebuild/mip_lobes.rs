//! The surface that MIP lobes are of.

use glintbake_format::view::MipLobes;
use glintbake_format::{Container, Fault, Finding};
use glintbake_runtime::Instance;

/// The normal of every texel of the surface, by way of its quilt if it has one.
pub(super) fn from_sample(
    container: &Container<'_>,
    instance: &Instance,
) -> Result<Vec<[f32; 2]>, Finding> {
    let lobes = MipLobes::of_map(container, instance)?;
    let mut texels = Vec::with_capacity(instance.texel_count() as usize);
    for row in 0..instance.height {
        for column in 0..instance.width {
            let normal = lobes.normal(column, row);
            let normal = normal.ok_or(Finding::new(Fault::MipIndex).within(lobes.id))?;
            texels.push(normal.map(|component| component as f32));
        }
    }
    Ok(texels)
}
