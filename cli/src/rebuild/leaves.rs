//! The texels of a cluster tree, leaf by leaf.

use glintbake_format::model::{CLUSTER_CHILDREN, ClusterTile, TileShape};
use glintbake_format::records::{ClusterNode, Instance};
use glintbake_format::view::ClusterTree;
use glintbake_format::{Container, Fault, Finding};

/// A box of normals: where it begins, and how far it runs.
type NormalBox = [[f64; 2]; 2];

/// The normals of the texels that `instance` of `container` was baked from, as its tree stores them, row by row.
///
/// # Errors
/// If a part of the tree is missing or damaged, or its leaves do not hold every texel.
pub(super) fn from_leaves(
    container: &Container<'_>,
    instance: &Instance,
) -> Result<Vec<[f32; 2]>, Finding> {
    let tree = ClusterTree::of_map(container, instance)?;
    let level = tree.layout.level(0);
    let mut texels = Texels {
        width: instance.width as usize,
        normals: vec![None; instance.texel_count() as usize],
    };
    for row in 0..level.tiles[1] {
        for column in 0..level.tiles[0] {
            texels.read(&tree, &level.tile(column, row))?;
        }
    }
    let missing = || Finding::new(Fault::ClusterTexels).within(tree.id);
    let normals = texels.normals.into_iter();
    normals.map(|normal| normal.ok_or_else(missing)).collect()
}

/// What was found so far.
struct Texels {
    width: usize,
    normals: Vec<Option<[f32; 2]>>,
}

impl Texels {
    /// Reads all leaves of `tile`.
    fn read(&mut self, tree: &ClusterTree<'_>, tile: &ClusterTile) -> Result<(), Finding> {
        let root = tree.root(tile)?;
        let whole = [
            root.low.map(|x| f64::from(x.get())),
            root.step.map(|x| 255.0 * f64::from(x.get())),
        ];
        let range = [0, tile.shape.clusters];
        if tile.shape.depth() == 1 {
            return self.leaves(tree, tile, tile.first_node, range, whole);
        }
        let node = tree.node(tile.first_node)?;
        for child in 0..CLUSTER_CHILDREN {
            let place = tile.first_node + 1 + u64::from(child);
            let below = child_box(node, child, whole);
            self.leaves(tree, tile, place, child_range(range, child), below)?;
        }
        Ok(())
    }

    /// Reads the leaves under the node at `place`, which holds `count` clusters from `first`.
    fn leaves(
        &mut self,
        tree: &ClusterTree<'_>,
        tile: &ClusterTile,
        place: u64,
        range: [u32; 2],
        own: NormalBox,
    ) -> Result<(), Finding> {
        let node = tree.node(place)?;
        for child in 0..CLUSTER_CHILDREN {
            let [cluster, count] = child_range(range, child);
            if count == 0 {
                continue;
            }
            let texels = tile.shape.first_texel(cluster + 1) - tile.shape.first_texel(cluster);
            let leaf = tile.first_leaf + u64::from(cluster);
            let below = child_box(node, child, own);
            for number in 0..texels as usize {
                let texel = tree.leaf_texel(place, child, leaf, number, below)?;
                let [x, y] = texel.place;
                if x >= tile.size[0] || y >= tile.size[1] {
                    return Err(Finding::new(Fault::ClusterBox).within(tree.id).at(place));
                }
                let column = (tile.origin[0] + x) as usize;
                let row = (tile.origin[1] + y) as usize;
                self.normals[row * self.width + column] =
                    Some(texel.normal.map(|component| component as f32));
            }
        }
        Ok(())
    }
}

/// First bottom cluster, and number of them, of child `child` of a node that has `count` from `first`.
fn child_range([first, count]: [u32; 2], child: u32) -> [u32; 2] {
    let start = TileShape::child_cluster(first, count, child);
    [
        start,
        TileShape::child_cluster(first, count, child + 1) - start,
    ]
}

/// The box of child `child` of `node`, whose own is `low` and `extent`.
fn child_box(node: &ClusterNode, child: u32, [low, extent]: NormalBox) -> NormalBox {
    let side = |from: &[u8; 16], to: &[u8; 16], axis: usize| {
        let step = extent[axis] / 255.0;
        let [from, to] = [from, to].map(|bytes| f64::from(bytes[child as usize]));
        [low[axis] + from * step, (to - from) * step]
    };
    let s = side(&node.low_s, &node.high_s, 0);
    let t = side(&node.low_t, &node.high_t, 1);
    [[s[0], t[0]], [s[1], t[1]]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_bake::normals::NormalMap;
    use glintbake_bake::{MethodRecipe, Recipe, bake};
    use glintbake_format::model::{Method, Wrap};
    use glintbake_runtime::Package;
    use glintbake_samples::{Kind, Options, generate};

    #[test]
    fn every_texel_comes_back_from_its_leaf_to_what_leaves_round() {
        for (kind, width, height) in [
            (Kind::Noise, 13, 7),
            (Kind::Waves, 130, 67),
            (Kind::Flakes, 70, 1),
        ] {
            let options = Options {
                width,
                height,
                ..Options::new(kind, 1)
            };
            let sample = generate(kind, &options).expect("in range");
            let map = NormalMap::new(width, height, Wrap::Repeat, sample.normals);
            let method = MethodRecipe::new(Method::ClusterTree, &[0.1]);
            let plan = bake(&map, &Recipe::new(vec![method]), None).expect("in range");
            let bytes = plan.to_bytes();
            let package = Package::open(&bytes).expect("it was just baked");
            let instance = package.instances().next().expect("one was baked");
            let texels = from_leaves(package.container(), &instance).expect("it is sound");
            assert_eq!(texels.len(), map.texels().len());
            let mut worst: f32 = 0.0;
            for (stored, baked) in texels.iter().zip(map.texels()) {
                for axis in 0..2 {
                    worst = worst.max((stored[axis] - baked[axis]).abs());
                }
            }
            assert!(worst <= 1.6e-5, "{kind:?}: {worst}");
        }
    }
}
