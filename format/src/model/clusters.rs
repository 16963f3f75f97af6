//! Cluster trees: how a map is cut into tiles, and a tile's texels into nodes and leaves.
//!
//! Nothing here is stored: place and size of every tile, node and leaf follow from the size of the map.

/// Children of a node, and the most texels of a leaf.
pub const CLUSTER_CHILDREN: u32 = 16;

/// Levels of tiles a tree can have.
pub const CLUSTER_LEVELS: usize = 3;

/// Sides of the tiles of each level, in texels.
const SIDES: [u32; CLUSTER_LEVELS] = [64, 256, 1024];
/// Most texels of a bottom cluster on each level: the leaves of level 0, which are stored, and clusters that are not.
const BOTTOM: [u32; CLUSTER_LEVELS] = [16, 16, 256];

/// The tiles of a map on every level, and where their nodes and leaves are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClusterLayout {
    size: [u32; 2],
}

/// One level of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClusterLevel {
    /// Its number, 0 for the tiles that have leaves.
    pub number: u32,
    /// Side of its tiles in texels, but for those cut by the map's right and lower border.
    pub side: u32,
    /// Columns and rows of tiles.
    pub tiles: [u32; 2],
    /// Place of its first tile's root.
    first_root: u32,
    /// Place of its first tile's first node.
    first_node: u64,
    /// Nodes and leaves of a tile that is not in the last column, that is; of a row of tiles; both for other rows than
    /// the last, and for the last.
    shapes: [[TileShape; 2]; 2],
    size: [u32; 2],
}

/// What the number of texels in a tile says of its tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileShape {
    /// Texels, at least 1.
    pub texels: u32,
    /// Bottom clusters: leaves on level 0.
    pub clusters: u32,
}

/// One tile of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClusterTile {
    /// Its texels and bottom clusters.
    pub shape: TileShape,
    /// Column and row of its first texel.
    pub origin: [u32; 2],
    /// Columns and rows of texels.
    pub size: [u32; 2],
    /// Place of its root record.
    pub root: u32,
    /// Place of its first node, the root of its tree.
    pub first_node: u64,
    /// Place of its first leaf; means nothing above level 0.
    pub first_leaf: u64,
}

impl TileShape {
    const fn new(width: u32, height: u32, bottom: u32) -> Self {
        let texels = width * height;
        Self {
            texels,
            clusters: texels.div_ceil(bottom),
        }
    }

    /// Levels of nodes: 1 to 3.
    pub const fn depth(self) -> u32 {
        if self.clusters <= 16 {
            1
        } else if self.clusters <= 256 {
            2
        } else {
            3
        }
    }

    /// Nodes: 1, 17 or 273.
    pub const fn nodes(self) -> u32 {
        match self.depth() {
            1 => 1,
            2 => 17,
            _ => 273,
        }
    }

    /// The first texel of bottom cluster `cluster`, in the order of the clusters; the number of texels for the one after
    /// the last.
    #[inline]
    pub const fn first_texel(self, cluster: u32) -> u32 {
        (self.texels as u64 * cluster as u64 / self.clusters as u64) as u32
    }

    /// The first bottom cluster of child `child` (16 for the end of the last) of a node that has `count` from `first`.
    #[inline]
    pub const fn child_cluster(first: u32, count: u32, child: u32) -> u32 {
        first + count * child / CLUSTER_CHILDREN
    }

    /// Whether every node splits into 16 of one size down to single clusters, and these have one number of texels.
    pub const fn is_even(self) -> bool {
        (self.clusters == 16 || self.clusters == 256 || self.clusters == 4096)
            && self.texels.is_multiple_of(self.clusters)
    }
}

impl ClusterLayout {
    /// The tiles of a map of `width` × `height` texels; `None` if it is empty or a side is above 65535.
    pub const fn new(width: u32, height: u32) -> Option<Self> {
        if width == 0 || height == 0 || width > 0xFFFF || height > 0xFFFF {
            return None;
        }
        Some(Self {
            size: [width, height],
        })
    }

    /// Columns and rows of the map.
    pub const fn map_size(self) -> [u32; 2] {
        self.size
    }

    /// The number of levels, 1 to 3: each next one if the map is wider or higher than a tile of the one before.
    pub const fn levels(self) -> u32 {
        let [width, height] = self.size;
        let longer = if width > height { width } else { height };
        1 + (longer > SIDES[0]) as u32 + (longer > SIDES[1]) as u32
    }

    /// Level `number`; the last one for numbers beyond.
    pub const fn level(self, number: u32) -> ClusterLevel {
        let mut first_root = 0;
        let mut first_node = 0;
        let mut at = 0;
        loop {
            let level = self.level_at(at, first_root, first_node);
            if at >= number || at + 1 >= self.levels() {
                return level;
            }
            first_root += level.tiles[0] * level.tiles[1];
            first_node += level.node_count();
            at += 1;
        }
    }

    const fn level_at(self, number: u32, first_root: u32, first_node: u64) -> ClusterLevel {
        let (side, bottom) = match number {
            0 => (SIDES[0], BOTTOM[0]),
            1 => (SIDES[1], BOTTOM[1]),
            _ => (SIDES[2], BOTTOM[2]),
        };
        let [width, height] = self.size;
        let tiles = [width.div_ceil(side), height.div_ceil(side)];
        let last = [
            width - (tiles[0] - 1) * side,
            height - (tiles[1] - 1) * side,
        ];
        ClusterLevel {
            number,
            side,
            tiles,
            first_root,
            first_node,
            shapes: [
                [
                    TileShape::new(side, side, bottom),
                    TileShape::new(last[0], side, bottom),
                ],
                [
                    TileShape::new(side, last[1], bottom),
                    TileShape::new(last[0], last[1], bottom),
                ],
            ],
            size: self.size,
        }
    }

    /// Roots of all levels: one a tile.
    pub const fn root_count(self) -> u64 {
        let last = self.level(self.levels() - 1);
        last.first_root as u64 + last.tiles[0] as u64 * last.tiles[1] as u64
    }

    /// Nodes of all levels.
    pub const fn node_count(self) -> u64 {
        let last = self.level(self.levels() - 1);
        last.first_node + last.node_count()
    }

    /// Leaves, all of level 0.
    pub const fn leaf_count(self) -> u64 {
        let level = self.level(0);
        let [_, rows] = level.tiles;
        (rows as u64 - 1) * level.row_clusters(false) + level.row_clusters(true)
    }
}

impl ClusterLevel {
    /// Nodes of the whole level.
    pub const fn node_count(self) -> u64 {
        let [_, rows] = self.tiles;
        (rows as u64 - 1) * self.row_nodes(false) + self.row_nodes(true)
    }

    /// The shapes of the tiles of a row: of all but the last, and of the last.
    const fn row_shapes(self, is_last: bool) -> [TileShape; 2] {
        let [others, last] = self.shapes;
        if is_last { last } else { others }
    }

    const fn row_nodes(self, is_last: bool) -> u64 {
        let [inner, outer] = self.row_shapes(is_last);
        (self.tiles[0] as u64 - 1) * inner.nodes() as u64 + outer.nodes() as u64
    }

    const fn row_clusters(self, is_last: bool) -> u64 {
        let [inner, outer] = self.row_shapes(is_last);
        (self.tiles[0] as u64 - 1) * inner.clusters as u64 + outer.clusters as u64
    }

    /// The tile in `column` and `row`; the nearest one if there is none.
    #[inline]
    pub const fn tile(&self, column: u32, row: u32) -> ClusterTile {
        let [columns, rows] = self.tiles;
        let last_column = column >= columns - 1;
        let last_row = row >= rows - 1;
        let column = if last_column { columns - 1 } else { column };
        let row = if last_row { rows - 1 } else { row };
        let shapes = if last_row {
            &self.shapes[1]
        } else {
            &self.shapes[0]
        };
        let shape = if last_column { shapes[1] } else { shapes[0] };
        let origin = [column * self.side, row * self.side];
        ClusterTile {
            shape,
            origin,
            size: [
                if last_column {
                    self.size[0] - origin[0]
                } else {
                    self.side
                },
                if last_row {
                    self.size[1] - origin[1]
                } else {
                    self.side
                },
            ],
            root: self.first_root + row * columns + column,
            first_node: self.first_node
                + row as u64 * self.row_nodes(false)
                + column as u64 * shapes[0].nodes() as u64,
            first_leaf: row as u64 * self.row_clusters(false)
                + column as u64 * shapes[0].clusters as u64,
        }
    }

    /// Texels to a unit of stored positions: 1, but 4 on the level of 1024 texels.
    pub const fn unit(&self) -> u32 {
        self.side.div_ceil(256)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_nodes_and_leaves_follow_each_other_without_gaps() {
        for [width, height] in [
            [1, 1],
            [64, 64],
            [65, 3],
            [200, 130],
            [1100, 700],
            [2048, 2048],
        ] {
            let layout = ClusterLayout::new(width, height).unwrap();
            let (mut root, mut node, mut leaf) = (0, 0, 0);
            for number in 0..layout.levels() {
                let level = layout.level(number);
                let mut texels = 0;
                for row in 0..level.tiles[1] {
                    for column in 0..level.tiles[0] {
                        let tile = level.tile(column, row);
                        assert_eq!(tile.root, root);
                        assert_eq!(tile.first_node, node);
                        assert_eq!(tile.shape.texels, tile.size[0] * tile.size[1]);
                        root += 1;
                        node += u64::from(tile.shape.nodes());
                        texels += tile.shape.texels;
                        if number == 0 {
                            assert_eq!(tile.first_leaf, leaf);
                            leaf += u64::from(tile.shape.clusters);
                        }
                    }
                }
                assert_eq!(texels, width * height);
            }
            assert_eq!(u64::from(root), layout.root_count());
            assert_eq!(node, layout.node_count());
            assert_eq!(leaf, layout.leaf_count());
        }
    }

    #[test]
    fn clusters_of_any_number_of_texels_hold_a_few_each() {
        for texels in 1..=4096 {
            let shape = TileShape::new(texels, 1, 16);
            let sizes = (0..shape.clusters)
                .map(|cluster| shape.first_texel(cluster + 1) - shape.first_texel(cluster));
            assert!(
                sizes.clone().all(|size| (1..=16).contains(&size)),
                "{texels}"
            );
            assert_eq!(sizes.sum::<u32>(), texels);
            assert_eq!(shape.first_texel(0), 0);
        }
        let even = TileShape::new(64, 64, 16);
        assert!(even.is_even() && (even.depth(), even.nodes()) == (2, 17));
        assert!(!TileShape::new(63, 64, 16).is_even());
    }

    #[test]
    fn bytes_stay_below_six_and_a_half_a_texel() {
        let layout = ClusterLayout::new(2048, 2048).unwrap();
        let bytes = 16 * layout.root_count() + 256 * layout.node_count() + 64 * layout.leaf_count();
        assert!(bytes as f64 / (2048.0 * 2048.0) < 6.3, "{bytes}");
    }
}
