//! Pebbled leather.
//!
//! A relief of three layers: domed pebbles that meet in creases, wrinkles that run across them, and pores. Pebbles are
//! cells of Worley's basis (1996): with F₁ ≤ F₂ ≤ … the distances to the seeds, F₂ − F₁ is 0 on the borders of cells and
//! grows inwards. Their positions are warped by a smooth field first, so that borders are not straight.
//! Wrinkles follow the zero lines of a Gaussian field. Slopes are exact derivatives, through the warp's Jacobian.

use core::ops::Range;

use rayon::prelude::*;

use crate::{
    BAND_ROWS, Options,
    cells::{CellBlock, CellGrid},
    gaussian_field::{FieldBand, GaussianField, Jet, Stream},
    hollow,
    random::{Random, key},
    slopes::normalise,
};

/// Side of a pebble's cell at scale 1, in texels.
const PEBBLE_SIDE: f64 = 22.0;

/// Kernel width of the field whose zero lines are wrinkles, at scale 1, in texels: lines are about 13 texels apart.
const WRINKLE_SIGMA: f64 = 3.0;

/// A wrinkle's half width, in standard deviations of the field: h = −depth · (1 − (field/width)²)³ within it.
const WRINKLE_WIDTH: f64 = 0.6;

/// Depth of a wrinkle at scale 1, in texels; pebbles are [`PEBBLE_HEIGHT`] of their side, 2.6 texels.
const WRINKLE_DEPTH: f64 = 0.35;

/// Side of the cell that holds at most one pore, at scale 1, in texels.
const PORE_SIDE: f64 = 9.0;

/// Chance of a pore in its cell at density 1.
const PORE_CHANCE: f64 = 0.35;

/// Standard deviation of the warp and its kernel width, in pebble sides.
const WARP: f64 = 0.12;
const WARP_SIGMA: f64 = 0.45;

/// The warp is held below this many standard deviations, so that the cells it reaches are known beforehand.
const WARP_LIMIT: f64 = 5.0;

/// Seeds keep to this middle part of their cell each way: no seed is nearer to a point than 1.5 − JITTER/2 = 1.1 cell
/// sides unless it is among the 3 × 3 cells around, nor than 2.1 unless among the 5 × 5.
const JITTER: f64 = 0.8;

/// A pebble: h = height · (∏ (1 − (1 − ((Fₖ − F₁)/crease)²)³) − dome · F₁²) over the seeds k = 2, 3, … with
/// Fₖ − F₁ < crease, all in cell sides.
///
/// The product over all seeds, not the second alone, keeps the slope continuous where the second nearest changes.
const PEBBLE_HEIGHT: f64 = 0.12;
const CREASE: f64 = 0.4;
const DOME: f64 = 0.9;

/// Where F₁ is at most this, no seed outside the 3 × 3 cells has Fₖ − F₁ < CREASE. (None outside the 5 × 5 ever has:
/// F₁ is at most (½ + JITTER/2) √2 = 1.27, for no cell is empty.)
const NEAR: f64 = 0.7;

/// Position of a seed within its cell, both in (0, 1).
type Seed = [f64; 2];

/// A pore in its cell: a hollow, so deep that `steepness` is its steepest slope.
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
                radius: random.range(0.22, 0.44) * side,
                steepness: random.range(0.3, 0.8),
            })
        })
    }

    /// The slope of the pebbles at the warped `point`, (∂h/∂column, ∂h/∂row).
    fn pebble_slope(&self, seeds: &CellBlock<Seed>, point: [f64; 2]) -> [f64; 2] {
        let inverse_size = self.pebbles.cell_size.map(|size| 1.0 / size);
        for rings in [1, 2] {
            let mut offsets = [[0.0; 2]; 25];
            let mut count = 0;
            let mut nearest = f64::INFINITY;
            seeds.visit_around(point, rings, |corner, seed| {
                let offset = [
                    (point[0] - corner[0]) * inverse_size[0] - seed[0],
                    (point[1] - corner[1]) * inverse_size[1] - seed[1],
                ];
                nearest = nearest.min(offset[0] * offset[0] + offset[1] * offset[1]);
                offsets[count] = offset;
                count += 1;
            });
            if nearest <= NEAR * NEAR || rings == 2 {
                return pebble_slope(&offsets[..count]);
            }
        }
        unreachable!("the second ring always returns")
    }

    /// The slope of the pores at `point`, (∂h/∂column, ∂h/∂row).
    fn pore_slope(&self, pores: &CellBlock<Option<Pore>>, point: [f64; 2]) -> [f64; 2] {
        let mut slope = [0.0; 2];
        pores.visit_around(point, 1, |corner, pore| {
            let Some(pore) = pore else { return };
            let [width, height] = self.pores.cell_size;
            let offset = [
                (point[0] - corner[0] - pore.seed[0] * width) / pore.radius,
                (point[1] - corner[1] - pore.seed[1] * height) / pore.radius,
            ];
            // Radii are below half a cell: pores beyond the 3 × 3 cells do not reach here.
            for (sum, x) in slope.iter_mut().zip(hollow::slope(offset, pore.steepness)) {
                *sum += x;
            }
        });
        slope
    }

    /// Adds the slopes of the wrinkles on `row` to `sums`.
    fn add_wrinkles(&self, band: &FieldBand<'_>, row: usize, sums: &mut [[f64; 2]]) {
        let scale = 1.0 / (self.wrinkles.expected_height() * WRINKLE_WIDTH);
        band.visit_row(row, |column, jet| {
            let z = jet.height * scale;
            let rest = 1.0 - z * z;
            if rest <= 0.0 {
                return;
            }
            let factor = self.wrinkle_depth * 6.0 * z * rest * rest * scale;
            for (sum, slope) in sums[column].iter_mut().zip(jet.slope) {
                *sum += factor * slope;
            }
        });
    }
}

/// The slope of a pebble, in cell sides, at the point that lies `offsets` from each seed around.
fn pebble_slope(offsets: &[[f64; 2]]) -> [f64; 2] {
    let squared = |o: &[f64; 2]| o[0] * o[0] + o[1] * o[1];
    let mut first = 0;
    for (k, offset) in offsets.iter().enumerate() {
        if squared(offset) < squared(&offsets[first]) {
            first = k;
        }
    }
    let nearest = offsets[first];
    // At a seed F₁ has no gradient, but there no other seed is near enough to ask for it.
    let f1 = squared(&nearest).sqrt().max(f64::MIN_POSITIVE);
    let far = f1 + CREASE;
    let mut product = 1.0;
    // ∇ log of the product.
    let mut gradient = [0.0; 2];
    for (k, offset) in offsets.iter().enumerate() {
        if k == first || squared(offset) >= far * far {
            continue;
        }
        let fk = squared(offset).sqrt();
        // On a border the factor is 0 and its logarithm has no gradient; this near, their product is 0 within 1e-5.
        let q = ((fk - f1) / CREASE).max(1e-5);
        let rest = 1.0 - q * q;
        let factor = 1.0 - rest * rest * rest;
        product *= factor;
        let rate = 6.0 * q * rest * rest / (factor * CREASE);
        for axis in 0..2 {
            gradient[axis] += rate * (offset[axis] / fk - nearest[axis] / f1);
        }
    }
    [0, 1].map(|axis| PEBBLE_HEIGHT * (product * gradient[axis] - 2.0 * DOME * nearest[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, generate, tests::slopes};

    #[test]
    fn seeds_outside_the_searched_cells_do_not_matter() {
        let options = Options::new(Kind::Leather, 330);
        let leather = Leather::new(&options);
        let block = leather.pebbles(0..330);
        let seed = |cell: [i64; 2]| {
            let [x, y] = cell.map(|index| index.rem_euclid(15) as u64);
            let mut random = Random::at(key(options.seed, Stream::Pebble, 0), x, y);
            [0, 1].map(|_| random.range(0.5 - 0.5 * JITTER, 0.5 + 0.5 * JITTER))
        };
        for i in 0..20_000 {
            let mut random = Random::at(key(9, Stream::Noise, 0), i, 0);
            let point = [random.range(0.0, 330.0), random.range(0.0, 330.0)];
            let cell = point.map(|x| (x / 22.0) as i64);
            let offsets: Vec<_> = (-3..=3)
                .flat_map(|dy| (-3..=3).map(move |dx| [cell[0] + dx, cell[1] + dy]))
                .map(|cell| {
                    [0, 1].map(|axis| point[axis] / 22.0 - cell[axis] as f64 - seed(cell)[axis])
                })
                .collect();
            let [all, found] = [pebble_slope(&offsets), leather.pebble_slope(&block, point)];
            for axis in 0..2 {
                assert!(
                    (all[axis] - found[axis]).abs() < 1e-9,
                    "{point:?}: {all:?} {found:?}"
                );
            }
        }
    }

    #[test]
    fn pebble_slopes_are_derivatives() {
        let height = |offsets: &[[f64; 2]]| {
            let mut f: Vec<f64> = offsets.iter().map(|o| o[0].hypot(o[1])).collect();
            f.sort_by(f64::total_cmp);
            let product: f64 = f[1..]
                .iter()
                .map(|fk| 1.0 - (1.0 - ((fk - f[0]) / CREASE).powi(2)).max(0.0).powi(3))
                .product();
            PEBBLE_HEIGHT * (product - DOME * f[0] * f[0])
        };
        let mut random = Random::at(key(2, Stream::Noise, 0), 0, 0);
        for _ in 0..2000 {
            let offsets: [[f64; 2]; 6] =
                core::array::from_fn(|_| [random.range(-1.0, 1.0), random.range(-1.0, 1.0)]);
            let step = 1e-6;
            let moved = |dx: f64, dy: f64| height(&offsets.map(|[x, y]| [x + dx, y + dy]));
            let expected = [
                (moved(step, 0.0) - moved(-step, 0.0)) / (2.0 * step),
                (moved(0.0, step) - moved(0.0, -step)) / (2.0 * step),
            ];
            let found = pebble_slope(&offsets);
            for axis in 0..2 {
                // Twice what a border within the step takes.
                assert!(
                    (found[axis] - expected[axis]).abs() < 2e-5,
                    "{offsets:?}: {found:?} {expected:?}"
                );
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
