//! Walking the trees of some tiles: each child is skipped, accepted as one Gaussian, or opened.
//!
//! Breadth first: all nodes of one depth are looked at before those below them, whose memory is asked for as they are found. What
//! a query waits for is memory, and this way it waits for many nodes at once. Queues are of fixed size; a full one is worked
//! off before more is added.
//!
//! ```text
//! Walk ──Run──► open: nodes ──► leaves        queue: what waits
//!  └────Trial: does a tile without leaves serve?        bounds: errors, for strict answers
//! ```
#![expect(
    clippy::indexing_slicing,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

mod bounds;
mod open;
mod queue;

use super::find::Stored;
use super::lanes::{
    self, BITS, Frame, LANES, LEAST_TERM, Lanes, NormalBox, Normals, Place, exponential,
};
use super::lobe::Lobe;
use super::region::{Origin, Region};
use crate::error::QueryError;
use crate::simd::{Instructions, Work, fetch};
use bounds::rounding_error;
use glintbake_format::model::{ClusterLevel, ClusterTile, TileShape};
use glintbake_format::view::ClusterTree;
use queue::{CROWDED, LEAVES, Leaf, NO_SLOT, NODES, Node, Queue, Slot, TILES, existing};

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

    /// Adds a texel of the normal `stored` and weight `weight`, in no unit. After all tiles: errors have no unit from here on.
    pub fn exact(&mut self, stored: &Stored, weight: f64) {
        let normal = stored.normal;
        let Centre { point, scale } = self.centre;
        let offset = [
            (normal[0] - point[0]) * scale,
            (normal[1] - point[1]) * scale,
        ];
        let [s, t] = offset.map(|x| x as f32);
        let [exponent, factor] = self.lobe.exponent(s, t);
        if S::STRICT {
            self.sink.unit(1.0);
            let off = (stored.rounding * scale) as f32;
            let error = rounding_error(off, 0.5 * (s * s + t * t));
            self.sink.error(1.00001 * weight as f32 * error);
        }
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
