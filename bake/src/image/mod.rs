//! File to samples: PNG, TGA, TIFF, JPEG, WebP and EXR, by [`Bands`] of rows or as one [`Raster`].
//!
//! Nothing here knows what a normal is. Either hands on the file's own samples in their own type, in the file's
//! row order (first row on top), without any colour management: normals and heights are data, so gamma, ICC
//! profiles and Exif orientation are ignored on purpose.
//!
//! | format | samples | notes |
//! |---|---|---|
//! | PNG | 8 and 16 bit, 1 to 4 channels | palettes are expanded to RGB, 1 to 4 bit grey to 8 bit |
//! | TGA | 8 bit | no signature, so known by its file name alone |
//! | TIFF | 8 and 16 bit, 1 to 4 channels; 32-bit float RGB and RGBA | first image of the file |
//! | JPEG, WebP | 8 bit | lossy data is read, though it makes poor normals |
//! | EXR | half and float | layer and channels as asked, see [`ReadOptions`] |
//!
//! # What a hostile file can do
//! Sizes are checked against [`Limits`] before anything of that size is allocated, and memory then grows with the rows
//! that arrive. Decoders that give up on a
//! cut-off file by filling in grey (JPEG, WebP) or by not looking (a PNG without its end) are not believed: such a
//! file is [`ImageError::Truncated`]. A decoder that panics is caught, and the file is [`ImageError::Corrupt`]; its
//! message is kept off standard error by a panic hook, installed once, that stays silent only for the thread that
//! is decoding at that moment and passes every other panic on to the hook that was there before.

mod bands;
mod complete;
mod error;
mod exr_channels;
mod guard;
mod identity;
mod open_exr;
mod paged;
mod png_rows;
mod raster;
mod read;
#[cfg(test)]
mod tests;
mod tiff_rows;
mod whole;

pub use bands::Bands;
pub use error::ImageError;
pub use identity::{HashedFile, InputFile, identify};
pub use raster::{Format, Header, Layout, Raster, SampleType, Samples};
pub(crate) use raster::{each_type, reserve};
pub use read::{Limits, ReadOptions, read};
