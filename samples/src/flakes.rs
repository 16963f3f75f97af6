//! Metallic flakes of car paint.

use core::f64::consts::TAU;

use rayon::prelude::*;

use crate::{
    BAND_ROWS, Gtr, Options,
    cells::CellGrid,
    random::{Random, Stream, key},
    slopes::normal_at,
};

/// Exponent γ of the flakes' GTR distribution, that of \[AWKK21\], figure 1.
pub const FLAKE_GAMMA: f64 = 1.5;

/// Texels of one cell, and so of one flake on average, at scale 1.
const TEXELS_PER_FLAKE: f64 = 32.0;

/// Sides of a flake: broken leaves of metal are irregular polygons; more sides would look round.
const SIDES: usize = 6;

/// Smallest and largest distance of a side from the flake's seed, in cell sides.
///
/// A regular hexagon of the mean distance covers 1.15 cells: flakes overlap, and the gaps between them stay small.
const REACH: [f64; 2] = [0.4, 0.75];

/// A flake cut from a leaf of metal, lying at some depth of the paint.
struct Flake {
    /// Position within its cell, both in [0, 1).
    seed: [f64; 2],
    /// Outward normal of each side over the side's distance from the seed, in 1/texel.
    sides: [[f64; 2]; SIDES],
    /// 1/reach², in 1/texel²: corners farther than the reach are broken off.
    inverse_squared_reach: f64,
    /// In [0, 1), 0 on top.
    depth: f64,
    normal: [f32; 2],
}

impl Flake {
    fn new(random: &mut Random, cell_side: f64, gtr: Gtr) -> Self {
        let seed = [random.unit(), random.unit()];
        let turn = random.unit();
        let size = random.range(0.8, 1.2);
        let sides = core::array::from_fn(|side| {
            // Each direction strays by up to a fifth of the angle between two sides.
            let angle = TAU * (turn + (side as f64 + random.range(-0.2, 0.2)) / SIDES as f64);
            let distance = random.range(REACH[0], REACH[1]) * size * cell_side;
            let (sin, cos) = libm::sincos(angle);
            [cos / distance, sin / distance]
        });
        let reach = REACH[1] * 1.1 * size * cell_side;
        Self {
            seed,
            sides,
            inverse_squared_reach: 1.0 / (reach * reach),
            depth: random.unit(),
            normal: normal_at(gtr.sin_squared(random.unit()), TAU * random.unit()),
        }
    }

    /// How far `offset` (from the seed, in texels) lies out of the flake: at most 1 inside, then growing.
    fn gauge(&self, [dx, dy]: [f64; 2]) -> f64 {
        let farthest_side = self
            .sides
            .iter()
            .map(|&[x, y]| x * dx + y * dy)
            .fold(0.0, f64::max);
        farthest_side.max((dx * dx + dy * dy) * self.inverse_squared_reach)
    }
}

/// Fills `normals` with flakes: each texel shows the uppermost flake over its centre, or, in a gap, the flake it is
/// least far out of, among those of the 3 × 3 cells around.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let width = options.width as usize;
    let grid = grid(options);
    let key = key(options.seed, Stream::Flake, 0);
    let gtr = Gtr {
        alpha: options.roughness,
        gamma: FLAKE_GAMMA,
    };
    let cell_side = (grid.cell_size[0] * grid.cell_size[1]).sqrt();
    normals
        .par_chunks_mut(BAND_ROWS * width)
        .enumerate()
        .for_each(|(index, band)| {
            let first = index * BAND_ROWS;
            let rows = first..first + band.len() / width;
            let block = grid.block(rows.clone(), 0.0, |column, row| {
                Flake::new(&mut Random::at(key, column, row), cell_side, gtr)
            });
            for (row, texels) in rows.zip(band.chunks_mut(width)) {
                let y = row as f64 + 0.5;
                for (column, texel) in texels.iter_mut().enumerate() {
                    let x = column as f64 + 0.5;
                    let mut best = f64::INFINITY;
                    block.visit_around([x, y], 1, |corner, flake| {
                        // A deeper flake cannot win, inside or out: no need to know where its sides are.
                        if flake.depth >= best {
                            return;
                        }
                        let gauge = flake.gauge([
                            x - corner[0] - flake.seed[0] * grid.cell_size[0],
                            y - corner[1] - flake.seed[1] * grid.cell_size[1],
                        ]);
                        let rank = if gauge <= 1.0 { flake.depth } else { gauge };
                        if rank < best {
                            best = rank;
                            *texel = flake.normal;
                        }
                    });
                }
            }
        });
}

fn grid(options: &Options) -> CellGrid {
    CellGrid::new(
        options.width,
        options.height,
        TEXELS_PER_FLAKE.sqrt() * options.scale,
    )
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::{Kind, generate};

    /// Texels of each visible flake, by the bits of its normal.
    fn flakes(options: &Options) -> HashMap<[u32; 2], usize> {
        let sample = generate(Kind::Flakes, options).expect("valid options");
        let mut texel_counts = HashMap::new();
        for normal in sample.normals {
            *texel_counts.entry(normal.map(f32::to_bits)).or_default() += 1;
        }
        texel_counts
    }

    #[test]
    fn a_flake_shows_the_stated_texels() {
        for (scale, size) in [(0.5, 128), (1.0, 256), (3.0, 512)] {
            let options = Options {
                scale,
                ..Options::new(Kind::Flakes, size)
            };
            let flakes = flakes(&options);
            let mean = f64::from(size * size) / flakes.len() as f64;
            let stated = TEXELS_PER_FLAKE * scale * scale;
            assert!(
                (mean / stated - 1.0).abs() < 0.05,
                "scale {scale}: {mean} texels"
            );
            let usual = flakes
                .values()
                .filter(|&&count| (0.25..2.0).contains(&(count as f64 / stated)))
                .count();
            assert!(
                usual as f64 > 0.9 * flakes.len() as f64,
                "scale {scale}: {usual} of {} flakes are of usual size",
                flakes.len()
            );
        }
    }

    #[test]
    fn normals_follow_the_distribution_in_angle_and_azimuth() {
        for alpha in [0.002, 0.12, 0.7] {
            let options = Options {
                roughness: alpha,
                ..Options::new(Kind::Flakes, 512)
            };
            let normals: Vec<_> = flakes(&options)
                .into_keys()
                .map(|bits| bits.map(|x| f64::from(f32::from_bits(x))))
                .collect();
            // F(sin² θ) for γ = 3/2, integrated by hand: (1 − α/√q)/(1 − α) with q = α² + (1 − α²) sin² θ.
            let mut levels: Vec<f64> = normals
                .iter()
                .map(|[s, t]| {
                    let q = alpha * alpha + (1.0 - alpha * alpha) * (s * s + t * t);
                    (1.0 - alpha / q.sqrt()) / (1.0 - alpha)
                })
                .collect();
            levels.sort_by(f64::total_cmp);
            let distance = crate::tests::distance_from_uniform(&levels);
            assert!(distance < 1.0, "alpha {alpha}: {distance}");
            let mut turns: Vec<f64> = normals
                .iter()
                .map(|&[s, t]| libm::atan2(t, s) / TAU + 0.5)
                .collect();
            turns.sort_by(f64::total_cmp);
            let distance = crate::tests::distance_from_uniform(&turns);
            assert!(distance < 1.0, "alpha {alpha}: azimuth {distance}");
        }
    }

    #[test]
    fn roughness_changes_normals_but_not_outlines() {
        let edges = |roughness| {
            let options = Options {
                roughness,
                ..Options::new(Kind::Flakes, 64)
            };
            let sample = generate(Kind::Flakes, &options).expect("valid options");
            let pairs = sample.normals.windows(2);
            pairs.map(|pair| pair[0] == pair[1]).collect::<Vec<_>>()
        };
        assert_eq!(edges(0.002), edges(0.3));
    }
}
