//! What waits in a walk: tiles, nodes and leaves, in queues of fixed size.

use crate::ndf::cluster_tree::lanes::NormalBox;
use crate::ndf::cluster_tree::region::Origin;
use glintbake_format::model::TileShape;

/// Tiles walked together.
pub(super) const TILES: usize = 16;
/// Nodes that wait.
pub(super) const NODES: usize = 128;
/// From this many on the newest is looked at first, so that its whole subtree has room: 15 more for each of three depths.
pub(super) const CROWDED: usize = NODES - 3 * 16;
/// Leaves that wait.
pub(super) const LEAVES: usize = 32;

/// A tile to walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub shape: TileShape,
    pub first_node: u32,
    pub first_leaf: u32,
    pub origin: Origin,
    /// Texels to a unit of positions.
    pub unit: f32,
    /// Texels of a bottom cluster, if all have as many; else 0.
    pub even: u32,
    /// How often the tile counts.
    pub copies: f32,
    pub has_leaves: bool,
}

pub(super) const NO_SLOT: Slot = Slot {
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
pub(super) struct Node {
    pub own: NormalBox,
    /// Its place.
    pub place: u32,
    /// First bottom cluster, and number of them.
    pub first: u16,
    pub count: u16,
    /// Number in its tile.
    pub number: u16,
    pub slot: u8,
    pub inside: bool,
}

/// A leaf to sum up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub own: NormalBox,
    pub leaf: u32,
    /// Place of its node.
    pub node: u32,
    pub texels: u8,
    /// Its number among the children there.
    pub lane: u8,
    pub slot: u8,
    pub inside: bool,
}

impl Node {
    pub const NONE: Self = Self {
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
    pub const NONE: Self = Self {
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
pub(super) struct Queue<T, const SIZE: usize> {
    pub items: [T; SIZE],
    pub start: usize,
    pub count: usize,
}

impl<T: Copy, const SIZE: usize> Queue<T, SIZE> {
    #[inline(always)]
    pub const fn new(none: T) -> Self {
        Self {
            items: [none; SIZE],
            start: 0,
            count: 0,
        }
    }

    #[inline(always)]
    pub fn push(&mut self, item: T) {
        let at = (self.start + self.count) % SIZE;
        if let Some(slot) = self.items.get_mut(at) {
            *slot = item;
        }
        self.count += 1;
    }

    /// Takes the oldest, or the newest if there are `crowded` or more.
    #[inline(always)]
    pub fn pop(&mut self, crowded: usize) -> Option<T> {
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

/// The texels of the largest child of a node of `slot` that has `count` bottom clusters.
#[inline(always)]
pub(super) fn most_texels(slot: &Slot, count: u32) -> f32 {
    let clusters = count.div_ceil(16);
    if slot.even > 0 {
        (clusters * slot.even) as f32
    } else {
        (clusters * 16) as f32
    }
}

/// Texels of the bottom clusters from `start` to `end`.
#[inline(always)]
pub(super) fn texels_of(slot: &Slot, start: u32, end: u32) -> u32 {
    if slot.even > 0 {
        (end - start) * slot.even
    } else {
        slot.shape.first_texel(end) - slot.shape.first_texel(start)
    }
}

/// A bit for each child of a node of `count` bottom clusters from `first` that has any.
pub(super) fn existing(first: u32, count: u32) -> u32 {
    (0..16).fold(0, |bits, lane| {
        let start = TileShape::child_cluster(first, count, lane);
        let end = TileShape::child_cluster(first, count, lane + 1);
        bits | u32::from(end > start) << lane
    })
}
