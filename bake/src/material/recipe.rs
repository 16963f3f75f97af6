//! What a material is baked from: the words of its file, with defaults filled in.

use super::inputs::MaterialInputs;
use crate::recipe::{self, Recipe};
use glintbake_format::model::Wrap;
use glintbake_format::records::LayerKind;
use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// Everything that decides a material's package, besides the contents of its maps.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MaterialRecipe {
    /// The layers, the top first; 1 to 8.
    pub layers: Vec<LayerRecipe>,
}

/// What one layer is asked for.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct LayerRecipe {
    /// What it does with light.
    #[serde(serialize_with = "kind_name")]
    pub kind: LayerKind,
    /// The map of its normals, and how it is baked; `None` for a lobe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<MapRecipe>,
    /// Beckmann roughness of its lobe, 1e-4 to 1; 0 with a map.
    pub lobe: f64,
    /// How often its maps repeat in the unit square of the material.
    pub scale: [f64; 2],
    /// Reflectance at normal incidence by colour; 0 for coats.
    pub f0: [f64; 3],
    /// Albedo below the gloss of a base, or what a coat lets pass; 0 for glints.
    pub colour: [f64; 3],
    /// Index of refraction of a coat; 0 for others.
    pub ior: f64,
    /// The part of the surface it covers.
    pub opacity: f64,
    /// The image that says where it covers the surface.
    #[serde(skip)]
    pub opacity_map: Option<PathBuf>,
    /// How that continues beyond its border.
    #[serde(serialize_with = "wrap_name")]
    pub opacity_wrap: Wrap,
}

/// A map, and how it is baked.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MapRecipe {
    /// The image. Not part of the recipe: its name, size and content are.
    #[serde(skip)]
    pub path: PathBuf,
    /// How it is decoded, and the one method it is baked for.
    pub recipe: Recipe,
}

impl MaterialRecipe {
    /// The cache key: BLAKE3 of the recipe's canonical bytes, the inputs' names and hashes and the algorithm's version.
    pub fn hash(&self, inputs: &MaterialInputs) -> [u8; 32] {
        let present: Vec<_> = inputs
            .layers
            .iter()
            .map(|layer| (layer.map.is_some(), layer.opacity.is_some()))
            .collect();
        let files: Vec<_> = inputs.files().map(|file| file.identity()).collect();
        recipe::hash_of(&("material", self, present), &files)
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature is serde's"
)]
fn kind_name<S: Serializer>(kind: &LayerKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kind.name())
}

fn wrap_name<S: Serializer>(wrap: &Wrap, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(wrap.name())
}
