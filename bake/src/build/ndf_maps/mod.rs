//! NDF maps: images of the NDFs of an example's tiles, and its copies over a surface \[XTXW24\] §5 and §6.

mod copies;
mod images;
mod polygon;
mod splat;

use crate::error::BakeError;
use crate::noise::NoiseCopy;
use crate::normals::NormalMap;
use copies::{Placed, Scattered};
use glintbake_format::model::{NdfMapLayout, NdfPixels};
use glintbake_format::records::{NdfCopy, NdfImage, NdfMapRoot};
use rayon::prelude::*;
use splat::{Image, Splat};
use zerocopy::little_endian::{F64, I16, U16, U32};

/// The most pixels of all images of a package: 128 MB.
const MOST_PIXELS: f64 = 6.7e7;

/// The most cells of all lobes, each of which is in about 13 images and has about a hundred pixels there: ten seconds.
const MOST_CELLS: f64 = 4e6;

/// The most standard deviations between points: a tenth of a kernel may be missed, as by the settings of other papers.
const MOST_BETWEEN_POINTS: f64 = 2.5;

/// The most copies whose transformations the image of the surface is made of.
const MOST_IN_SURFACE: usize = 512;

/// How images are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageOptions {
    /// Standard deviation σr of the kernel.
    pub sigma: f64,
    /// Distance of spline nodes in units of σr, for [`NdfPixels::Splines`].
    pub pitch: f64,
    /// Pixels along a side of each image, for [`NdfPixels::Points`].
    pub side: u32,
    /// Normal of what no copy covers.
    pub ground: [f64; 2],
    /// Standard deviation of its kernel.
    pub ground_deviation: f64,
}

/// Where copies lie.
#[derive(Clone, Copy, Debug)]
pub enum Copies<'a> {
    /// Close to each other, all under this transformation.
    Tiled([[f64; 2]; 2]),
    /// Where each of them says.
    Scattered(&'a [NoiseCopy]),
}

/// The sections.
#[derive(Debug)]
pub struct Built {
    /// What images and copies have in common.
    pub root: NdfMapRoot,
    /// Where images lie.
    pub images: Vec<NdfImage>,
    /// Their pixels.
    pub pixels: Vec<U16>,
    /// The copies that are seen.
    pub copies: Vec<NdfCopy>,
    /// Their neighbours.
    pub neighbours: Vec<U32>,
    /// The grid of their centres; empty if they are tiled.
    pub grid: Vec<U32>,
}

/// The NDF maps of the example `map`. Work is split by tile and by copy, so that threads change nothing.
///
/// # Errors
/// [`BakeError::Option`] for surfaces too small for their copies, copies under too many others, and images of too many pixels.
pub fn build(
    map: &NormalMap,
    layout: &NdfMapLayout,
    copies: Copies<'_>,
    options: &ImageOptions,
) -> Result<Built, BakeError> {
    let (placed, scattered) = place(layout, copies)?;
    let sigma = options.sigma;
    let pitch = match layout.pixels {
        NdfPixels::Splines => options.pitch * sigma,
        NdfPixels::Points => 2.0 / f64::from(options.side),
    };
    let mut images = match layout.pixels {
        NdfPixels::Splines => {
            check_size(map, layout, sigma, pitch)?;
            images::splines(map, layout, sigma, pitch)
        }
        NdfPixels::Points => {
            check_points(sigma, pitch)?;
            images::points(map, layout, sigma, options.side)
        }
    };
    if let Some(scattered) = &scattered {
        images.push(surface(&images, layout, scattered, pitch, options));
    }
    let unit = 1.0 / (core::f64::consts::TAU * sigma * sigma);
    let mut records = Vec::with_capacity(images.len());
    let mut pixels = Vec::new();
    for image in &images {
        let (record, packed) = match layout.pixels {
            NdfPixels::Splines => image.packed(unit, pixels.len() as u32),
            NdfPixels::Points => image.packed_whole(unit, pixels.len() as u32),
        };
        records.push(record);
        pixels.extend(packed);
    }
    let [ground_s, ground_t] = options.ground.map(F64::new);
    let (unit, reach, cells, covered) = match &scattered {
        Some(all) => (all.unit, all.reach, all.cells, all.covered),
        None => (
            placed.1,
            copies::reach(placed.0.matrix, f64::from(layout.example())),
            0,
            1.0,
        ),
    };
    let root = NdfMapRoot {
        pitch: F64::new(pitch),
        ground: [ground_s, ground_t],
        ground_deviation: F64::new(options.ground_deviation),
        covered: F64::new(covered),
        unit: F64::new(unit),
        reach: F64::new(reach),
        cells: U32::new(cells),
        reserved: [0; 4],
    };
    let (copies, neighbours, grid) = match scattered {
        Some(all) => {
            let neighbours = all.neighbours.into_iter().flatten().map(U32::new).collect();
            (all.records, neighbours, all.grid)
        }
        None => {
            let copy = NdfCopy {
                centre: placed.0.place.map(U32::new),
                matrix: placed.0.entries.map(I16::new),
                neighbours: U32::ZERO,
                visible: U16::new(u16::MAX),
                reserved: [0; 2],
            };
            (vec![copy], Vec::new(), Vec::new())
        }
    };
    Ok(Built {
        root,
        images: records,
        pixels,
        copies,
        neighbours,
        grid,
    })
}

/// The copy that all others follow and its unit, and the copies that do not follow any.
fn place(
    layout: &NdfMapLayout,
    copies: Copies<'_>,
) -> Result<((Placed, f64), Option<Scattered>), BakeError> {
    let size = f64::from(layout.size);
    match copies {
        Copies::Tiled(matrix) => {
            let unit = copies::unit_of(core::iter::once(matrix));
            // So that the first corner of an example that is not turned is that of texture space.
            let half = 0.5 * f64::from(layout.example()) / size;
            let [[xx, xy], [yx, yy]] = matrix;
            let centre =
                [xx * half + xy * half, yx * half + yy * half].map(|along| along - along.floor());
            let copy = NoiseCopy { centre, matrix };
            Ok(((copies::place(&copy, size, unit), unit), None))
        }
        Copies::Scattered(all) => {
            let scattered = Scattered::new(all, layout.example(), layout.size)?;
            let first = scattered.placed[0];
            Ok(((first, scattered.unit), Some(scattered)))
        }
    }
}

/// Refuses roughnesses at which the images of the example would be too large.
fn check_size(
    map: &NormalMap,
    layout: &NdfMapLayout,
    sigma: f64,
    pitch: f64,
) -> Result<(), BakeError> {
    let [pixels, cells] = images::cost(map, layout, sigma, pitch);
    if pixels <= MOST_PIXELS && cells <= MOST_CELLS {
        return Ok(());
    }
    Err(BakeError::Option {
        option: "--roughness",
        value: (sigma * core::f64::consts::SQRT_2).to_string(),
        reason: format!(
            "NDF images of normals that spread and change so much would take {:.0} MB and {cells:.1e} cells; give a greater roughness, or \
             use --method lobes",
            2e-6 * pixels
        ),
    })
}

/// Refuses points between which kernels would be lost.
///
/// The sum of a Gaussian at points `p` standard deviations apart is its integral but for `2 exp(-2π² / p²)`.
fn check_points(sigma: f64, pitch: f64) -> Result<(), BakeError> {
    if pitch <= MOST_BETWEEN_POINTS * sigma {
        return Ok(());
    }
    let side = (2.0 / (MOST_BETWEEN_POINTS * sigma)).ceil();
    Err(BakeError::Option {
        option: "--ndf-pixels",
        value: format!("{:.0}", 2.0 / pitch),
        reason: format!(
            "points {:.1} standard deviations of the kernel apart miss most of what they stand for; give {side:.0} or more, a greater \
             roughness, or leave the option out for splines",
            pitch / sigma
        ),
    })
}

/// The NDF of the whole surface, for footprints of very many copies: what tiles show on average, under the transformations of
/// evenly chosen copies, and the ground. Moved mass keeps its kernel; where slopes are scaled that is an approximation.
fn surface(
    images: &[Image],
    layout: &NdfMapLayout,
    scattered: &Scattered,
    pitch: f64,
    options: &ImageOptions,
) -> Image {
    let count = scattered.placed.len();
    let step = count.div_ceil(MOST_IN_SURFACE);
    let chosen: Vec<usize> = (0..count).step_by(step).collect();
    let tiles = layout.tiles(0);
    let seen: Vec<Vec<f64>> = chosen
        .par_iter()
        .map(|&number| scattered.tiles_seen(number, tiles))
        .collect();
    let mut weights = vec![0.0; (tiles * tiles) as usize];
    for of_copy in &seen {
        for (sum, share) in weights.iter_mut().zip(of_copy) {
            *sum += share;
        }
    }
    let total: f64 = weights.iter().sum();
    for weight in &mut weights {
        *weight /= total;
    }
    let lowest: Vec<&Image> = images.iter().take(weights.len()).collect();
    let shown = Image::mean(&lowest, &weights);
    let areas: Vec<f64> = chosen
        .iter()
        .zip(&seen)
        .map(|(&number, seen)| {
            let [[xx, xy], [yx, yy]] = scattered.placed[number].matrix;
            (xx * yy - xy * yx).abs() * seen.iter().sum::<f64>()
        })
        .collect();
    let area: f64 = areas.iter().sum();
    let is_whole = layout.pixels == NdfPixels::Points;
    let parts: Vec<(Image, f64)> = chosen
        .par_iter()
        .zip(&areas)
        .map(|(&number, &own)| {
            let matrix = scattered.placed[number].matrix;
            let turned = shown.moved(pitch, is_whole, |normal| {
                turn(matrix, layout.scales_slopes, normal)
            });
            (turned, own / area * scattered.covered)
        })
        .collect();
    let bare = 1.0 - scattered.covered;
    let variance = match layout.pixels {
        NdfPixels::Splines => options.ground_deviation.powi(2) - pitch * pitch / 3.0,
        NdfPixels::Points => options.ground_deviation.powi(2),
    };
    let ground = Image::of(
        &[Splat {
            weight: 1.0,
            mean: options.ground,
            covariance: [variance, 0.0, variance],
        }],
        pitch,
    );
    let mut all: Vec<&Image> = parts.iter().map(|(image, _)| image).collect();
    let mut shares: Vec<f64> = parts.iter().map(|(_, share)| *share).collect();
    all.push(&ground);
    shares.push(bare);
    let mean = Image::mean(&all, &shares);
    if is_whole {
        let low = -(options.side as i32 / 2);
        return mean.within([low; 2], [low + options.side as i32; 2]);
    }
    mean
}

/// Where a copy under `matrix` has the normal that the example has at `normal`.
fn turn(matrix: [[f64; 2]; 2], scales_slopes: bool, normal: [f64; 2]) -> [f64; 2] {
    let [[xx, xy], [yx, yy]] = matrix;
    // With t up where texture space has v down.
    let (xy, yx) = (-xy, -yx);
    let [s, t] = normal;
    if !scales_slopes {
        let determinant = xx * yy - xy * yx;
        let sign = if determinant > 0.0 { 1.0 } else { -1.0 };
        // The orthogonal factor of a polar decomposition: M plus, or minus, its adjugate transposed.
        let (a, b) = (xx + sign * yy, xy - sign * yx);
        let length = (a * a + b * b).sqrt();
        let (a, b) = (a / length, b / length);
        return [a * s + b * t, sign * (a * t - b * s)];
    }
    let square = 1.0 - s * s - t * t;
    let z = square.max(1e-12).sqrt();
    // Slopes are s/z and t/z, and M⁻ᵀ takes them to those of the copy.
    let determinant = xx * yy - xy * yx;
    let (x, y) = (s / z, t / z);
    let (x, y) = (
        (yy * x - yx * y) / determinant,
        (xx * y - xy * x) / determinant,
    );
    let length = (1.0 + x * x + y * y).sqrt();
    [x / length, y / length]
}
