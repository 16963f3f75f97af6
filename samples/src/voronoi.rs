//! Metallic flakes as cells of a Voronoi diagram.
//!
//! The metallic paint of \[YHJ*14\], section 7: texels are clustered "into Voronoi cells, whose centers are chosen
//! using Poisson disk sampling", each cell with "a fixed normal …, drawn from the Beckmann distribution" and no
//! interpolation.

use rayon::prelude::*;

use crate::{
    BAND_ROWS, Options,
    disk::Disk,
    poisson_disk::{PoissonDisk, REACH},
    random::{Random, Stream, key},
    slopes::normal,
};

/// Texels of a flake on average, at scale 1: as many as [`flakes`](crate::Kind::Flakes) show.
const TEXELS_PER_FLAKE: f64 = 32.0;

/// Texels of the smallest flakes, on average: smaller ones would be white noise.
const MIN_TEXELS_PER_FLAKE: f64 = 4.0;

/// Area of a tile per centre, in squared radii.
///
/// Disks of half the radius then cover 0.547 of it, as random sequential ones do when no other fits (Feder 1980).
const AREA_PER_CENTRE: f64 = 1.436;

/// Fills `normals` with flakes: each texel has the normal of the centre nearest to its own.
pub fn fill(options: &Options, normals: &mut [[f32; 2]]) {
    let width = options.width as usize;
    let radius = radius(options);
    let centres = PoissonDisk::new(options.seed, [options.width, options.height], radius);
    let key = key(options.seed, Stream::Facet, 0);
    // Slopes of Beckmann's distribution are Gaussian with variance α²/2 (Heitz 2014, appendix).
    let deviation = options.roughness * core::f64::consts::FRAC_1_SQRT_2;
    let reach = radius * REACH;
    normals
        .par_chunks_mut(BAND_ROWS * width)
        .enumerate()
        .for_each(|(index, band)| {
            let first = index * BAND_ROWS;
            let rows = first..first + band.len() / width;
            let mut nearest = vec![f64::INFINITY; band.len()];
            // No texel is farther from its centre than the reach: each centre is compared at the texels in its disk
            // alone.
            let near = rows.start as f64 - reach..rows.end as f64 + reach;
            centres.visit_rows(near, |centre| {
                let [column, row] = centres.wrapped(centre.cell).map(|index| index as u64);
                let facet = Random::at(key, column, row).gaussian_pair();
                let facet = normal(facet.map(|x| x * deviation));
                let disk = Disk {
                    centre: centre.position,
                    radius: reach,
                };
                disk.visit_texels(rows.clone(), width, |index, [dx, dy]| {
                    let squared = dx * dx + dy * dy;
                    if squared < nearest[index] {
                        nearest[index] = squared;
                        band[index] = facet;
                    }
                });
            });
        });
}

/// Distance that centres keep, in texels.
fn radius(options: &Options) -> f64 {
    let texels = TEXELS_PER_FLAKE * options.scale * options.scale;
    (texels.max(MIN_TEXELS_PER_FLAKE) / AREA_PER_CENTRE).sqrt()
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;
    use std::collections::HashMap;

    use super::*;
    use crate::{Kind, generate, tests::slopes};

    fn flakes(options: &Options) -> HashMap<[u32; 2], usize> {
        let sample = generate(Kind::Voronoi, options).expect("valid options");
        let mut texel_counts = HashMap::new();
        for normal in sample.normals {
            *texel_counts.entry(normal.map(f32::to_bits)).or_default() += 1;
        }
        texel_counts
    }

    #[test]
    fn every_texel_has_the_normal_of_its_nearest_centre() {
        for (width, height, scale) in [(80, 140, 1.0), (3, 150, 0.7), (90, 70, 4.0)] {
            let options = Options {
                width,
                height,
                scale,
                ..Options::new(Kind::Voronoi, 1)
            };
            let sample = generate(Kind::Voronoi, &options).expect("valid options");
            let [w, h] = [width, height].map(f64::from);
            let mut centres = Vec::new();
            let disk = PoissonDisk::new(options.seed, [width, height], radius(&options));
            disk.visit_rows(0.0..h, |centre| centres.push(centre));
            let key = key(options.seed, Stream::Facet, 0);
            for (index, &found) in sample.normals.iter().enumerate() {
                let [x, y] =
                    [index as u32 % width, index as u32 / width].map(|i| f64::from(i) + 0.5);
                let squared = |position: [f64; 2]| {
                    let [dx, dy] = [(x - position[0], w), (y - position[1], h)].map(|(d, side)| {
                        let d = d.rem_euclid(side);
                        d.min(side - d)
                    });
                    dx * dx + dy * dy
                };
                let nearest = centres
                    .iter()
                    .min_by(|a, b| squared(a.position).total_cmp(&squared(b.position)))
                    .expect("a centre");
                let [column, row] = disk.wrapped(nearest.cell).map(|i| i as u64);
                let slope = Random::at(key, column, row).gaussian_pair();
                let expected = normal(slope.map(|x| x * options.roughness * 0.5_f64.sqrt()));
                for axis in 0..2 {
                    let error = (expected[axis] - found[axis]).abs();
                    assert!(error < 1e-6, "({x}, {y}): {found:?}, not {expected:?}");
                }
            }
        }
    }

    #[test]
    fn a_flake_shows_the_stated_texels() {
        for (scale, size) in [(0.5, 128), (1.0, 256), (3.0, 512)] {
            let options = Options {
                scale,
                ..Options::new(Kind::Voronoi, size)
            };
            let flakes = flakes(&options);
            let mean = f64::from(size * size) / flakes.len() as f64;
            let stated = TEXELS_PER_FLAKE * scale * scale;
            assert!(
                (mean / stated - 1.0).abs() < 0.05,
                "scale {scale}: {mean} texels"
            );
            // Poisson disks make flakes even: the smallest holds a disk of half the radius, 0.547 of the mean.
            let odd = flakes
                .values()
                .map(|&count| count as f64 / stated)
                .filter(|share| !(0.4..2.0).contains(share));
            assert!(odd.count() <= flakes.len() / 200, "scale {scale}");
        }
    }

    #[test]
    fn slopes_of_flakes_follow_beckmann() {
        for alpha in [0.002, 0.12, 0.7] {
            let options = Options {
                roughness: alpha,
                ..Options::new(Kind::Voronoi, 512)
            };
            let mut all = slopes(&generate(Kind::Voronoi, &options).expect("valid options"));
            all.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
            all.dedup();
            assert!(all.len() > 7000, "{} flakes", all.len());
            // tan² θ is exponential with mean α²: ∫ D cos θ dω up to θ is 1 − exp(−tan² θ/α²).
            let mut levels: Vec<_> = all
                .iter()
                .map(|[a, b]| 1.0 - libm::exp(-(a * a + b * b) / (alpha * alpha)))
                .collect();
            levels.sort_by(f64::total_cmp);
            let distance = crate::tests::distance_from_uniform(&levels);
            assert!(distance < 1.0, "alpha {alpha}: {distance}");
            let mut turns: Vec<_> = all
                .iter()
                .map(|&[a, b]| libm::atan2(b, a) / TAU + 0.5)
                .collect();
            turns.sort_by(f64::total_cmp);
            let distance = crate::tests::distance_from_uniform(&turns);
            assert!(distance < 1.0, "alpha {alpha}: azimuth {distance}");
        }
    }
}
