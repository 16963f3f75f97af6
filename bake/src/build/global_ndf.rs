//! Global NDFs: what a bounce after the first sees of the whole map, as an image to evaluate and to draw from, \[YHJ*14\] §6.

use super::surface::texel;
use crate::normals::NormalMap;
use glintbake_format::model::Interpolation;
use glintbake_format::records::TileRoot;
use rayon::prelude::*;
use zerocopy::little_endian::{F32, U32};

/// Pixels along a side.
pub const SIDE: usize = 128;

/// Deviations of the kernel that the image reaches beyond the map's normals.
const MARGIN: f64 = 4.5;

/// Parts of the map that are counted apart, at most; by rows, so that they depend on the map alone.
const PARTS: usize = 64;

/// A global NDF.
pub struct GlobalNdf {
    /// The middle of the first pixel, and the pitch.
    pub root: Vec<TileRoot>,
    /// Shares of the pixels, row by row, each with those before it, of `u32::MAX`.
    pub sums: Vec<U32>,
}

/// Shares of pixels, row by row.
type Image = Vec<f64>;

/// The NDF of all of `map` under a kernel of deviation `sigma`: the pixels' shares of a mixture of tents about their middles, two
/// pitches wide, so that its density is the image interpolated bilinearly.
///
/// Normals at the middles of texels, and of surfaces that are interpolated a quarter of a texel to each side, are splatted
/// bilinearly and blurred by a Gaussian. Splats and tents add a sixth of the squared pitch each to the variance, which the blur
/// leaves out. A pitch is a 127th of the range of normals and 9 sigma; a kernel much narrower than that is as wide as the pitch.
/// O(texels).
pub fn build(map: &NormalMap, interpolation: Interpolation, sigma: f64) -> GlobalNdf {
    let grid = Grid::of(map, sigma);
    let height = map.height() as usize;
    let rows = height.div_ceil(PARTS);
    let parts: Vec<Image> = (0..height.div_ceil(rows))
        .into_par_iter()
        .map(|part| {
            let mut image = vec![0.0; SIDE * SIDE];
            for y in part * rows..((part + 1) * rows).min(height) {
                for x in 0..map.width() {
                    splat_cell(
                        &mut image,
                        &grid,
                        map,
                        interpolation,
                        [i64::from(x), y as i64],
                    );
                }
            }
            image
        })
        .collect();
    let mut image = vec![0.0; SIDE * SIDE];
    for part in &parts {
        for (sum, share) in image.iter_mut().zip(part) {
            *sum += share;
        }
    }
    // Along s, then, turned, along t; turned back.
    for axis in 0..2 {
        let pixels = sigma / grid.pitch[axis];
        image = blurred_and_turned(&image, (pixels * pixels - 1.0 / 3.0).max(0.0));
    }
    let root = TileRoot {
        low: grid.low.map(|x| F32::new(x as f32)),
        step: grid.pitch.map(|x| F32::new(x as f32)),
    };
    GlobalNdf {
        root: vec![root],
        sums: sums_of(&image),
    }
}

/// Where pixels lie, in the numbers that are stored.
struct Grid {
    low: [f64; 2],
    pitch: [f64; 2],
}

impl Grid {
    fn of(map: &NormalMap, sigma: f64) -> Self {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for normal in map.texels() {
            for axis in 0..2 {
                low[axis] = low[axis].min(f64::from(normal[axis]));
                high[axis] = high[axis].max(f64::from(normal[axis]));
            }
        }
        let low = low.map(|x| f64::from((x - MARGIN * sigma) as f32));
        let pitch = [0, 1].map(|axis| {
            let pitch = (high[axis] + MARGIN * sigma - low[axis]) / (SIDE - 1) as f64;
            f64::from(pitch as f32)
        });
        Self { low, pitch }
    }
}

/// Adds the normals of cell (`x`, `y`).
fn splat_cell(
    image: &mut Image,
    grid: &Grid,
    map: &NormalMap,
    interpolation: Interpolation,
    [x, y]: [i64; 2],
) {
    if interpolation == Interpolation::None {
        return splat(image, grid, texel(map, x, y));
    }
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| texel(map, x + i, y + j));
    for (across, down) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
        let weights = [
            (1.0 - across) * (1.0 - down),
            across * (1.0 - down),
            (1.0 - across) * down,
            across * down,
        ];
        let mut normal = [0.0; 2];
        for (weight, corner) in weights.iter().zip(&corners) {
            normal = [
                normal[0] + weight * corner[0],
                normal[1] + weight * corner[1],
            ];
        }
        splat(image, grid, normal);
    }
}

/// Adds 1, shared by the four pixels around `normal`.
fn splat(image: &mut Image, grid: &Grid, normal: [f64; 2]) {
    let [(column, right), (row, down)] = [0, 1].map(|axis| {
        let place = ((normal[axis] - grid.low[axis]) / grid.pitch[axis]).clamp(0.0, 126.999);
        (place as usize, place - place.floor())
    });
    let place = row * SIDE + column;
    image[place] += (1.0 - right) * (1.0 - down);
    image[place + 1] += right * (1.0 - down);
    image[place + SIDE] += (1.0 - right) * down;
    image[place + SIDE + 1] += right * down;
}

/// `image` with its rows blurred by a Gaussian of `variance` squared pixels, as columns.
fn blurred_and_turned(image: &[f64], variance: f64) -> Image {
    let kernel = kernel(variance);
    let reach = kernel.len() - 1;
    let rows: Vec<Vec<f64>> = image
        .par_chunks(SIDE)
        .map(|row| {
            let value = |x: usize| {
                let low = x.saturating_sub(reach);
                let near = low..(x + reach + 1).min(SIDE);
                near.map(|other| kernel[other.abs_diff(x)] * row[other])
                    .sum()
            };
            (0..SIDE).map(value).collect()
        })
        .collect();
    (0..SIDE * SIDE)
        .map(|place| rows[place % SIDE][place / SIDE])
        .collect()
}

/// Half of a kernel of `variance` squared pixels that adds up to 1, from its middle outwards.
fn kernel(variance: f64) -> Vec<f64> {
    // Where samples of the Gaussian would be too few to have its variance, three have.
    if variance < 0.25 {
        return vec![1.0 - variance, 0.5 * variance];
    }
    let reach = (MARGIN * variance.sqrt()).ceil() as usize;
    let samples: Vec<f64> = (0..=reach.min(SIDE))
        .map(|x| libm::exp(-0.5 * (x * x) as f64 / variance))
        .collect();
    let total = samples[0] + 2.0 * samples[1..].iter().sum::<f64>();
    samples.iter().map(|sample| sample / total).collect()
}

/// Shares added up, of `u32::MAX`.
fn sums_of(image: &[f64]) -> Vec<U32> {
    let total: f64 = image.iter().sum();
    let mut sum = 0.0;
    let mut sums: Vec<U32> = image
        .iter()
        .map(|share| {
            sum += share;
            U32::new((sum / total * f64::from(u32::MAX)).round() as u32)
        })
        .collect();
    if let Some(last) = sums.last_mut() {
        last.set(u32::MAX);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::model::Wrap;

    /// Mean and variance of s under the mixture of tents.
    fn moments(global: &GlobalNdf) -> [f64; 2] {
        let root = global.root[0];
        let (low, pitch) = (f64::from(root.low[0].get()), f64::from(root.step[0].get()));
        let mut before = 0;
        let (mut mean, mut square) = (0.0, 0.0);
        for (place, sum) in global.sums.iter().enumerate() {
            let share = f64::from(sum.get() - before) / f64::from(u32::MAX);
            before = sum.get();
            let s = low + pitch * (place % SIDE) as f64;
            mean += share * s;
            square += share * (s * s + pitch * pitch / 6.0);
        }
        [mean, square - mean * mean]
    }

    #[test]
    fn mean_and_variance_are_those_of_normals_and_kernel() {
        for (spread, sigma) in [(0.0, 0.01), (0.2, 0.05), (0.3, 0.01), (0.4, 0.25)] {
            let texels = (0..900).map(|i| [spread * ((i % 30) as f32 / 14.5 - 1.0), 0.1]);
            let map = NormalMap::new(30, 30, Wrap::Repeat, texels.collect());
            let global = build(&map, Interpolation::None, sigma);
            let [mean, variance] = moments(&global);
            let (spread, count) = (f64::from(spread), 30.0_f64);
            let own = spread * spread * (count * count - 1.0) / 12.0 * (2.0 / 29.0) * (2.0 / 29.0);
            assert!(mean.abs() < 1e-4, "{mean}");
            let exact = own + sigma * sigma;
            // The least blurred kernel that splats and tents leave is a pitch wide; tails are cut.
            assert!(
                (variance / exact - 1.0).abs() < 2e-3,
                "{spread} {sigma}: {variance} for {exact}"
            );
        }
    }
}
