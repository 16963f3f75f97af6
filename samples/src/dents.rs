//! Brushed metal with dents.
//!
//! The blender's lid of \[YHJ*14\], figure 10. Dents are round hollows; where they meet, their heights add, to each
//! other's and to the brushing's.

use core::ops::Range;

use rayon::prelude::*;

use crate::{
    BAND_ROWS, Options, brushed,
    cells::CellGrid,
    disk::Disk,
    hollow,
    random::{Random, Stream, key},
    slopes::normalise,
    waves::fill_slopes,
};

/// Side of the cells that dents lie in, at scale 1, in texels.
const CELL_SIDE: f64 = 48.0;

/// Dents of a cell at density 1, on average.
///
/// Dents are 23 texels across in the mean and cover ⟨πR²⟩ = 543 texels: at most 0.8 · 543/48² = 19 % of a map.
const DENTS_PER_CELL: f64 = 0.8;

/// Radii at scale 1, in texels; small ones are frequent.
const RADIUS: [f64; 2] = [6.0, 24.0];

/// Smallest radius, in texels: narrower hollows fall between texels.
const MIN_RADIUS: f64 = 1.5;

/// Steepest slope of a dent, in RMS slopes of the brushing.
const STEEPNESS: [f64; 2] = [0.8, 2.0];

/// A hollow in the metal.
struct Dent {
    /// Middle, in texels from the tile's corner.
    disk: Disk,
    /// Steepest slope.
    steepness: f64,
}

/// Fills `normals` with those of brushed metal with dents, its RMS slope exactly `roughness`.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let width = options.width as usize;
    let brushing = brushed::fields(options);
    fill_slopes(&brushing, width, normals);
    let squares = brushing
        .iter()
        .filter(|(_, field)| field.expected_slope() > 0.0)
        .map(|(slope, _)| slope * slope);
    let dents = Dents::new(options, squares.sum::<f64>().sqrt());
    normals
        .par_chunks_mut(BAND_ROWS * width)
        .enumerate()
        .for_each(|(index, band)| {
            let first = index * BAND_ROWS;
            dents.add_slopes(first..first + band.len() / width, width, band);
        });
    normalise(normals, width, options.roughness);
}

/// The dents of a tile.
struct Dents {
    grid: CellGrid,
    key: u64,
    per_cell: f64,
    radius: [f64; 2],
    steepness: [f64; 2],
}

impl Dents {
    /// Those in a brushing of RMS slope `brushed_slope`.
    fn new(options: &Options, brushed_slope: f64) -> Self {
        let scale = options.scale.max(MIN_RADIUS / RADIUS[0]);
        // A dent does not reach around the tile to itself.
        let widest = 0.5 * f64::from(options.width.min(options.height));
        Self {
            grid: CellGrid::new(options.width, options.height, CELL_SIDE * scale),
            key: key(options.seed, Stream::Dent, 0),
            per_cell: DENTS_PER_CELL * options.density,
            radius: RADIUS.map(|radius| (radius * scale).min(widest)),
            steepness: STEEPNESS.map(|steepness| steepness * brushed_slope),
        }
    }

    /// Calls `visit` for each dent that reaches a point with y in `rows` (texels), those of copies above and below the
    /// tile too, in a fixed order.
    fn visit_rows(&self, rows: Range<f64>, mut visit: impl FnMut(&Dent)) {
        let [width, height] = self.grid.cell_size;
        let row_at = |y: f64| (y / height).floor() as i64;
        let first = row_at(rows.start - self.radius[1]);
        let last = row_at(rows.end + self.radius[1]);
        for row in first..=last {
            let wrapped = row.rem_euclid(self.grid.row_count) as u64;
            for column in 0..self.grid.column_count {
                let mut random = Random::at(self.key, column as u64, wrapped);
                let count = (self.per_cell + random.unit()) as u32;
                for _ in 0..count {
                    let dent = self.dent(&mut random, [column as f64 * width, row as f64 * height]);
                    let (y, radius) = (dent.disk.centre[1], dent.disk.radius);
                    if y + radius > rows.start && y - radius < rows.end {
                        visit(&dent);
                    }
                }
            }
        }
    }

    /// The next dent of the cell with its corner there.
    fn dent(&self, random: &mut Random, corner: [f64; 2]) -> Dent {
        let centre = [0, 1].map(|axis| corner[axis] + random.unit() * self.grid.cell_size[axis]);
        let small = random.unit();
        let [least, most] = self.radius;
        Dent {
            disk: Disk {
                centre,
                radius: least + (most - least) * small * small,
            },
            steepness: random.range(self.steepness[0], self.steepness[1]),
        }
    }

    /// Adds the slopes of the dents to those of `rows`.
    fn add_slopes(&self, rows: Range<usize>, width: usize, slopes: &mut [[f32; 2]]) {
        self.visit_rows(rows.start as f64..rows.end as f64, |dent| {
            let radius = dent.disk.radius;
            dent.disk
                .visit_texels(rows.clone(), width, |index, offset| {
                    let slope = hollow::slope(offset.map(|x| x / radius), dent.steepness);
                    for (sum, x) in slopes[index].iter_mut().zip(slope) {
                        *sum += x as f32;
                    }
                });
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, generate};

    #[test]
    fn dents_are_added_to_the_brushing_at_every_texel() {
        for (width, height, scale) in [(150, 140, 1.0), (37, 130, 0.6), (130, 90, 2.0)] {
            let options = Options {
                width,
                height,
                scale,
                density: 2.0,
                seed: 4,
                ..Options::new(Kind::Dents, 1)
            };
            let sample = generate(Kind::Dents, &options).expect("valid options");
            let brushing = brushed::fields(&options);
            let mut expected = vec![[0.0; 2]; sample.normals.len()];
            fill_slopes(&brushing, width as usize, &mut expected);
            let squares: f64 = brushing.iter().map(|(slope, _)| slope * slope).sum();
            let dents = Dents::new(&options, squares.sqrt());
            let mut all = Vec::new();
            for row in 0..dents.grid.row_count {
                for column in 0..dents.grid.column_count {
                    let mut random = Random::at(dents.key, column as u64, row as u64);
                    let count = (dents.per_cell + random.unit()) as u32;
                    let [w, h] = dents.grid.cell_size;
                    let corner = [column as f64 * w, row as f64 * h];
                    all.extend((0..count).map(|_| dents.dent(&mut random, corner)));
                }
            }
            assert!(!all.is_empty());
            for (index, sum) in expected.iter_mut().enumerate() {
                let [x, y] =
                    [index as u32 % width, index as u32 / width].map(|i| f64::from(i) + 0.5);
                for Dent { disk, steepness } in &all {
                    for copy in 0..9 {
                        let [dx, dy] = [copy % 3 - 1, copy / 3 - 1].map(f64::from);
                        let offset = [
                            x + dx * f64::from(width) - disk.centre[0],
                            y + dy * f64::from(height) - disk.centre[1],
                        ];
                        let slope = hollow::slope(offset.map(|x| x / disk.radius), *steepness);
                        for axis in 0..2 {
                            sum[axis] += slope[axis] as f32;
                        }
                    }
                }
            }
            normalise(&mut expected, width as usize, options.roughness);
            for (index, (expected, found)) in expected.iter().zip(&sample.normals).enumerate() {
                for axis in 0..2 {
                    let error = (expected[axis] - found[axis]).abs();
                    assert!(error < 1e-5, "{index}: {found:?}, not {expected:?}");
                }
            }
        }
    }

    #[test]
    fn without_dents_it_is_brushed_metal() {
        let options = Options {
            density: 0.0,
            ..Options::new(Kind::Dents, 100)
        };
        let generate = |kind| generate(kind, &options).expect("valid options");
        assert_eq!(generate(Kind::Dents), generate(Kind::Brushed));
    }

    #[test]
    fn density_decides_how_much_is_dented() {
        // Brushing hardly leans along u: what does is dented.
        let dented = |density| {
            let options = Options {
                density,
                ..Options::new(Kind::Dents, 1024)
            };
            let sample = generate(Kind::Dents, &options).expect("valid options");
            let leans = |normal: &&[f32; 2]| normal[0].abs() > 0.02;
            sample.normals.iter().filter(leans).count() as f64 / (1024.0 * 1024.0)
        };
        let [none, usual, twice] = [0.0, 1.0, 2.0].map(dented);
        assert!(none < 0.05, "{none}");
        assert!((0.09..0.19).contains(&usual), "{usual}");
        assert!((1.5..2.0).contains(&(twice / usual)), "{twice}");
    }
}
