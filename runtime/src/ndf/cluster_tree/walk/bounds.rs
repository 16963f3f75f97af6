//! How far sums can be from those over texels: docs/cluster-tree.md, "Errors".

use super::Sink;
use super::open::leaf_bits;
use super::queue::{Leaf, Slot, texels_of};
use crate::ndf::cluster_tree::lanes::{self, Lanes, NormalBox, exponential, get, max, min};
use glintbake_format::model::TileShape;
use glintbake_format::records::{ClusterNode, LeafKind};

/// Adds to the error the children whose bit is set in `skipped` of a node of `slot` that has `count` bottom clusters from
/// `first`: a child's terms are e^-exponent at most.
pub(super) fn count_skipped<S: Sink>(
    sink: &mut S,
    slot: &Slot,
    first: u32,
    count: u32,
    exponents: &Lanes,
    skipped: u32,
) {
    for lane in 0..16 {
        let start = TileShape::child_cluster(first, count, lane);
        let end = TileShape::child_cluster(first, count, lane + 1);
        let texels = texels_of(slot, start, end);
        if skipped >> lane & 1 == 1 && texels > 0 {
            let most = exponential(-get(exponents, lane as usize));
            sink.error(1.00001 * most * texels as f32 * slot.copies);
        }
    }
}

/// The steepest slope of a unit Gaussian of peak 1 at points whose exponent is at least `exponent`: `d e^(-d²/2)`, greatest at
/// d = 1.
fn slope(exponent: f32) -> f32 {
    if exponent <= 0.5 {
        return 0.606_531;
    }
    let distance = 2.0 * exponent * lanes::inverse_root(2.0 * exponent);
    1.00001 * distance * exponential(-exponent)
}

/// The sides of `own`. Those of a node that lies may run backwards, and no error may be less than none.
fn sides(own: &NormalBox) -> [f32; 2] {
    own.extent().map(f32::abs)
}

/// How far the mean term of a cluster can be from that of the Gaussian of its stored moments, on the disk: docs/cluster-tree.md,
/// "Errors". At most 1, as terms are from 0 to 1.
pub(super) fn moment_error(own: &NormalBox, [ss, tt]: [f32; 2]) -> f32 {
    let [width, height] = sides(own);
    let diagonal = width + height;
    // Rounding of a deviation, by half a 510th of a side, of the correlation, by a 254th, and of the mean.
    let of = |variance: f32, side: f32| {
        let off = side * (1.0 / 1020.0);
        let deviation = variance * lanes::inverse_root(max(variance, 1e-30));
        (2.0 * deviation * off + off * off, deviation, off)
    };
    let (error_s, deviation_s, off_s) = of(ss, width);
    let (error_t, deviation_t, off_t) = of(tt, height);
    let product = (deviation_s + off_s) * (deviation_t + off_t);
    let error_st =
        deviation_s * off_t + deviation_t * off_s + off_s * off_t + product * (1.0 / 254.0);
    let trace = ss + tt + error_s + error_t;
    let root = trace * lanes::inverse_root(max(trace, 1e-30));
    // A cluster lies within its box, wherever its mean: the radius is the diagonal at most.
    let third = 0.2301 * trace * (diagonal + 1.6 * root);
    // The cluster's Gaussian reaches beyond its box, so that the steepest slope of all counts.
    let mean = slope(0.0) * diagonal * (1.0 / 510.0);
    min(
        third + mean + 0.5 * (error_s + error_t + 2.0 * error_st),
        1.0,
    )
}

/// How far the term of a texel of a leaf can be from that of its normal before it was rounded.
pub(super) fn leaf_error(leaf: &Leaf, node: &ClusterNode, least: f32) -> f32 {
    let lane = usize::from(leaf.lane);
    let most = leaf_bits(node, lane).most() as f32;
    let kind = node.deviation_xy.get(lane).copied().unwrap_or(0);
    let finer = match LeafKind::of(kind) {
        Some(LeafKind::Wide) => 16.0,
        // To 31 bits, which the slack for arithmetic covers.
        Some(LeafKind::Palette) => return 0.0,
        _ => 1.0,
    };
    let [width, height] = sides(&leaf.own);
    let off = 0.5 * (width + height) / (most * finer);
    rounding_error(off, least)
}

/// How far a term can be from that of a normal `off` away, if exponents are at least `least`: at most 1, as terms are from 0 to 1.
pub(super) fn rounding_error(off: f32, least: f32) -> f32 {
    let near = max(2.0 * least, 0.0);
    let distance = near * lanes::inverse_root(max(near, 1e-30));
    let inner = max(distance - off, 0.0);
    min(off * slope(0.5 * inner * inner), 1.0)
}
