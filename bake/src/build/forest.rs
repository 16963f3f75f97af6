//! The forest: bounding boxes over the long lists of an inverse bin map.
//!
//! \[AWKK21\] §5.4 splits kd-tree cells in the middle. On clustered flakes that makes long chains of cells with one
//! occupied half; here a list in Morton order is halved by *count*, so that every tree is as shallow as it can be,
//! needs no pointers, and its boxes fit their texels tightly.

use super::inverse_bin_map::InverseBinMap;
use glintbake_format::model::ForestShape;
use glintbake_format::records::{BoxRecord, ForestNode, TexelPosition};
use zerocopy::little_endian::U16;

/// The forest over `inverse` for `leaf_size` (at least 1), or `None` if no list is longer than a leaf.
///
/// 32 / `leaf_size` bytes a texel; O(texels), bottom up.
pub fn build(inverse: &InverseBinMap, leaf_size: u32) -> Option<Vec<ForestNode>> {
    let texels = inverse.positions.len() as u32;
    let slots = ForestShape::slot_count(texels, leaf_size) as usize;
    let mut nodes = vec![ForestNode::default(); slots];
    let mut any = false;
    let mut boxes = Vec::new();
    for key in 0..inverse.offsets.len() - 1 {
        let list = inverse.list(key);
        let shape = ForestShape::new(list.start as u32, list.len() as u32, leaf_size);
        if shape.depth() > 0 {
            any = true;
            fill_tree(&inverse.positions[list], shape, &mut nodes, &mut boxes);
        }
    }
    any.then_some(nodes)
}

fn fill_tree(
    list: &[TexelPosition],
    shape: ForestShape,
    nodes: &mut [ForestNode],
    boxes: &mut Vec<Bounds>,
) {
    let depth = shape.depth();
    boxes.clear();
    boxes.extend((0..1 << depth).map(|leaf| {
        let first = shape.first_texel(depth, leaf) as usize;
        let end = shape.first_texel(depth, leaf + 1) as usize;
        Bounds::of(&list[first..end])
    }));
    for level in (0..depth).rev() {
        for node in 0..1 << level {
            let pair = [boxes[2 * node], boxes[2 * node + 1]];
            nodes[shape.slot(level, node as u32) as usize] = ForestNode {
                children: pair.map(Bounds::to_record),
            };
            boxes[node] = pair[0].union(pair[1]);
        }
    }
}

#[derive(Clone, Copy)]
struct Bounds {
    low: [u16; 2],
    high: [u16; 2],
}

impl Bounds {
    /// No texels: the identity of [`union`](Self::union).
    const EMPTY: Self = Self {
        low: [u16::MAX; 2],
        high: [0; 2],
    };

    fn of(texels: &[TexelPosition]) -> Self {
        texels.iter().fold(Self::EMPTY, |bounds, texel| {
            let point = [texel.column.get(), texel.row.get()];
            bounds.union(Self {
                low: point,
                high: point,
            })
        })
    }

    fn union(self, other: Self) -> Self {
        Self {
            low: [self.low[0].min(other.low[0]), self.low[1].min(other.low[1])],
            high: [
                self.high[0].max(other.high[0]),
                self.high[1].max(other.high[1]),
            ],
        }
    }

    fn to_record(self) -> BoxRecord {
        if self.low[0] > self.high[0] {
            return BoxRecord::default();
        }
        let [first_column, first_row] = self.low.map(U16::new);
        let [last_column, last_row] = self.high.map(U16::new);
        BoxRecord {
            first_column,
            first_row,
            last_column,
            last_row,
        }
    }
}
