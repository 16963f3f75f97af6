//! Clustered lobes, level by level, of a map or of a surface quilted from a sample.

mod cluster;
mod encode;
mod moments;

use super::lobes::Lattice;
use crate::normals::NormalMap;
use cluster::clusters;
use glintbake_format::model::{LobeLattice, MIP_LANES, MipLayout, QuiltLayout};
use glintbake_format::records::MipBlock;
use glintbake_format::view::{LobeNormal, NO_CELL};
use moments::Moments;
use rayon::prelude::*;
use zerocopy::little_endian::U32;

/// How many times as many clusters as are stored those of larger cells are made of. On leather and scratches twice as many would leave
/// 1.2 and 1.4 times the error under large footprints.
const FINER: usize = 8;

/// Cells of the lowest level from which twice as many have to do, as baking takes time in proportion: a map of 1024 texels a side has four
/// times as many, a sample of 256 a sixteenth.
const MANY_CELLS: usize = 1 << 12;
const FINER_OF_MANY: usize = 2;

/// How many times as much normals count as positions, both in comparable units, at the lowest level and at most; twice as much on each
/// level. A footprint is as wide as a cell, so that where in it a lobe lies changes its weight a little, but its normal must be within
/// the kernel's width of the half vector, which is narrow beside what a cell's normals range over, the more so the larger it is: with
/// 1 throughout, errors under footprints of 100 texels are twice as large.
const LEAST_NORMALS: f64 = 4.0;
const MOST_NORMALS: f64 = 32.0;

/// Clustered lobes of a surface.
pub struct MipLobes {
    /// For each place of cells of the sample, its number or [`NO_CELL`]; none without a quilt.
    pub index: Vec<U32>,
    /// Blocks of all cells.
    pub blocks: Vec<MipBlock>,
}

/// The lowest level whose cells have at least four times as many lobes as clusters, and at least `overlap` texels a side.
///
/// Below, clustering would save less than twice or so what a query sums, and cost as much memory again as all levels above.
pub fn first_level(per_side: u8, blocks: u8, overlap: u32) -> u8 {
    let lobes = 4 * u32::from(blocks) * MIP_LANES as u32;
    let of_texel = u32::from(per_side) * u32::from(per_side);
    let is_enough = |&level: &u8| of_texel << (2 * level) >= lobes && 1 << level >= overlap;
    (1..14).find(is_enough).unwrap_or(14)
}

/// The clustered lobes of `sample`, laid out by `layout`; `origins` are those of its quilt, or none.
///
/// Those of the lowest level are clusters of the lobes themselves, those of each next one of the clusters of the four cells it covers,
/// eight times as many of which are kept for that. Cells of the sample that no patch has are left out. O(texels of the sample × clusters)
/// for each level and `O(patches × clusters²)`; memory as for two levels.
pub fn build(sample: &NormalMap, layout: &MipLayout, origins: &[[u16; 2]]) -> MipLobes {
    let side = 1 << layout.first_level.min(16);
    let [across, down] = [sample.width(), sample.height()].map(|size| size.div_ceil(side));
    let cells = across as usize * down as usize;
    let mut builder = Builder {
        layout: *layout,
        count: usize::from(layout.blocks) * MIP_LANES,
        finer: if cells > MANY_CELLS {
            FINER_OF_MANY
        } else {
            FINER
        },
        index: Vec::new(),
        blocks: Vec::new(),
    };
    if layout.first_level > layout.top() {
        return builder.finish();
    }
    let lattice = Lattice::new(
        sample,
        LobeLattice {
            curved: true,
            per_side: layout.per_side,
        },
    );
    match layout.quilt {
        None => builder.surface(None, |column, row| {
            lobes_of_cell(&lattice, layout, [column, row])
        }),
        Some(quilt) => {
            let top = builder.sample(&lattice, &quilt, origins);
            let of_patch = |column: u32, row: u32| {
                let patch = row as usize * quilt.patches[0] as usize + column as usize;
                let [x, y] = origins[patch];
                let texel = [u32::from(x), u32::from(y)];
                top[place_of(&quilt, quilt.patch_log, texel)].clone()
            };
            builder.surface(Some(&of_patch), |_, _| Vec::new());
        }
    }
    builder.finish()
}

/// Where among the places of `level` the cell that begins at `texel` is.
fn place_of(quilt: &QuiltLayout, level: u8, [x, y]: [u32; 2]) -> usize {
    let step = MipLayout::step(quilt, level);
    let [columns, _] = MipLayout::places(quilt, level);
    (y / step) as usize * columns as usize + (x / step) as usize
}

/// The lobes of texels `first` to `end` of the map, which repeats, off the first texel's corner.
fn lobes_between(
    lattice: &Lattice<'_>,
    per_side: u8,
    first: [u32; 2],
    size: [u32; 2],
) -> Vec<Moments> {
    let per_side = u32::from(per_side);
    let [columns, rows] = lattice.size();
    let spacing = 1.0 / f64::from(per_side);
    let variance = (LobeLattice::DEVIATION * spacing).powi(2);
    let [across, down] = size.map(|side| side * per_side);
    (0..across * down)
        .map(|number| {
            let (x, y) = (number % across, number / across);
            let lobe = lattice.lobe(
                (first[0] * per_side + x) % columns,
                (first[1] * per_side + y) % rows,
            );
            let position = [x, y].map(|place| (f64::from(place) + 0.5) * spacing);
            let slope = lobe.slope.map(|slope| slope / spacing);
            Moments::of_lobe(position, variance, &LobeNormal { slope, ..lobe })
        })
        .collect()
}

/// The lobes of a cell of the lowest level of a map.
fn lobes_of_cell(lattice: &Lattice<'_>, layout: &MipLayout, cell: [u32; 2]) -> Vec<Moments> {
    let side = 1 << layout.first_level;
    let first = cell.map(|place| place * side);
    let size = core::array::from_fn(|axis| side.min(layout.size[axis] - first[axis]));
    lobes_between(lattice, layout.per_side, first, size)
}

struct Builder {
    layout: MipLayout,
    /// Clusters of a cell.
    count: usize,
    /// How many times as many larger cells are made of.
    finer: usize,
    index: Vec<U32>,
    blocks: Vec<MipBlock>,
}

/// Clusters of a cell to be stored, and more of them for larger cells.
struct Cell {
    blocks: Vec<MipBlock>,
    finer: Vec<Moments>,
}

impl Builder {
    fn finish(self) -> MipLobes {
        MipLobes {
            index: self.index,
            blocks: self.blocks,
        }
    }

    /// The clusters of `members`, of a cell of `level`, seeded by what the cell is.
    fn cell(&self, members: &[Moments], level: u8, place: u64) -> Cell {
        let side = f64::from(1_u32 << level);
        let seed = place << 8 | u64::from(level);
        let normals = LEAST_NORMALS * f64::from(1_u32 << (level - self.layout.first_level));
        let normals = normals.min(MOST_NORMALS);
        let finer = clusters(members, self.finer * self.count, side, normals, seed);
        let mut stored = clusters(&finer, self.count, side, normals, !seed);
        let blocks = encode::blocks(&mut stored, side, usize::from(self.layout.blocks));
        Cell { blocks, finer }
    }

    /// Adds the cells of the sample, level by level, that patches at `origins` have; returns the finer clusters of those of patches, by
    /// place.
    fn sample(
        &mut self,
        lattice: &Lattice<'_>,
        quilt: &QuiltLayout,
        origins: &[[u16; 2]],
    ) -> Vec<Vec<Moments>> {
        let mut below: Vec<Vec<Moments>> = Vec::new();
        let mut stored = 0;
        for level in self.layout.first_level..=quilt.patch_log {
            let [columns, rows] = MipLayout::places(quilt, level);
            let step = MipLayout::step(quilt, level);
            let mut is_used = vec![false; columns as usize * rows as usize];
            let cells = 1 << (quilt.patch_log - level);
            for &origin in origins {
                for within in 0..cells * cells {
                    let within = [within % cells, within / cells].map(|cell| cell << level);
                    is_used[place_of(quilt, level, quilt.texel(origin, within))] = true;
                }
            }
            let side = 1_u32 << level;
            let made: Vec<Option<Cell>> = is_used
                .par_iter()
                .enumerate()
                .map(|(place, &is_used)| {
                    let number = place as u32;
                    let first = [number % columns * step, number / columns * step];
                    is_used.then(|| {
                        let members = if level == self.layout.first_level {
                            lobes_between(lattice, self.layout.per_side, first, [side; 2])
                        } else {
                            quarters(side, |x, y| {
                                let origin = first.map(|x| x as u16);
                                let texel = quilt.texel(origin, [x, y]);
                                below[place_of(quilt, level - 1, texel)].clone()
                            })
                        };
                        self.cell(&members, level, place as u64)
                    })
                })
                .collect();
            below = Vec::with_capacity(made.len());
            for cell in made {
                let Some(cell) = cell else {
                    self.index.push(U32::new(NO_CELL));
                    below.push(Vec::new());
                    continue;
                };
                self.index.push(U32::new(stored));
                stored += 1;
                self.blocks.extend(cell.blocks);
                below.push(cell.finer);
            }
        }
        below
    }

    /// Adds the cells of the surface, level by level: of those `below` the lowest, or else of the lobes of each.
    fn surface(
        &mut self,
        below: Option<&(dyn Fn(u32, u32) -> Vec<Moments> + Sync)>,
        lobes: impl Fn(u32, u32) -> Vec<Moments> + Sync,
    ) {
        let mut finer: Vec<Vec<Moments>> = Vec::new();
        let lowest = self.layout.first_of_surface();
        for level in lowest..=self.layout.top() {
            let [columns, rows] = self.layout.cells(level);
            let [across, down] = self.layout.cells(level - 1);
            let side = 1_u32 << level;
            let made: Vec<Cell> = (0..columns * rows)
                .into_par_iter()
                .map(|place| {
                    let (column, row) = (place % columns, place / columns);
                    let child = |x: u32, y: u32| {
                        let (x, y) = (2 * column + 2 * x / side, 2 * row + 2 * y / side);
                        if x >= across || y >= down {
                            return Vec::new();
                        }
                        match below {
                            Some(below) if level == lowest => below(x, y),
                            _ => finer[y as usize * across as usize + x as usize].clone(),
                        }
                    };
                    let members = if below.is_none() && level == lowest {
                        lobes(column, row)
                    } else {
                        quarters(side, child)
                    };
                    self.cell(&members, level, 1 << 40 | u64::from(place))
                })
                .collect();
            finer = Vec::with_capacity(made.len());
            for cell in made {
                self.blocks.extend(cell.blocks);
                finer.push(cell.finer);
            }
        }
    }
}

/// The clusters of the four quarters of a cell of `side` texels, off its own corner; `of` gives those of the quarter at a texel.
fn quarters(side: u32, of: impl Fn(u32, u32) -> Vec<Moments>) -> Vec<Moments> {
    let half = side / 2;
    let mut all = Vec::new();
    for [x, y] in [[0, 0], [half, 0], [0, half], [half, half]] {
        let corner = [f64::from(x), f64::from(y)];
        all.extend(of(x, y).into_iter().map(|lobe| lobe.moved(corner)));
    }
    all
}
