//! Cluster trees: the texels of each tile split by position and normal into ever smaller groups, each with its moments.
//!
//! See docs/cluster-tree.md for the structure and [`ClusterLayout`] for its places. A group is halved at the median of its
//! widest side, where a texel of position is worth 1/128 of a component of a normal; four halvings make the
//! sixteen children of a node.
//!
//! Tiles of 64 and of 256 texels are split texel by texel, tiles of 1024 by groups of 16 that their tiles of 256 are split into
//! further. O(N) in the texels of the map. The same for any number of threads.

mod encode;
mod moments;
mod split;

use crate::normals::NormalMap;
use encode::Encoder;
use glintbake_format::model::{CLUSTER_CHILDREN, ClusterLayout, ClusterLevel, ClusterTile};
use glintbake_format::records::{ClusterLeaf, ClusterNode, FineBits, TileRoot};
use moments::Inner;
use rayon::prelude::*;
use split::Item;
use zerocopy::little_endian::U32;

/// What a texel of position is worth in a tile of 64, as a change of a normal's component: larger values make clusters
/// compact in position, smaller ones in their normals.
const TEXEL_WORTH: f64 = 256.0 / 32768.0;
/// The same in larger tiles, where boxes matter less, times 64 over their side.
const COARSE_TEXEL_WORTH: f64 = 2.0 / 32768.0;

/// The sections of a cluster tree.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusterSections {
    /// Roots of all tiles, level by level.
    pub roots: Vec<TileRoot>,
    /// Nodes of all tiles.
    pub nodes: Vec<ClusterNode>,
    /// Leaves of the finest tiles.
    pub leaves: Vec<ClusterLeaf>,
    /// Finer bits of wide leaves.
    pub fine: Vec<FineBits>,
    /// Places in `fine` by node of the finest tiles; empty if `fine` is.
    pub fine_starts: Vec<U32>,
}

/// One tile's part of the sections.
#[derive(Clone, Debug, Default)]
struct TileSections {
    root: Option<TileRoot>,
    nodes: Vec<ClusterNode>,
    leaves: Vec<ClusterLeaf>,
    fine: Vec<FineBits>,
    /// Lines of `fine` before each node's.
    fine_before: Vec<u32>,
}

/// The cluster tree of `map`, which must be no wider and no higher than the format allows.
///
/// Peak memory beside the map and what is stored: 16 bytes a texel of the tiles at hand.
///
/// # Panics
/// If a side of the map is above 65535.
pub fn build(map: &NormalMap) -> ClusterSections {
    let layout = ClusterLayout::new(map.width(), map.height()).expect("sides were checked");
    let level = layout.level(0);
    let mut sections = ClusterSections {
        roots: Vec::with_capacity(layout.root_count() as usize),
        nodes: Vec::with_capacity(layout.node_count() as usize),
        leaves: Vec::with_capacity(layout.leaf_count() as usize),
        fine: Vec::new(),
        fine_starts: Vec::new(),
    };
    for row in 0..level.tiles[1] {
        let tiles: Vec<TileSections> = (0..level.tiles[0])
            .into_par_iter()
            .map(|column| texel_tile(map, &level, &level.tile(column, row)))
            .collect();
        for tile in tiles {
            sections.push(tile);
        }
    }
    if sections.fine.is_empty() {
        sections.fine_starts = Vec::new();
    }
    if layout.levels() == 2 {
        let level = layout.level(1);
        let tiles: Vec<TileSections> = all_tiles(&level)
            .into_par_iter()
            .map(|tile| texel_tile(map, &level, &tile))
            .collect();
        for tile in tiles {
            sections.push_coarse(tile);
        }
    } else if layout.levels() == 3 {
        sections.push_large(map, layout);
    }
    sections
}

fn all_tiles(level: &ClusterLevel) -> Vec<ClusterTile> {
    (0..level.tiles[1])
        .flat_map(|row| (0..level.tiles[0]).map(move |column| level.tile(column, row)))
        .collect()
}

impl ClusterSections {
    fn push(&mut self, tile: TileSections) {
        let first = self.fine.len() as u32;
        self.fine_starts.extend(
            tile.fine_before
                .iter()
                .map(|&before| U32::new(first + before)),
        );
        self.fine.extend(tile.fine);
        self.leaves.extend(tile.leaves);
        self.push_coarse(TileSections {
            fine: Vec::new(),
            leaves: Vec::new(),
            fine_before: Vec::new(),
            ..tile
        });
    }

    fn push_coarse(&mut self, tile: TileSections) {
        self.roots.extend(tile.root);
        self.nodes.extend(tile.nodes);
    }

    /// Adds the tiles of 256 and of 1024 texels: each of the latter together with those in it, whose clusters it is made of.
    fn push_large(&mut self, map: &NormalMap, layout: ClusterLayout) {
        let (middle, large) = (layout.level(1), layout.level(2));
        let mut rows_of_large = Vec::new();
        let mut large_tiles = Vec::new();
        for row in 0..large.tiles[1] {
            // A row of large tiles at a time bounds memory.
            let mut made: Vec<(Vec<Vec<TileSections>>, TileSections)> = (0..large.tiles[0])
                .into_par_iter()
                .map(|column| large_tile(map, &middle, &large, [column, row]))
                .collect();
            for inner_row in 0..4 {
                for (inner, _) in &mut made {
                    if let Some(row) = inner.get_mut(inner_row) {
                        rows_of_large.append(row);
                    }
                }
            }
            large_tiles.extend(made.into_iter().map(|(_, tile)| tile));
        }
        for tile in rows_of_large.into_iter().chain(large_tiles) {
            self.push_coarse(tile);
        }
    }
}

/// The texels of `tile` of `map`.
fn texels(map: &NormalMap, tile: &ClusterTile) -> Vec<Item> {
    let mut items = Vec::with_capacity(tile.shape.texels as usize);
    let width = map.width() as usize;
    for y in 0..tile.size[1] {
        let start = (tile.origin[1] + y) as usize * width + tile.origin[0] as usize;
        let row = &map.texels()[start..start + tile.size[0] as usize];
        for (x, &normal) in (0..).zip(row) {
            items.push(Item {
                normal,
                place: [x, y as u16],
                id: y << 16 | u32::from(x),
            });
        }
    }
    items
}

/// The tile of `level` from the texels of `map`.
fn texel_tile(map: &NormalMap, level: &ClusterLevel, tile: &ClusterTile) -> TileSections {
    tree(level, tile, &mut texels(map, tile), &[])
}

/// Texels of the groups that tiles of 1024 are made of.
const GROUP: usize = 16;

/// The texels of whole tiles, ordered by cluster, split on into groups of [`GROUP`].
fn groups(items: &mut [Item], level: &ClusterLevel) -> Vec<(Item, Inner)> {
    let clusters = level.tile(0, 0).shape.clusters as usize;
    let size = items.len() / clusters;
    let ends: Vec<usize> = (0..=size / GROUP).map(|group| group * GROUP).collect();
    let worth = worth(level);
    let mut groups = Vec::with_capacity(items.len() / GROUP);
    for cluster in items.chunks_exact_mut(size) {
        split::split(cluster, &ends, worth);
        for group in cluster.chunks_exact(GROUP) {
            let moments = Inner::of(group, &[]);
            let item = Item {
                normal: moments.mean.map(|x| x as f32),
                place: moments.place.map(|x| x as u16),
                id: 0,
            };
            groups.push((item, moments));
        }
    }
    groups
}

/// Tile number `place` of the level of 1024 texels, and in rows those of the level of 256 in it.
fn large_tile(
    map: &NormalMap,
    middle: &ClusterLevel,
    large: &ClusterLevel,
    place: [u32; 2],
) -> (Vec<Vec<TileSections>>, TileSections) {
    let tile = large.tile(place[0], place[1]);
    let end = |axis: usize| (4 * place[axis] + 4).min(middle.tiles[axis]);
    let columns = 4 * place[0]..end(0);
    let whole = tile.size == [large.side; 2];
    let places: Vec<[u32; 2]> = (4 * place[1]..end(1))
        .flat_map(|row| columns.clone().map(move |column| [column, row]))
        .collect();
    let made: Vec<_> = places
        .into_par_iter()
        .map(|[column, row]| {
            let inner = middle.tile(column, row);
            let mut items = texels(map, &inner);
            let sections = tree(middle, &inner, &mut items, &[]);
            let mut clusters = if whole {
                groups(&mut items, middle)
            } else {
                Vec::new()
            };
            for (item, inner_moments) in &mut clusters {
                for axis in 0..2 {
                    let offset = (inner.origin[axis] - tile.origin[axis]) as u16;
                    item.place[axis] += offset;
                    inner_moments.shift(axis, offset);
                }
            }
            (sections, clusters)
        })
        .collect();
    let mut clusters = Vec::new();
    let mut rows: Vec<Vec<TileSections>> = Vec::new();
    for (number, (sections, own)) in made.into_iter().enumerate() {
        if number % columns.len() == 0 {
            rows.push(Vec::new());
        }
        rows.last_mut()
            .expect("a row was just begun")
            .push(sections);
        clusters.extend(own);
    }
    let sections = if whole {
        let mut items = Vec::with_capacity(clusters.len());
        let mut inner = Vec::with_capacity(clusters.len());
        for (id, (item, moments)) in (0..).zip(clusters) {
            items.push(Item { id, ..item });
            inner.push(moments);
        }
        tree(large, &tile, &mut items, &inner)
    } else {
        texel_tile(map, large, &tile)
    };
    (rows, sections)
}

/// What a texel of position is worth in tiles of `level`.
fn worth(level: &ClusterLevel) -> f64 {
    if level.number == 0 {
        TEXEL_WORTH
    } else {
        COARSE_TEXEL_WORTH * 64.0 / f64::from(level.side)
    }
}

/// The tree over `items`, texels or groups of `inner` moments, of `tile`; orders `items` by cluster.
fn tree(
    level: &ClusterLevel,
    tile: &ClusterTile,
    items: &mut [Item],
    inner: &[Inner],
) -> TileSections {
    let shape = tile.shape;
    let worth = worth(level);
    // Groups have one number of texels.
    let texels_an_item = shape.texels / items.len() as u32;
    let mut encoder = Encoder::new(level, tile, items, inner, texels_an_item);
    encoder.node(items, inner, [0, shape.clusters], worth);
    if shape.depth() >= 2 {
        for child in 0..CLUSTER_CHILDREN {
            encoder.inner_node(items, inner, &[child], worth);
        }
    }
    if shape.depth() >= 3 {
        for child in 0..CLUSTER_CHILDREN {
            for grandchild in 0..CLUSTER_CHILDREN {
                encoder.inner_node(items, inner, &[child, grandchild], worth);
            }
        }
    }
    encoder.finish()
}

#[cfg(test)]
mod tests;
