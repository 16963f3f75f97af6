//! The P-NDF of one footprint as a picture of the projected disk.

use super::{colour, first_error};
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_runtime::{Ndf, QueryError};
use libm::{log1p, sqrt};
use rayon::prelude::*;

/// Density is sampled at this many positions along each side of a pixel.
const SUBPIXELS: u32 = 2;

/// How far below the peak the colours reach: four decades, so that a Beckmann lobe shows out to three of its
/// standard deviations.
const DARKEST: f64 = 1e-4;

/// Outside the disk, in linear light.
const OUTSIDE: f64 = 0.008;

/// The rim of the disk, in linear light.
const RIM: f64 = 0.25;

/// A P-NDF over the projected disk.
#[derive(Clone, Debug, PartialEq)]
pub struct NdfPicture {
    /// 8-bit sRGB, row-major from the top.
    pub pixels: Vec<u8>,
    /// The largest density at any of the positions it was evaluated at, per steradian.
    pub peak: f64,
    /// ∫ D ds dt over the picture, by the midpoint rule. Over the whole disk it is the footprint's mean of t·n for
    /// a Beckmann kernel, up to what lies below the horizon.
    pub integral: f64,
}

/// What one pixel holds: densities in f32 keep the largest picture within a gigabyte.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    /// Mean density, 0 where positions lie outside the disk.
    density: f32,
    /// Share of the positions inside the disk.
    inside: f32,
}

/// Densities over a square part of the projected disk, before they are colours.
#[derive(Clone, Debug)]
pub struct Densities {
    raster: Raster,
    field: Vec<Pixel>,
    /// As [`NdfPicture::peak`].
    pub peak: f64,
    /// As [`NdfPicture::integral`].
    pub integral: f64,
}

/// The P-NDF of the patch under `footprint`, `pixels` a side, s to the right and t up, both from -1/`zoom` to 1/`zoom`.
///
/// Each pixel is the mean of 2 × 2 evaluations; its colour is [`colour::heat`] of a logarithmic scale that ends four
/// decades below the brightest pixel. Outside the disk is grey; a thin line marks the rim. Cost: `4 * pixels²`
/// evaluations, 8 bytes a pixel besides the picture.
///
/// # Errors
/// As [`Ndf::facets`].
pub fn draw(
    ndf: &(impl Ndf + Sync),
    footprint: &Footprint,
    pixels: u32,
    zoom: f64,
) -> Result<NdfPicture, QueryError> {
    let densities = Densities::of(ndf, footprint, pixels, zoom)?;
    Ok(NdfPicture {
        pixels: densities.colours(densities.brightest()),
        peak: densities.peak,
        integral: densities.integral,
    })
}

impl Densities {
    /// The densities that [`draw`] colours.
    ///
    /// # Errors
    /// As [`Ndf::facets`].
    pub fn of(
        ndf: &(impl Ndf + Sync),
        footprint: &Footprint,
        pixels: u32,
        zoom: f64,
    ) -> Result<Self, QueryError> {
        let raster = Raster {
            side: pixels,
            reach: 1.0 / zoom,
        };
        let side = pixels as usize;
        let mut field = vec![Pixel::default(); side * side];
        let rows: Vec<_> = field
            .par_chunks_mut(side.max(1))
            .enumerate()
            .map(|(y, row)| raster.evaluate_row(ndf, footprint, y as u32, row))
            .collect();
        let mut peak = 0.0_f64;
        let mut sum = 0.0;
        for row in first_error(rows)? {
            peak = peak.max(row.peak);
            sum += row.sum;
        }
        let position = raster.step() / f64::from(SUBPIXELS);
        Ok(Self {
            raster,
            field,
            peak,
            integral: sum * position * position,
        })
    }

    /// The same part of the disk with other `densities`: one a pixel, row-major from the top, averages over pixels.
    ///
    /// # Panics
    /// If there are not as many as pixels.
    #[must_use]
    pub fn replaced(&self, densities: &[f64]) -> Self {
        assert_eq!(densities.len(), self.field.len(), "one density a pixel");
        let field = self
            .field
            .iter()
            .zip(densities)
            .map(|(pixel, &density)| Pixel {
                density: density as f32,
                ..*pixel
            })
            .collect();
        let step = self.raster.step();
        Self {
            raster: self.raster,
            field,
            peak: densities.iter().copied().fold(0.0, f64::max),
            integral: densities.iter().sum::<f64>() * step * step,
        }
    }

    /// The greatest density of a pixel.
    pub fn brightest(&self) -> f32 {
        let densities = self.field.iter().map(|pixel| pixel.density);
        densities.fold(0.0, f32::max)
    }

    /// Relative L1 distance from `reference`, pixel by pixel: `Σ|D - D*| / ΣD*`, 0 if the reference is.
    pub fn distance_from(&self, reference: &Self) -> f64 {
        let (mut off, mut all) = (0.0, 0.0);
        for (found, expected) in self.field.iter().zip(&reference.field) {
            let [found, expected] = [found, expected].map(|pixel| f64::from(pixel.density));
            off += (found - expected).abs();
            all += expected;
        }
        if all > 0.0 { off / all } else { 0.0 }
    }

    /// The picture, 8-bit sRGB, row-major from the top, on a scale that ends at `brightest`.
    pub fn colours(&self, brightest: f32) -> Vec<u8> {
        let side = self.raster.side as usize;
        let mut bytes = vec![0; 3 * side * side];
        bytes
            .par_chunks_mut(3 * side.max(1))
            .zip(self.field.par_chunks(side.max(1)))
            .enumerate()
            .for_each(|(y, (row, field))| {
                for ((x, rgb), pixel) in row.chunks_exact_mut(3).enumerate().zip(field) {
                    let colour = self.raster.colour(x as u32, y as u32, *pixel, brightest);
                    rgb.copy_from_slice(&colour);
                }
            });
        bytes
    }
}

struct RowTotals {
    peak: f64,
    sum: f64,
}

/// Where the picture's pixels lie on the disk.
#[derive(Clone, Copy, Debug)]
struct Raster {
    side: u32,
    reach: f64,
}

impl Raster {
    /// The side of a pixel on the disk.
    fn step(self) -> f64 {
        2.0 * self.reach / f64::from(self.side)
    }

    /// The half vector `x` pixels from the left and `y` from the top.
    fn half_vector(self, x: f64, y: f64) -> HalfVector {
        HalfVector {
            s: x * self.step() - self.reach,
            t: self.reach - y * self.step(),
        }
    }

    fn evaluate_row(
        self,
        ndf: &impl Ndf,
        footprint: &Footprint,
        y: u32,
        row: &mut [Pixel],
    ) -> Result<RowTotals, QueryError> {
        let count = f64::from(SUBPIXELS);
        let place =
            |pixel: u32, subpixel: u32| f64::from(pixel) + (f64::from(subpixel) + 0.5) / count;
        let mut totals = RowTotals {
            peak: 0.0,
            sum: 0.0,
        };
        for (x, pixel) in row.iter_mut().enumerate() {
            let mut sum = 0.0;
            let mut inside = 0_u16;
            for subpixel in 0..SUBPIXELS * SUBPIXELS {
                let half_vector = self.half_vector(
                    place(x as u32, subpixel % SUBPIXELS),
                    place(y, subpixel / SUBPIXELS),
                );
                if half_vector.is_on_disk() {
                    let density = ndf.eval(footprint, half_vector)?;
                    totals.peak = totals.peak.max(density);
                    sum += density;
                    inside += 1;
                }
            }
            totals.sum += sum;
            let share = 1.0 / (count * count);
            pixel.density = (sum * share) as f32;
            pixel.inside = f32::from(inside) * share as f32;
        }
        Ok(totals)
    }

    fn colour(self, x: u32, y: u32, pixel: Pixel, brightest: f32) -> [u8; 3] {
        // log1p instead of a log with a floor: the scale runs into black smoothly instead of breaking off.
        let value = if brightest > 0.0 {
            let relative = f64::from(pixel.density) / f64::from(brightest);
            log1p(relative / DARKEST) / log1p(1.0 / DARKEST)
        } else {
            0.0
        };
        let inside = f64::from(pixel.inside);
        let HalfVector { s, t } = self.half_vector(f64::from(x) + 0.5, f64::from(y) + 0.5);
        // A line a pixel and a half wide just outside the rim, so that it covers no density.
        let distance = (sqrt(s * s + t * t) - 1.0) / self.step();
        let line = (1.25 - (distance - 0.75).abs()).clamp(0.0, 1.0);
        let ground = OUTSIDE + (RIM - OUTSIDE) * line;
        colour::heat(value).map(|byte| {
            let signal = f64::from(byte) / 255.0;
            colour::quantised(signal * inside + colour::srgb(ground) * (1.0 - inside))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures;
    use super::*;
    use glintbake_format::model::{Binning, Method, disk_grid_resolution};
    use glintbake_runtime::microfacet::beckmann;

    const PATCH: Footprint = Footprint {
        centre: [0.5, 0.5],
        edge_1: [0.25, 0.0],
        edge_2: [0.0, 0.25],
    };

    /// With this roughness the number of bins a side is odd, so that a flat map's normal is a bin's centre.
    const ROUGHNESS: f64 = 0.1;

    fn picture(normal: [f32; 2], pixels: u32, zoom: f64) -> NdfPicture {
        let bytes = fixtures::constant(normal, ROUGHNESS);
        draw(&fixtures::ndf(&bytes), &PATCH, pixels, zoom).expect("the footprint is in range")
    }

    /// Sum of all channels of the pixels that `choose` picks by column and row.
    fn brightness(picture: &NdfPicture, side: u32, choose: impl Fn(u32, u32) -> bool) -> u64 {
        (0..side * side)
            .zip(picture.pixels.chunks_exact(3))
            .filter(|(index, _)| choose(index % side, index / side))
            .map(|(_, rgb)| rgb.iter().map(|&byte| u64::from(byte)).sum::<u64>())
            .sum()
    }

    #[test]
    fn a_flat_map_is_one_lobe_of_known_height_and_volume() {
        assert_eq!(disk_grid_resolution(ROUGHNESS) % 2, 1);
        let side = 101;
        let flat = picture([0.0, 0.0], side, 1.0);
        // The positions nearest to the pole lie a quarter of a pixel from it along both axes.
        let offset = 0.25 * 2.0 / f64::from(side);
        let nearest = HalfVector {
            s: offset,
            t: offset,
        };
        let expected = beckmann::density(nearest.direction(), [0.0, 0.0, 1.0], ROUGHNESS);
        assert!(
            (flat.peak - expected).abs() < 1e-9 * expected,
            "{} instead of {expected}",
            flat.peak
        );
        // The 45 bins of the default neighbourhood keep all but 6e-5 of the energy.
        assert!((flat.integral - 1.0).abs() < 1e-3, "{}", flat.integral);
    }

    #[test]
    fn a_zoomed_picture_integrates_what_it_shows() {
        let zoomed = picture([0.0, 0.0], 64, 10.0);
        // The share of a Beckmann lobe within the square of slopes ±x is erf(x / α)² to first order in its width.
        let expected = libm::erf(0.1 / ROUGHNESS);
        assert!(
            (zoomed.integral - expected * expected).abs() < 0.02,
            "{}",
            zoomed.integral
        );
    }

    #[test]
    fn s_is_to_the_right_and_t_is_up() {
        let side = 40;
        let up = picture([0.0, 0.6], side, 1.0);
        let above = brightness(&up, side, |_, row| row < side / 2);
        let below = brightness(&up, side, |_, row| row >= side / 2);
        assert!(above > below, "{above} above, {below} below");
        let right = picture([0.6, 0.0], side, 1.0);
        let right_half = brightness(&right, side, |column, _| column >= side / 2);
        let left_half = brightness(&right, side, |column, _| column < side / 2);
        assert!(
            right_half > left_half,
            "{right_half} right, {left_half} left"
        );
    }

    #[test]
    fn outside_the_disk_is_grey_and_the_middle_is_the_lightest_colour() {
        let side = 64;
        let flat = picture([0.0, 0.0], side, 1.0);
        let corner = &flat.pixels[..3];
        assert!(corner[0] > 0 && corner[0] == corner[1] && corner[1] == corner[2]);
        let middle = 3 * (side / 2 + side * (side / 2)) as usize;
        let pixel = &flat.pixels[middle..middle + 3];
        let lightest = colour::heat(1.0);
        for (seen, wanted) in pixel.iter().zip(lightest) {
            assert!(seen.abs_diff(wanted) <= 2, "{pixel:?}, {lightest:?}");
        }
    }

    #[test]
    fn mirror_flakes_are_drawn_too() {
        let bytes = fixtures::flakes(Method::SpecularBins, &[]);
        let ndf = fixtures::ndf(&bytes);
        assert_eq!(
            ndf.instance().bins().map(|bins| bins.grid.binning()),
            Some(Binning::EqualSolidAngle),
            "the map is without a kernel"
        );
        let whole = Footprint {
            edge_1: [1.0, 0.0],
            edge_2: [0.0, 1.0],
            ..PATCH
        };
        let drawn = draw(&ndf, &whole, 400, 1.0).expect("the footprint is in range");
        let map = fixtures::flake_map();
        let mean = map
            .texels()
            .iter()
            .map(|&[s, t]| {
                let half_vector = HalfVector {
                    s: f64::from(s),
                    t: f64::from(t),
                };
                half_vector.direction()[2]
            })
            .sum::<f64>()
            / map.texels().len() as f64;
        // Texels move within their bins of a hundredth of the disk's width, and the picture's grid cuts bins.
        assert!(
            (drawn.integral - mean).abs() < 0.01,
            "{} instead of {mean}",
            drawn.integral
        );
    }

    #[test]
    fn the_picture_does_not_depend_on_threads() {
        let bytes = fixtures::flakes(Method::FlakeBins, &[0.02]);
        let ndf = fixtures::ndf(&bytes);
        let [one, three] =
            [1, 3].map(|threads| fixtures::with_threads(threads, || draw(&ndf, &PATCH, 50, 1.0)));
        assert_eq!(one, three);
    }

    #[test]
    fn a_bad_footprint_is_an_error() {
        let bytes = fixtures::constant([0.0, 0.0], ROUGHNESS);
        let footprint = Footprint {
            centre: [f64::NAN, 0.0],
            ..PATCH
        };
        assert_eq!(
            draw(&fixtures::ndf(&bytes), &footprint, 8, 1.0),
            Err(QueryError::NotFinite)
        );
    }
}
