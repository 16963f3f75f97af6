//! What a Gaussian weighs beyond the border of a clamped map, whose border texels have no end.

use crate::error::QueryError;
use crate::overlap::{GaussianFootprint, TexelBox};
use crate::scan::MapShape;
use core::ops::Range;
use glintbake_format::model::Wrap;

/// Calls `visit(column, row, weight)` for the texels of the border of a clamped map, with the weight of what they stand
/// for beyond it; corners more than once. Nothing if the map repeats, or holds the footprint.
pub(super) fn for_each_texel(
    shape: MapShape,
    footprint: &GaussianFootprint,
    visit: &mut impl FnMut(u32, u32, f64) -> Result<(), QueryError>,
) -> Result<(), QueryError> {
    let TexelBox { low, high } = footprint.bounds();
    let (width, height) = (f64::from(shape.width), f64::from(shape.height));
    let beyond = [
        low[0] < 0.0,
        high[0] > width,
        low[1] < 0.0,
        high[1] > height,
    ];
    if shape.wrap == Wrap::Repeat || !beyond.contains(&true) {
        return Ok(());
    }
    let [left, right, above, below] = beyond;
    let rectangles = footprint.rectangles();
    // All but what is cut off is weighed, as of thin Gaussians.
    let mut weigh = |texel: [u32; 2], low: [f64; 2], high: [f64; 2]| {
        let [low, high] = [low, high].map(|[x, y]| footprint.centred(x, y));
        let weight = rectangles.share([low[0], high[0]], [low[1], high[1]]);
        if weight > 0.0 {
            visit(texel[0], texel[1], weight)?;
        }
        Ok::<_, QueryError>(())
    };
    let ends = |cell: u32, size: u32| {
        [
            if cell == 0 {
                f64::NEG_INFINITY
            } else {
                f64::from(cell)
            },
            if cell + 1 == size {
                f64::INFINITY
            } else {
                f64::from(cell) + 1.0
            },
        ]
    };
    // To the left and right all the way up and down, above and below over the map alone.
    for row in met(low[1], high[1], shape.height) {
        let [top, bottom] = ends(row, shape.height);
        if left {
            weigh([0, row], [f64::NEG_INFINITY, top], [0.0, bottom])?;
        }
        if right {
            weigh(
                [shape.width - 1, row],
                [width, top],
                [f64::INFINITY, bottom],
            )?;
        }
    }
    if above || below {
        for column in met(low[0], high[0], shape.width) {
            let (start, end) = (f64::from(column), f64::from(column) + 1.0);
            if above {
                weigh([column, 0], [start, f64::NEG_INFINITY], [end, 0.0])?;
            }
            if below {
                weigh(
                    [column, shape.height - 1],
                    [start, height],
                    [end, f64::INFINITY],
                )?;
            }
        }
    }
    Ok(())
}

/// The cells of `size` in a row that hold what lies from `low` to `high`, beyond the border by the last of them.
fn met(low: f64, high: f64, size: u32) -> Range<u32> {
    let last = f64::from(size) - 1.0;
    libm::floor(low).clamp(0.0, last) as u32..libm::floor(high).clamp(0.0, last) as u32 + 1
}
