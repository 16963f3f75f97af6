//! A ball covered with a baked surface, in a dark studio under small lamps: what glints are for.
//!
//! ```text
//! pixel ─surface─► footprint, frame ─shading─► light (from studio, by skin) ─film─► bytes
//! ```
//!
//! - *Surface*: a unit ball seen without perspective, the map laid on it by a conformal projection; each pixel asks
//!   one footprint, the image of its square.
//! - *Skin*: a layered material as it is, or else, of a plain package, aluminium with the map's facets under a blue clear coat, so
//!   that every map shows as car paint would: flakes glint, scratches and brush marks draw streaks. Facets are masked by facets
//!   as the package says, or as V-cavities.
//! - *Studio*: soft boxes, a dim room, and nine small lamps, six times as wide as the sun.
//! - *Film*: a little bloom, and a tone curve on which the brightest glints turn white.
//!
//! What is left out: light that scatters more than once, refraction's turning of light in the coat, shadows.

mod film;
mod layered;
mod metal;
mod sequence;
mod shading;
mod skin;
mod studio;
mod surface;
mod vector;

pub use layered::Layered;
pub use metal::Metal;
pub use skin::{Scattering, Skin};

use super::first_error;
use film::Light;
use glintbake_runtime::QueryError;
use rayon::prelude::*;
use shading::Shading;
use studio::Studio;
use surface::View;
use vector::{Vector, add, scale, smoothstep};

/// Side of a texel in pixels in the middle of the ball, if nothing else is asked for: the size that sparkled best on
/// the sample maps. Towards the rim a pixel covers up to some hundreds.
const TEXEL_IN_PIXELS: f64 = 1.0 / 3.0;

/// What a ball is drawn with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Side of the picture in pixels.
    pub side: u32,
    /// How often the map repeats around the ball's circumference along its rows, at the scale of the picture's middle;
    /// texels are square. `None`: so that a texel is a third of a pixel there, and a pixel covers 9 texels.
    pub tiles: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            side: 512,
            tiles: None,
        }
    }
}

impl Options {
    /// How often a map of `width` texels repeats around the ball.
    fn tiles_of(&self, width: f64) -> f64 {
        self.tiles
            .unwrap_or_else(|| surface::circumference(self.side) / (TEXEL_IN_PIXELS * width))
    }
}

/// The picture of a ball.
#[derive(Clone, Debug, PartialEq)]
pub struct Ball {
    /// 8-bit sRGB, row-major from the top.
    pub pixels: Vec<u8>,
    /// Side of the picture in pixels.
    pub side: u32,
    /// How often the map repeats around the ball.
    pub tiles: f64,
}

/// The ball covered with `skin`.
///
/// Each pixel of the ball asks for 18 evaluations and, of a plain package, 32 samples, and for as many evaluations more as
/// samples find lamps; a picture of 512 pixels takes some seconds. Of a layered material there are 64 samples, each evaluated,
/// and pictures take some ten times as long. The same package gives the same bytes on any number of threads.
///
/// # Errors
/// What queries fail with; [`QueryError::FootprintTooLarge`] if `tiles` is so large that a pixel covers more than a query
/// may.
pub fn draw(skin: &impl Skin, options: &Options) -> Result<Ball, QueryError> {
    let tiles = options.tiles_of(skin.texels()[0]);
    Ok(Ball {
        pixels: film::develop(options.side as usize, &expose(skin, options.side, tiles)?),
        side: options.side,
        tiles,
    })
}

/// Linear light over a picture of `side` pixels, row-major from the top; 12 bytes a pixel.
fn expose(skin: &impl Skin, side: u32, tiles: f64) -> Result<Vec<Light>, QueryError> {
    let view = View::new(side, tiles, skin.texels());
    let studio = Studio::new();
    let shading = Shading {
        skin,
        studio: &studio,
        view,
    };
    let width = side as usize;
    let mut light: Vec<Light> = vec![[0.0; 3]; width * width];
    let rows: Vec<_> = light
        .par_chunks_mut(width.max(1))
        .enumerate()
        .map(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let (x, y) = (x as u32, y as u32);
                let place = view.place(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let coverage = view.coverage(place);
                let mut colour = scale(backdrop(place), 1.0 - coverage);
                if coverage > 0.0 {
                    colour = add(colour, scale(shading.pixel(x, y)?, coverage));
                }
                *pixel = colour.map(|component| component as f32);
            }
            Ok::<_, QueryError>(())
        })
        .collect();
    first_error(rows)?;
    Ok(light)
}

/// The wall behind the ball at `place`: dark, with a pool of light low behind the ball.
fn backdrop([x, y]: [f64; 2]) -> Vector {
    let y = y + 0.35;
    let distance = libm::sqrt(x * x + y * y);
    let pool = smoothstep(1.75, 0.2, distance);
    scale([0.042, 0.049, 0.062], 0.10 + 0.90 * pool)
}

#[cfg(test)]
mod tests {
    use super::super::fixtures;
    use super::*;
    use glintbake_format::model::Method;

    const SIDE: u32 = 64;

    fn ball(bytes: &[u8]) -> Ball {
        let options = Options {
            side: SIDE,
            tiles: Some(2.0),
        };
        draw(&Metal(fixtures::ndf(bytes)), &options).expect("footprints of balls are in range")
    }

    #[test]
    fn a_texel_is_a_third_of_a_pixel_unless_asked_otherwise() {
        // Around the ball lie 64 texels a tile; its diameter is 0.86 of the picture's side.
        let texels = Options::default().tiles_of(64.0) * 64.0;
        let pixels = std::f64::consts::PI * 0.86 * 512.0;
        assert!((texels / pixels - 3.0).abs() < 1e-9);
        let drawn = ball(&fixtures::constant([0.0, 0.0], 0.05));
        assert_eq!(drawn.tiles, 2.0);
        assert_eq!(drawn.side, SIDE);
        assert_eq!(drawn.pixels.len(), 3 * (SIDE * SIDE) as usize);
    }

    #[test]
    fn the_picture_does_not_depend_on_threads() {
        for (method, roughness) in [
            (Method::FlakeBins, &[0.05][..]),
            (Method::SpecularBins, &[][..]),
        ] {
            let bytes = fixtures::flakes(method, roughness);
            let [one, three] =
                [1, 3].map(|threads| fixtures::with_threads(threads, || ball(&bytes)));
            assert_eq!(one, three);
        }
    }

    #[test]
    fn every_pixel_is_finite_and_lit_and_the_corners_are_backdrop() {
        let bytes = fixtures::constant([0.0, 0.0], 0.05);
        let light =
            expose(&Metal(fixtures::ndf(&bytes)), SIDE, 2.0).expect("footprints are in range");
        for pixel in &light {
            assert!(pixel.iter().all(|x| x.is_finite() && *x > 0.0), "{pixel:?}");
        }
        let view = View::new(SIDE, 2.0, [8.0, 8.0]);
        let corner = backdrop(view.place(0.5, 0.5)).map(|x| x as f32);
        assert_eq!(light[0], corner);
    }

    #[test]
    fn a_surface_that_leans_moves_its_highlights_the_other_way() {
        // Facets that face up send the same lamp to the viewer from farther down, and so for right and left.
        let flat = highlight([0.0, 0.0]);
        let up = highlight([0.0, 0.2]);
        let right = highlight([0.2, 0.0]);
        assert!(up[1] > flat[1] + 2.0, "{flat:?}, leaning up {up:?}");
        assert!(
            right[0] < flat[0] - 2.0,
            "{flat:?}, leaning right {right:?}"
        );
    }

    /// The centre of the light of a ball whose facets all have the normal (s, t), in pixels from the left and top.
    fn highlight(normal: [f32; 2]) -> [f64; 2] {
        let bytes = fixtures::constant(normal, 0.1);
        let light =
            expose(&Metal(fixtures::ndf(&bytes)), SIDE, 2.0).expect("footprints are in range");
        let mut sum = [0.0; 3];
        for (index, pixel) in (0..SIDE * SIDE).zip(&light) {
            let weight = f64::from(pixel[2]);
            sum[0] += weight * f64::from(index % SIDE);
            sum[1] += weight * f64::from(index / SIDE);
            sum[2] += weight;
        }
        [sum[0] / sum[2], sum[1] / sum[2]]
    }
}
