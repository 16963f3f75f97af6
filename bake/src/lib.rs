//! From normal maps to `.glint` packages.
//!
//! ```text
//! file ──image::Bands──► Samples ──normals::read──► NormalMap ──bake──► PackagePlan ──package::publish──► file
//! ```
//!
//! Rows become normals as they are decoded; [`image::read`] and [`normals::decode`] do the same by way of a raster.
//! Each step takes the previous step's type and nothing else. [`oracle`] answers the same queries as a package,
//! slowly and in f64, from a [`normals::NormalMap`] alone: it never sees baked bytes.
//!
//! Packages depend on the input's content and the recipe, on nothing else: transcendental functions come from
//! `libm` on every platform, and parallel work is split by fixed sizes.
#![deny(missing_docs)]

mod bake;
pub mod build;
mod error;
pub mod image;
pub mod material;
mod metadata;
mod methods;
pub mod noise;
pub mod normals;
pub mod oracle;
pub mod package;
mod progress;
mod recipe;

pub use bake::{bake, bake_with_progress, check};
pub use error::BakeError;
pub use package::PackagePlan;
pub use progress::{Progress, Stage};
pub use recipe::{
    Chosen, DEFAULT_CLUSTERS, DEFAULT_LEAF_SIZE, DEFAULT_MERGE_ERROR, DEFAULT_METHOD,
    DEFAULT_NDF_PITCH, DEFAULT_ROUGHNESS, LeftOut, MethodRecipe, NdfCopies, NdfMapRecipe,
    NdfMapped, QuiltRecipe, Quilted, Recipe, Source, default_filter,
};
