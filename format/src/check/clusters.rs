//! Structural checks of the sections behind `cluster-tree`.

use super::Limited;
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::model::{CLUSTER_CHILDREN, ClusterTile, TileShape};
use crate::records::{ClusterNode, Instance, LeafBits, LeafKind, RASTER_SIDE, unpack_raster};
use crate::view::{ClusterTree, LeafTexel, Raster};

/// Reports sections of the wrong size; boxes that are none or leave their tile; children and texels that should not be there;
/// leaves that do not hold each texel of their tile once, or whose mean is not that of their texels.
pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    // Looked up as queries do, so that an instance without a tree to share is found.
    if let Err(finding) = ClusterTree::of_map(container, instance) {
        return report(finding);
    }
    let raster = match Raster::open(container, instance) {
        Ok(raster) => raster,
        Err(finding) => return report(finding),
    };
    if let Some(raster) = &raster {
        check_raster(raster, report);
    }
    let tree = match ClusterTree::open(container, instance) {
        Ok(Some(tree)) => tree,
        // That of another instance is checked with it.
        Ok(None) => return,
        Err(finding) => return report(finding),
    };
    let mut limited = Limited::new(report);
    let mut fine = 0;
    for number in 0..tree.layout.levels() {
        let level = tree.layout.level(number);
        for row in 0..level.tiles[1] {
            for column in 0..level.tiles[0] {
                let tile = level.tile(column, row);
                let mut checked = Tile {
                    tree: &tree,
                    raster: raster.as_ref(),
                    tile: &tile,
                    has_leaves: number == 0,
                    unit: level.unit(),
                    seen: [0; 64],
                    fine: &mut fine,
                };
                checked.check(&mut limited);
            }
        }
    }
    if fine != tree.fine.len() as u64 {
        let found = Finding::new(Fault::ClusterLeafKind).within(tree.id);
        limited.report(found.values(fine, tree.fine.len() as u64));
    }
}

struct Tile<'t> {
    tree: &'t ClusterTree<'t>,
    raster: Option<&'t Raster<'t>>,
    tile: &'t ClusterTile,
    has_leaves: bool,
    /// Texels to a unit of positions.
    unit: u32,
    /// A bit for each texel met, a row each.
    seen: [u64; 64],
    /// Wide leaves so far.
    fine: &'t mut u64,
}

/// A box of normals: where it begins, and how far it runs.
type Box2 = [[f64; 2]; 2];

impl Tile<'_> {
    fn check(&mut self, report: &mut Limited<'_>) {
        let root = match self.tree.root(self.tile) {
            Ok(root) => root,
            Err(finding) => return report.report(finding),
        };
        let low = root.low.map(|x| f64::from(x.get()));
        let extent = root.step.map(|x| 255.0 * f64::from(x.get()));
        let within = |axis: usize| {
            let (low, extent) = (low.get(axis).copied(), extent.get(axis).copied());
            low.zip(extent).is_some_and(|(low, extent)| {
                low >= -1.0 && extent >= 0.0 && low + extent <= 1.0 + 1e-6
            })
        };
        if !within(0) || !within(1) {
            report.report(self.at(Fault::ClusterRoot, u64::from(self.tile.root)));
        }
        let shape = self.tile.shape;
        let first = self.tile.first_node;
        self.node(
            first,
            0,
            shape.clusters,
            shape.depth(),
            [low, extent],
            report,
        );
        for child in 0..CLUSTER_CHILDREN {
            if shape.depth() < 2 {
                break;
            }
            let [start, count] = range(0, shape.clusters, child);
            let Some(inner) = self.child_box(first, child, [low, extent]) else {
                return;
            };
            let place = first + 1 + u64::from(child);
            self.node(place, start, count, shape.depth() - 1, inner, report);
            for grandchild in 0..CLUSTER_CHILDREN {
                if shape.depth() < 3 {
                    break;
                }
                let [start, count] = range(start, count, grandchild);
                let Some(inner) = self.child_box(place, grandchild, inner) else {
                    return;
                };
                let place = first + 17 + u64::from(16 * child + grandchild);
                self.node(place, start, count, 1, inner, report);
            }
        }
        if self.has_leaves {
            let met: u32 = self.seen.iter().map(|row| row.count_ones()).sum();
            if met != shape.texels {
                report.report(self.at(Fault::ClusterTexels, u64::from(self.tile.root)));
            }
        }
    }

    fn at(&self, fault: Fault, place: u64) -> Finding {
        Finding::new(fault).within(self.tree.id).at(place)
    }

    fn child_box(&self, place: u64, child: u32, parent: Box2) -> Option<Box2> {
        let node = self.tree.node(place).ok()?;
        child_box(node, child as usize, parent)
    }

    /// Checks the node at `place`, whose children are or share out `count` bottom clusters from `first`.
    fn node(
        &mut self,
        place: u64,
        first: u32,
        count: u32,
        depth: u32,
        parent: Box2,
        report: &mut Limited<'_>,
    ) {
        let Ok(node) = self.tree.node(place) else {
            return report.report(self.at(Fault::SectionCount, place));
        };
        for child in 0..CLUSTER_CHILDREN {
            let [start, clusters] = range(first, count, child);
            let bytes = Child::of(node, child as usize);
            if clusters == 0 {
                if bytes != Child::default() {
                    report.report(self.at(Fault::ClusterUnused, place));
                }
                continue;
            }
            let reach = self.tile.size.map(|size| size.div_ceil(self.unit));
            let inside = |[low, high]: [u8; 2], reach: u32| low <= high && u32::from(high) < reach;
            if bytes.s[0] > bytes.s[1]
                || bytes.t[0] > bytes.t[1]
                || !inside(bytes.x, reach[0])
                || !inside(bytes.y, reach[1])
            {
                report.report(self.at(Fault::ClusterBox, place));
            }
            let is_leaf = self.has_leaves && depth == 1;
            match LeafKind::of(bytes.kind) {
                Some(LeafKind::Narrow) => {}
                Some(kind) if is_leaf => *self.fine += u64::from(kind == LeafKind::Wide),
                _ => report.report(self.at(Fault::ClusterLeafKind, place)),
            }
            if is_leaf {
                self.leaf(place, node, child, start, parent, report);
            }
        }
    }

    fn leaf(
        &mut self,
        place: u64,
        node: &ClusterNode,
        child: u32,
        cluster: u32,
        parent: Box2,
        report: &mut Limited<'_>,
    ) {
        let shape = self.tile.shape;
        let leaf = self.tile.first_leaf + u64::from(cluster);
        let texels = shape.first_texel(cluster + 1) - shape.first_texel(cluster);
        let Some([low, extent]) = child_box(node, child as usize, parent) else {
            return;
        };
        let kind = Child::of(node, child as usize).kind;
        if LeafKind::of(kind) == Some(LeafKind::Wide) {
            let expected = Some(*self.fine as usize - 1);
            if self.tree.fine_place(place, &node.deviation_xy, child) != expected {
                return report.report(self.at(Fault::ClusterLeafKind, place));
            }
        }
        let mut sum = [0.0; 2];
        for texel in 0..texels as usize {
            let found = self
                .tree
                .leaf_texel(place, child, leaf, texel, [low, extent]);
            let Ok(texel) = found else {
                return report.report(self.at(Fault::ClusterLeafKind, place));
            };
            let [x, y] = texel.place;
            match self.seen.get_mut(y as usize) {
                Some(row) if x < self.tile.size[0] && y < self.tile.size[1] => *row |= 1 << x,
                _ => report.report(self.at(Fault::ClusterBox, place)),
            }
            if let Some(raster) = self.raster {
                self.compare(raster, texel, leaf_slack(node, child, extent), report);
            }
            sum = [sum[0] + texel.normal[0], sum[1] + texel.normal[1]];
        }
        if self.has_rest(leaf, kind, texels) {
            report.report(self.at(Fault::ClusterUnused, place));
        }
        let mean = |at: usize, bytes: &[u8; 16]| {
            let byte = bytes.get(child as usize).copied().unwrap_or_default();
            let (low, extent) = (low.get(at).copied(), extent.get(at).copied());
            let (low, extent) = low.zip(extent).unwrap_or_default();
            (
                low + f64::from(byte) / 255.0 * extent,
                extent / 255.0 + 1e-6,
            )
        };
        for (at, bytes) in [(0, &node.mean_s), (1, &node.mean_t)] {
            let (mean, slack) = mean(at, bytes);
            let sum = sum.get(at).copied().unwrap_or_default();
            if (sum - mean * f64::from(texels)).abs() > slack * f64::from(texels) {
                report.report(self.at(Fault::ClusterMoments, place));
            }
        }
    }

    /// Checks that `raster` has the normal of `texel`, which its leaf rounds by `slack` at most.
    fn compare(
        &self,
        raster: &Raster<'_>,
        texel: LeafTexel,
        slack: [f64; 2],
        report: &mut Limited<'_>,
    ) {
        let [column, row] = self.tile.origin;
        let [x, y] = texel.place;
        let place = [column.saturating_add(x), row.saturating_add(y)];
        let Ok(normal) = raster.normal(place[0], place[1]) else {
            return;
        };
        let [_, step] = raster.lattice.offset_and_step();
        let off = normal
            .iter()
            .zip(texel.normal)
            .zip(slack)
            .any(|((own, leaf), slack)| (own - leaf).abs() > 0.5 * step + slack + 1e-6);
        if off {
            let texel = u64::from(place[1]) * u64::from(raster.size[0]) + u64::from(place[0]);
            let fault = Finding::new(Fault::RasterNormal).within(raster.id);
            report.report(fault.at(texel));
        }
    }

    /// Whether the words of `leaf` beyond its texels are not zero.
    fn has_rest(&self, leaf: u64, kind: u8, texels: u32) -> bool {
        let Some(leaf) = self.tree.leaves.get(leaf as usize) else {
            return false;
        };
        if LeafKind::of(kind) == Some(LeafKind::Palette) {
            let words = leaf.0.iter().skip(8).map(|word| word.get());
            return words
                .flat_map(|word| [word & 0xFFFF, word >> 16])
                .skip(texels as usize)
                .any(|entry| entry != 0);
        }
        leaf.0
            .iter()
            .skip(texels as usize)
            .any(|word| word.get() != 0)
    }
}

/// Reports normals of `raster` that lie outside the disk, and words beyond the map that are not zero.
fn check_raster(raster: &Raster<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let [_, step] = raster.lattice.offset_and_step();
    // A normal on the rim may be rounded beyond it, by half a step of either component.
    let most = (1.0 + step) * (1.0 + step);
    let mut place = 0;
    for row in 0..raster.size[1].div_ceil(RASTER_SIDE) {
        for column in 0..raster.columns {
            let words = raster.blocks.get(place).map(|block| block.0);
            for (number, word) in (0..).zip(words.into_iter().flatten()) {
                let x = RASTER_SIDE * column + number % RASTER_SIDE;
                let y = RASTER_SIDE * row + number / RASTER_SIDE;
                let fault = if x >= raster.size[0] || y >= raster.size[1] {
                    (word.get() != 0).then_some(Fault::RasterUnused)
                } else {
                    let numbers = unpack_raster(word.get());
                    let [s, t] = numbers.map(|n| raster.lattice.component(n));
                    let is_there = numbers.iter().all(|&n| raster.lattice.has(n));
                    (!is_there || s * s + t * t > most).then_some(Fault::RasterRange)
                };
                if let Some(fault) = fault {
                    limited.report(Finding::new(fault).within(raster.id).at(place as u64));
                }
            }
            place += 1;
        }
    }
}

/// How far the texels of a leaf, child `child` of `node`, may be off what they were before rounding, in s and t; its box of
/// normals runs over `extent`.
fn leaf_slack(node: &ClusterNode, child: u32, extent: [f64; 2]) -> [f64; 2] {
    let bytes = Child::of(node, child as usize);
    let steps = match LeafKind::of(bytes.kind) {
        Some(LeafKind::Palette) => return [0.0; 2],
        kind => {
            let side = |[first, last]: [u8; 2]| last.wrapping_sub(first);
            let most = LeafBits::new(side(bytes.x), side(bytes.y)).most();
            f64::from(most)
                * if kind == Some(LeafKind::Wide) {
                    16.0
                } else {
                    1.0
                }
        }
    };
    extent.map(|extent| 0.5 * extent / steps)
}

/// First bottom cluster, and number of them, of child `child` of a node that has `count` from `first`.
fn range(first: u32, count: u32, child: u32) -> [u32; 2] {
    let start = TileShape::child_cluster(first, count, child);
    [
        start,
        TileShape::child_cluster(first, count, child + 1) - start,
    ]
}

/// What a node says of one child.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Child {
    s: [u8; 2],
    t: [u8; 2],
    x: [u8; 2],
    y: [u8; 2],
    kind: u8,
    moments: [u8; 7],
}

impl Child {
    fn of(node: &ClusterNode, child: usize) -> Self {
        let at = |bytes: &[u8; 16]| bytes.get(child).copied().unwrap_or_default();
        Self {
            s: [at(&node.low_s), at(&node.high_s)],
            t: [at(&node.low_t), at(&node.high_t)],
            x: [at(&node.low_x), at(&node.high_x)],
            y: [at(&node.low_y), at(&node.high_y)],
            kind: at(&node.deviation_xy),
            moments: [
                at(&node.mean_s),
                at(&node.mean_t),
                at(&node.deviation_s),
                at(&node.deviation_t),
                at(&node.correlation),
                at(&node.mean_x),
                at(&node.mean_y),
            ],
        }
    }
}

/// The box of child `child` of `node`, which itself has the box `parent`.
fn child_box(node: &ClusterNode, child: usize, [low, extent]: Box2) -> Option<Box2> {
    let of = |low_byte: &[u8; 16], high_byte: &[u8; 16], low: f64, extent: f64| {
        let (from, to) = (*low_byte.get(child)?, *high_byte.get(child)?);
        let step = extent / 255.0;
        let reach = f64::from(to) - f64::from(from);
        Some([low + f64::from(from) * step, reach * step])
    };
    let [low_s, extent_s] = of(&node.low_s, &node.high_s, low[0], extent[0])?;
    let [low_t, extent_t] = of(&node.low_t, &node.high_t, low[1], extent[1])?;
    Some([[low_s, low_t], [extent_s, extent_t]])
}
