//! Why a bake failed.

use crate::image::ImageError;
use crate::material::MaterialError;
use crate::noise::NoiseError;
use crate::normals::NormalsError;
use crate::package::PublishError;

/// Why a bake failed, grouped by who can mend it.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The input file cannot be read as an image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The noise map cannot be used.
    #[error(transparent)]
    Noise(#[from] NoiseError),
    /// The image is no normal map.
    #[error(transparent)]
    Normals(#[from] NormalsError),
    /// An option's value cannot be baked.
    #[error("{option} {value}: {reason}")]
    Option {
        /// The option.
        option: &'static str,
        /// The value given.
        value: String,
        /// What is wrong with it and what to give instead.
        reason: String,
    },
    /// The map is larger than texel positions can say.
    #[error("the map is {width} x {height} texels; no side may exceed 65535: cut it into tiles")]
    MapTooLarge {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A material file gives no material.
    #[error(transparent)]
    Material(Box<MaterialError>),
    /// The package cannot be written.
    #[error(transparent)]
    Publish(#[from] PublishError),
}
