//! Footprints without area: a segment, or a point.

use super::texel_axis::TexelAxis;
use std::collections::BTreeMap;

/// Weight of each texel by (row, column) under a footprint whose edges are parallel, or vanish.
///
/// The image of a uniform (a, b) is then a segment with a trapezoid of density along it: `a edge_1` and `b edge_2`
/// are two independent uniform steps along the same line. With one edge zero the density is uniform, with both
/// zero the texel at the centre takes everything. A segment along a texel border belongs to the texels that the
/// border begins.
///
/// Edges that are only nearly parallel are turned onto their common line, see [`super::box_weights`] for the error.
pub(super) fn segment_weights(
    horizontal: &TexelAxis,
    vertical: &TexelAxis,
) -> BTreeMap<(u32, u32), f64> {
    let axes = [horizontal, vertical];
    let along = axes.map(|axis| axis.edges().map(|edge| edge.value()));
    let extents = axes.map(TexelAxis::extent);

    // Share of the segment that each edge spans: per axis its part of the extent, the same on both for parallel
    // edges. An axis without extent has no say.
    let shares: Vec<f64> = (0..2)
        .filter(|&axis| extents[axis] > 0.0)
        .map(|axis| along[axis][0].abs() / extents[axis])
        .collect();
    let first_share = match shares.len() {
        0 => 1.0,
        count => shares.iter().sum::<f64>() / count as f64,
    };
    let longer = usize::from(first_share < 0.5);
    let direction = [0, 1].map(|axis| extents[axis] * along[axis][longer].signum());
    let shorter_share = first_share.min(1.0 - first_share);

    // The segment is `x direction` for x in [-1/2, 1/2]; cut it wherever it crosses a texel border.
    let mut cuts = vec![-0.5, 0.5];
    for (axis, length) in axes.into_iter().zip(direction) {
        if length == 0.0 {
            continue;
        }
        let half = 0.5 * length.abs();
        let crossings = axis
            .texels_between(-half, half)
            .map(|k| axis.border(k).value() / length);
        cuts.extend(crossings.filter(|x| x.abs() < 0.5));
    }
    cuts.sort_unstable_by(f64::total_cmp);

    let mut weights = BTreeMap::new();
    for piece in cuts.windows(2) {
        let weight =
            trapezoid_below(piece[1], shorter_share) - trapezoid_below(piece[0], shorter_share);
        if weight > 0.0 {
            let middle = 0.5 * (piece[0] + piece[1]);
            let column = horizontal.texel_at(middle * direction[0]);
            let row = vertical.texel_at(middle * direction[1]);
            *weights
                .entry((vertical.fold(row), horizontal.fold(column)))
                .or_insert(0.0) += weight;
        }
    }
    weights
}

/// Probability that a step uniform over `1 - shorter` plus one uniform over `shorter` ends below x.
///
/// Both steps are centred at 0, `shorter` is in [0, 1/2], x in [-1/2, 1/2].
pub(super) fn trapezoid_below(x: f64, shorter: f64) -> f64 {
    if x > 0.0 {
        return 1.0 - trapezoid_below(-x, shorter);
    }
    let longer = 1.0 - shorter;
    let from_end = x + 0.5;
    if from_end < shorter {
        // On the ramp the density rises from 0 to 1 / longer within `shorter`.
        0.5 * from_end / longer * (from_end / shorter)
    } else {
        (from_end - 0.5 * shorter) / longer
    }
}
