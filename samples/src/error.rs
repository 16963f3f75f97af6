//! Why a sample cannot be generated.

use core::fmt;

use crate::options::{MAX_DENSITY, MAX_SCALE, MAX_SIDE, MIN_SCALE};

/// Why [`generate`](crate::generate) refused; every message names the remedy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleError {
    /// A side is zero: give both at least one texel.
    EmptySize {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// A side is longer than [`MAX_SIDE`]: the map tiles, so ask for a smaller tile.
    TooLarge {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// The feature scale is not a number from [`MIN_SCALE`] to [`MAX_SCALE`].
    Scale {
        /// The scale asked for.
        value: f64,
    },
    /// The roughness is not a number from 0 to the kind's largest.
    Roughness {
        /// The roughness asked for.
        value: f64,
        /// The kind's [largest roughness](crate::Kind::max_roughness).
        max: f64,
    },
    /// The density is not a number from 0 to [`MAX_DENSITY`].
    Density {
        /// The density asked for.
        value: f64,
    },
    /// The map does not fit into memory: ask for a smaller one.
    OutOfMemory {
        /// Texels asked for, 8 bytes each.
        texel_count: usize,
    },
}

impl fmt::Display for SampleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::EmptySize { width, height } => write!(
                f,
                "a {width} x {height} map has no texels; both sides must be at least 1"
            ),
            Self::TooLarge { width, height } => write!(
                f,
                "a {width} x {height} map is too large; sides go up to {MAX_SIDE}, and the map tiles"
            ),
            Self::Scale { value } => write!(
                f,
                "scale {value} is not a number from {MIN_SCALE} to {MAX_SCALE}"
            ),
            Self::Roughness { value, max } => {
                write!(
                    f,
                    "roughness {value} is not a number from 0 to {max}, the most this kind takes"
                )
            }
            Self::Density { value } => {
                write!(f, "density {value} is not a number from 0 to {MAX_DENSITY}")
            }
            Self::OutOfMemory { texel_count } => write!(
                f,
                "no memory for {texel_count} texels of 8 bytes; ask for a smaller map"
            ),
        }
    }
}

impl core::error::Error for SampleError {}
