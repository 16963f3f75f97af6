//! Lobes of position and normal: blocks of 4 × 4 under a box pyramid, with moments of every cell.

mod blocks;
mod lattice;
mod moments;
mod spread;

use super::box_pyramid::{self, Bounds, BoxPyramid};
use crate::normals::NormalMap;
use blocks::{Block, Rounding};
use glintbake_format::model::{BoxPyramidLayout, LobeLattice, PYRAMID_SIDE};
use glintbake_format::records::{
    BoxNode, CurvedLobeBlock, CurvedWideLobeBlock, LobeBlock, LobeIndex, LobeMoments, LobeSpreads,
    TileRoot, WideLobeBlock,
};
use glintbake_format::view::LobeNormal;
pub(super) use lattice::Lattice;
use moments::Sums;
use rayon::prelude::*;
use zerocopy::little_endian::{U16, U32};

/// Most that 16 bits may move a normal, in deviations σr of the kernel: densities under the least footprints, of four lobes or so,
/// err by a third of it.
const MOST_ROUNDING: f64 = 2e-4;

/// The steepest slope of a Gaussian of deviation 1 and peak 1: a normal moved by δ σr changes a density by at most so much δ.
const STEEPEST: f64 = 0.606_530_659_712_633_4;

/// Lobes of a map.
pub struct Lobes {
    /// The box of all normals.
    pub root: Vec<TileRoot>,
    /// Nodes of the box pyramid.
    pub nodes: Vec<BoxNode>,
    /// Where the blocks of the lowest nodes lie.
    pub index: Vec<LobeIndex>,
    /// How far lobes spread in the children of each node; none if lobes are flat.
    pub spreads: Vec<LobeSpreads>,
    /// Moments of the children of each node.
    pub moments: Vec<LobeMoments>,
    /// Flat blocks in 16 bits, or none.
    pub flat: Vec<LobeBlock>,
    /// Curved blocks in 16 bits, or none.
    pub curved: Vec<CurvedLobeBlock>,
    /// Flat blocks in full, or none.
    pub wide_flat: Vec<WideLobeBlock>,
    /// Curved blocks in full, or none.
    pub wide_curved: Vec<CurvedWideLobeBlock>,
}

/// How exactly lobes are kept.
#[derive(Clone, Copy, Debug)]
pub struct Precision {
    /// The least deviation σr of a kernel that they are to serve.
    pub sigma: f64,
    /// Most that merging 4 × 4 lobes into one plane may change the density of any of them, of its peak.
    pub merge_error: f64,
}

/// The lobes of `map`. O(texels); about 40 bytes a lobe while it works, 14 to 26 of them kept.
///
/// # Panics
/// If the map is empty or a side above 65535.
pub fn build(map: &NormalMap, kind: LobeLattice, precision: Precision) -> Lobes {
    let lattice = Lattice::new(map, kind);
    let [columns, rows] = lattice.size();
    let layout = BoxPyramidLayout::new(columns, rows).expect("sides were checked");
    let [across, down] = layout.size(0);
    let bounds: Vec<Bounds> = (0..across * down)
        .into_par_iter()
        .map(|place| bounds_of(&lobes_of(&lattice, place % across, place / across)))
        .collect();
    let pyramid = box_pyramid::build(layout, &bounds);
    drop(bounds);
    let rounding = Rounding {
        most: MOST_ROUNDING * precision.sigma,
        merge: precision.merge_error / STEEPEST * precision.sigma,
    };
    let mut lobes = Lobes {
        root: Vec::new(),
        nodes: Vec::new(),
        index: Vec::new(),
        spreads: Vec::new(),
        moments: Vec::new(),
        flat: Vec::new(),
        curved: Vec::new(),
        wide_flat: Vec::new(),
        wide_curved: Vec::new(),
    };
    let mut sums = Vec::new();
    let [node_columns, node_rows] = layout.size(1);
    for row in 0..node_rows {
        let nodes: Vec<Node> = (0..node_columns)
            .into_par_iter()
            .map(|column| node_of(&lattice, &pyramid, [column, row], rounding))
            .collect();
        for node in nodes {
            sums.push((node.sums, spread::greatest(&node.spreads)));
            lobes.moments.push(node.moments);
            lobes.spreads.push(node.spreads);
            lobes.add(node.blocks, kind.curved);
        }
    }
    for level in 2..=layout.top() {
        sums = add_level(&pyramid, level, &sums, &mut lobes);
    }
    if !kind.curved {
        lobes.spreads = Vec::new();
    }
    Lobes {
        root: pyramid.root,
        nodes: pyramid.nodes,
        ..lobes
    }
}

impl Lobes {
    /// Adds the blocks of the next lowest node.
    fn add(&mut self, blocks: Vec<Block>, is_curved: bool) {
        let (narrow, wide) = if is_curved {
            (self.curved.len(), self.wide_curved.len())
        } else {
            (self.flat.len(), self.wide_flat.len())
        };
        let mut index = LobeIndex {
            first: U32::new(narrow as u32),
            first_wide: U32::new(wide as u32),
            narrow: U16::ZERO,
            wide: U16::ZERO,
        };
        for (child, block) in blocks.into_iter().enumerate() {
            let bit = 1 << child;
            match block {
                Block::Narrow(stored) => {
                    index.narrow |= bit;
                    if is_curved {
                        self.curved.push(*stored);
                    } else {
                        self.flat.push(stored.normals);
                    }
                }
                Block::Wide(stored) => {
                    index.wide |= bit;
                    if is_curved {
                        self.wide_curved.push(*stored);
                    } else {
                        self.wide_flat.push(stored.normals);
                    }
                }
                Block::Merged => {}
            }
        }
        self.index.push(index);
    }
}

/// A lowest node in the making.
struct Node {
    sums: Sums,
    spreads: LobeSpreads,
    moments: LobeMoments,
    /// Its sixteen blocks; merged where there is none.
    blocks: Vec<Block>,
}

/// The lobes of the block in `column` and `row` of blocks.
fn lobes_of(lattice: &Lattice<'_>, column: u32, row: u32) -> blocks::Lobes {
    let [columns, rows] = lattice.size();
    core::array::from_fn(|number| {
        let x = column * PYRAMID_SIDE + number as u32 % PYRAMID_SIDE;
        let y = row * PYRAMID_SIDE + number as u32 / PYRAMID_SIDE;
        (x < columns && y < rows).then(|| lattice.lobe(x, y))
    })
}

/// The box of the lobes' normals.
fn bounds_of(lobes: &blocks::Lobes) -> Bounds {
    lobes.iter().flatten().fold(Bounds::NONE, |bounds, lobe| {
        bounds.with(lobe.normal, [0.0; 2])
    })
}

/// How far child `child` of a node is from the node's middle, `side` lobes a side of the child.
fn offset(child: usize, side: f64) -> [f64; 2] {
    let place = |number: usize| (number as f64 - 1.5) * side;
    [place(child % 4), place(child / 4)]
}

fn node_of(
    lattice: &Lattice<'_>,
    pyramid: &BoxPyramid,
    [column, row]: [u32; 2],
    rounding: Rounding,
) -> Node {
    let place = pyramid.layout.place(1, column, row);
    let mut sums = Sums::default();
    let mut cells = [None; 16];
    let mut stored = [None; 16];
    let mut spreads = [0.0; 16];
    for child in 0..16_usize {
        let Some(bounds) = pyramid.child(place, child as u32) else {
            continue;
        };
        let lobes = lobes_of(
            lattice,
            column * PYRAMID_SIDE + child as u32 % PYRAMID_SIDE,
            row * PYRAMID_SIDE + child as u32 / PYRAMID_SIDE,
        );
        let mut own = Sums::default();
        for (number, lobe) in lobes.iter().enumerate() {
            if let Some(lobe) = lobe {
                own.add(lobe, offset(number, 1.0));
            }
        }
        sums.merge(&own, offset(child, 4.0));
        cells[child] = Some((own.lobe(4.0), bounds));
        stored[child] = Some(lobes);
        let lobes = lobes.iter().flatten();
        spreads[child] = lobes.map(LobeNormal::spread).fold(0.0, f64::max);
    }
    let moments = moments::encode(&cells);
    let blocks = (0..16_usize)
        .map(|child| match (stored[child], cells[child]) {
            (Some(lobes), Some((_, bounds))) => {
                let cell = moments
                    .cell(child as u32, &bounds)
                    .expect("a node has 16 children");
                blocks::encode(&lobes, &cell, rounding)
            }
            _ => Block::Merged,
        })
        .collect();
    Node {
        sums,
        spreads: spread::encode(&spreads),
        moments,
        blocks,
    }
}

/// Adds the moments of the nodes of `level`, and how far lobes spread there, whose children have the sums and the greatest
/// spreads `finer`; returns those of the nodes.
fn add_level(
    pyramid: &BoxPyramid,
    level: u32,
    finer: &[(Sums, f64)],
    lobes: &mut Lobes,
) -> Vec<(Sums, f64)> {
    let layout = &pyramid.layout;
    let [columns, rows] = layout.size(level);
    let [across, _] = layout.size(level - 1);
    let side = f64::from(PYRAMID_SIDE.pow(level));
    let nodes: Vec<(Sums, LobeSpreads, LobeMoments)> = (0..columns * rows)
        .into_par_iter()
        .map(|number| {
            let (column, row) = (number % columns, number / columns);
            let place = layout.place(level, column, row);
            let mut sums = Sums::default();
            let mut spreads = [0.0; 16];
            let cells = core::array::from_fn(|child| {
                let bounds = pyramid.child(place, child as u32)?;
                let x = column * PYRAMID_SIDE + child as u32 % PYRAMID_SIDE;
                let y = row * PYRAMID_SIDE + child as u32 / PYRAMID_SIDE;
                let (own, spread) = finer[(y * across + x) as usize];
                sums.merge(&own, offset(child, side));
                spreads[child] = spread;
                Some((own.lobe(side), bounds))
            });
            (sums, spread::encode(&spreads), moments::encode(&cells))
        })
        .collect();
    let mut sums = Vec::with_capacity(nodes.len());
    for (own, spreads, moments) in nodes {
        sums.push((own, spread::greatest(&spreads)));
        lobes.spreads.push(spreads);
        lobes.moments.push(moments);
    }
    sums
}
