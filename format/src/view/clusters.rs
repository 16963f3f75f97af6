//! Cluster trees: tiles, nodes, and the texels of leaves.

use super::bin_tables::elements;
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::{CLUSTER_LEVELS, ClusterLayout, ClusterLevel, ClusterTile};
use crate::records::{
    ClusterLeaf, ClusterNode, FINE_BITS, FINE_STARTS, FineBits, Instance, LEAVES, LeafBits,
    LeafKind, NODES, PALETTE_UNIT, ROOTS, TileRoot,
};
use crate::section::SectionId;
use zerocopy::little_endian::U32;

/// The cluster tree of one map.
#[derive(Clone, Copy, Debug)]
pub struct ClusterTree<'a> {
    /// How tiles, nodes and leaves lie.
    pub layout: ClusterLayout,
    /// Its levels; those there are not repeat the last.
    levels: [ClusterLevel; CLUSTER_LEVELS],
    /// The section of nodes.
    pub id: SectionId,
    /// Roots of all tiles.
    pub roots: &'a [TileRoot],
    /// Nodes of all tiles.
    pub nodes: &'a [ClusterNode],
    /// Leaves of the finest tiles.
    pub leaves: &'a [ClusterLeaf],
    /// Finer bits of wide leaves, in the order of these.
    pub fine: &'a [FineBits],
    /// For each node of the finest tiles, the place in `fine` of its first wide leaf; empty if there is no wide leaf.
    pub fine_starts: &'a [U32],
}

/// A texel of a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafTexel {
    /// Column and row in the tile.
    pub place: [u32; 2],
    /// The point (s, t).
    pub normal: [f64; 2],
}

impl<'a> ClusterTree<'a> {
    /// The tree stored with `instance` itself, or `None` if it stores none. O(1).
    ///
    /// # Errors
    /// If one of its sections is missing, or has not as many elements as the map's size says.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        let Some(layout) = instance.clusters() else {
            return Ok(None);
        };
        let id = instance.section(NODES);
        if container.find(id).is_none() {
            return Ok(None);
        }
        let count = |count: u64| {
            usize::try_from(count).map_err(|_| Finding::new(Fault::SectionCount).within(id))
        };
        let (fine, fine_starts) = if container.find(instance.section(FINE_BITS)).is_some() {
            let starts = count(layout.level(0).node_count())?;
            (
                container.elements(instance.section(FINE_BITS))?,
                elements(container, instance, FINE_STARTS, starts)?,
            )
        } else {
            (&[][..], &[][..])
        };
        Ok(Some(Self {
            layout,
            levels: [0, 1, 2].map(|number| layout.level(number)),
            id,
            roots: elements(container, instance, ROOTS, count(layout.root_count())?)?,
            nodes: elements(container, instance, NODES, count(layout.node_count())?)?,
            leaves: elements(container, instance, LEAVES, count(layout.leaf_count())?)?,
            fine,
            fine_starts,
        }))
    }

    /// The tree of the map that `instance` was baked from: its own, or that of the first other instance of the same map and
    /// method that stores one. O(instances).
    ///
    /// # Errors
    /// As [`open`](Self::open), and if no instance stores it.
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        super::of_map(container, instance, Self::open)?
            .ok_or(Finding::new(Fault::SectionMissing).within(instance.section(NODES)))
    }

    /// Level `number`; the last one for numbers beyond.
    #[inline]
    pub fn level(&self, number: u32) -> &ClusterLevel {
        let [first, second, third] = &self.levels;
        match number {
            0 => first,
            1 => second,
            _ => third,
        }
    }

    /// That something of the tree is not there or not readable.
    pub fn damaged(&self) -> Finding {
        Finding::new(Fault::SectionCount).within(self.id)
    }

    /// The root of `tile`'s boxes.
    ///
    /// # Errors
    /// If it is not stored, or holds a number that is not finite or out of range.
    #[inline]
    pub fn root(&self, tile: &ClusterTile) -> Result<&'a TileRoot, Finding> {
        let root = self.roots.get(tile.root as usize).ok_or(self.damaged())?;
        let in_range = |x: zerocopy::little_endian::F32| (-1.0..=1.0).contains(&x.get());
        let [low_s, low_t] = root.low;
        let [step_s, step_t] = root.step;
        if in_range(low_s) && in_range(low_t) && in_range(step_s) && in_range(step_t) {
            Ok(root)
        } else {
            Err(Finding::new(Fault::ClusterRoot)
                .within(self.id)
                .at(u64::from(tile.root)))
        }
    }

    /// The node at `place`.
    ///
    /// # Errors
    /// If it is not stored.
    #[inline]
    pub fn node(&self, place: u64) -> Result<&'a ClusterNode, Finding> {
        self.nodes.get(place as usize).ok_or(self.damaged())
    }

    /// The place in `fine` of the finer bits of child `child` of the node at `place`, whose leaves' kinds are in
    /// `deviation_xy`.
    #[inline]
    pub fn fine_place(&self, place: u64, deviation_xy: &[u8; 16], child: u32) -> Option<usize> {
        let start = self.fine_starts.get(place as usize)?.get() as usize;
        let before = deviation_xy
            .iter()
            .take(child as usize)
            .filter(|&&kind| kind >> 6 == LeafKind::Wide as u8)
            .count();
        start.checked_add(before)
    }

    /// Texel number `texel` of the leaf at `leaf`, child `child` of the node at `place`; the leaf's box of normals runs from
    /// `low` over `extent`. In f64; what queries do in blocks.
    ///
    /// # Errors
    /// If a part of it is not stored.
    pub fn leaf_texel(
        &self,
        place: u64,
        child: u32,
        leaf: u64,
        texel: usize,
        [low, extent]: [[f64; 2]; 2],
    ) -> Result<LeafTexel, Finding> {
        let node = self.node(place)?;
        let words = &self.leaves.get(leaf as usize).ok_or(self.damaged())?.0;
        let byte = |bytes: &[u8; 16]| {
            bytes
                .get(child as usize)
                .copied()
                .ok_or_else(|| self.damaged())
        };
        let word = |words: &[U32; 16], at: usize| {
            words
                .get(at)
                .map(|word| word.get())
                .ok_or_else(|| self.damaged())
        };
        let (x, y) = (byte(&node.low_x)?, byte(&node.low_y)?);
        let kind = LeafKind::of(byte(&node.deviation_xy)?).ok_or(self.damaged())?;
        if kind == LeafKind::Palette {
            let pair = word(words, 8 + texel / 2)?;
            let entry = if texel.is_multiple_of(2) {
                pair & 0xFFFF
            } else {
                pair >> 16
            };
            let colour = 2 * (entry & 3) as usize;
            let component = |at| word(words, at).map(|word| f64::from(word as i32) * PALETTE_UNIT);
            return Ok(LeafTexel {
                place: [(entry >> 2) & 63, (entry >> 8) & 63],
                normal: [component(colour)?, component(colour + 1)?],
            });
        }
        let bits = LeafBits::new(
            byte(&node.high_x)?.wrapping_sub(x),
            byte(&node.high_y)?.wrapping_sub(y),
        );
        let [column, row, s, t] = bits.unpack(word(words, texel)?);
        let (values, most) = if kind == LeafKind::Wide {
            let fine = self
                .fine_place(place, &node.deviation_xy, child)
                .and_then(|at| self.fine.get(at))
                .ok_or(self.damaged())?;
            let finer = fine.0.get(texel).copied().ok_or(self.damaged())?;
            let join = |high: u32, low: u8| f64::from(high) * 16.0 + f64::from(low);
            (
                [join(s, finer & 15), join(t, finer >> 4)],
                join(bits.most(), 15),
            )
        } else {
            ([f64::from(s), f64::from(t)], f64::from(bits.most()))
        };
        Ok(LeafTexel {
            place: [u32::from(x) + column, u32::from(y) + row],
            normal: [
                low[0] + values[0] / most * extent[0],
                low[1] + values[1] / most * extent[1],
            ],
        })
    }
}
