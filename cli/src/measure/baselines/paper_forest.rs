//! The look-up of \[AWKK21\] §5.4 as printed: index, inverse bin map, and a forest of midpoint kd-trees.
//!
//! What `flake-bins` is measured against (`benches/contest.rs`), and nothing else: it shares no code with the baker or
//! the runtime but the definition of bins.
//!
//! - Index: size and offset for every bin of the grid. A list of at most `L` texels is one leaf.
//! - Inverse bin map: 16-bit positions, the texels of each tree's node consecutive.
//! - Forest: a kd-tree for each list longer than `L`. The larger side of a cell is always split in the middle, so no
//!   split is stored; a node stores where in the inverse bin map its second half begins. All in one list of integers.
//!
//! The paper leaves three things open. The texels of crossing leaves count by their exact clipped area (eq. 12; the
//! authors' released code takes them as in or out by their middle). A map is taken to repeat. And no small footprint
//! is evaluated texel by texel instead (§4.1): that is `plain_scan`'s row of the contest.

use super::parallelogram::{Parallelogram, Relation};
use super::window::{self, MOST_BINS};
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{BinGrid, Footprint, HalfVector, Neighbourhood, Wrap};

/// The paper's leaf size.
pub const LEAF_SIZE: u32 = 10;

/// How the trees of a window's bins are gone through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Traversal {
    /// All trees at once, each cell tested against the footprint once for all: the end of §5.4.
    #[default]
    Together,
    /// One tree after the other.
    OneByOne,
}

/// A map's normals by bin, in the paper's structure.
#[derive(Clone, Debug)]
pub struct PaperForest {
    width: u32,
    height: u32,
    grid: BinGrid,
    leaf_size: u32,
    index: Vec<Bin>,
    positions: Vec<[u16; 2]>,
    forest: Vec<u32>,
}

/// An entry of the index.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    size: u32,
    /// Start of the list in the inverse bin map, or, of a list longer than a leaf, of its tree in the forest.
    offset: u32,
}

impl PaperForest {
    /// The texels of `map` by their bin on `grid`, with trees over lists longer than `leaf_size`.
    ///
    /// A tree is its list's start followed by its nodes, parents first. A node is the place in the inverse bin map where
    /// its second half begins; if both halves are nodes, the place of the second in the forest follows it. Leaves
    /// need nothing: that a half is one follows from its size.
    ///
    /// # Panics
    /// If `map` does not repeat, has a side above 65 535, or `leaf_size` is 0.
    pub fn new(map: &NormalMap, grid: BinGrid, leaf_size: u32) -> Self {
        let (width, height) = (map.width(), map.height());
        assert_eq!(
            map.wrap(),
            Wrap::Repeat,
            "the baselines are for maps that repeat"
        );
        assert!(width.max(height) <= 65_535, "positions are of 16 bits");
        assert!(leaf_size > 0, "a leaf holds a texel at least");
        let bins: Vec<u32> = bins(map, grid).collect();
        let mut index = vec![Bin::default(); grid.count() as usize];
        for &bin in &bins {
            index[bin as usize].size += 1;
        }
        let mut next = Vec::with_capacity(index.len());
        let mut total = 0;
        for bin in &mut index {
            bin.offset = total;
            next.push(total);
            total += bin.size;
        }
        let mut positions = vec![[0; 2]; bins.len()];
        for (texel, &bin) in bins.iter().enumerate() {
            let place = &mut next[bin as usize];
            let (column, row) = (texel % width as usize, texel / width as usize);
            positions[*place as usize] = [column as u16, row as u16];
            *place += 1;
        }
        let mut forest = Vec::new();
        for bin in &mut index {
            if bin.size > leaf_size {
                let mut planter = Planter {
                    leaf_size,
                    positions: &mut positions,
                    forest: &mut forest,
                };
                bin.offset = planter.tree(bin.offset, bin.size, Cell::root(width, height));
            }
        }
        Self {
            width,
            height,
            grid,
            leaf_size,
            index,
            positions,
            forest,
        }
    }

    /// Bytes a texel of index, inverse bin map and forest: what evaluation needs. Sampling needs the bin map as well.
    pub fn bytes_per_texel(&self) -> f64 {
        let bytes =
            size_of_val(&*self.index) + size_of_val(&*self.positions) + size_of_val(&*self.forest);
        bytes as f64 / self.positions.len() as f64
    }
}

/// The bin number of every texel of `map`, row by row.
pub(crate) fn bins(map: &NormalMap, grid: BinGrid) -> impl Iterator<Item = u32> {
    map.texels().iter().map(move |&[s, t]| {
        let (column, row) = grid.bin_of(HalfVector {
            s: f64::from(s),
            t: f64::from(t),
        });
        grid.number(column, row)
    })
}

/// What a node of any tree covers: all trees have the same cells.
#[derive(Clone, Copy, Debug)]
struct Cell {
    corner: [u16; 2],
    size: [u16; 2],
}

impl Cell {
    fn root(width: u32, height: u32) -> Self {
        Self {
            corner: [0; 2],
            size: [width as u16, height as u16],
        }
    }

    /// The two halves, and the axis across which they lie.
    #[inline]
    fn halves(self) -> ([Self; 2], usize) {
        let axis = usize::from(self.size[0] < self.size[1]);
        let mut halves = [self; 2];
        let first = self.size[axis] / 2;
        halves[0].size[axis] = first;
        halves[1].size[axis] -= first;
        halves[1].corner[axis] += first;
        (halves, axis)
    }

    #[inline]
    fn relation(self, footprint: &Parallelogram) -> Relation {
        let low = self.corner.map(f64::from);
        let size = self.size.map(f64::from);
        footprint.relation(low, [low[0] + size[0], low[1] + size[1]])
    }
}

/// What building a tree writes to.
struct Planter<'a> {
    leaf_size: u32,
    positions: &'a mut [[u16; 2]],
    forest: &'a mut Vec<u32>,
}

impl Planter<'_> {
    /// Plants the tree of the list of `size` texels at `start`, and returns its place.
    fn tree(&mut self, start: u32, size: u32, root: Cell) -> u32 {
        let place = self.forest.len() as u32;
        self.forest.push(start);
        self.node(start, start + size, root);
        place
    }

    /// Adds the node of the texels from `first` to `last` and all below it. A cell of one texel holds at most one
    /// texel of a list, so this is at most 32 levels deep.
    fn node(&mut self, first: u32, last: u32, cell: Cell) {
        let (halves, axis) = cell.halves();
        let list = &mut self.positions[first as usize..last as usize];
        let border = halves[1].corner[axis];
        list.sort_by_key(|position| position[axis] >= border);
        let split = first + list.partition_point(|position| position[axis] < border) as u32;
        let place = self.forest.len();
        self.forest.push(split);
        let is_node = [split - first, last - split].map(|size| size > self.leaf_size);
        if is_node == [true; 2] {
            self.forest.push(0);
        }
        if is_node[0] {
            self.node(first, split, halves[0]);
        }
        if is_node[1] {
            if is_node[0] {
                self.forest[place + 1] = self.forest.len() as u32;
            }
            self.node(split, last, halves[1]);
        }
    }
}

/// A node of one bin's tree that waits to be opened.
#[derive(Clone, Copy, Debug, Default)]
struct Branch {
    /// Place among the window's bins.
    bin: u32,
    first: u32,
    last: u32,
    /// Place in the forest.
    node: u32,
}

/// Queries of a [`PaperForest`], with the memory that they share.
#[derive(Clone, Debug)]
pub struct PaperLookup<'a> {
    structure: &'a PaperForest,
    traversal: Traversal,
    /// Cells to visit, each with the place of its first branch; the last one's run to the end.
    cells: Vec<(Cell, usize)>,
    branches: Vec<Branch>,
    /// For each of the window's bins: its number, whole texels, and the area of parts of texels.
    found: Vec<(u32, u32, f64)>,
}

impl<'a> PaperLookup<'a> {
    /// Queries of `structure` by `traversal`.
    pub fn new(structure: &'a PaperForest, traversal: Traversal) -> Self {
        Self {
            structure,
            traversal,
            cells: Vec::new(),
            branches: Vec::new(),
            found: Vec::with_capacity(MOST_BINS),
        }
    }

    /// Calls `visit(column, row, weight)` for the bins of the neighbourhood around `half_vector`'s bin that have weight
    /// over `footprint`.
    ///
    /// # Panics
    /// If the footprint has no area.
    pub fn bin_weights(
        &mut self,
        footprint: &Footprint,
        half_vector: HalfVector,
        neighbourhood: Neighbourhood,
        visit: &mut dyn FnMut(u32, u32, f64),
    ) {
        let PaperForest {
            width,
            height,
            grid,
            ref index,
            ..
        } = *self.structure;
        self.found.clear();
        for (row, columns) in window::rows(grid, half_vector, neighbourhood) {
            for column in columns {
                let bin = grid.number(column, row);
                if index[bin as usize].size > 0 {
                    self.found.push((bin, 0, 0.0));
                }
            }
        }
        let footprint = Parallelogram::new(footprint, width, height);
        for copy in footprint.copies(width, height) {
            self.tile(&copy);
        }
        for &(bin, whole_texels, area) in &self.found {
            let area = f64::from(whole_texels) + area;
            if area > 0.0 {
                let (column, row) = grid.column_row(bin);
                visit(column, row, area / footprint.area());
            }
        }
    }

    /// Adds what the first tile has under `footprint`.
    fn tile(&mut self, footprint: &Parallelogram) {
        let structure = self.structure;
        let root = Cell::root(structure.width, structure.height);
        let inside = root.relation(footprint) == Relation::Inside;
        for place in 0..self.found.len() {
            let Bin { size, offset } = structure.index[self.found[place].0 as usize];
            if inside {
                self.found[place].1 += size;
            } else if size <= structure.leaf_size {
                self.leaf(footprint, place as u32, offset, offset + size);
            } else {
                let first = structure.forest[offset as usize];
                self.branches.push(Branch {
                    bin: place as u32,
                    first,
                    last: first + size,
                    node: offset + 1,
                });
                if self.traversal == Traversal::OneByOne {
                    self.descend(footprint, root);
                }
            }
        }
        self.descend(footprint, root);
    }

    /// Opens the branches that wait, all of them of the cell `root`, and all below.
    fn descend(&mut self, footprint: &Parallelogram, root: Cell) {
        if self.branches.is_empty() {
            return;
        }
        let structure = self.structure;
        let leaf_size = structure.leaf_size;
        let mut opened = [Branch::default(); MOST_BINS];
        self.cells.push((root, 0));
        while let Some((cell, start)) = self.cells.pop() {
            let count = self.branches.len() - start;
            opened[..count].copy_from_slice(&self.branches[start..]);
            self.branches.truncate(start);
            let (halves, _) = cell.halves();
            for (half, cell) in halves.into_iter().enumerate() {
                let relation = cell.relation(footprint);
                if relation == Relation::Outside {
                    continue;
                }
                let start = self.branches.len();
                for branch in &opened[..count] {
                    let split = structure.forest[branch.node as usize];
                    let sizes = [split - branch.first, branch.last - split];
                    let size = sizes[half];
                    let first = if half == 0 { branch.first } else { split };
                    if relation == Relation::Inside {
                        self.found[branch.bin as usize].1 += size;
                    } else if size > leaf_size {
                        let node = if sizes[1 - half] <= leaf_size {
                            branch.node + 1
                        } else if half == 0 {
                            branch.node + 2
                        } else {
                            structure.forest[branch.node as usize + 1]
                        };
                        self.branches.push(Branch {
                            bin: branch.bin,
                            first,
                            last: first + size,
                            node,
                        });
                    } else if size > 0 {
                        self.leaf(footprint, branch.bin, first, first + size);
                    }
                }
                if self.branches.len() > start {
                    self.cells.push((cell, start));
                }
            }
        }
    }

    /// Adds the texels from `first` to `last` of the inverse bin map one by one.
    #[inline]
    fn leaf(&mut self, footprint: &Parallelogram, bin: u32, first: u32, last: u32) {
        let (_, whole_texels, area) = &mut self.found[bin as usize];
        for &position in &self.structure.positions[first as usize..last as usize] {
            match footprint.texel_relation(position) {
                Relation::Outside => {}
                Relation::Inside => *whole_texels += 1,
                Relation::Crossing => *area += footprint.clipped_area(position),
            }
        }
    }
}
