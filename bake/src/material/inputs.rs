//! The images that a material names, hashed.

use super::recipe::MaterialRecipe;
use crate::image::{HashedFile, ImageError};
use crate::progress::Progress;
use std::path::Path;

/// The images of a material.
#[derive(Clone, Debug)]
pub struct MaterialInputs {
    /// Those of each layer, the top first.
    pub layers: Vec<LayerInputs>,
}

/// The images of a layer.
#[derive(Clone, Debug)]
pub struct LayerInputs {
    /// The map of its normals.
    pub map: Option<HashedFile>,
    /// Its opacity map.
    pub opacity: Option<HashedFile>,
}

impl MaterialInputs {
    /// The images that `recipe` names, each streamed once.
    ///
    /// # Errors
    /// As [`HashedFile::open`].
    pub fn open(recipe: &MaterialRecipe, progress: &dyn Progress) -> Result<Self, ImageError> {
        let open = |path: Option<&Path>| {
            path.map(|path| HashedFile::open(path, progress))
                .transpose()
        };
        let layers = recipe
            .layers
            .iter()
            .map(|layer| {
                Ok(LayerInputs {
                    map: open(layer.map.as_ref().map(|map| map.path.as_path()))?,
                    opacity: open(layer.opacity_map.as_deref())?,
                })
            })
            .collect::<Result<_, ImageError>>()?;
        Ok(Self { layers })
    }

    /// All of them, layer by layer, the map of normals first.
    pub fn files(&self) -> impl Iterator<Item = &HashedFile> {
        self.layers
            .iter()
            .flat_map(|layer| layer.map.iter().chain(&layer.opacity))
    }
}
