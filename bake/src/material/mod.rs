//! Layered materials: from a small TOML file, and the maps it names, to one package.
//!
//! ```text
//! file.toml ──file──► MaterialRecipe ──inputs──► hashed maps ──bake──► PackagePlan
//! ```
//!
//! What a material means is said by the runtime (`glintbake_runtime::layers`) and docs/materials.md; the keys of the file are
//! listed there as well.

mod bake;
mod error;
mod file;
mod inputs;
mod keys;
mod opacity;
mod recipe;

pub use bake::{BakedMaterial, LayerMaps, bake, bake_maps};
pub use error::MaterialError;
pub use file::read;
pub use inputs::{LayerInputs, MaterialInputs};
pub use opacity::OpacityMap;
pub use recipe::{LayerRecipe, MapRecipe, MaterialRecipe};

#[cfg(test)]
mod tests;
