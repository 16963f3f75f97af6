//! Samples to unit normals: from a file ([`read()`]) or a [`Raster`](crate::image::Raster) ([`decode()`]) to a
//! [`NormalMap`] and its [`Statistics`].
//!
//! # From sample to component
//! With `M = 2^bits - 1` for integer samples `x`:
//!
//! | samples | `--range` | `--zero` | component |
//! |---|---|---|---|
//! | integers | `auto`, `unorm` | `127.5` | `x / M * 2 - 1`; the two middle values are ∓1/M, zero lies between |
//! | integers | `auto`, `unorm` | `128` | `max(-1, (x - c) / (c - 1))`, `c` = 128 or 32768, which is zero |
//! | floats | `auto`, `snorm` | | `x` |
//! | floats | `unorm` | | `2 x - 1` |
//!
//! Integer files hold no signed samples, so `snorm` is refused for them, as `128` is for floats.
//!
//! # From components to a normal
//! - *Three components* (`xyz`) are divided by their length, whatever it is; mean, shortest and longest length are
//!   reported, since filtered and lossy maps hold vectors shorter than 1.
//! - *Two components* are taken as they are, with `z = sqrt(1 - s² - t²)`. A point outside the disk is scaled to its
//!   rim.
//! - `--y dx` turns t around.
//!
//! # Texels at and beyond the rim
//! A component is only known to a lattice step: 2/M (or 1/(c - 1)) for integers; a half float's 2⁻¹¹ is taken for
//! all floats. Within [`RIM_STEPS`] = 4 steps, a z below 0, or a two-component point outside the disk, is taken for
//! a normal on the rim and counted in [`Statistics::clamped_to_rim`]. At 8 bit that is z ≥ -8/255 or a length
//! up to 1 + 8/255.
//!
//! What remains cannot be a normal: NaN or infinite components, a length below one step (2⁻²⁴ for floats, the
//! smallest half float) where rounding has left no direction, and points further beyond the rim. The first such
//! texel is named, and the map refused, unless [`DecodeOptions::repair`] lets each take the nearest valid normal.
//!
//! # Heights
//! With `h` in texels (sample in 0..1 × [`DecodeOptions::height_scale`]), columns to the right and rows *down*, the
//! surface `(column, -row, h)` has the normal `(-∂h/∂column, +∂h/∂row, 1)`, normalised: rows run against t.
//! Derivatives are central differences. Over the border `repeat` continues with the opposite side; `clamp`
//! takes the one-sided difference, so that a plane keeps its slope to the last texel, which the map then continues
//! for ever. The first channel counts, be it grey or red; NaN and infinite heights are the bad texels here.
//!
//! # Cost
//! 8 bytes a texel, beside the raster if there is one; about 20 ns a texel on one thread. The result, statistics
//! included, depends neither on the number of threads nor on the bands in which samples come.

mod channels;
mod check;
mod coding;
mod decode;
mod error;
mod height;
mod map;
mod options;
mod repair;
mod statistics;
mod stream;
#[cfg(test)]
mod tests;
mod vectors;

pub use decode::{RIM_STEPS, decode};
pub use error::NormalsError;
pub use map::NormalMap;
pub use options::{Channels, DecodeOptions, GreenAxis, Input, Range, Zero};
pub use statistics::{Lattice, Lengths, Statistics};
pub use stream::read;
