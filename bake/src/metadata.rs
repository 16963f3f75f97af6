//! The metadata section: what a person or a build wants to know of a package, as JSON with sorted keys.

use crate::image::InputFile;
use crate::material::MaterialRecipe;
use crate::methods::Bake;
use crate::recipe::{Recipe, Source};
use glintbake_format::records::{LayerNormals, MaterialLayer};
use serde_json::{Value, json};

/// The metadata of a package, as canonical JSON text. Nothing in it depends on time, machine or folder.
pub(crate) fn text(recipe: &Recipe, source: Option<&Source>, bake: &Bake<'_>) -> String {
    let inputs: Vec<_> = source.iter().map(|source| &source.input).collect();
    let mut value = common(&inputs, bake);
    value["recipe"] = json!(recipe);
    value["statistics"] = json!(source.map(|source| &source.statistics));
    // `Value` keeps its keys sorted, whatever the order structs declare them in.
    value.to_string()
}

/// The metadata of a package that holds a material of `layers`.
pub(crate) fn of_material(
    recipe: &MaterialRecipe,
    inputs: &[&InputFile],
    sources: &[Option<Source>],
    layers: &[MaterialLayer],
    bake: &Bake<'_>,
) -> String {
    let mut value = common(inputs, bake);
    let material: Vec<Value> = recipe
        .layers
        .iter()
        .zip(sources)
        .zip(layers)
        .map(|((recipe, source), layer)| {
            json!({
                "input": source.as_ref().map(|source| &source.input.name),
                "instance": match layer.normals {
                    LayerNormals::Instance(number) => Some(number),
                    LayerNormals::Lobe(_) => None,
                },
                "kind": layer.kind.name(),
                "opacity-size": layer.opacity_map.map(|map| map.levels.map_size()),
                "recipe": recipe,
                "statistics": source.as_ref().map(|source| &source.statistics),
            })
        })
        .collect();
    value["material"] = json!(material);
    value.to_string()
}

/// What the metadata of every package has.
fn common(inputs: &[&InputFile], bake: &Bake<'_>) -> Value {
    let inputs: Vec<Value> = inputs
        .iter()
        .map(|input| {
            json!({
                "blake3": blake3::Hash::from_bytes(input.blake3).to_hex().as_str(),
                "bytes": input.bytes,
                "name": input.name,
            })
        })
        .collect();
    let mut value = json!({
        "convention": {
            "half-vector": "s right, t up, projected unit disk",
            "ndf": "density per steradian of half vectors; each flake's own kernel integrates to 1",
            "texture": "u right along columns, v down along rows, one tile is the unit square",
        },
        "inputs": inputs,
        "chosen": bake.chosen,
        "left-out": bake.left_out,
        "tool": { "name": "glintbake", "version": env!("CARGO_PKG_VERSION") },
    });
    if !bake.quilted.is_empty() {
        value["quilted"] = json!(bake.quilted);
    }
    if !bake.ndf_mapped.is_empty() {
        value["ndf-maps"] = json!(bake.ndf_mapped);
    }
    value
}
