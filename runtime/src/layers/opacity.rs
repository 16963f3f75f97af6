//! How much of the patch under a footprint a layer covers.

use crate::error::QueryError;
use crate::overlap::Placement;
use crate::pyramid::{Probes, for_each_cell};
use glintbake_format::model::{Filter, Footprint};
use glintbake_format::view::Opacity;

/// The average of `map` under `footprint`, weighed by `filter`, in [0, 1]: trilinear in the MIP map, with up to 15 probes along
/// the footprint where it is longer than wide (\[AWKK21\] §6: "a single channel mip map"). Continuous in the footprint. At most
/// 120 bytes are read.
///
/// Against the plain average of texels under boxes of one texel and more it is off by what a MIP map blurs: see
/// docs/materials.md for figures.
pub(super) fn average(
    map: &Opacity<'_>,
    footprint: &Footprint,
    filter: Filter,
) -> Result<f64, QueryError> {
    let levels = map.levels();
    let [width, height] = levels.map_size();
    let wrap = map.layout.wrap;
    let placement = Placement::new(footprint, width, height, wrap)?;
    let probes = Probes::new([placement.edge_1, placement.edge_2], filter, levels);
    let mut sum = 0.0;
    for (level, share) in probes.levels() {
        if share > 0.0 {
            let mut add = |column, row, weight: f64| {
                sum += weight * map.value(level, column, row)?;
                Ok(())
            };
            let size = levels.size(level);
            for_each_cell(
                &placement,
                &probes,
                [width, height],
                size,
                wrap,
                share,
                &mut add,
            )?;
        }
    }
    // Weights add up to 1 within rounding.
    Ok(sum.clamp(0.0, 1.0))
}
