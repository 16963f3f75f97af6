//! Pebbled leather.
//!
//! A relief of three layers: domed pebbles that meet in creases; wrinkles on them, the same pattern finer and much
//! shallower; and pores. Pebbles and wrinkles are Worley's cellular basis (1996): with F₁ ≤ F₂ the distances to the
//! two nearest seeds, F₂ − F₁ is 0 on the borders of cells and grows inwards. Positions are warped by a smooth field
//! first, so that borders are not straight. Slopes are exact derivatives, through the warp's Jacobian.

use rayon::prelude::*;

use crate::{
    BAND_ROWS, Options,
    cells::{CellBlock, CellGrid},
    gaussian_field::{FieldBand, GaussianField, Jet, Stream},
    random::{Random, key},
    slopes::normalise,
};

/// Side of a pebble's cell at scale 1, in texels.
const PEBBLE_SIDE: f64 = 22.0;

/// Side of a wrinkle's cell at scale 1, in texels.
const WRINKLE_SIDE: f64 = 7.0;

/// Side of the cell that holds at most one pore, at scale 1, in texels.
const PORE_SIDE: f64 = 9.0;

/// Chance of a pore in its cell at density 1.
const PORE_CHANCE: f64 = 0.35;

/// Standard deviation of the warp and its kernel width, in pebble sides.
const WARP: f64 = 0.09;
const WARP_SIGMA: f64 = 0.35;

/// The warp is held below this many standard deviations, so that the cells it reaches are known beforehand.
const WARP_LIMIT: f64 = 5.0;

/// Seeds keep to this middle part of their cell each way: the two nearest then lie in the 3 × 3 cells around, for
/// a seed further away is at least 1.5 − JITTER/2 from the point, and the second of four corner seeds at most
/// (1 + JITTER)/√2.
const JITTER: f64 = 0.65;

/// Rounded cells parted by creases: h = height · (1 − exp(−(q/crease)²) − dome · F₁²), q = F₂ − F₁, all in cell sides.
struct CellRelief {
    height: f64,
    crease: f64,
    dome: f64,
}

const PEBBLE: CellRelief = CellRelief {
    height: 0.12,
    crease: 0.22,
    dome: 0.9,
};
const WRINKLE: CellRelief = CellRelief {
    height: 0.06,
    crease: 0.3,
    dome: 0.3,
};

/// Position of a seed within its cell, both in (0, 1).
type Seed = [f64; 2];

/// A pore in its cell: h = −steepness · radius · √e · exp(−d²/(2·radius²)), so that `steepness` is its steepest slope.
struct Pore {
    seed: Seed,
    radius: f64,
    steepness: f64,
}

/// Fills `normals` with those of a leather, its RMS slope exactly `roughness`.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let width = options.width as usize;
    let leather = Leather::new(options);
    normals
        .par_chunks_mut(BAND_ROWS * width)
        .enumerate()
        .for_each(|(index, slopes)| leather.fill_band(index * BAND_ROWS, width, slopes));
    normalise(normals, width, options.roughness);
}

/// The periodic grids and fields that a leather is made of.
struct Leather {
    pebbles: CellGrid,
    wrinkles: CellGrid,
    pores: CellGrid,
    warp: [GaussianField; 2],
    /// Standard deviation of the warp, in texels.
    warp_size: f64,
    pore_chance: f64,
    seed: u64,
}

impl Leather {
    fn new(options: &Options) -> Self {
        let size = [options.width, options.height];
        let grid = |side: f64| CellGrid::new(size[0], size[1], side * options.scale);
        let pebbles = grid(PEBBLE_SIDE);
        let side = pebbles.cell_size[0].min(pebbles.cell_size[1]);
        Self {
            pebbles,
            wrinkles: grid(WRINKLE_SIDE),
            pores: grid(PORE_SIDE),
            warp: [0, 1].map(|axis| {
                GaussianField::new(
                    options.seed,
                    Stream::Warp,
                    axis,
                    size,
                    [WARP_SIGMA * side; 2],
                )
            }),
            warp_size: WARP * side,
            pore_chance: PORE_CHANCE * options.density,
            seed: options.seed,
        }
    }

    /// Writes the slopes (∂h/∂column, ∂h/∂row) of the rows from `first`.
    fn fill_band(&self, first: usize, width: usize, slopes: &mut [[f32; 2]]) {
        let rows = first..first + slopes.len() / width;
        let reach = WARP_LIMIT * self.warp_size;
        let block = |grid: &CellGrid, stream: Stream| {
            let key = key(self.seed, stream, 0);
            let [top, bottom] = [rows.start as f64 - reach, rows.end as f64 + reach];
            grid.block(
                grid.row_of(top) - 1,
                grid.row_of(bottom) + 1,
                |column, row| {
                    let mut random = Random::at(key, column, row);
                    [0, 1].map(|_| random.range(0.5 - 0.5 * JITTER, 0.5 + 0.5 * JITTER))
                },
            )
        };
        let pebbles = block(&self.pebbles, Stream::Pebble);
        let wrinkles = block(&self.wrinkles, Stream::Wrinkle);
        let pores = self.pores(rows.start, rows.end);
        let warp = [0, 1].map(|axis: usize| self.warp[axis].band(rows.clone()));
        let mut warp_rows = [0, 1].map(|_| vec![NO_WARP; width]);
        for (row, texels) in rows.zip(slopes.chunks_mut(width)) {
            for (axis, jets) in warp_rows.iter_mut().enumerate() {
                self.warp_row(axis, &warp[axis], row, jets);
            }
            for (column, texel) in texels.iter_mut().enumerate() {
                let point = [column as f64 + 0.5, row as f64 + 0.5];
                let [a, b] = [warp_rows[0][column], warp_rows[1][column]];
                let warped = [point[0] + a.height, point[1] + b.height];
                let [u, v] = [
                    PEBBLE.slope(&self.pebbles, &pebbles, warped),
                    WRINKLE.slope(&self.wrinkles, &wrinkles, warped),
                ]
                .into_iter()
                .fold([0.0; 2], |sum, slope| {
                    [sum[0] + slope[0], sum[1] + slope[1]]
                });
                let pore = pore_slope(&self.pores, &pores, point);
                // Jᵀ (u, v), J = I + ∂warp/∂point.
                *texel = [0, 1].map(|axis| {
                    let identity = [u, v][axis];
                    (identity + a.slope[axis] * u + b.slope[axis] * v + pore[axis]) as f32
                });
            }
        }
    }

    /// The displacement along `axis` of each texel of `row`, in texels, with its derivatives.
    fn warp_row(&self, axis: usize, band: &FieldBand<'_>, row: usize, jets: &mut [Jet]) {
        let expected = self.warp[axis].expected_height();
        let reach = WARP_LIMIT * self.warp_size;
        band.visit_row(row, |column, jet| {
            let scale = self.warp_size / expected;
            jets[column] = Jet {
                height: (jet.height * scale).clamp(-reach, reach),
                slope: jet.slope.map(|x| x * scale),
            };
        });
    }

    fn pores(&self, first_row: usize, end_row: usize) -> CellBlock<Option<Pore>> {
        let key = key(self.seed, Stream::Pore, 0);
        let [width, height] = self.pores.cell_size;
        let side = width.min(height);
        let first = self.pores.row_of(first_row as f64) - 1;
        let last = self.pores.row_of(end_row as f64) + 1;
        self.pores.block(first, last, |column, row| {
            let mut random = Random::at(key, column, row);
            (random.unit() < self.pore_chance).then(|| Pore {
                seed: [random.unit(), random.unit()],
                radius: random.range(0.08, 0.16) * side,
                steepness: random.range(0.3, 0.8),
            })
        })
    }
}

const NO_WARP: Jet = Jet {
    height: 0.0,
    slope: [0.0; 2],
};

impl CellRelief {
    /// The slope at `point`, (∂h/∂column, ∂h/∂row), of the relief over the cells of `grid` with seeds `block`.
    fn slope(&self, grid: &CellGrid, block: &CellBlock<Seed>, point: [f64; 2]) -> [f64; 2] {
        let mut nearest = [(f64::INFINITY, [0.0; 2]); 2];
        let cell = [grid.column_of(point[0]), grid.row_of(point[1])];
        for (corner, seed) in block.around(cell[0], cell[1]) {
            let offset =
                [0, 1].map(|axis| (point[axis] - corner[axis]) / grid.cell_size[axis] - seed[axis]);
            let squared = offset[0] * offset[0] + offset[1] * offset[1];
            if squared < nearest[1].0 {
                nearest[1] = (squared, offset);
                if squared < nearest[0].0 {
                    nearest.swap(0, 1);
                }
            }
        }
        // At a seed itself F₁ has no gradient, but there the terms that need it are 0.
        let [f1, f2] = nearest.map(|(squared, _)| squared.sqrt().max(f64::MIN_POSITIVE));
        let q = (f2 - f1) / self.crease;
        let rise = self.height * 2.0 * q / self.crease * libm::exp(-q * q);
        let fall = -2.0 * self.height * self.dome;
        // Heights are in cell sides as distances are: slopes along each axis need no unit.
        [0, 1].map(|axis| {
            let [o1, o2] = nearest.map(|(_, offset)| offset[axis]);
            rise * (o2 / f2 - o1 / f1) + fall * o1
        })
    }
}

/// The slope at `point` of the pores around it.
fn pore_slope(grid: &CellGrid, block: &CellBlock<Option<Pore>>, point: [f64; 2]) -> [f64; 2] {
    let mut slope = [0.0; 2];
    for (corner, pore) in block.around(grid.column_of(point[0]), grid.row_of(point[1])) {
        let Some(pore) = pore else { continue };
        let offset = [0, 1].map(|axis| {
            (point[axis] - corner[axis] - pore.seed[axis] * grid.cell_size[axis]) / pore.radius
        });
        let half_squared = 0.5 * (offset[0] * offset[0] + offset[1] * offset[1]);
        // A pore's nearest border of the 3 × 3 cells is a cell away, at least 6 radii: exp(−18).
        if half_squared < 18.0 {
            let steep = pore.steepness * libm::exp(0.5 - half_squared);
            for (sum, x) in slope.iter_mut().zip(offset) {
                *sum += steep * x;
            }
        }
    }
    slope
}
