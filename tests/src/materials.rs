//! Layered materials in memory, for tests.

use glintbake_bake::material::{
    LayerMaps, LayerRecipe, MapRecipe, MaterialRecipe, OpacityMap, bake_maps,
};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, Recipe};
use glintbake_format::model::Wrap;
use glintbake_format::records::LayerKind;
use std::path::PathBuf;

/// A layer and its maps.
#[derive(Clone, Debug)]
pub struct Layer {
    /// What it is baked from.
    pub recipe: LayerRecipe,
    /// The map of its normals.
    pub normals: Option<NormalMap>,
    /// Its opacity map.
    pub opacity: Option<OpacityMap>,
}

impl Layer {
    fn new(kind: LayerKind, lobe: f64) -> Self {
        Self {
            recipe: LayerRecipe {
                kind,
                map: None,
                lobe,
                scale: [1.0; 2],
                f0: [0.0; 3],
                colour: [0.0; 3],
                ior: 0.0,
                opacity: 1.0,
                opacity_map: None,
                opacity_wrap: Wrap::Repeat,
            },
            normals: None,
            opacity: None,
        }
    }

    /// A clear coat of index `ior` and a lobe of roughness `lobe`.
    pub fn coat(ior: f64, lobe: f64) -> Self {
        let mut layer = Self::new(LayerKind::Coat, lobe);
        layer.recipe.ior = ior;
        layer.recipe.colour = [1.0; 3];
        layer
    }

    /// Glints of reflectance `f0` with the normals of `map`, baked by `method`.
    pub fn glints(map: &NormalMap, method: MethodRecipe, f0: [f64; 3]) -> Self {
        let mut layer = Self::new(LayerKind::Glints, 0.0);
        layer.recipe.f0 = f0;
        layer.mapped(map, method)
    }

    /// A base of reflectance `f0` and albedo `diffuse`, and a lobe of roughness `lobe`.
    pub fn base(f0: [f64; 3], diffuse: [f64; 3], lobe: f64) -> Self {
        let mut layer = Self::new(LayerKind::Base, lobe);
        layer.recipe.f0 = f0;
        layer.recipe.colour = diffuse;
        layer
    }

    /// The same with the normals of `map`, baked by `method`, in place of a lobe.
    #[must_use]
    pub fn mapped(mut self, map: &NormalMap, method: MethodRecipe) -> Self {
        self.recipe.lobe = 0.0;
        self.recipe.map = Some(MapRecipe {
            path: PathBuf::new(),
            recipe: Recipe::new(vec![method]),
        });
        self.normals = Some(map.clone());
        self
    }

    /// The same where `texels`, `width` × `height` of them, say.
    #[must_use]
    pub fn covering(mut self, width: u32, height: u32, texels: Vec<u8>, wrap: Wrap) -> Self {
        self.recipe.opacity_map = Some(PathBuf::new());
        self.recipe.opacity_wrap = wrap;
        self.opacity = Some(OpacityMap {
            width,
            height,
            texels,
        });
        self
    }
}

/// The package of `layers`, the top first.
pub fn material(layers: &[Layer]) -> Vec<u8> {
    let recipe = MaterialRecipe {
        layers: layers.iter().map(|layer| layer.recipe.clone()).collect(),
    };
    let baked = bake_maps(&recipe, [0; 32], &[], &(), &mut |place, _| {
        Ok(LayerMaps {
            normals: layers[place].normals.clone(),
            source: None,
            opacity: layers[place].opacity.clone(),
        })
    });
    let plan = baked.expect("the recipes of fixtures are in range").plan;
    plan.to_bytes()
}
