//! Downwards through the trees of lists.

use super::{LISTS, List};
use crate::error::QueryError;
use crate::ndf::bin_weights::sums::Sums;
use crate::overlap::{Parallelogram, Probe, TexelBox};
use core::hint::black_box;
use glintbake_format::model::ForestShape;
use glintbake_format::records::{BoxRecord, FOREST, ForestNode, TexelPosition};
use glintbake_format::view::{BinTables, InverseBinMap};
use glintbake_format::{Fault, Finding};

/// Nodes read together before the first of them is tested. Most lie in cache lines of their own, and whoever waits for
/// one may as well wait for several.
const TOGETHER: usize = 16;
/// Nodes that may wait to be opened: the roots of all lists, and what opening them leaves.
const WAITING: usize = LISTS + 3 * TOGETHER + ForestShape::MAX_DEPTH as usize;
/// Waiting nodes above which they are opened one by one, depth first. `TOGETHER` at once leave at most `TOGETHER` more
/// than there were, one by one at most one more a level.
const CROWDED: usize = WAITING - TOGETHER - ForestShape::MAX_DEPTH as usize;
/// Crossing leaves read together.
const LEAVES: usize = 4 * TOGETHER;
/// Texels of a leaf tested together.
const CHUNK: usize = 32;

/// An inner node to open.
#[derive(Clone, Copy)]
struct Node {
    /// Number among the window's lists.
    list: u32,
    level: u32,
    node: u32,
}

impl Node {
    const ROOT: Self = Self {
        list: 0,
        level: 0,
        node: 0,
    };
}

/// A leaf to look through: places of the inverse bin map.
#[derive(Clone, Copy)]
struct Leaf {
    /// The list's place among the sums.
    place: u32,
    first: u32,
    last: u32,
}

impl Leaf {
    const NONE: Self = Self {
        place: 0,
        first: 0,
        last: 0,
    };
}

/// The traversal of lists under the part of a footprint in one tile.
pub(super) struct Walk<'a> {
    tables: &'a BinTables<'a>,
    inverse: &'a InverseBinMap<'a>,
    footprint: &'a Parallelogram,
    probe: Probe<'a>,
    unbounded: bool,
    sums: &'a mut Sums,
    waiting: [Node; WAITING],
    leaves: [Leaf; LEAVES],
    leaf_count: usize,
}

impl<'a> Walk<'a> {
    /// The traversal under `footprint`, to be tested by `probe`, of lists whose texels are added to `sums`; `unbounded`
    /// if it reaches beyond the border of a clamped map.
    pub fn new(
        tables: &'a BinTables<'a>,
        inverse: &'a InverseBinMap<'a>,
        footprint: &'a Parallelogram,
        probe: Probe<'a>,
        unbounded: bool,
        sums: &'a mut Sums,
    ) -> Self {
        Self {
            tables,
            inverse,
            footprint,
            probe,
            unbounded,
            sums,
            waiting: [Node::ROOT; WAITING],
            leaves: [Leaf::NONE; LEAVES],
            leaf_count: 0,
        }
    }

    /// Adds the weights of `lists` to the sums.
    ///
    /// Downwards from the roots of all lists at once: a box outside is skipped, one inside counts by its number of
    /// texels, and the texels of a crossing leaf are tested one by one. Each node is visited at most once and covers
    /// texels no other node of its level covers, so the work is bounded by the lists' length whatever the bytes say.
    pub fn lists(&mut self, lists: &[List]) -> Result<(), QueryError> {
        let mut count = 0;
        for (number, list) in (0..).zip(lists) {
            if list.shape.depth() == 0 {
                self.add_leaf(list.place, list.start, list.end, true);
                self.make_room(1)?;
            } else if let Some(slot) = self.waiting.get_mut(count) {
                *slot = Node {
                    list: number,
                    ..Node::ROOT
                };
                count += 1;
            }
        }
        let mut opened = [(Node::ROOT, ForestNode::default()); TOGETHER];
        while count > 0 {
            let together = if count > CROWDED {
                1
            } else {
                count.min(TOGETHER)
            };
            count -= together;
            let nodes = self.waiting.get(count..).unwrap_or_default();
            for (opened, &node) in opened.iter_mut().zip(nodes).take(together) {
                *opened = (node, self.record(lists, node)?);
            }
            self.make_room(2 * TOGETHER)?;
            for (node, record) in opened.iter().take(together) {
                let list = lists.get(node.list as usize).unwrap_or(&List::NONE);
                let level = node.level + 1;
                for (child, bounds) in (node.node.wrapping_mul(2)..).zip(&record.children) {
                    let first = list.start + list.shape.first_texel(level, child);
                    let last = list.start + list.shape.first_texel(level, child.wrapping_add(1));
                    let relation = self.probe.relation(&self.texels(bounds));
                    if relation.inside {
                        let texels = u64::from(last.saturating_sub(first));
                        self.sums.add_inside(list.place, texels);
                    }
                    // Written in any case, kept only if crossing: that costs less than a wrong guess.
                    if level == list.shape.depth() {
                        self.add_leaf(list.place, first, last, relation.crossing);
                    } else {
                        if let Some(slot) = self.waiting.get_mut(count) {
                            *slot = Node {
                                list: node.list,
                                level,
                                node: child,
                            };
                        }
                        count += usize::from(relation.crossing);
                    }
                }
            }
        }
        self.make_room(LEAVES)
    }

    fn record(&self, lists: &[List], node: Node) -> Result<ForestNode, QueryError> {
        let slot = lists
            .get(node.list as usize)
            .map(|list| list.shape.slot(node.level, node.node) as usize);
        self.inverse
            .forest
            .zip(slot)
            .and_then(|(nodes, slot)| nodes.get(slot))
            .copied()
            .ok_or_else(|| {
                Finding::new(Fault::SectionMissing)
                    .within(self.tables.instance.section(FOREST))
                    .into()
            })
    }

    /// Writes a leaf down, and keeps it if it is `wanted`.
    #[inline]
    fn add_leaf(&mut self, place: u32, first: u32, last: u32, wanted: bool) {
        if let Some(leaf) = self.leaves.get_mut(self.leaf_count) {
            *leaf = Leaf { place, first, last };
            self.leaf_count += usize::from(wanted);
        }
    }

    /// Looks through the leaves written down unless there is room for `more`.
    #[inline]
    fn make_room(&mut self, more: usize) -> Result<(), QueryError> {
        if self.leaf_count + more <= LEAVES {
            return Ok(());
        }
        let leaves = self.leaves;
        let leaves = leaves.get(..self.leaf_count).unwrap_or_default();
        self.leaf_count = 0;
        // Fetches the leaves all at once.
        for leaf in leaves {
            let positions = self.positions(leaf)?;
            black_box((positions.first().copied(), positions.last().copied()));
        }
        for leaf in leaves {
            self.leaf(leaf)?;
        }
        Ok(())
    }

    fn positions(&self, leaf: &Leaf) -> Result<&'a [TexelPosition], Finding> {
        self.inverse
            .positions
            .get(leaf.first as usize..leaf.last as usize)
            .ok_or(Finding::new(Fault::IndexOrder))
    }

    fn leaf(&mut self, leaf: &Leaf) -> Result<(), QueryError> {
        let positions = self.positions(leaf)?;
        let mut inside = 0_u32;
        if self.unbounded {
            for position in positions {
                let texel = self.texels(&BoxRecord {
                    first_column: position.column,
                    first_row: position.row,
                    last_column: position.column,
                    last_row: position.row,
                });
                let relation = self.probe.relation(&texel);
                inside += u32::from(relation.inside);
                if relation.crossing {
                    self.sums.add(leaf.place, self.footprint.weight(&texel));
                }
            }
        } else {
            // Where each of these texels lies is anyone's guess, so nothing may branch on it before the few that cross
            // the outline are known.
            for positions in positions.chunks(CHUNK) {
                let mut crossing = [(0, 0); CHUNK];
                let mut count = 0;
                for position in positions {
                    let (column, row) = (position.column.get(), position.row.get());
                    let relation = self.probe.texel(column, row);
                    inside += u32::from(relation.inside);
                    if let Some(slot) = crossing.get_mut(count) {
                        *slot = (column, row);
                    }
                    count += usize::from(relation.crossing);
                }
                for &(column, row) in crossing.iter().take(count) {
                    self.sums.add(leaf.place, self.probe.weight(column, row));
                }
            }
        }
        self.sums.add_inside(leaf.place, u64::from(inside));
        Ok(())
    }

    /// The area of texture the texels from one corner of `bounds` to the other cover; without end beyond the border of
    /// a clamped map.
    #[inline]
    fn texels(&self, bounds: &BoxRecord) -> TexelBox {
        let mut texels = TexelBox {
            low: [
                f64::from(bounds.first_column.get()),
                f64::from(bounds.first_row.get()),
            ],
            high: [
                f64::from(bounds.last_column.get()) + 1.0,
                f64::from(bounds.last_row.get()) + 1.0,
            ],
        };
        if self.unbounded {
            let instance = &self.tables.instance;
            let size = [f64::from(instance.width), f64::from(instance.height)];
            texels.low = texels
                .low
                .map(|low| if low <= 0.0 { f64::NEG_INFINITY } else { low });
            for (high, size) in texels.high.iter_mut().zip(size) {
                if *high >= size {
                    *high = f64::INFINITY;
                }
            }
        }
        texels
    }
}
