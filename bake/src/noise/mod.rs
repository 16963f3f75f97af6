//! Noise maps: where on a surface copies of a tiny example lie, and how, one pixel a copy \[XTXW24\] §6.2.
//!
//! | file | channels | a pixel |
//! |---|---|---|
//! | `OpenEXR` | `center.x`, `center.y` | centre, in tiles of texture space: right and down, 0 to 1 |
//! | | and `matrix.xx`, `matrix.xy`, `matrix.yx`, `matrix.yy` | where texels of the example go, right and down |
//! | | or `transform.rotation`, `transform.scale`, `transform.shear`, `transform.mirror` | degrees counter-clockwise in the picture; a factor; shear along rows; mirrored left to right if at least ½ |
//! | 16-bit PNG, four channels | red, green | centre, in 65536ths of a tile |
//! | | blue | rotation, in 65536ths of a turn |
//! | | alpha | 32768 if mirrored, plus the scale in 2048ths |
//!
//! Width and height of the image mean nothing but their product. A transformation first mirrors, then shears, scales and turns.

mod generate;
mod read;

pub use generate::{Density, NoiseOptions, generate};
pub use read::read;

use crate::image::{ImageError, InputFile};
use serde::Serialize;

/// The most copies of a surface.
pub const MAX_COPIES: usize = 1 << 22;

/// The least determinant of a transformation, as a share of its greatest entry squared: less is a line.
pub const LEAST_DETERMINANT: f64 = 1e-3;

/// The greatest entry of a transformation.
pub const GREATEST_ENTRY: f64 = 1000.0;

/// Where a copy of the example lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseCopy {
    /// Its centre, in tiles of texture space, 0 to 1.
    pub centre: [f64; 2],
    /// Rows of M: a texel `d` from the middle of the example, right and down, lies `M d` from the centre.
    pub matrix: [[f64; 2]; 2],
}

/// All copies, and where they are from.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseMap {
    /// The copies, in the order of pixels.
    pub copies: Vec<NoiseCopy>,
    /// What they are from, for the recipe.
    pub source: NoiseSource,
}

/// Where copies are from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseSource {
    /// A file, by name, size and hash.
    File {
        /// Its name, without the folder.
        name: String,
        /// Its size in bytes.
        bytes: u64,
        /// Its BLAKE3 hash, in hexadecimal.
        blake3: String,
    },
    /// Chance.
    Generated(NoiseOptions),
}

impl NoiseSource {
    /// That of the file `input`.
    pub(crate) fn of(input: &InputFile) -> Self {
        Self::File {
            name: input.name.clone(),
            bytes: input.bytes,
            blake3: blake3::Hash::from_bytes(input.blake3).to_hex().to_string(),
        }
    }
}

/// Why a noise map cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum NoiseError {
    /// The file cannot be read as an image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The image has other channels, or samples of another type.
    #[error("{file}: {reason}")]
    Layout {
        /// The file, without its folder.
        file: String,
        /// What it should have.
        reason: String,
    },
    /// A pixel is no copy.
    #[error("{file}: pixel ({column}, {row}): {reason}")]
    Pixel {
        /// The file, without its folder.
        file: String,
        /// Its column.
        column: usize,
        /// Its row.
        row: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// An option is out of range.
    #[error("{option} {value}: {reason}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: String,
        /// What it may be.
        reason: String,
    },
}

/// How the example is turned, from the words of a command line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Transform {
    /// Degrees, counter-clockwise in the picture.
    pub rotation: f64,
    /// How many times as large, along columns and rows of the example.
    pub scale: [f64; 2],
    /// How far rows move along, for each row up.
    pub shear: f64,
    /// Whether left and right are exchanged.
    pub is_mirrored: bool,
}

impl Default for Transform {
    fn default() -> Self {
        Self {
            rotation: 0.0,
            scale: [1.0; 2],
            shear: 0.0,
            is_mirrored: false,
        }
    }
}

impl Transform {
    /// The rows of M, in texture space: right and down.
    ///
    /// Counter-clockwise in the picture, where up is positive, is `[[cos, sin], [-sin, cos]]` where down is; a shear that moves
    /// upper rows to the right then has a negative entry.
    pub fn matrix(&self) -> [[f64; 2]; 2] {
        let (sine, cosine) = libm::sincos(self.rotation.rem_euclid(360.0).to_radians());
        // Exact where turns are, so that these keep copies on the texels.
        let exact = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
        let (sine, cosine) = (exact(sine), exact(cosine));
        let [x, y] = self.scale;
        let mirror = if self.is_mirrored { -1.0 } else { 1.0 };
        let (xx, xy, yy) = (x * mirror, -x * self.shear, y);
        [
            [cosine * xx, cosine * xy + sine * yy],
            [-sine * xx, -sine * xy + cosine * yy],
        ]
    }
}

/// Why `matrix` is no transformation of an example, if it is not.
pub fn fault_of(matrix: [[f64; 2]; 2]) -> Option<String> {
    let [[xx, xy], [yx, yy]] = matrix;
    if ![xx, xy, yx, yy].iter().all(|x| x.is_finite()) {
        return Some("the transformation has an entry that is no number".to_owned());
    }
    let greatest = xx.abs().max(xy.abs()).max(yx.abs()).max(yy.abs());
    if !(1.0 / GREATEST_ENTRY..=GREATEST_ENTRY).contains(&greatest) {
        return Some(format!(
            "the transformation scales by {greatest}; it may by 1/{GREATEST_ENTRY} to {GREATEST_ENTRY}"
        ));
    }
    let determinant = xx * yy - xy * yx;
    if determinant.abs() < LEAST_DETERMINANT * greatest * greatest {
        return Some(format!(
            "the transformation [{xx} {xy}; {yx} {yy}] is singular: it makes a line of the example"
        ));
    }
    None
}
