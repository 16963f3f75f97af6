//! A normal map from lobes.

use glintbake_format::view::Lobes;
use glintbake_format::{Container, Fault, Finding};
use glintbake_runtime::Instance;

/// The normals of lobes, one a texel.
pub(super) fn from_lobes(
    container: &Container<'_>,
    instance: &Instance,
) -> Result<Vec<[f32; 2]>, Finding> {
    let lobes = Lobes::of_map(container, instance)?;
    let mut texels = Vec::with_capacity(instance.texel_count() as usize);
    for row in 0..instance.height {
        for column in 0..instance.width {
            let missing = || Finding::new(Fault::PyramidBox).within(lobes.pyramid.id);
            let (place, child, bounds) =
                lobes.pyramid.block_at(column, row)?.ok_or_else(missing)?;
            let number = 4 * (row % 4) + column % 4;
            let lobe = lobes.lobe(place, child, number, &bounds)?;
            texels.push(lobe.normal.map(|component| component as f32));
        }
    }
    Ok(texels)
}
