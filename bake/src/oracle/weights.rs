//! Texel weights of a box footprint, by clipping it against every texel.

use super::double_double::DoubleDouble;
use super::gaussian::gaussian_weights;
use super::polygon::Polygon;
use super::segment::segment_weights;
use super::texel_axis::TexelAxis;
use crate::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint};

/// The widest shadow of a footprint on either axis, in tiles, that [`box_weights`] accepts.
///
/// The oracle visits every texel of every tile covered; twice the sum of the longest edges that a query accepts.
pub const MAX_SPAN_TILES: f64 = 1024.0;

/// Share of the area of its bounding rectangle below which a footprint is taken as a segment.
///
/// At this ratio both ways are right to about 1e-14: clipping loses digits like 1e-31 / ratio, the segment moves
/// every point by at most the ratio times the footprint's extent.
const SEGMENT_RATIO: f64 = 1e-16;

/// A texel of the map and the part of a footprint's weight that lies on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelWeight {
    /// Column of the texel.
    pub column: u32,
    /// Row of the texel, from the top.
    pub row: u32,
    /// `w_k`, in (0, 1]: `|A ∩ T_k| / |A|` of a box footprint, `∫_{T_k} G` of a Gaussian one.
    pub weight: f64,
}

/// Every texel under `footprint` as `filter` weighs it: [`box_weights`] or [`gaussian_weights`].
///
/// # Panics
/// As the two.
pub fn texel_weights(map: &NormalMap, footprint: &Footprint, filter: Filter) -> Vec<TexelWeight> {
    match filter {
        Filter::Box => box_weights(map, footprint),
        Filter::Gaussian => gaussian_weights(map, footprint),
    }
}

/// Every texel under `footprint` with its weight `w_k = |A ∩ T_k| / |A|`: each once, row-major, summing to 1.
///
/// \[AWKK21\] eq. 12, for the parallelogram of the footprint on the map as its wrap mode continues it; the weights
/// of all copies of a texel are added. Vanishing or parallel edges give the image of a uniform (a, b): a
/// trapezoid of density along a segment, or the texel at the centre, borders belonging to the texel to their right
/// or below. Texels without weight are left out.
///
/// # Accuracy
/// Each weight is within 1e-13 for every footprint: from points to [`MAX_SPAN_TILES`], any anisotropy, any finite
/// centre. The area is clipped with 106-bit numbers relative to the centre, and weights do not change when either
/// axis is stretched, so only the area's share of its bounding rectangle matters: the error is near 1e-31 / share
/// down to a share of 1e-16, below it the footprint is turned into a segment, which moves weights by at most 8
/// times the share. Components below 1e-100 texel count as zero.
///
/// # Cost
/// Proportional to the texels covered, all copies counted.
///
/// # Panics
/// If a number of the footprint is not finite, the map is empty, or the footprint's shadow on an axis exceeds
/// [`MAX_SPAN_TILES`].
pub fn box_weights(map: &NormalMap, footprint: &Footprint) -> Vec<TexelWeight> {
    let Footprint {
        centre,
        edge_1,
        edge_2,
    } = *footprint;
    assert!(
        map.width() > 0 && map.height() > 0,
        "an empty map has no weights"
    );
    for axis in 0..2 {
        let span = edge_1[axis].abs() + edge_2[axis].abs();
        assert!(
            centre[axis].is_finite() && span <= MAX_SPAN_TILES,
            "a footprint must be finite and span at most {MAX_SPAN_TILES} tiles"
        );
    }
    let axis = |i: usize, size| TexelAxis::new(centre[i], [edge_1[i], edge_2[i]], size, map.wrap());
    let (horizontal, vertical) = (axis(0, map.width()), axis(1, map.height()));

    let ([x_1, x_2], [y_1, y_2]) = (horizontal.edges(), vertical.edges());
    let area = (x_1 * y_2 - y_1 * x_2).abs();
    if area.value() <= SEGMENT_RATIO * horizontal.extent() * vertical.extent() {
        return segment_weights(&horizontal, &vertical)
            .into_iter()
            .map(|((row, column), weight)| TexelWeight {
                column,
                row,
                weight,
            })
            .collect();
    }
    let outline = Polygon::parallelogram([x_1, y_1], [x_2, y_2]);
    polygon_weights(&outline, area, &horizontal, &vertical, map.width())
}

/// The areas of `outline` on each texel, divided by `area`.
fn polygon_weights(
    outline: &Polygon,
    area: DoubleDouble,
    horizontal: &TexelAxis,
    vertical: &TexelAxis,
    width: u32,
) -> Vec<TexelWeight> {
    let half_height = 0.5 * vertical.extent();
    let mut rows: Vec<(u32, i64)> = vertical
        .texels_between(-half_height, half_height)
        .map(|k| (vertical.fold(k), k))
        .collect();
    rows.sort_unstable();

    let mut weights = Vec::new();
    let mut sums = RowSums::new(width);
    for copies in rows.chunk_by(|a, b| a.0 == b.0) {
        for &(_, k) in copies {
            add_row(outline, k, horizontal, vertical, &mut sums);
        }
        let row = copies[0].0;
        sums.drain(|column, sum| {
            let weight = (sum / area).value();
            weights.push(TexelWeight {
                column,
                row,
                weight,
            });
        });
    }
    weights
}

/// Adds the areas of `outline` on the texels of row `k` of the endless map.
fn add_row(
    outline: &Polygon,
    k: i64,
    horizontal: &TexelAxis,
    vertical: &TexelAxis,
    sums: &mut RowSums,
) {
    let (top, bottom) = (vertical.lower(k), vertical.upper(k));
    let strip = outline.strip(1, top, bottom);
    let Some((left, right)) = strip.range(0) else {
        return;
    };
    // A convex outline holds a whole texel exactly if it holds the texel's top and bottom sides.
    let side = |place: Option<DoubleDouble>| strip.side_at(1, place?);
    let whole = side(top).zip(side(bottom)).map(|(upper, lower)| {
        let from = if upper.0 > lower.0 { upper.0 } else { lower.0 };
        let to = if upper.1 < lower.1 { upper.1 } else { lower.1 };
        (from, to)
    });
    for column in horizontal.texels_between(left.value(), right.value()) {
        let (start, end) = (horizontal.lower(column), horizontal.upper(column));
        let is_whole = match (whole, start, end) {
            (Some((from, to)), Some(start), Some(end)) => from <= start && end <= to,
            _ => false,
        };
        let covered = if is_whole {
            DoubleDouble::from(1.0)
        } else {
            strip.strip(0, start, end).area()
        };
        sums.add(horizontal.fold(column), covered);
    }
}

/// Sum of each column of one row of the map: covered area, or weight.
pub(super) struct RowSums {
    sums: Vec<DoubleDouble>,
    touched: Vec<u32>,
}

impl RowSums {
    pub(super) fn new(width: u32) -> Self {
        Self {
            sums: vec![DoubleDouble::ZERO; width as usize],
            touched: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, column: u32, addend: DoubleDouble) {
        if addend == DoubleDouble::ZERO {
            return;
        }
        let sum = &mut self.sums[column as usize];
        if *sum == DoubleDouble::ZERO {
            self.touched.push(column);
        }
        *sum = *sum + addend;
    }

    /// Hands out the non-zero columns in order, and starts over.
    pub(super) fn drain(&mut self, mut take: impl FnMut(u32, DoubleDouble)) {
        self.touched.sort_unstable();
        for column in self.touched.drain(..) {
            take(column, core::mem::take(&mut self.sums[column as usize]));
        }
    }
}
