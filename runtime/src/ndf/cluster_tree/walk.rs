//! Walking the trees of some tiles: each child is skipped, accepted as one Gaussian, or opened.
//!
//! Breadth first: all nodes of one depth are looked at before those below them, whose memory is asked for as they are found. What
//! a query waits for is memory, and this way it waits for many nodes at once. Queues are of fixed size; a full one is worked
//! off before more is added.

use super::lanes::{self, Child, Lanes, Texels, child, exponential, get, set_from};
use super::lobe::Lobe;
use super::region::{Origin, Region};
use crate::error::QueryError;
use core::hint::black_box;
use glintbake_format::Finding;
use glintbake_format::model::{ClusterTile, TileShape};
use glintbake_format::records::{LeafBits, LeafKind};
use glintbake_format::view::ClusterTree;

/// Tiles walked together.
const TILES: usize = 16;
/// Nodes or leaves that wait at one depth.
const QUEUE: usize = 32;
/// Places that must be free for the children of one node.
const ROOM: usize = QUEUE - 16;

/// How much a walk may leave out or approximate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    /// Terms of e^-this and less are skipped.
    pub exponent: f32,
    /// Clusters whose greatest variance is at most this, in units of σr², may be accepted.
    pub variance: f32,
    /// Of these, those whose variance times the square of half the box's longer side is at most this: heavy tails, which a
    /// Gaussian does not have, need a box that is wide for its variance.
    pub tail: f32,
}

/// What terms go to. Terms are shares of the kernel's peak times weights; `weights` those alone.
pub(super) trait Sink {
    /// Whether errors are added up.
    const STRICT: bool = false;

    /// Up to `bound` more of the sum, in the unit of weights, is missing or too much.
    fn error(&mut self, bound: f32) {
        let _ = bound;
    }

    /// Weights given from now on are in this unit, but those of [`exact`](Self::exact).
    fn unit(&mut self, unit: f64);

    /// Texels at `texels`, and what they weigh; those without term have a term of 0.
    fn texels(&mut self, terms: &Lanes, weights: &Lanes, texels: &Texels);

    /// A cluster of weight `weight`, of mean normal `mean`.
    fn cluster(&mut self, term: f32, weight: f32, mean: [f32; 2]);

    /// A texel of weight `weight`, its normal `offset` from the half vector in units of σr.
    fn exact(&mut self, term: f64, weight: f64, offset: [f64; 2]);

    /// Called now and then, so that sums in single precision stay short.
    fn flush(&mut self);
}

/// A tile to walk.
#[derive(Clone, Copy, Debug)]
struct Slot {
    shape: TileShape,
    first_node: u32,
    first_leaf: u32,
    origin: Origin,
    /// Texels to a unit of positions.
    unit: f32,
    /// Texels of a bottom cluster, if all have as many; else 0.
    even: u32,
    /// How often the tile counts.
    copies: f32,
    has_leaves: bool,
}

/// A node to open.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    /// Number in its tile.
    number: u32,
    slot: u32,
    /// First bottom cluster, and number of them.
    first: u32,
    count: u32,
    low: [f32; 2],
    step: [f32; 2],
    depth: u32,
    inside: bool,
}

/// A leaf to sum up.
#[derive(Clone, Copy, Debug, Default)]
struct Leaf {
    leaf: u32,
    slot: u32,
    /// Place of its node, and its number among the children there.
    node: u32,
    lane: u32,
    texels: u32,
    low: [f32; 2],
    extent: [f32; 2],
    first: [u8; 2],
    more: [u8; 2],
    kind: u8,
    inside: bool,
}

/// A queue of fixed size.
#[derive(Clone, Debug)]
struct Queue<T> {
    items: [T; QUEUE],
    count: usize,
}

impl<T: Copy + Default> Queue<T> {
    fn new() -> Self {
        Self {
            items: [T::default(); QUEUE],
            count: 0,
        }
    }

    #[inline(always)]
    fn push(&mut self, item: T) {
        if let Some(slot) = self.items.get_mut(self.count) {
            *slot = item;
            self.count += 1;
        }
    }

    #[inline(always)]
    fn get(&self, place: usize) -> Option<&T> {
        self.items.get(..self.count)?.get(place)
    }
}

/// The half vector and the kernel's width.
#[derive(Clone, Copy, Debug)]
pub(super) struct Centre {
    /// The half vector on the disk.
    pub point: [f64; 2],
    /// 1 / σr.
    pub scale: f64,
}

/// A walk over tiles.
pub(super) struct Walk<'a, 'w, R, L, S> {
    tree: &'a ClusterTree<'a>,
    region: &'w R,
    lobe: L,
    centre: Centre,
    limits: Limits,
    pub sink: S,
    slots: [Slot; TILES],
    slot_count: usize,
    /// Nodes by their height above the tile's root.
    nodes: [Queue<Node>; 3],
    leaves: Queue<Leaf>,
}

impl<'a, 'w, R: Region, L: Lobe, S: Sink> Walk<'a, 'w, R, L, S> {
    #[inline(always)]
    pub fn new(
        tree: &'a ClusterTree<'a>,
        region: &'w R,
        lobe: L,
        centre: Centre,
        limits: Limits,
        sink: S,
    ) -> Self {
        let slot = Slot {
            shape: TileShape {
                texels: 1,
                clusters: 1,
            },
            first_node: 0,
            first_leaf: 0,
            origin: Origin {
                texel: [0; 2],
                offset: [0.0; 2],
            },
            unit: 1.0,
            even: 0,
            copies: 0.0,
            has_leaves: false,
        };
        Self {
            tree,
            region,
            lobe,
            centre,
            limits,
            sink,
            slots: [slot; TILES],
            slot_count: 0,
            nodes: [Queue::new(), Queue::new(), Queue::new()],
            leaves: Queue::new(),
        }
    }

    /// Weights from now on are in this unit.
    pub fn set_unit(&mut self, unit: f64) {
        self.sink.unit(unit);
    }

    /// Adds a texel of the normal `normal` and weight `weight`, in no unit.
    pub fn exact(&mut self, normal: [f64; 2], weight: f64) {
        let Centre { point, scale } = self.centre;
        let offset = [
            (normal[0] - point[0]) * scale,
            (normal[1] - point[1]) * scale,
        ];
        let [s, t] = offset.map(|x| x as f32);
        let (exponents, factors) = self.lobe.exponents(&[s; lanes::LANES], &[t; lanes::LANES]);
        let term = f64::from(get(&factors, 0)) * f64::from(exponential(-get(&exponents, 0)));
        if get(&exponents, 0) <= LEAST_TERM {
            self.sink.exact(term * weight, weight, offset);
        }
    }

    /// Adds `tile`, at `origin`, of positions in `unit` texels; `copies` times, if it is `inside`.
    #[inline(always)]
    pub fn tile(
        &mut self,
        tile: &ClusterTile,
        origin: Origin,
        unit: u32,
        inside: bool,
        copies: f32,
        has_leaves: bool,
    ) -> Result<(), QueryError> {
        if self.slot_count == TILES {
            self.run()?;
        }
        let root = self.tree.root(tile)?;
        if let Some(slot) = self.slots.get_mut(self.slot_count) {
            *slot = Slot {
                shape: tile.shape,
                first_node: tile.first_node as u32,
                first_leaf: tile.first_leaf as u32,
                origin,
                unit: unit as f32,
                even: if tile.shape.is_even() {
                    tile.shape.texels / tile.shape.clusters
                } else {
                    0
                },
                copies,
                has_leaves,
            };
        }
        let Centre { point, scale } = self.centre;
        let low = [
            ((f64::from(root.low[0].get()) - point[0]) * scale) as f32,
            ((f64::from(root.low[1].get()) - point[1]) * scale) as f32,
        ];
        let step = root.step.map(|step| (f64::from(step.get()) * scale) as f32);
        let node = Node {
            number: 0,
            slot: self.slot_count as u32,
            first: 0,
            count: tile.shape.clusters,
            low,
            step,
            depth: tile.shape.depth(),
            inside,
        };
        self.fetch_node(tile.first_node as u32);
        let [first, ..] = &mut self.nodes;
        first.push(node);
        self.slot_count += 1;
        Ok(())
    }

    /// Asks memory for the four lines of a node.
    #[inline(always)]
    fn fetch_node(&self, place: u32) {
        if let Some(node) = self.tree.nodes.get(place as usize) {
            let [a, ..] = node.low_s;
            let [b, ..] = node.mean_s;
            let [c, ..] = node.correlation;
            let [d, ..] = node.high_y;
            black_box((a, b, c, d));
        }
    }

    /// Walks all tiles that wait.
    #[inline(always)]
    pub fn run(&mut self) -> Result<(), QueryError> {
        self.open_first()?;
        self.slot_count = 0;
        self.sink.flush();
        Ok(())
    }

    #[inline(always)]
    fn open_first(&mut self) -> Result<(), QueryError> {
        for place in 0..self.slot_count {
            let [first, second, _] = &self.nodes;
            let Some(&node) = first.get(place) else { break };
            if second.count > ROOM {
                self.open_second()?;
            }
            self.open(node, 0)?;
        }
        let [first, ..] = &mut self.nodes;
        first.count = 0;
        self.open_second()
    }

    // Kept apart, as is what follows, so that each loop has the registers to itself.
    #[inline(never)]
    fn open_second(&mut self) -> Result<(), QueryError> {
        for place in 0..QUEUE {
            let [_, second, third] = &self.nodes;
            let Some(&node) = second.get(place) else {
                break;
            };
            if third.count > ROOM {
                self.open_third()?;
            }
            self.open(node, 1)?;
        }
        let [_, second, _] = &mut self.nodes;
        second.count = 0;
        self.open_third()
    }

    #[inline(never)]
    fn open_third(&mut self) -> Result<(), QueryError> {
        for place in 0..QUEUE {
            let [.., third] = &self.nodes;
            let Some(&node) = third.get(place) else { break };
            self.open(node, 2)?;
        }
        let [.., third] = &mut self.nodes;
        third.count = 0;
        self.sum_leaves()
    }

    /// Looks at the children of `node`, which is `height` below its tile's root.
    #[inline(never)]
    fn open(&mut self, node: Node, height: usize) -> Result<(), QueryError> {
        let tree = self.tree;
        let Some(slot) = self.slots.get(node.slot as usize).copied() else {
            return Ok(());
        };
        let place = slot.first_node.wrapping_add(node.number);
        let record = tree.node(u64::from(place))?;
        let distances = lanes::normal_distances(record, node.low, node.step);
        let mut alive = lanes::at_most(&distances, self.limits.exponent);
        if S::STRICT {
            self.count_skipped(&node, &slot, &distances, !alive);
        }
        if alive == 0 {
            return Ok(());
        }
        let mut inside = if node.inside { 0xFFFF } else { 0 };
        if !node.inside {
            let places = lanes::places(record, slot.origin.offset, slot.unit);
            let relations = self
                .region
                .relations(&places, &distances, self.limits.exponent);
            if S::STRICT && R::HAS_TAIL {
                // Position and normal together are beyond the limit.
                let limit = [self.limits.exponent; lanes::LANES];
                self.count_skipped(&node, &slot, &limit, alive & !relations.meets);
            }
            alive &= relations.meets;
            inside = relations.inside;
        }
        let is_bottom = node.depth == 1;
        if is_bottom && slot.has_leaves && self.leaves.count > ROOM {
            self.sum_leaves()?;
        }
        while alive != 0 {
            let lane = alive.trailing_zeros();
            alive &= alive - 1;
            let first = TileShape::child_cluster(node.first, node.count, lane);
            let count = TileShape::child_cluster(node.first, node.count, lane + 1) - first;
            if count == 0 {
                continue;
            }
            let own = child(record, lane as usize, node.low, node.step);
            let is_inside = inside >> lane & 1 == 1;
            let texels = if slot.even > 0 {
                count * slot.even
            } else {
                slot.shape.first_texel(first + count) - slot.shape.first_texel(first)
            };
            // What is at the bottom of a tile without leaves cannot be opened.
            let always = is_bottom && !slot.has_leaves;
            let exponent = get(&distances, lane as usize);
            if self.accept(&own, &slot, is_inside, exponent, texels, always) {
                continue;
            }
            if is_bottom {
                self.leaf(&own, &slot, &node, lane, first, texels, is_inside);
            } else {
                let number = if node.number == 0 {
                    1 + lane
                } else {
                    17 + 16 * (node.number - 1) + lane
                };
                self.fetch_node(slot.first_node.wrapping_add(number));
                let below = Node {
                    number,
                    slot: node.slot,
                    first,
                    count,
                    low: own.low,
                    step: own.extent.map(|extent| extent * (1.0 / 255.0)),
                    depth: node.depth - 1,
                    inside: is_inside,
                };
                if let Some(queue) = self.nodes.get_mut(height + 1) {
                    queue.push(below);
                }
            }
        }
        Ok(())
    }

    /// Adds to the error the children of `node` whose bit is set in `skipped`: a child's terms are e^-exponent at most.
    fn count_skipped(&mut self, node: &Node, slot: &Slot, exponents: &Lanes, skipped: u32) {
        for lane in 0..16 {
            let first = TileShape::child_cluster(node.first, node.count, lane);
            let last = TileShape::child_cluster(node.first, node.count, lane + 1);
            let texels = slot.shape.first_texel(last) - slot.shape.first_texel(first);
            if skipped >> lane & 1 == 1 && texels > 0 {
                let most = exponential(-get(exponents, lane as usize));
                self.sink
                    .error(1.00001 * most * texels as f32 * slot.copies);
            }
        }
    }

    /// Adds a cluster as one Gaussian, if that is near enough, or `always`.
    #[inline(always)]
    fn accept(
        &mut self,
        own: &Child,
        slot: &Slot,
        inside: bool,
        exponent: f32,
        texels: u32,
        always: bool,
    ) -> bool {
        let [ss, _, tt] = own.covariance;
        // Tried first on the disk, where variances are no greater than in any chart.
        let side = 0.5 * lanes::max(own.extent[0], own.extent[1]);
        let variance = lanes::max(ss, tt);
        if !always && (variance > self.limits.variance || variance * side * side > self.limits.tail)
        {
            return false;
        }
        let weight = if inside {
            Some(1.0)
        } else {
            self.region
                .cluster_weight(own, slot.origin.offset, slot.unit, exponent, always)
        };
        let Some(weight) = weight else { return false };
        let chart = self.lobe.chart(own.mean, own.covariance);
        if !always && chart.variance() > self.limits.variance * 2.0 {
            return false;
        }
        if S::STRICT {
            let count = texels as f32 * slot.copies;
            let of_weight = if inside {
                0.0
            } else {
                let (offset, unit) = (slot.origin.offset, slot.unit);
                self.region.weight_error(own, offset, unit, weight) * exponential(-exponent)
            };
            let of_moments = lanes::max(weight, 0.0) * moment_error(own);
            self.sink.error(count * (of_weight + of_moments));
        }
        let weight = weight * texels as f32 * slot.copies;
        self.sink.cluster(weight * chart.term(), weight, own.mean);
        true
    }

    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "the loop it is a part of has them at hand"
    )]
    fn leaf(
        &mut self,
        own: &Child,
        slot: &Slot,
        node: &Node,
        lane: u32,
        cluster: u32,
        texels: u32,
        inside: bool,
    ) {
        let leaf = slot.first_leaf.wrapping_add(cluster);
        if let Some(record) = self.tree.leaves.get(leaf as usize) {
            let [word, ..] = record.0;
            black_box(word);
        }
        self.leaves.push(Leaf {
            leaf,
            slot: node.slot,
            node: slot.first_node.wrapping_add(node.number),
            lane,
            texels,
            low: own.low,
            extent: own.extent,
            first: own.first,
            more: own.more,
            kind: own.kind,
            inside,
        });
    }

    #[inline(never)]
    fn sum_leaves(&mut self) -> Result<(), QueryError> {
        for place in 0..QUEUE {
            let Some(&leaf) = self.leaves.get(place) else {
                break;
            };
            self.sum_leaf(&leaf)?;
        }
        self.leaves.count = 0;
        self.sink.flush();
        Ok(())
    }

    /// Adds the texels of a leaf.
    #[inline(always)]
    fn sum_leaf(&mut self, leaf: &Leaf) -> Result<(), QueryError> {
        let tree = self.tree;
        let record = tree.leaves.get(leaf.leaf as usize).ok_or(tree.damaged())?;
        let (texels, first) = self.texels(leaf, record)?;
        // On the disk distances are no greater than in any chart: what is too far there need not be looked at further.
        let mut distances = lanes::each(|lane| {
            let (s, t) = (get(&texels.s, lane), get(&texels.t, lane));
            0.5 * (s * s + t * t)
        });
        set_from(&mut distances, leaf.texels, f32::INFINITY);
        let least = lanes::least(&distances);
        if S::STRICT {
            let copies = self
                .slots
                .get(leaf.slot as usize)
                .map_or(0.0, |slot| slot.copies);
            let count = leaf.texels as f32 * copies;
            let skipped = if least > self.limits.exponent {
                exponential(-least)
            } else {
                leaf_error(leaf, least)
            };
            self.sink.error(1.00001 * count * skipped);
        }
        if least > self.limits.exponent {
            return Ok(());
        }
        let (mut exponents, factors) = self.lobe.exponents(&texels.s, &texels.t);
        set_from(&mut exponents, leaf.texels, f32::INFINITY);
        let near = lanes::at_most(&exponents, LEAST_TERM);
        if near == 0 {
            return Ok(());
        }
        let Some(slot) = self.slots.get(leaf.slot as usize) else {
            return Ok(());
        };
        let weights = if leaf.inside {
            [slot.copies; lanes::LANES]
        } else {
            self.region.weights(&texels, &slot.origin, first, near)
        };
        let terms = lanes::each(|lane| {
            let exponent = get(&exponents, lane);
            let term = get(&factors, lane) * get(&weights, lane) * exponential(-exponent);
            if exponent <= LEAST_TERM { term } else { 0.0 }
        });
        self.sink.texels(&terms, &weights, &texels);
        Ok(())
    }

    /// The texels of a leaf, and the column and row they are counted from.
    #[inline(always)]
    fn texels(
        &self,
        leaf: &Leaf,
        record: &glintbake_format::records::ClusterLeaf,
    ) -> Result<(Texels, [u8; 2]), Finding> {
        let tree = self.tree;
        let bits = LeafBits::new(leaf.more[0], leaf.more[1]);
        match LeafKind::of(leaf.kind) {
            Some(LeafKind::Narrow) => {
                let texels = lanes::narrow_texels(record, bits, leaf.low, leaf.extent);
                Ok((texels, leaf.first))
            }
            Some(LeafKind::Palette) => {
                let Centre { point, scale } = self.centre;
                Ok((lanes::palette_texels(record, point, scale), [0; 2]))
            }
            Some(LeafKind::Wide) => {
                let kinds = &tree.node(u64::from(leaf.node))?.deviation_xy;
                let fine = tree
                    .fine_place(u64::from(leaf.node), kinds, leaf.lane)
                    .and_then(|place| tree.fine.get(place))
                    .ok_or(tree.damaged())?;
                let texels = lanes::wide_texels(record, fine, bits, leaf.low, leaf.extent);
                Ok((texels, leaf.first))
            }
            None => Err(tree.damaged()),
        }
    }
}

/// Texels of leaves that are opened anyway count down to e^-this.
const LEAST_TERM: f32 = 40.0;

/// The steepest slope of a unit Gaussian of peak 1 at points whose exponent is at least `exponent`: `d e^(-d²/2)`, greatest at
/// d = 1.
fn slope(exponent: f32) -> f32 {
    if exponent <= 0.5 {
        return 0.606_531;
    }
    let distance = 2.0 * exponent * lanes::inverse_root(2.0 * exponent);
    1.00001 * distance * exponential(-exponent)
}

/// How far the mean term of a cluster can be from that of the Gaussian of its stored moments, on the disk: docs/cluster-tree.md,
/// "Errors".
fn moment_error(own: &Child) -> f32 {
    let [width, height] = own.extent;
    let diagonal = width + height;
    let [ss, _, tt] = own.covariance;
    // Rounding of a deviation, by half a 510th of a side, of the correlation, by a 254th, and of the mean.
    let of = |variance: f32, side: f32| {
        let off = side * (1.0 / 1020.0);
        let deviation = variance * lanes::inverse_root(lanes::max(variance, 1e-30));
        (2.0 * deviation * off + off * off, deviation, off)
    };
    let (error_s, deviation_s, off_s) = of(ss, width);
    let (error_t, deviation_t, off_t) = of(tt, height);
    let product = (deviation_s + off_s) * (deviation_t + off_t);
    let error_st =
        deviation_s * off_t + deviation_t * off_s + off_s * off_t + product * (1.0 / 254.0);
    let trace = ss + tt + error_s + error_t;
    let root = trace * lanes::inverse_root(lanes::max(trace, 1e-30));
    // A cluster lies within its box, wherever its mean: the radius is the diagonal at most.
    let third = 0.2301 * trace * (diagonal + 1.6 * root);
    // The cluster's Gaussian reaches beyond its box, so that the steepest slope of all counts.
    let mean = slope(0.0) * diagonal * (1.0 / 510.0);
    third + mean + 0.5 * (error_s + error_t + 2.0 * error_st)
}

/// How far the term of a texel of a leaf can be from that of its normal before it was rounded.
fn leaf_error(leaf: &Leaf, least: f32) -> f32 {
    let most = LeafBits::new(leaf.more[0], leaf.more[1]).most() as f32;
    let finer = match LeafKind::of(leaf.kind) {
        Some(LeafKind::Wide) => 16.0,
        // To 31 bits, which the slack for arithmetic covers.
        Some(LeafKind::Palette) => return 0.0,
        _ => 1.0,
    };
    let off = 0.5 * (leaf.extent[0] + leaf.extent[1]) / (most * finer);
    let near = lanes::max(2.0 * least, 0.0);
    let distance = near * lanes::inverse_root(lanes::max(near, 1e-30));
    let inner = lanes::max(distance - off, 0.0);
    off * slope(0.5 * inner * inner)
}
