//! The metadata section: what a person or a build wants to know of a package, as JSON with sorted keys.

use crate::methods::Bake;
use crate::recipe::{Recipe, Source};
use serde_json::{Value, json};

/// The metadata of a package, as canonical JSON text. Nothing in it depends on time, machine or folder.
pub(crate) fn text(recipe: &Recipe, source: Option<&Source>, bake: &Bake<'_>) -> String {
    let inputs: Vec<Value> = source
        .iter()
        .map(|source| {
            json!({
                "blake3": blake3::Hash::from_bytes(source.input.blake3).to_hex().as_str(),
                "bytes": source.input.bytes,
                "name": source.input.name,
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
        "recipe": recipe,
        "statistics": source.map(|source| &source.statistics),
        "tool": { "name": "glintbake", "version": env!("CARGO_PKG_VERSION") },
    });
    if !bake.quilted.is_empty() {
        value["quilted"] = json!(bake.quilted);
    }
    // `Value` keeps its keys sorted, whatever the order structs declare them in.
    value.to_string()
}
