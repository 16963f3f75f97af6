//! The normal of one texel: its leaf is among those whose boxes of positions hold it.

use crate::error::QueryError;
use glintbake_format::Finding;
use glintbake_format::model::TileShape;
use glintbake_format::records::{ClusterNode, LeafBits, LeafKind};
use glintbake_format::view::ClusterTree;

/// A box of normals: where it begins, and how far it runs.
type NormalBox = [[f64; 2]; 2];

/// The normal of a texel as it is stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    /// Its point (s, t).
    pub normal: [f64; 2],
    /// How far it can be from the one that was baked: half a step in s, and half one in t.
    pub rounding: f64,
}

/// The normal of the texel in `column` and `row` of the map: exact as stored. Boxes of siblings overlap where
/// texels were split by their normals, so that a few leaves are looked through; all 256 of a tile at most.
///
/// # Errors
/// If the tile's leaves do not hold the texel.
pub(super) fn normal(tree: &ClusterTree<'_>, column: u32, row: u32) -> Result<Stored, QueryError> {
    let level = tree.layout.level(0);
    let tile = level.tile(column / level.side, row / level.side);
    let place = [
        column.wrapping_sub(tile.origin[0]),
        row.wrapping_sub(tile.origin[1]),
    ];
    let root = tree.root(&tile)?;
    let whole = [
        root.low.map(|x| f64::from(x.get())),
        root.step.map(|x| 255.0 * f64::from(x.get())),
    ];
    let search = Search {
        tree,
        first_leaf: tile.first_leaf,
        shape: tile.shape,
        place,
    };
    let range = [0, tile.shape.clusters];
    if tile.shape.depth() == 1 {
        if let Some(normal) = search.leaves(tile.first_node, range, whole)? {
            return Ok(normal);
        }
    } else {
        let node = tree.node(tile.first_node)?;
        for child in 0..16 {
            let [first, count] = child_range(range, child);
            if count == 0 || !holds(node, child, place) {
                continue;
            }
            let below = tile.first_node + 1 + u64::from(child);
            let own = child_box(node, child, whole);
            if let Some(normal) = search.leaves(below, [first, count], own)? {
                return Ok(normal);
            }
        }
    }
    Err(QueryError::Damaged(tree.damaged()))
}

struct Search<'t> {
    tree: &'t ClusterTree<'t>,
    first_leaf: u64,
    shape: TileShape,
    place: [u32; 2],
}

impl Search<'_> {
    /// The texel among the leaves of the node at `place`.
    fn leaves(
        &self,
        place: u64,
        range: [u32; 2],
        own: NormalBox,
    ) -> Result<Option<Stored>, Finding> {
        let node = self.tree.node(place)?;
        for child in 0..16 {
            let [cluster, count] = child_range(range, child);
            if count == 0 || !holds(node, child, self.place) {
                continue;
            }
            let leaf = self.first_leaf + u64::from(cluster);
            let texels = self.shape.first_texel(cluster + 1) - self.shape.first_texel(cluster);
            let inner = child_box(node, child, own);
            for texel in 0..texels as usize {
                let found = self.tree.leaf_texel(place, child, leaf, texel, inner)?;
                if found.place == self.place {
                    return Ok(Some(Stored {
                        normal: found.normal.map(|x| x.clamp(-1.0, 1.0)),
                        rounding: rounding(node, child, inner),
                    }));
                }
            }
        }
        Ok(None)
    }
}

/// Half a step in s and half one in t of the texels of the leaf that is child `child` of `node`, and has the box `own`.
fn rounding(node: &ClusterNode, child: u32, [_, extent]: NormalBox) -> f64 {
    let side = |high: &[u8; 16], low: &[u8; 16]| {
        let side = byte(high, child).wrapping_sub(byte(low, child));
        (side & 0xFF) as u8
    };
    let bits = LeafBits::new(
        side(&node.high_x, &node.low_x),
        side(&node.high_y, &node.low_y),
    );
    let most = f64::from(bits.most());
    let steps = match LeafKind::of(byte(&node.deviation_xy, child) as u8) {
        Some(LeafKind::Wide) => 16.0 * most + 15.0,
        // To 31 bits, which the slack for arithmetic covers.
        Some(LeafKind::Palette) => return 0.0,
        _ => most,
    };
    let [s, t] = extent;
    0.5 * (s.abs() + t.abs()) / steps
}

fn child_range([first, count]: [u32; 2], child: u32) -> [u32; 2] {
    let start = TileShape::child_cluster(first, count, child);
    [
        start,
        TileShape::child_cluster(first, count, child + 1) - start,
    ]
}

fn byte(bytes: &[u8; 16], child: u32) -> u32 {
    bytes.get(child as usize).map_or(0, |&byte| u32::from(byte))
}

fn holds(node: &ClusterNode, child: u32, [x, y]: [u32; 2]) -> bool {
    (byte(&node.low_x, child)..=byte(&node.high_x, child)).contains(&x)
        && (byte(&node.low_y, child)..=byte(&node.high_y, child)).contains(&y)
}

fn child_box(node: &ClusterNode, child: u32, [low, extent]: NormalBox) -> NormalBox {
    let [step_s, step_t] = extent.map(|extent| extent / 255.0);
    let from = [byte(&node.low_s, child), byte(&node.low_t, child)].map(f64::from);
    let to = [byte(&node.high_s, child), byte(&node.high_t, child)].map(f64::from);
    [
        [low[0] + from[0] * step_s, low[1] + from[1] * step_t],
        [(to[0] - from[0]) * step_s, (to[1] - from[1]) * step_t],
    ]
}
