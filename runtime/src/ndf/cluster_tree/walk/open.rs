//! Looking at the children of a node, and at the texels of a leaf.
#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use super::bounds::{count_skipped, leaf_error, moment_error};
use super::queue::{Leaf, Node, existing, most_texels, texels_of};
use super::{Centre, Sink, Walk, child_number, fetch_node, height};
use crate::error::QueryError;
use crate::ndf::cluster_tree::lanes::{
    self, BITS, Frame, LANES, LEAST_TERM, Lanes, Moments, Normals, Place, Spread, Texels,
    exponential, get, max,
};
use crate::ndf::cluster_tree::lobe::Lobe;
use crate::ndf::cluster_tree::region::Region;
use crate::simd::fetch;
use glintbake_format::model::TileShape;
use glintbake_format::records::{ClusterNode, FineBits, LeafBits, LeafKind};
use glintbake_format::view::ClusterTree;

impl<R: Region, L: Lobe, S: Sink> Walk<'_, R, L, S> {
    /// Looks at the children of `node`.
    #[inline(always)]
    pub(super) fn open(&mut self, node: Node) -> Result<(), QueryError> {
        let tree = self.tree;
        let Some(slot) = self.slots.get(usize::from(node.slot)) else {
            return Ok(());
        };
        let record = tree.node(u64::from(node.place))?;
        let limits = self.limits;
        let Normals {
            distances,
            mut alive,
            narrow,
        } = lanes::normals(record, node.own, self.lobe, limits);
        let (first, count) = (u32::from(node.first), u32::from(node.count));
        if slot.even == 0 {
            alive &= existing(first, count);
        }
        if S::STRICT {
            count_skipped(&mut self.sink, slot, first, count, &distances, !alive);
        }
        if alive == 0 {
            return Ok(());
        }
        let frame = Frame {
            offset: slot.origin.offset,
            unit: slot.unit,
        };
        let is_bottom = slot.shape.depth() <= height(u32::from(node.number)) + 1;
        let always = is_bottom && !slot.has_leaves;
        let mut inside = 0xFFFF;
        if !node.inside {
            let region = self.region;
            let mut meets = 0;
            inside = 0;
            for lane in 0..LANES {
                let place = Place::of(record, lane, frame);
                let [misses, cuts] = region.relation(place, distances[lane], limits.exponent);
                meets |= if misses <= 0.0 { BITS[lane] } else { 0 };
                inside |= if cuts <= 0.0 { BITS[lane] } else { 0 };
            }
            if S::STRICT && R::HAS_TAIL {
                // Position and normal together are beyond the limit.
                let limit = [limits.exponent; LANES];
                count_skipped(&mut self.sink, slot, first, count, &limit, alive & !meets);
            }
            alive &= meets;
            if alive == 0 {
                return Ok(());
            }
        }
        let may_be_one = alive & narrow;
        let mut weights = [1.0; LANES];
        let mut one = may_be_one & inside;
        if may_be_one & !inside != 0 && most_texels(slot, count) <= self.region.most_blurred() {
            let region = self.region;
            let mut even = 0;
            for lane in 0..LANES {
                let place = Place::of(record, lane, frame);
                let spread = Spread::of(record, lane, place);
                let [weight, excess] = region.cluster_weight(place, spread, distances[lane]);
                let is_inside = inside & BITS[lane] != 0;
                weights[lane] = if is_inside { 1.0 } else { weight };
                even |= if is_inside | always | (excess <= 0.0) {
                    BITS[lane]
                } else {
                    0
                };
            }
            one = may_be_one & even;
        }
        if one != 0 {
            self.add_clusters(node, record, &distances, &weights, one, inside);
        }
        // A tile without leaves was asked before whether it serves.
        let mut rest = if always { 0 } else { alive & !one };
        let Some(slot) = self.slots.get(usize::from(node.slot)) else {
            return Ok(());
        };
        while rest != 0 {
            let lane = rest.trailing_zeros();
            rest &= rest - 1;
            let own = node.own.child(record, lane as usize);
            let start = TileShape::child_cluster(first, count, lane);
            let end = TileShape::child_cluster(first, count, lane + 1);
            let inside = inside >> lane & 1 == 1;
            if is_bottom {
                let leaf = slot.first_leaf.wrapping_add(start);
                if let Some(record) = tree.leaves.get(leaf as usize) {
                    fetch(record);
                }
                if let Some(fine) = fine_bits(tree, node.place, record, lane) {
                    fetch(fine);
                }
                self.leaves.push(Leaf {
                    own,
                    leaf,
                    node: node.place,
                    texels: texels_of(slot, start, end) as u8,
                    lane: lane as u8,
                    slot: node.slot,
                    inside,
                });
            } else {
                let number = child_number(u32::from(node.number), lane);
                let place = slot.first_node.wrapping_add(number);
                fetch_node(tree, place);
                self.nodes.push(Node {
                    own,
                    place,
                    first: start as u16,
                    count: (end - start) as u16,
                    number: number as u16,
                    slot: node.slot,
                    inside,
                });
            }
        }
        Ok(())
    }

    /// Adds those children of `node` whose bit is set in `wanted` as one Gaussian each.
    #[inline(always)]
    fn add_clusters(
        &mut self,
        node: Node,
        record: &ClusterNode,
        distances: &Lanes,
        weights: &Lanes,
        wanted: u32,
        inside: u32,
    ) {
        let Some(slot) = self.slots.get(usize::from(node.slot)) else {
            return;
        };
        let (first, count) = (u32::from(node.first), u32::from(node.count));
        let mut counts = [slot.copies * (slot.even * count.div_ceil(16)) as f32; LANES];
        if slot.even == 0 {
            for (lane, texels) in (0..).zip(&mut counts) {
                let start = TileShape::child_cluster(first, count, lane);
                let end = TileShape::child_cluster(first, count, lane + 1);
                *texels = slot.copies * texels_of(slot, start, end) as f32;
            }
        }
        let lobe = self.lobe;
        let [mut terms, mut shares, mut mean_s, mut mean_t] = [[0.0; LANES]; 4];
        for lane in 0..LANES {
            let moments = Moments::of(record, lane, node.own);
            let chart = lobe.chart(moments.mean, moments.covariance);
            let is_taken = wanted & BITS[lane] != 0;
            let share = counts[lane] * weights[lane];
            shares[lane] = if is_taken { share } else { 0.0 };
            // A child that does not count may have any term, even none that is a number.
            let term = share * chart.term();
            terms[lane] = if is_taken { term } else { 0.0 };
            mean_s[lane] = moments.mean[0];
            mean_t[lane] = moments.mean[1];
        }
        if S::STRICT {
            let frame = Frame {
                offset: slot.origin.offset,
                unit: slot.unit,
            };
            for lane in 0..LANES {
                if wanted >> lane & 1 == 0 {
                    continue;
                }
                let weight = get(weights, lane);
                let of_weight = if inside >> lane & 1 == 1 {
                    0.0
                } else {
                    let place = Place::of(record, lane, frame);
                    self.region.weight_error(place, weight) * exponential(-get(distances, lane))
                };
                let own = node.own.child(record, lane);
                let [ss, _, tt] = Moments::of(record, lane, node.own).covariance;
                let of_moments = max(weight, 0.0) * moment_error(&own, [ss, tt]);
                self.sink
                    .error(get(&counts, lane) * (of_weight + of_moments));
            }
        }
        self.sink.terms(&terms, &shares, &mean_s, &mean_t);
    }

    /// Adds the texels of a leaf.
    #[inline(always)]
    pub(super) fn sum_leaf(&mut self, leaf: &Leaf) -> Result<(), QueryError> {
        let tree = self.tree;
        let record = tree.leaves.get(leaf.leaf as usize).ok_or(tree.damaged())?;
        let node = tree.node(u64::from(leaf.node))?;
        let lane = usize::from(leaf.lane);
        let byte = |bytes: &[u8; LANES]| bytes.get(lane).copied().unwrap_or(0);
        let mut first = [byte(&node.low_x), byte(&node.low_y)];
        let bits = leaf_bits(node, lane);
        let (count, limit) = (u32::from(leaf.texels), self.limits.exponent);
        let mut texels = Texels::NONE;
        // On the disk distances are no greater than in any chart: what is too far there need not be looked at further.
        let near = match LeafKind::of(byte(&node.deviation_xy)) {
            Some(LeafKind::Narrow) => texels.read_narrow(record, bits, leaf.own, count, limit),
            Some(LeafKind::Palette) => {
                let Centre { point, scale } = self.centre;
                first = [0; 2];
                texels.read_palette(record, point, scale, count, limit)
            }
            Some(LeafKind::Wide) => {
                let fine =
                    fine_bits(tree, leaf.node, node, u32::from(leaf.lane)).ok_or(tree.damaged())?;
                texels.read_wide(record, fine, bits, leaf.own, count, limit)
            }
            None => return Err(tree.damaged().into()),
        };
        let Some(slot) = self.slots.get(usize::from(leaf.slot)) else {
            return Ok(());
        };
        if S::STRICT {
            let least = lanes::least(&texels.distances);
            let skipped = if least > limit {
                exponential(-least)
            } else {
                leaf_error(leaf, node, least)
            };
            self.sink
                .error(1.00001 * count as f32 * slot.copies * skipped);
        }
        if near == 0 {
            return Ok(());
        }
        let mut weights = [slot.copies; LANES];
        if !leaf.inside {
            let region = self.region;
            region.weights(&texels, &slot.origin, first, count, &mut weights);
        }
        let lobe = self.lobe;
        let mut terms = [0.0; LANES];
        for lane in 0..LANES {
            let [exponent, factor] = lobe.exponent(texels.s[lane], texels.t[lane]);
            let value = factor * weights[lane] * exponential(-exponent);
            let far = max(exponent, texels.distances[lane]);
            terms[lane] = if far <= LEAST_TERM { value } else { 0.0 };
        }
        self.sink.terms(&terms, &weights, &texels.s, &texels.t);
        Ok(())
    }
}

/// The finer bits of the wide leaf that is child `lane` of `node`, which is at `place`.
#[inline(always)]
fn fine_bits<'a>(
    tree: &ClusterTree<'a>,
    place: u32,
    node: &ClusterNode,
    lane: u32,
) -> Option<&'a FineBits> {
    let start = tree.fine_starts.get(place as usize)?.get() as usize;
    let mut wide = 0;
    for lane in 0..LANES {
        let is_wide = node.deviation_xy[lane] >> 6 == LeafKind::Wide as u8;
        wide |= if is_wide { BITS[lane] } else { 0 };
    }
    let before = (wide & lanes::first_bits(lane)).count_ones() as usize;
    tree.fine.get(start.checked_add(before)?)
}

/// How the leaf that is child `lane` of `node` shares its bits out.
#[inline(always)]
pub(super) fn leaf_bits(node: &ClusterNode, lane: usize) -> LeafBits {
    let byte = |bytes: &[u8; LANES]| bytes.get(lane).copied().unwrap_or(0);
    LeafBits::new(
        byte(&node.high_x).wrapping_sub(byte(&node.low_x)),
        byte(&node.high_y).wrapping_sub(byte(&node.low_y)),
    )
}
