//! What lies beyond the border of a clamped map: each texel of the border goes on without end.

use super::find;
use super::lobe::Lobe;
use super::region::Region;
use super::walk::{Sink, Walk};
use crate::error::QueryError;
use crate::overlap::{GaussianFootprint, Parallelogram, TexelBox};
use glintbake_format::view::ClusterTree;

/// Calls `visit` with each texel of the border whose endless part `bounds` reaches, and that part.
pub(super) fn for_each_border_texel(
    tree: &ClusterTree<'_>,
    bounds: &TexelBox,
    visit: &mut dyn FnMut([u32; 2], TexelBox) -> Result<(), QueryError>,
) -> Result<(), QueryError> {
    let [width, height] = tree.layout.map_size();
    let size = [f64::from(width), f64::from(height)];
    let TexelBox { low, high } = *bounds;
    // Casts saturate.
    let range = |low: f64, high: f64, size: u32| {
        let first = low.max(0.0) as u32;
        let last = if high > 0.0 { high as u32 + 1 } else { 0 };
        first.min(size)..last.min(size)
    };
    let endless = [f64::NEG_INFINITY, f64::INFINITY];
    let mut emit = |texel: [u32; 2], x: [f64; 2], y: [f64; 2]| {
        visit(
            texel,
            TexelBox {
                low: [x[0], y[0]],
                high: [x[1], y[1]],
            },
        )
    };
    let span = |cell: u32| [f64::from(cell), f64::from(cell) + 1.0];
    let sides_x = [
        (low[0] < 0.0, 0, [endless[0], 0.0]),
        (high[0] > size[0], width - 1, [size[0], endless[1]]),
    ];
    let sides_y = [
        (low[1] < 0.0, 0, [endless[0], 0.0]),
        (high[1] > size[1], height - 1, [size[1], endless[1]]),
    ];
    for (is_met, row, y) in sides_y {
        if is_met {
            for column in range(low[0], high[0], width) {
                emit([column, row], span(column), y)?;
            }
        }
    }
    for (is_met, column, x) in sides_x {
        if is_met {
            for row in range(low[1], high[1], height) {
                emit([column, row], x, span(row))?;
            }
            for (is_also_met, row, y) in sides_y {
                if is_also_met {
                    emit([column, row], x, y)?;
                }
            }
        }
    }
    Ok(())
}

/// Hands `walk` what of `footprint` lies beyond the border.
pub(super) fn under_box<R: Region, L: Lobe, S: Sink>(
    tree: &ClusterTree<'_>,
    footprint: &Parallelogram,
    walk: &mut Walk<'_, R, L, S>,
) -> Result<(), QueryError> {
    for_each_border_texel(tree, &footprint.bounds(), &mut |texel, part| {
        let weight = footprint.weight(&part);
        if weight > 0.0 {
            walk.exact(&find::normal(tree, texel[0], texel[1])?, weight);
        }
        Ok(())
    })
}

/// Hands `walk` what of the Gaussian lies beyond the border.
pub(super) fn under_gaussian<R: Region, L: Lobe, S: Sink>(
    tree: &ClusterTree<'_>,
    footprint: &GaussianFootprint,
    walk: &mut Walk<'_, R, L, S>,
) -> Result<(), QueryError> {
    let rectangles = footprint.rectangles();
    for_each_border_texel(tree, &footprint.bounds(), &mut |texel, part| {
        let [low, high] = [part.low, part.high].map(|[x, y]| footprint.centred(x, y));
        let weight = rectangles.share([low[0], high[0]], [low[1], high[1]]);
        if weight > 0.0 {
            walk.exact(&find::normal(tree, texel[0], texel[1])?, weight);
        }
        Ok(())
    })
}
