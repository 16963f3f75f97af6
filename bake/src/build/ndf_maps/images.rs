//! The NDF of each tile of an example, as the density of its lobes over the tile, \[XTXW24\] §5.2.
//!
//! *Splines.* The NDF of a tile is a sum of Gaussians no narrower than σr. Pixels are coefficients of cubic B-splines, whose
//! integral is the pixels' and which are positive where pixels are. A B-spline has the variance h²/3, h being the pitch: the
//! coefficients are samples of the same density with `σr² - h²/3` in place of σr². With h = σr that leaves the fourth cumulant,
//! h⁴/30, by which the peak of a Gaussian of σr is 0.4 % too low, and aliasing of `2 exp(-2π² (σr² - h²/3) / h²)`, 4e-6.
//!
//! *Lobes over texels.* A texel is cut into cells in which normals change by little more than σr; over a cell, the share of a lobe
//! has a weight, a mean and a variance in closed form, as products of those of the axes, and its normals have mean `s + J m` and
//! covariance `σr² + J V Jᵀ`.

use super::splat::{Image, Splat};
use crate::normals::NormalMap;
use glintbake_format::model::{LobeLattice, NdfMapLayout, Wrap};
use rayon::prelude::*;

/// Most that the mean normal may change over a cell, in units of σr: what the shape of a cell's share then errs by is 3e-3 of a peak.
const MOST_CHANGE: f64 = 1.25;

/// Least share of a texel that a lobe adds to a cell, to count.
const LEAST_SHARE: f64 = 1e-7;

/// Texels beyond which a lobe counts as nothing: 4e-7 of it lies farther from its middle than 2.1.
const LOBE_REACH: i64 = 2;

/// A lobe of the example: its normal, and the slopes of it along columns and rows.
pub(super) struct Lobe {
    pub normal: [f64; 2],
    pub slope: [[f64; 2]; 2],
}

/// The lobe at texel (`x`, `y`) of the endless lattice.
pub(super) fn lobe(map: &NormalMap, x: i64, y: i64) -> Lobe {
    let fold = |index: i64, side: u32| {
        let side = i64::from(side);
        match map.wrap() {
            Wrap::Repeat => index.rem_euclid(side) as usize,
            Wrap::Clamp => index.clamp(0, side - 1) as usize,
        }
    };
    let normal = |x: i64, y: i64| {
        let place = fold(y, map.height()) * map.width() as usize + fold(x, map.width());
        map.texels()[place].map(f64::from)
    };
    let halved = |before: [f64; 2], after: [f64; 2]| {
        [0, 1].map(|axis: usize| 0.5 * (after[axis] - before[axis]))
    };
    Lobe {
        normal: normal(x, y),
        slope: [
            halved(normal(x - 1, y), normal(x + 1, y)),
            halved(normal(x, y - 1), normal(x, y + 1)),
        ],
    }
}

/// A part of an interval of a lobe's Gaussian.
#[derive(Clone, Copy, Debug)]
struct Part {
    weight: f64,
    mean: f64,
    variance: f64,
}

/// The parts of a lobe along an axis, `cells` equal ones of the texel that lies `offset` texels beyond the lobe's own.
fn parts(offset: i64, cells: u32) -> Vec<Part> {
    let sigma = LobeLattice::DEVIATION;
    let density = |z: f64| libm::exp(-0.5 * z * z) / (core::f64::consts::TAU).sqrt();
    let below = |z: f64| 0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2);
    (0..cells)
        .map(|cell| {
            let at = |edge: u32| (offset as f64 - 0.5 + f64::from(edge) / f64::from(cells)) / sigma;
            let (from, to) = (at(cell), at(cell + 1));
            // On the side where both tails are small.
            let weight = if from > 0.0 {
                below(-from) - below(-to)
            } else {
                below(to) - below(from)
            };
            if weight < LEAST_SHARE {
                return Part {
                    weight: 0.0,
                    mean: 0.0,
                    variance: 0.0,
                };
            }
            let mean = (density(from) - density(to)) / weight;
            let square = 1.0 + (from * density(from) - to * density(to)) / weight;
            let width = to - from;
            // No narrower than nothing, no wider than all at the ends.
            let variance = (square - mean * mean).clamp(0.0, 0.25 * width * width);
            Part {
                weight,
                mean: sigma * mean,
                variance: sigma * sigma * variance,
            }
        })
        .collect()
}

/// The shares of lobes over the texel at (`column`, `row`), with the variance `variance` of the kernel; they integrate to one.
fn splats(map: &NormalMap, [column, row]: [i64; 2], sigma: f64, variance: f64) -> Vec<Splat> {
    let mut splats = Vec::new();
    for y in row - LOBE_REACH..=row + LOBE_REACH {
        for x in column - LOBE_REACH..=column + LOBE_REACH {
            let lobe = lobe(map, x, y);
            let cells = lobe.slope.map(|[s, t]| cells_of(s, t, sigma) as u32);
            let [across, down] =
                [(column - x, cells[0]), (row - y, cells[1])].map(|(offset, cells)| {
                    let mut parts = parts(offset, cells);
                    parts.retain(|part| part.weight >= LEAST_SHARE);
                    parts
                });
            for down in down {
                for across in &across {
                    let weight = across.weight * down.weight;
                    if weight < LEAST_SHARE {
                        continue;
                    }
                    let [[s_x, t_x], [s_y, t_y]] = lobe.slope;
                    splats.push(Splat {
                        weight,
                        mean: [
                            lobe.normal[0] + s_x * across.mean + s_y * down.mean,
                            lobe.normal[1] + t_x * across.mean + t_y * down.mean,
                        ],
                        covariance: [
                            variance + s_x * s_x * across.variance + s_y * s_y * down.variance,
                            s_x * t_x * across.variance + s_y * t_y * down.variance,
                            variance + t_x * t_x * across.variance + t_y * t_y * down.variance,
                        ],
                    });
                }
            }
        }
    }
    let total: f64 = splats.iter().map(|splat| splat.weight).sum();
    for splat in &mut splats {
        splat.weight /= total;
    }
    splats
}

/// About how many pixels the splines of all tiles have, and of how many cells they are made: what can be said before they are.
pub(super) fn cost(map: &NormalMap, layout: &NdfMapLayout, sigma: f64, pitch: f64) -> [f64; 2] {
    let side = i64::from(map.width());
    let mut cells = 0.0;
    let mut boxes: Vec<[[f64; 2]; 2]> = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let mut own = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
            for (i, j) in (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j))) {
                let lobe = lobe(map, x + i, y + j);
                for (axis, own) in own.iter_mut().enumerate() {
                    // A texel from its middle a lobe has hardly any weight left.
                    let reach = lobe.slope[0][axis].abs() + lobe.slope[1][axis].abs();
                    own[0] = own[0].min(lobe.normal[axis] - reach);
                    own[1] = own[1].max(lobe.normal[axis] + reach);
                }
            }
            boxes.push(own);
            let of_lobe = lobe(map, x, y).slope.map(|[s, t]| cells_of(s, t, sigma));
            cells += of_lobe[0] * of_lobe[1];
        }
    }
    let mut pixels = 0.0;
    for level in 0..layout.levels() {
        let tiles = layout.tiles(level) as usize;
        if level > 0 {
            let child = |x: usize, y: usize| boxes[y * 2 * tiles + x];
            boxes = (0..tiles * tiles)
                .map(|tile| {
                    let (x, y) = (2 * (tile % tiles), 2 * (tile / tiles));
                    let four = [
                        child(x, y),
                        child(x + 1, y),
                        child(x, y + 1),
                        child(x + 1, y + 1),
                    ];
                    [0, 1].map(|axis: usize| {
                        let low = four
                            .iter()
                            .map(|one| one[axis][0])
                            .fold(f64::INFINITY, f64::min);
                        let high = four
                            .iter()
                            .map(|one| one[axis][1])
                            .fold(f64::NEG_INFINITY, f64::max);
                        [low, high]
                    })
                })
                .collect();
        }
        let width = |[low, high]: [f64; 2]| (high - low + 10.0 * sigma) / pitch;
        pixels += boxes
            .iter()
            .map(|one| width(one[0]) * width(one[1]))
            .sum::<f64>();
    }
    [pixels, cells]
}

/// Into how many cells a texel is cut along an axis on which normals change by (`s`, `t`).
fn cells_of(s: f64, t: f64, sigma: f64) -> f64 {
    ((s * s + t * t).sqrt() / (MOST_CHANGE * sigma))
        .ceil()
        .max(1.0)
}

/// Spline coefficients of every tile, level by level and row by row, at nodes of `pitch`, for the kernel deviation `sigma`.
pub(super) fn splines(
    map: &NormalMap,
    layout: &NdfMapLayout,
    sigma: f64,
    pitch: f64,
) -> Vec<Image> {
    let variance = sigma * sigma - pitch * pitch / 3.0;
    let side = layout.tiles(0) as usize;
    let mut images: Vec<Image> = (0..side * side)
        .into_par_iter()
        .map(|tile| {
            let place = [tile % side, tile / side].map(|along| along as i64);
            Image::of(&splats(map, place, sigma, variance), pitch)
        })
        .collect();
    for level in 1..layout.levels() {
        let (below, side) = (
            layout.tiles(level - 1) as usize,
            layout.tiles(level) as usize,
        );
        let first = layout.tiles_before(level - 1);
        let level: Vec<Image> = (0..side * side)
            .into_par_iter()
            .map(|tile| {
                let (x, y) = (2 * (tile % side), 2 * (tile / side));
                let child = |x: usize, y: usize| &images[first + y * below + x];
                let four = [
                    child(x, y),
                    child(x + 1, y),
                    child(x, y + 1),
                    child(x + 1, y + 1),
                ];
                Image::mean(&four, &[0.25; 4])
            })
            .collect();
        images.extend(level);
    }
    images
}

/// The images of \[XTXW24\] eq. 2: in each tile the mean of its texels' kernels, at the middles of `side` × `side` pixels over the disk's
/// square, level by level and row by row.
pub(super) fn points(map: &NormalMap, layout: &NdfMapLayout, sigma: f64, side: u32) -> Vec<Image> {
    let pitch = 2.0 / f64::from(side);
    let low = -(side as i32 / 2);
    let peak = 1.0 / (core::f64::consts::TAU * sigma * sigma);
    (0..layout.levels())
        .flat_map(|level| {
            let tiles = layout.tiles(level);
            (0..tiles * tiles).map(move |tile| (level, tile % tiles, tile / tiles))
        })
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(level, column, row)| {
            let texels = 1_u32 << level;
            let weight = peak / f64::from(texels * texels);
            let mut image = Image::zeros([low; 2], [low + side as i32; 2]);
            for y in row * texels..(row + 1) * texels {
                for x in column * texels..(column + 1) * texels {
                    let normal = map.texels()[(y * map.width() + x) as usize].map(f64::from);
                    let near = normal.map(|at| {
                        let node = |at: f64| (at / pitch - 0.5).floor() as i32 - low;
                        let reach = 9.0 * sigma;
                        (
                            node(at - reach).max(0),
                            (node(at + reach) + 1).min(side as i32 - 1),
                        )
                    });
                    let fall = |node: i32, normal: f64| {
                        let distance = (f64::from(low + node) + 0.5) * pitch - normal;
                        libm::exp(-0.5 * distance * distance / (sigma * sigma))
                    };
                    for j in near[1].0..=near[1].1 {
                        let of_row = weight * fall(j, normal[1]);
                        for i in near[0].0..=near[0].1 {
                            image.values[(j * side as i32 + i) as usize] +=
                                of_row * fall(i, normal[0]);
                        }
                    }
                }
            }
            image
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_lobe_have_its_weight_mean_and_variance() {
        for cells in [1, 3, 40] {
            let all: Vec<Part> = (-3..=3).flat_map(|offset| parts(offset, cells)).collect();
            let sum = |of: &dyn Fn(&Part) -> f64| all.iter().map(of).sum::<f64>();
            let weight = sum(&|part| part.weight);
            let mean = sum(&|part| part.weight * part.mean);
            let square = sum(&|part| part.weight * (part.mean * part.mean + part.variance));
            assert!((weight - 1.0).abs() < 1e-5, "{cells} {weight}");
            assert!(mean.abs() < 1e-9, "{cells} {mean}");
            let variance = LobeLattice::DEVIATION * LobeLattice::DEVIATION;
            assert!(
                (square - variance).abs() < 1e-4 * variance,
                "{cells} {square}"
            );
        }
    }
}
