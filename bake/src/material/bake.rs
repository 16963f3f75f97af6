//! From a recipe and its maps to a package.

use super::error::MaterialError;
use super::inputs::MaterialInputs;
use super::opacity::{self, OpacityMap};
use super::recipe::{LayerRecipe, MaterialRecipe};
use crate::bake::baker;
use crate::build;
use crate::error::BakeError;
use crate::image::ReadOptions;
use crate::metadata;
use crate::methods::Bake;
use crate::normals::{self, NormalMap};
use crate::package::PackagePlan;
use crate::progress::{Progress, Stage};
use crate::recipe::Source;
use glintbake_format::SectionId;
use glintbake_format::model::PyramidLayout;
use glintbake_format::records::{
    INSTANCES, Instance, LayerNormals, MATERIAL, METADATA, MaterialLayer, OPACITY, OpacityLayout,
};

/// Bytes of an opacity texel while it is read and averaged.
const OPACITY_BYTES: u64 = 4;

/// The maps of one layer, as read.
#[derive(Debug, Default)]
pub struct LayerMaps {
    /// The normals, of a layer that has a map.
    pub normals: Option<NormalMap>,
    /// Where they came from, if from a file.
    pub source: Option<Source>,
    /// Where the layer covers the surface, of a layer that has an opacity map.
    pub opacity: Option<OpacityMap>,
}

/// A material's package, ready to be written, and where the normals of each layer came from.
pub struct BakedMaterial {
    /// The package.
    pub plan: PackagePlan,
    /// The source of each layer, the top first; `None` of layers without a map.
    pub sources: Vec<Option<Source>>,
}

/// The package of `recipe` from its `inputs`, one layer after the other; a map that would take more than `memory` bytes is
/// refused before it is read.
///
/// The same recipe and inputs give the same bytes, whatever the number of threads.
///
/// # Errors
/// [`BakeError`] if a map cannot be read, is no normal map, or does not fit the format.
pub fn bake(
    recipe: &MaterialRecipe,
    inputs: &MaterialInputs,
    memory: u64,
    progress: &dyn Progress,
) -> Result<BakedMaterial, BakeError> {
    let hash = recipe.hash(inputs);
    let names: Vec<_> = inputs.files().map(|file| file.identity()).collect();
    bake_maps(recipe, hash, &names, progress, &mut |place, layer| {
        let files = &inputs.layers[place];
        let mut maps = LayerMaps::default();
        if let (Some(map), Some(file)) = (&layer.map, &files.map) {
            let mut options = map.recipe.read_options();
            options.limits.texels = memory / map.recipe.bytes_per_texel();
            let (normals, statistics) =
                normals::read(file, &options, &map.recipe.decode, progress)?;
            maps.normals = Some(normals);
            maps.source = Some(Source {
                input: file.identity().clone(),
                statistics,
            });
        }
        if let Some(file) = &files.opacity {
            let mut options = ReadOptions::default();
            options.limits.texels = memory / OPACITY_BYTES;
            maps.opacity = Some(opacity::read(file, &options)?);
        }
        Ok(maps)
    })
}

/// The package of `recipe`, whose header carries `hash` and whose metadata name `inputs`, from the maps that `load` gives for
/// each layer in turn, by its place.
///
/// # Errors
/// Whatever `load` fails with; [`BakeError::MapTooLarge`].
///
/// # Panics
/// If `load` gives a layer other maps than the recipe asks for, or there are more layers than a material may have.
pub fn bake_maps(
    recipe: &MaterialRecipe,
    hash: [u8; 32],
    inputs: &[&crate::image::InputFile],
    progress: &dyn Progress,
    load: &mut dyn FnMut(usize, &LayerRecipe) -> Result<LayerMaps, BakeError>,
) -> Result<BakedMaterial, BakeError> {
    let maps = recipe.layers.iter().flat_map(|layer| &layer.map);
    let mut bake = Bake {
        layer: 0,
        plan: PackagePlan::new(hash),
        instances: Vec::new(),
        left_out: Vec::new(),
        chosen: Vec::new(),
        quilted: Vec::new(),
        ndf_mapped: Vec::new(),
        progress,
        instance_count: maps.map(|map| map.recipe.instance_count()).sum(),
    };
    let (mut layers, mut sources) = (Vec::new(), Vec::new());
    for (place, layer) in recipe.layers.iter().enumerate() {
        let maps = load(place, layer)?;
        bake.layer = place as u16;
        layers.push(add_layer(layer, &maps, &mut bake)?);
        sources.push(maps.source);
    }
    let metadata = metadata::of_material(recipe, inputs, &sources, &layers, &bake);
    let mut plan = bake.plan;
    let instances: Vec<_> = bake
        .instances
        .into_iter()
        .map(Instance::to_record)
        .collect();
    let layers: Vec<_> = layers.into_iter().map(MaterialLayer::to_record).collect();
    plan.add_critical(SectionId::shared(INSTANCES), instances);
    plan.add(SectionId::shared(MATERIAL), layers);
    plan.add(SectionId::shared(METADATA), metadata.into_bytes());
    Ok(BakedMaterial { plan, sources })
}

/// Adds the sections of `layer`; returns its record.
fn add_layer(
    layer: &LayerRecipe,
    maps: &LayerMaps,
    bake: &mut Bake<'_>,
) -> Result<MaterialLayer, BakeError> {
    let normals = match (&layer.map, &maps.normals) {
        (Some(recipe), Some(normals)) => {
            let number = bake.next_number();
            for method in &recipe.recipe.methods {
                baker(method.method).bake(normals, method, bake)?;
            }
            LayerNormals::Instance(number)
        }
        (None, None) => LayerNormals::Lobe(layer.lobe as f32),
        _ => panic!("a layer has the maps its recipe asks for"),
    };
    assert_eq!(
        layer.opacity_map.is_some(),
        maps.opacity.is_some(),
        "a layer has the opacity map its recipe asks for"
    );
    let opacity_map = match &maps.opacity {
        None => None,
        Some(map) => {
            bake.progress.report(
                Stage::Structures,
                bake.instances.len() as u64,
                bake.instance_count,
            );
            let levels =
                PyramidLayout::new(map.width, map.height, 0).ok_or(BakeError::MapTooLarge {
                    width: map.width,
                    height: map.height,
                })?;
            let cells = build::opacity::build(levels, &map.texels);
            let id = SectionId::of_instance(bake.layer, 0, OPACITY);
            bake.plan.add(id, cells);
            Some(OpacityLayout {
                levels,
                wrap: layer.opacity_wrap,
            })
        }
    };
    Ok(MaterialLayer {
        opacity_map,
        ..layer.to_record_with(normals)
    })
}

impl From<MaterialError> for BakeError {
    fn from(error: MaterialError) -> Self {
        Self::Material(Box::new(error))
    }
}
