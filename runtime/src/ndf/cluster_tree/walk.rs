//! Walking the trees of some tiles: each child is skipped, accepted as one Gaussian, or opened.
//!
//! Breadth first: all nodes of one depth are looked at before those below them, whose memory is asked for as they are found. What
//! a query waits for is memory, and this way it waits for many nodes at once. Queues are of fixed size; a full one is worked
//! off before more is added.

#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use super::lanes::{
    self, BITS, Frame, LANES, LEAST_TERM, Lanes, Moments, NormalBox, Normals, Place, Spread,
    Texels, exponential, get, max,
};
use super::lobe::Lobe;
use super::region::{Origin, Region};
use crate::error::QueryError;
use crate::simd::{Instructions, Work, fetch};
use glintbake_format::model::{ClusterLevel, ClusterTile, TileShape};
use glintbake_format::records::{ClusterNode, FineBits, LeafBits, LeafKind};
use glintbake_format::view::ClusterTree;

/// Tiles walked together.
const TILES: usize = 16;
/// Nodes that wait.
const NODES: usize = 128;
/// From this many on the newest is looked at first, so that its whole subtree has room: 15 more for each of three depths.
const CROWDED: usize = NODES - 3 * 16;
/// Leaves that wait.
const LEAVES: usize = 32;

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

    /// Texels or clusters of normals (s, t), and what they weigh; those without term have a term of 0.
    fn terms(&mut self, terms: &Lanes, weights: &Lanes, s: &Lanes, t: &Lanes);

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

const NO_SLOT: Slot = Slot {
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

/// A node to open.
#[derive(Clone, Copy, Debug)]
struct Node {
    own: NormalBox,
    /// Its place.
    place: u32,
    /// First bottom cluster, and number of them.
    first: u16,
    count: u16,
    /// Number in its tile.
    number: u16,
    slot: u8,
    inside: bool,
}

/// A leaf to sum up.
#[derive(Clone, Copy, Debug)]
struct Leaf {
    own: NormalBox,
    leaf: u32,
    /// Place of its node.
    node: u32,
    texels: u8,
    /// Its number among the children there.
    lane: u8,
    slot: u8,
    inside: bool,
}

impl Node {
    const NONE: Self = Self {
        own: NormalBox::NONE,
        place: 0,
        first: 0,
        count: 0,
        number: 0,
        slot: 0,
        inside: false,
    };
}

impl Leaf {
    const NONE: Self = Self {
        own: NormalBox::NONE,
        leaf: 0,
        node: 0,
        texels: 0,
        lane: 0,
        slot: 0,
        inside: false,
    };
}

/// A queue of fixed size, of a power of two.
#[derive(Clone, Debug)]
struct Queue<T, const SIZE: usize> {
    items: [T; SIZE],
    start: usize,
    count: usize,
}

impl<T: Copy, const SIZE: usize> Queue<T, SIZE> {
    #[inline(always)]
    const fn new(none: T) -> Self {
        Self {
            items: [none; SIZE],
            start: 0,
            count: 0,
        }
    }

    #[inline(always)]
    fn push(&mut self, item: T) {
        let at = (self.start + self.count) % SIZE;
        if let Some(slot) = self.items.get_mut(at) {
            *slot = item;
        }
        self.count += 1;
    }

    /// Takes the oldest, or the newest if there are `crowded` or more.
    #[inline(always)]
    fn pop(&mut self, crowded: usize) -> Option<T> {
        if self.count == 0 {
            return None;
        }
        self.count -= 1;
        let at = if self.count >= crowded {
            (self.start + self.count) % SIZE
        } else {
            let at = self.start;
            self.start = (at + 1) % SIZE;
            at
        };
        self.items.get(at).copied()
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
pub(super) struct Walk<'a, R, L, S> {
    tree: &'a ClusterTree<'a>,
    region: R,
    lobe: L,
    centre: Centre,
    limits: Limits,
    instructions: Instructions,
    pub sink: S,
    slots: [Slot; TILES],
    slot_count: usize,
    nodes: Queue<Node, NODES>,
    leaves: Queue<Leaf, LEAVES>,
}

impl<'a, R: Region, L: Lobe, S: Sink> Walk<'a, R, L, S> {
    #[inline(always)]
    pub fn new(
        tree: &'a ClusterTree<'a>,
        region: R,
        lobe: L,
        centre: Centre,
        limits: Limits,
        instructions: Instructions,
        sink: S,
    ) -> Self {
        Self {
            tree,
            region,
            lobe,
            centre,
            limits,
            instructions,
            sink,
            slots: [NO_SLOT; TILES],
            slot_count: 0,
            nodes: Queue::new(Node::NONE),
            leaves: Queue::new(Leaf::NONE),
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
        let [exponent, factor] = self.lobe.exponent(s, t);
        if exponent <= LEAST_TERM {
            let term = f64::from(factor) * f64::from(exponential(-exponent));
            self.sink.exact(term * weight, weight, offset);
        }
    }

    /// Adds `tile` of `level`, at `origin`; `copies` times, if it is `inside`. False if it has no leaves and does not serve without.
    #[inline]
    pub fn visit(
        &mut self,
        level: &ClusterLevel,
        tile: &ClusterTile,
        origin: Origin,
        inside: bool,
        copies: f32,
    ) -> Result<bool, QueryError> {
        let has_leaves = level.number == 0;
        let unit = level.unit() as f32;
        if !has_leaves && !self.serves(tile, origin, unit, inside)? {
            return Ok(false);
        }
        if self.slot_count == TILES {
            self.run()?;
        }
        let (own, place) = self.root_of(tile)?;
        if let Some(slot) = self.slots.get_mut(self.slot_count) {
            *slot = Slot {
                shape: tile.shape,
                first_node: tile.first_node as u32,
                first_leaf: tile.first_leaf as u32,
                origin,
                unit,
                even: if tile.shape.is_even() {
                    tile.shape.texels / tile.shape.clusters
                } else {
                    0
                },
                copies,
                has_leaves,
            };
        }
        fetch_node(self.tree, place);
        self.nodes.push(Node {
            own,
            place,
            first: 0,
            count: tile.shape.clusters as u16,
            number: 0,
            slot: self.slot_count as u8,
            inside,
        });
        self.slot_count += 1;
        Ok(true)
    }

    /// Whether the clusters of `tile`, which has no leaves, are narrow enough wherever the half vector is near.
    #[inline(never)]
    fn serves(
        &self,
        tile: &ClusterTile,
        origin: Origin,
        unit: f32,
        inside: bool,
    ) -> Result<bool, QueryError> {
        let frame = Frame {
            offset: origin.offset,
            unit,
        };
        let (own, place) = self.root_of(tile)?;
        self.instructions.run(Trial {
            walk: self,
            tile,
            frame,
            inside,
            root: (own, place),
        })
    }

    /// The box of normals of `tile`'s root node, and its place.
    #[inline]
    fn root_of(&self, tile: &ClusterTile) -> Result<(NormalBox, u32), QueryError> {
        let root = self.tree.root(tile)?;
        let Centre { point, scale } = self.centre;
        let own = NormalBox {
            low: [
                ((f64::from(root.low[0].get()) - point[0]) * scale) as f32,
                ((f64::from(root.low[1].get()) - point[1]) * scale) as f32,
            ],
            step: root.step.map(|step| (f64::from(step.get()) * scale) as f32),
        };
        Ok((own, tile.first_node as u32))
    }

    /// Walks all tiles that wait.
    #[inline(never)]
    pub fn run(&mut self) -> Result<(), QueryError> {
        let instructions = self.instructions;
        let done = instructions.run(Run { walk: self });
        self.slot_count = 0;
        self.sink.flush();
        done
    }
}

/// Asks memory for the four lines of a node.
#[inline(always)]
fn fetch_node(tree: &ClusterTree<'_>, place: u32) {
    if let Some(node) = tree.nodes.get(place as usize) {
        fetch(&node.low_s);
        fetch(&node.mean_s);
        fetch(&node.correlation);
        fetch(&node.high_y);
    }
}

/// Nodes of a tile that wait for their trial: 15 more at each of three depths.
const TRIAL: usize = 48;

/// Trying whether a tile without leaves serves.
struct Trial<'r, 'a, R, L, S> {
    walk: &'r Walk<'a, R, L, S>,
    tile: &'r ClusterTile,
    frame: Frame,
    inside: bool,
    root: (NormalBox, u32),
}

impl<R: Region, L: Lobe, S: Sink> Work for Trial<'_, '_, R, L, S> {
    type Output = Result<bool, QueryError>;

    #[inline(always)]
    fn run(self) -> Result<bool, QueryError> {
        let Walk {
            tree,
            region,
            lobe,
            limits,
            ..
        } = self.walk;
        let (region, limits) = (*region, *limits);
        let shape = self.tile.shape;
        let (own, place) = self.root;
        let mut waiting = [(own, 0_u32, 0_u32, shape.clusters); TRIAL];
        let mut count = 1_usize;
        while let Some(last) = count.checked_sub(1) {
            count = last;
            let Some(&(own, number, first, clusters)) = waiting.get(last) else {
                break;
            };
            let record = tree.node(u64::from(place.wrapping_add(number)))?;
            let Normals {
                distances,
                mut alive,
                narrow,
            } = lanes::normals(record, own, *lobe, limits);
            alive &= !narrow & existing(first, clusters);
            if !self.inside && alive != 0 {
                let mut meets = 0;
                for lane in 0..LANES {
                    let place = Place::of(record, lane, self.frame);
                    let [misses, _] = region.relation(place, distances[lane], limits.exponent);
                    meets |= if misses <= 0.0 { BITS[lane] } else { 0 };
                }
                alive &= meets;
            }
            let is_bottom = shape.depth() <= height(number) + 1;
            if is_bottom && alive != 0 {
                return Ok(false);
            }
            while alive != 0 {
                let lane = alive.trailing_zeros();
                alive &= alive - 1;
                let start = TileShape::child_cluster(first, clusters, lane);
                let end = TileShape::child_cluster(first, clusters, lane + 1);
                let below = own.child(record, lane as usize);
                if let Some(slot) = waiting.get_mut(count) {
                    *slot = (below, child_number(number, lane), start, end - start);
                    count += 1;
                }
            }
        }
        Ok(true)
    }
}

/// How far node `number` of a tile is below the root.
#[inline(always)]
fn height(number: u32) -> u32 {
    u32::from(number > 0) + u32::from(number > 16)
}

/// The number in its tile of child `lane` of node `number`.
#[inline(always)]
fn child_number(number: u32, lane: u32) -> u32 {
    if number == 0 {
        1 + lane
    } else {
        17 + 16 * (number - 1) + lane
    }
}

/// Walking the tiles that wait, as work for whatever vectors there are.
struct Run<'r, 'a, R, L, S> {
    walk: &'r mut Walk<'a, R, L, S>,
}

impl<R: Region, L: Lobe, S: Sink> Work for Run<'_, '_, R, L, S> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run(self) -> Result<(), QueryError> {
        let walk = self.walk;
        loop {
            while walk.leaves.count <= LEAVES - 16
                && let Some(node) = walk.nodes.pop(CROWDED)
            {
                walk.open(node)?;
            }
            while let Some(leaf) = walk.leaves.pop(LEAVES) {
                walk.sum_leaf(&leaf)?;
            }
            walk.sink.flush();
            if walk.nodes.count == 0 {
                return Ok(());
            }
        }
    }
}

impl<R: Region, L: Lobe, S: Sink> Walk<'_, R, L, S> {
    /// Looks at the children of `node`.
    #[inline(always)]
    fn open(&mut self, node: Node) -> Result<(), QueryError> {
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
    fn sum_leaf(&mut self, leaf: &Leaf) -> Result<(), QueryError> {
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
fn leaf_bits(node: &ClusterNode, lane: usize) -> LeafBits {
    let byte = |bytes: &[u8; LANES]| bytes.get(lane).copied().unwrap_or(0);
    LeafBits::new(
        byte(&node.high_x).wrapping_sub(byte(&node.low_x)),
        byte(&node.high_y).wrapping_sub(byte(&node.low_y)),
    )
}

/// The texels of the largest child of a node of `slot` that has `count` bottom clusters.
#[inline(always)]
fn most_texels(slot: &Slot, count: u32) -> f32 {
    let clusters = count.div_ceil(16);
    if slot.even > 0 {
        (clusters * slot.even) as f32
    } else {
        (clusters * 16) as f32
    }
}

/// Texels of the bottom clusters from `start` to `end`.
#[inline(always)]
fn texels_of(slot: &Slot, start: u32, end: u32) -> u32 {
    if slot.even > 0 {
        (end - start) * slot.even
    } else {
        slot.shape.first_texel(end) - slot.shape.first_texel(start)
    }
}

/// A bit for each child of a node of `count` bottom clusters from `first` that has any.
fn existing(first: u32, count: u32) -> u32 {
    (0..16).fold(0, |bits, lane| {
        let start = TileShape::child_cluster(first, count, lane);
        let end = TileShape::child_cluster(first, count, lane + 1);
        bits | u32::from(end > start) << lane
    })
}

/// Adds to the error the children whose bit is set in `skipped` of a node of `slot` that has `count` bottom clusters from
/// `first`: a child's terms are e^-exponent at most.
fn count_skipped<S: Sink>(
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

/// How far the mean term of a cluster can be from that of the Gaussian of its stored moments, on the disk: docs/cluster-tree.md,
/// "Errors".
fn moment_error(own: &NormalBox, [ss, tt]: [f32; 2]) -> f32 {
    let [width, height] = own.extent();
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
    third + mean + 0.5 * (error_s + error_t + 2.0 * error_st)
}

/// How far the term of a texel of a leaf can be from that of its normal before it was rounded.
fn leaf_error(leaf: &Leaf, node: &ClusterNode, least: f32) -> f32 {
    let lane = usize::from(leaf.lane);
    let most = leaf_bits(node, lane).most() as f32;
    let kind = node.deviation_xy.get(lane).copied().unwrap_or(0);
    let finer = match LeafKind::of(kind) {
        Some(LeafKind::Wide) => 16.0,
        // To 31 bits, which the slack for arithmetic covers.
        Some(LeafKind::Palette) => return 0.0,
        _ => 1.0,
    };
    let [width, height] = leaf.own.extent();
    let off = 0.5 * (width + height) / (most * finer);
    let near = max(2.0 * least, 0.0);
    let distance = near * lanes::inverse_root(max(near, 1e-30));
    let inner = max(distance - off, 0.0);
    off * slope(0.5 * inner * inner)
}
