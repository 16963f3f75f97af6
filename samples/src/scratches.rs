//! Fine grooves in polished metal.
//!
//! A groove is a height field of its own. In its frame (a along, b across, in texels, from its middle):
//!
//! ```text
//!     h(a, b) = −depth · e(a) · (1 + cos πq)/2     q = (b − κ a²/2)/w, |q| ≤ 1
//!     e(a) = (1 − (a/ℓ)²)²                         |a| ≤ ℓ
//! ```
//!
//! w is half the width, ℓ half the length, κ the bend. Slopes are its exact derivatives; walls are steepest at
//! q = ±½, where |∂h/∂b| = depth · π/(2w).

use core::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::{
    BAND_ROWS, Options,
    random::{Random, Stream, key},
    slopes::normal,
};

/// Texels of a map for each scratch, at scale 1 and density 1.
///
/// A scratch is 160 × 2.4 texels on average, so scattered ones cover 1 − exp(−160·2.4/800) = 38 % of a large map.
const TEXELS_PER_SCRATCH: f64 = 800.0;

/// Beckmann α of the polished ground between scratches, as a share of roughness: keeps its highlight from being a
/// single direction, and is invisible next to a groove.
const BASE_ROUGHNESS: f64 = 0.03;

/// Half widths at scale 1, in texels; narrower grooves fall between texels.
const HALF_WIDTH: [f64; 2] = [0.8, 2.0];

/// Half lengths at scale 1, in texels.
const HALF_LENGTH: [f64; 2] = [20.0, 200.0];

/// Length of the pieces that a scratch is drawn in, in half widths: short ones have tight bounding boxes.
const PIECE_LENGTH: f64 = 16.0;

struct Scratch {
    centre: [f64; 2],
    /// Unit vector along the middle, (columns, rows).
    along: [f64; 2],
    half_length: f64,
    half_width: f64,
    /// κ, in 1/texel: at most 0.3 ℓ⁻¹, so that the far ends turn by less than 17°.
    bend: f64,
    depth: f64,
}

/// Height and (∂/∂column, ∂/∂row) of a groove.
struct Groove {
    height: f64,
    slope: [f64; 2],
}

impl Scratch {
    /// Draws a scratch of scale `scale` on the tile of `options`.
    fn new(random: &mut Random, options: &Options, scale: f64) -> Self {
        let centre = [
            random.unit() * f64::from(options.width),
            random.unit() * f64::from(options.height),
        ];
        let (sin, cos) = libm::sincos(TAU * random.unit());
        // Short, narrow and shallow ones are the most frequent: squares of uniform numbers.
        let mut skewed = |[low, high]: [f64; 2]| {
            let u = random.unit();
            low + (high - low) * u * u
        };
        // Longer than the tile it would run on beside itself.
        let longest = 0.5 * f64::from(options.width.max(options.height));
        let half_length = (skewed(HALF_LENGTH) * scale).min(longest);
        let half_width = skewed(HALF_WIDTH) * scale;
        let steepness = skewed([0.25, 1.0]) * options.roughness;
        Self {
            centre,
            along: [cos, sin],
            half_length,
            half_width,
            bend: random.range(-0.3, 0.3) / half_length,
            depth: steepness * 2.0 * half_width / PI,
        }
    }

    /// The groove `offset` texels from the centre, (columns, rows), if it reaches there.
    fn groove(&self, offset: [f64; 2]) -> Option<Groove> {
        let [cos, sin] = self.along;
        let a = offset[0] * cos + offset[1] * sin;
        let b = offset[1] * cos - offset[0] * sin;
        let r = a / self.half_length;
        let q = (b - 0.5 * self.bend * a * a) / self.half_width;
        if q.abs() >= 1.0 || r.abs() >= 1.0 {
            return None;
        }
        let (sin_q, cos_q) = libm::sincos(PI * q);
        let fade = 1.0 - r * r;
        let profile = 0.5 * (1.0 + cos_q);
        let deep = self.depth * fade * fade;
        let across = deep * 0.5 * PI * sin_q / self.half_width;
        let along =
            self.depth * 4.0 * fade * r / self.half_length * profile - across * self.bend * a;
        Some(Groove {
            height: -deep * profile,
            slope: [along * cos - across * sin, along * sin + across * cos],
        })
    }

    fn piece_count(&self) -> u32 {
        (2.0 * self.half_length / (PIECE_LENGTH * self.half_width)).ceil() as u32
    }

    /// Texel columns and rows, not wrapped, that piece `piece` may reach: ([first, last], [first, last]).
    fn bounds(&self, piece: u32) -> [[i64; 2]; 2] {
        let step = 2.0 * self.half_length / f64::from(self.piece_count());
        let start = f64::from(piece) * step - self.half_length;
        let ends = [start, start + step];
        let bow = ends.map(|a| 0.5 * self.bend * a * a);
        let [cos, sin] = self.along;
        // Between its ends an arc bows out by κ step²/8 more than its chord.
        let margin = self.half_width + 0.125 * self.bend.abs() * step * step;
        [(self.centre[0], cos, -sin), (self.centre[1], sin, cos)].map(|(centre, along, across)| {
            let ends = [0, 1].map(|i| centre + ends[i] * along + bow[i] * across);
            let reach = margin * across.abs();
            [
                (ends[0].min(ends[1]) - reach - 0.5).ceil() as i64,
                (ends[0].max(ends[1]) + reach - 0.5).floor() as i64,
            ]
        })
    }
}

/// Fills `normals` with the ground and the grooves in it; where several meet, the deepest decides.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let width = options.width as usize;
    let height = options.height as usize;
    let scratches = scratches(options);
    let pieces = pieces_per_band(&scratches, height);
    let base_key = key(options.seed, Stream::ScratchBase, 0);
    let base_deviation = BASE_ROUGHNESS * options.roughness * core::f64::consts::FRAC_1_SQRT_2;
    normals
        .par_chunks_mut(BAND_ROWS * width)
        .enumerate()
        .for_each(|(index, band)| {
            let first_row = index * BAND_ROWS;
            let mut ground: Vec<_> = (0..band.len())
                .map(|_| Groove {
                    height: 0.0,
                    slope: [0.0; 2],
                })
                .collect();
            for &(scratch, piece) in &pieces[index] {
                let scratch = &scratches[scratch as usize];
                let [columns, rows] = scratch.bounds(piece);
                for y in rows[0]..=rows[1] {
                    let row = y.rem_euclid(height as i64) as usize;
                    let Some(start) = row
                        .checked_sub(first_row)
                        .map(|row| row * width)
                        .filter(|&start| start < band.len())
                    else {
                        continue;
                    };
                    for x in columns[0]..=columns[1] {
                        let column = x.rem_euclid(width as i64) as usize;
                        let offset = [
                            x as f64 + 0.5 - scratch.centre[0],
                            y as f64 + 0.5 - scratch.centre[1],
                        ];
                        let texel = &mut ground[start + column];
                        if let Some(groove) = scratch.groove(offset)
                            && groove.height < texel.height
                        {
                            *texel = groove;
                        }
                    }
                }
            }
            for (i, (texel, groove)) in band.iter_mut().zip(&ground).enumerate() {
                let [column, row] = [i % width, first_row + i / width];
                let grain = Random::at(base_key, column as u64, row as u64).gaussian_pair();
                *texel =
                    normal([0, 1].map(|axis| groove.slope[axis] + base_deviation * grain[axis]));
            }
        });
}

/// The scratches of a map, in a fixed order.
fn scratches(options: &Options) -> Vec<Scratch> {
    let area = f64::from(options.width) * f64::from(options.height);
    // Narrower than a texel they would fall between centres.
    let scale = options.scale.max(0.5 / HALF_WIDTH[0]);
    let count = (options.density * area / (TEXELS_PER_SCRATCH * scale * scale)).ceil();
    let key = key(options.seed, Stream::Scratch, 0);
    (0..count as u64)
        .map(|index| Scratch::new(&mut Random::at(key, index, 0), options, scale))
        .collect()
}

/// For each band of [`BAND_ROWS`] rows, the (scratch, piece) that reach it, in order.
fn pieces_per_band(scratches: &[Scratch], height: usize) -> Vec<Vec<(u32, u32)>> {
    let mut bands = vec![Vec::new(); height.div_ceil(BAND_ROWS)];
    for (index, scratch) in (0..).zip(scratches) {
        for piece in 0..scratch.piece_count() {
            let [_, rows] = scratch.bounds(piece);
            for y in rows[0]..=rows[1] {
                let band = &mut bands[y.rem_euclid(height as i64) as usize / BAND_ROWS];
                // Pieces come one after the other: if this one is in the band already, it is the last.
                if band.last() != Some(&(index, piece)) {
                    band.push((index, piece));
                }
            }
        }
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, generate};

    fn options(width: u32, height: u32, scale: f64) -> Options {
        Options {
            width,
            height,
            scale,
            seed: 11,
            ..Options::new(Kind::Scratches, 1)
        }
    }

    #[test]
    fn slopes_are_the_derivatives_of_the_heights() {
        let step = 1e-5;
        let mut seen = 0;
        for scratch in scratches(&options(200, 300, 2.0)) {
            for i in 0..200 {
                let offset = [
                    f64::from(i) * 0.37 - 37.0,
                    f64::from(i * 7 % 200) * 0.21 - 21.0,
                ];
                let at = |dx: f64, dy: f64| scratch.groove([offset[0] + dx, offset[1] + dy]);
                let [Some(here), Some(left), Some(right), Some(up), Some(down)] = [
                    at(0.0, 0.0),
                    at(-step, 0.0),
                    at(step, 0.0),
                    at(0.0, -step),
                    at(0.0, step),
                ] else {
                    continue;
                };
                let across = (right.height - left.height) / (2.0 * step);
                let along = (down.height - up.height) / (2.0 * step);
                assert!(
                    (across - here.slope[0]).abs() < 1e-8,
                    "{across} {:?}",
                    here.slope
                );
                assert!(
                    (along - here.slope[1]).abs() < 1e-8,
                    "{along} {:?}",
                    here.slope
                );
                assert!(here.height < 0.0);
                seen += 1;
            }
        }
        assert!(seen > 300, "only {seen} points were in a groove");
    }

    #[test]
    fn drawing_in_pieces_is_the_deepest_groove_at_every_texel() {
        // The second tile is narrower than its grooves are long: they wrap several times.
        for (width, height, scale) in [(150, 140, 0.8), (9, 130, 1.3)] {
            let options = options(width, height, scale);
            let sample = generate(Kind::Scratches, &options).expect("valid options");
            let scratches = scratches(&options);
            let base = key(options.seed, Stream::ScratchBase, 0);
            let deviation = BASE_ROUGHNESS * options.roughness * core::f64::consts::FRAC_1_SQRT_2;
            let copies = |extent: u32| {
                let reach = i64::from(width.max(height) / extent) + 1;
                (-reach..=reach).map(move |copy| copy as f64 * f64::from(extent))
            };
            for (index, found) in sample.normals.iter().enumerate() {
                let [x, y] = [index as u32 % width, index as u32 / width];
                let mut deepest = Groove {
                    height: 0.0,
                    slope: [0.0; 2],
                };
                for scratch in &scratches {
                    for dx in copies(width) {
                        for dy in copies(height) {
                            let groove = scratch.groove([
                                f64::from(x) + 0.5 + dx - scratch.centre[0],
                                f64::from(y) + 0.5 + dy - scratch.centre[1],
                            ]);
                            if let Some(groove) = groove
                                && groove.height < deepest.height
                            {
                                deepest = groove;
                            }
                        }
                    }
                }
                let grain = Random::at(base, u64::from(x), u64::from(y)).gaussian_pair();
                let expected =
                    normal([0, 1].map(|axis| deepest.slope[axis] + deviation * grain[axis]));
                for axis in 0..2 {
                    // Unwrapped coordinates differ by whole tiles, and so in their rounding.
                    assert!(
                        (expected[axis] - found[axis]).abs() < 1e-6,
                        "({x}, {y}): {expected:?} {found:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn density_decides_how_much_is_covered_and_roughness_how_steep() {
        let covered = |density| {
            let options = Options {
                density,
                ..options(512, 512, 1.0)
            };
            let sample = generate(Kind::Scratches, &options).expect("valid options");
            let steep = |&&[s, t]: &&[f32; 2]| s.hypot(t) > 0.06;
            assert!(sample.normals.iter().all(|[s, t]| {
                let sin_squared = f64::from(s * s + t * t);
                // The steepest wall, its fade along the groove, and six deviations of the grain.
                (sin_squared / (1.0 - sin_squared)).sqrt() < 0.6 * 1.2
            }));
            sample.normals.iter().filter(steep).count() as f64 / (512.0 * 512.0)
        };
        let [none, usual, many] = [0.0, 1.0, 4.0].map(covered);
        assert!(none < 1e-3, "{none}");
        assert!((0.15..0.38).contains(&usual), "{usual}");
        assert!(many > 2.0 * usual, "{many}");
    }
}
