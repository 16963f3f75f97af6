//! Pebbled leather.
//!
//! A relief of three layers: domed pebbles that meet in creases, wrinkles that run across them, and pores. Pebbles are
//! cells of Worley's basis (1996): with F₁ ≤ F₂ the distances to the two nearest seeds, F₂ − F₁ is 0 on the borders of
//! cells and grows inwards. Their positions are warped by a smooth field first, so that borders are not straight.
//! Wrinkles follow the zero lines of a Gaussian field. Slopes are exact derivatives, through the warp's Jacobian.

use core::ops::Range;

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

/// Kernel width of the field whose zero lines are wrinkles, at scale 1, in texels: lines are about 13 texels apart.
const WRINKLE_SIGMA: f64 = 3.0;

/// A wrinkle's half width, in standard deviations of the field: h = −depth · exp(−(field/width)²).
const WRINKLE_WIDTH: f64 = 0.35;

/// Depth of a wrinkle at scale 1, in texels; pebbles are [`PEBBLE_HEIGHT`] of their side, 2.6 texels.
const WRINKLE_DEPTH: f64 = 0.35;

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

/// A pebble: h = height · (1 − exp(−(q/crease)²) − dome · F₁²), q = F₂ − F₁, all in cell sides.
const PEBBLE_HEIGHT: f64 = 0.12;
const CREASE: f64 = 0.22;
const DOME: f64 = 0.9;

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
    wrinkles: GaussianField,
    /// [`WRINKLE_DEPTH`] at the map's scale.
    wrinkle_depth: f64,
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
            wrinkles: GaussianField::new(
                options.seed,
                Stream::Wrinkle,
                0,
                size,
                [WRINKLE_SIGMA * options.scale; 2],
            ),
            wrinkle_depth: WRINKLE_DEPTH * options.scale,
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
        let pebbles = self.pebbles(rows.clone());
        let pores = self.pores(rows.clone());
        let warp = self.warp.each_ref().map(|field| field.band(rows.clone()));
        let wrinkles = self.wrinkles.band(rows.clone());
        let mut warp_rows = [0, 1].map(|_| vec![Jet::default(); width]);
        let mut sums = vec![[0.0; 2]; width];
        for (row, texels) in rows.zip(slopes.chunks_mut(width)) {
            for (axis, jets) in warp_rows.iter_mut().enumerate() {
                self.warp_row(axis, &warp[axis], row, jets);
            }
            for (column, sum) in sums.iter_mut().enumerate() {
                let point = [column as f64 + 0.5, row as f64 + 0.5];
                let [a, b] = [warp_rows[0][column], warp_rows[1][column]];
                let warped = [point[0] + a.height, point[1] + b.height];
                let [u, v] = self.pebble_slope(&pebbles, warped);
                let pore = self.pore_slope(&pores, point);
                // Jᵀ (u, v), J = I + ∂warp/∂point.
                *sum = [
                    u + a.slope[0] * u + b.slope[0] * v + pore[0],
                    v + a.slope[1] * u + b.slope[1] * v + pore[1],
                ];
            }
            self.add_wrinkles(&wrinkles, row, &mut sums);
            for (texel, sum) in texels.iter_mut().zip(&sums) {
                *texel = sum.map(|x| x as f32);
            }
        }
    }

    /// The displacement along `axis` of each texel of `row`, in texels, with its derivatives.
    fn warp_row(&self, axis: usize, band: &FieldBand<'_>, row: usize, jets: &mut [Jet]) {
        let scale = self.warp_size / self.warp[axis].expected_height();
        let reach = WARP_LIMIT * self.warp_size;
        band.visit_row(row, |column, jet| {
            jets[column] = Jet {
                height: (jet.height * scale).clamp(-reach, reach),
                slope: jet.slope.map(|x| x * scale),
            };
        });
    }

    fn pebbles(&self, rows: Range<usize>) -> CellBlock<Seed> {
        let key = key(self.seed, Stream::Pebble, 0);
        let reach = WARP_LIMIT * self.warp_size;
        self.pebbles.block(rows, reach, |column, row| {
            let mut random = Random::at(key, column, row);
            [0, 1].map(|_| random.range(0.5 - 0.5 * JITTER, 0.5 + 0.5 * JITTER))
        })
    }

    fn pores(&self, rows: Range<usize>) -> CellBlock<Option<Pore>> {
        let key = key(self.seed, Stream::Pore, 0);
        let side = self.pores.cell_size[0].min(self.pores.cell_size[1]);
        self.pores.block(rows, 0.0, |column, row| {
            let mut random = Random::at(key, column, row);
            (random.unit() < self.pore_chance).then(|| Pore {
                seed: [random.unit(), random.unit()],
                radius: random.range(0.08, 0.16) * side,
                steepness: random.range(0.3, 0.8),
            })
        })
    }

    /// The slope of the pebbles at the warped `point`, (∂h/∂column, ∂h/∂row).
    fn pebble_slope(&self, seeds: &CellBlock<Seed>, point: [f64; 2]) -> [f64; 2] {
        let inverse_size = self.pebbles.cell_size.map(|size| 1.0 / size);
        let mut nearest = [(f64::INFINITY, [0.0; 2]); 2];
        seeds.visit_around(point, |corner, seed| {
            let offset =
                [0, 1].map(|axis| (point[axis] - corner[axis]) * inverse_size[axis] - seed[axis]);
            let squared = offset[0] * offset[0] + offset[1] * offset[1];
            if squared < nearest[1].0 {
                nearest[1] = (squared, offset);
                if squared < nearest[0].0 {
                    nearest.swap(0, 1);
                }
            }
        });
        // F₁ has no gradient at a seed; the guard picks 0 there.
        let [f1, f2] = nearest.map(|(squared, _)| squared.sqrt().max(f64::MIN_POSITIVE));
        let q = (f2 - f1) / CREASE;
        let rise = PEBBLE_HEIGHT * 2.0 * q / CREASE * libm::exp(-q * q);
        let fall = -2.0 * PEBBLE_HEIGHT * DOME;
        // Heights are in cell sides as distances are: slopes need no unit.
        [0, 1].map(|axis| {
            let [o1, o2] = nearest.map(|(_, offset)| offset[axis]);
            rise * (o2 / f2 - o1 / f1) + fall * o1
        })
    }

    /// The slope of the pores at `point`, (∂h/∂column, ∂h/∂row).
    fn pore_slope(&self, pores: &CellBlock<Option<Pore>>, point: [f64; 2]) -> [f64; 2] {
        let mut slope = [0.0; 2];
        pores.visit_around(point, |corner, pore| {
            let Some(pore) = pore else { return };
            let offset = [0, 1].map(|axis| {
                (point[axis] - corner[axis] - pore.seed[axis] * self.pores.cell_size[axis])
                    / pore.radius
            });
            let half_squared = 0.5 * (offset[0] * offset[0] + offset[1] * offset[1]);
            // The nearest pore not seen is a cell away, at least 6 radii: exp(−18).
            if half_squared < 18.0 {
                let steep = pore.steepness * libm::exp(0.5 - half_squared);
                for (sum, x) in slope.iter_mut().zip(offset) {
                    *sum += steep * x;
                }
            }
        });
        slope
    }

    /// Adds the slopes of the wrinkles on `row` to `sums`.
    fn add_wrinkles(&self, band: &FieldBand<'_>, row: usize, sums: &mut [[f64; 2]]) {
        let scale = 1.0 / (self.wrinkles.expected_height() * WRINKLE_WIDTH);
        band.visit_row(row, |column, jet| {
            let z = jet.height * scale;
            let factor = self.wrinkle_depth * 2.0 * z * libm::exp(-z * z) * scale;
            for (sum, slope) in sums[column].iter_mut().zip(jet.slope) {
                *sum += factor * slope;
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, generate, tests::slopes};

    #[test]
    fn the_second_nearest_seed_lies_in_the_cells_around() {
        let seed = |x: i64, y: i64| {
            let mut random = Random::at(key(1, Stream::Pebble, 0), x as u64, y as u64);
            // The ends of the range are where the search could fail first.
            [x, y].map(|cell| {
                let side = if random.unit() < 0.5 { -0.5 } else { 0.5 };
                cell as f64 + 0.5 + side * JITTER
            })
        };
        for cell_x in 0..30 {
            for cell_y in 0..30 {
                for i in 0..100 {
                    let point = [
                        cell_x as f64 + f64::from(i % 10) / 9.0,
                        cell_y as f64 + f64::from(i / 10) / 9.0,
                    ];
                    let second_nearest = |reach: i64| {
                        let mut squared: Vec<f64> = (-reach..=reach)
                            .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
                            .map(|(dx, dy)| {
                                let [x, y] = seed(cell_x + dx, cell_y + dy);
                                (x - point[0]).powi(2) + (y - point[1]).powi(2)
                            })
                            .collect();
                        squared.sort_by(f64::total_cmp);
                        squared[1]
                    };
                    assert_eq!(second_nearest(1), second_nearest(2), "{point:?}");
                }
            }
        }
    }

    #[test]
    fn creases_and_pores_lie_below_pebbles() {
        let sample = generate(Kind::Leather, &Options::new(Kind::Leather, 256)).expect("valid");
        let slopes = slopes(&sample);
        let mut moments = [0.0; 2];
        for row in slopes.chunks(256) {
            let heights: Vec<f64> = row
                .iter()
                .scan(0.0, |height, slope| {
                    *height += slope[0];
                    Some(*height)
                })
                .collect();
            let mean = heights.iter().sum::<f64>() / 256.0;
            for height in heights {
                moments[0] += (height - mean).powi(2) / (256.0 * 256.0);
                moments[1] += (height - mean).powi(3) / (256.0 * 256.0);
            }
        }
        let skewness = moments[1] / moments[0].powf(1.5);
        assert!(skewness < -0.3, "{skewness}");
    }
}
