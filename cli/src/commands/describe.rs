//! Words for what a package holds, shared by the commands that name it.

use crate::exit::{CommandError, Failure};
use glintbake_format::model::{MIP_LANES, MipLayout, NdfMapLayout, NdfPixels, PyramidLayout};
use glintbake_format::records::{
    InverseKind, LayerKind, LayerNormals, METADATA, MaterialLayer, Structure,
};
use glintbake_format::view::MaterialLayers;
use glintbake_format::{Fault, Finding, SectionId};
use glintbake_runtime::{Instance, Package};
use serde_json::{Value, json};

/// The metadata of `package`.
///
/// # Errors
/// [`Failure::Package`] if it is missing or not JSON.
pub(super) fn metadata(package: &Package<'_>) -> Result<Value, CommandError> {
    let id = SectionId::shared(METADATA);
    let text: &[u8] = package.container().elements(id)?;
    serde_json::from_slice(text).map_err(|error| {
        let finding = Finding::new(Fault::Metadata).within(id);
        CommandError::new(Failure::Package, format!("{finding}: {error}"))
    })
}

/// `bytes` for each texel of the package's map.
pub(super) fn bytes_per_texel(package: &Package<'_>, bytes: u64) -> f64 {
    let texels = package
        .instances()
        .next()
        .map_or(0, |instance| instance.texel_count());
    bytes as f64 / f64::from(texels.max(1))
}

/// One line about an instance.
pub(super) fn instance(instance: &Instance) -> String {
    // Trees, lobes and surfaces answer for every roughness: what it has is what a query that names none gets.
    let roughness = match (instance.roughness, instance.structure) {
        (
            Some(alpha),
            Structure::Clusters { .. }
            | Structure::Lobes(_)
            | Structure::MipLobes(_)
            | Structure::Surface { .. },
        ) => {
            format!(", any roughness ({alpha} by default)")
        }
        (Some(alpha), _) => format!(", roughness {alpha}"),
        (None, _) => String::new(),
    };
    let structure = match instance.structure {
        Structure::Bins(bins) => {
            let inverse = match bins.inverse {
                InverseKind::Forest => format!("forest of leaf size {}", bins.leaf_size),
                InverseKind::Tiles => "tile lists".to_owned(),
                InverseKind::None => "bin map alone".to_owned(),
            };
            let b = bins.grid.resolution();
            format!("{b} x {b} bins, {inverse}, {} index", bins.index.name())
        }
        Structure::Pyramid { finest_level } => {
            format!("levels {finest_level} to {}", top(instance))
        }
        Structure::Clusters { kernel } => format!("kernel {} by default", kernel.name()),
        Structure::Lobes(lattice) => {
            let kind = if lattice.curved { "curved" } else { "flat" };
            let count = lattice.per_side * lattice.per_side;
            format!("{kind} lobes, {count} a texel")
        }
        Structure::MipLobes(layout) => mip_lobes(&layout),
        Structure::NdfMaps(layout) => ndf_maps(&layout),
        Structure::Surface { interpolation } => {
            format!("interpolation {}", interpolation.name())
        }
    };
    format!(
        "instance {}: {} {} x {}{roughness}, {structure}, {}",
        instance.number,
        instance.method.name(),
        instance.width,
        instance.height,
        instance.wrap.name(),
    )
}

/// One line about each layer of the material in `package`; none if it holds no material.
///
/// # Errors
/// [`Failure::Package`] if the layers are damaged.
pub(super) fn layers(package: &Package<'_>) -> Result<Vec<String>, CommandError> {
    let layers = material(package)?;
    let lines = (0..).zip(&layers).map(|(place, layer)| {
        let mut words = vec![format!("layer {place}: {}", layer.kind.name())];
        words.push(match layer.normals {
            LayerNormals::Instance(number) => {
                let [u, v] = layer.scale;
                format!("instance {number} repeated {u} x {v} times")
            }
            LayerNormals::Lobe(roughness) => format!("roughness {roughness}"),
        });
        words.push(match layer.kind {
            LayerKind::Coat => format!("ior {}, colour {}", layer.ior, rgb(layer.colour)),
            LayerKind::Glints => format!("f0 {}", rgb(layer.f0)),
            LayerKind::Base => format!("f0 {}, diffuse {}", rgb(layer.f0), rgb(layer.colour)),
        });
        words.push(match layer.opacity_map {
            None => format!("opacity {}", layer.opacity),
            Some(map) => {
                let [width, height] = map.levels.map_size();
                format!("opacity {} of a map of {width} x {height}", layer.opacity)
            }
        });
        words.join(", ")
    });
    Ok(lines.collect())
}

/// The layers as JSON documents.
///
/// # Errors
/// As [`layers`].
pub(super) fn layer_documents(package: &Package<'_>) -> Result<Vec<Value>, CommandError> {
    let layers = material(package)?;
    let documents = (0..).zip(layers).map(|(place, layer)| {
        let (instance, roughness) = match layer.normals {
            LayerNormals::Instance(number) => (Some(number), None),
            LayerNormals::Lobe(roughness) => (None, Some(exact(roughness))),
        };
        json!({
            "colour": layer.colour.map(exact),
            "f0": layer.f0.map(exact),
            "instance": instance,
            "ior": exact(layer.ior),
            "kind": layer.kind.name(),
            "layer": place,
            "opacity": exact(layer.opacity),
            "opacity-size": layer.opacity_map.map(|map| map.levels.map_size()),
            "opacity-wrap": layer.opacity_map.map(|map| map.wrap.name()),
            "roughness": roughness,
            "scale": layer.scale.map(exact),
        })
    });
    Ok(documents.collect())
}

fn material(package: &Package<'_>) -> Result<Vec<MaterialLayer>, CommandError> {
    match MaterialLayers::open(package.container())? {
        None => Ok(Vec::new()),
        Some(layers) => Ok(layers.iter().collect::<Result<_, _>>()?),
    }
}

/// The shortest decimal number that is stored as `number`.
fn exact(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

fn rgb([red, green, blue]: [f32; 3]) -> String {
    if red == green && green == blue {
        red.to_string()
    } else {
        format!("({red}, {green}, {blue})")
    }
}

/// Levels and clusters of MIP lobes, and the quilt of their surface.
fn mip_lobes(layout: &MipLayout) -> String {
    let count = layout.per_side * layout.per_side;
    let clusters = usize::from(layout.blocks) * MIP_LANES;
    let levels = format!(
        "{count} lobes a texel, {clusters} clusters a cell from level {} to {}",
        layout.first_level,
        layout.top()
    );
    match layout.quilt {
        None => levels,
        Some(quilt) => format!(
            "{levels}, quilted from {} x {} by patches of {} + {}",
            quilt.sample[0],
            quilt.sample[1],
            quilt.patch(),
            quilt.overlap
        ),
    }
}

/// The same as a document.
fn mip_lobes_document(layout: &MipLayout) -> Value {
    let mut document = json!({
        "clusters": usize::from(layout.blocks) * MIP_LANES,
        "first-level": layout.first_level,
        "lobes-per-texel": layout.per_side * layout.per_side,
        "top-level": layout.top(),
    });
    if let Some(quilt) = layout.quilt {
        document["quilt"] = json!({
            "grid": 1_u32 << quilt.grid_log,
            "overlap": quilt.overlap,
            "patch": quilt.patch(),
            "patches": quilt.patches,
            "sample": quilt.sample,
        });
    }
    document
}

/// The example, its images, and how its copies lie.
fn ndf_maps(layout: &NdfMapLayout) -> String {
    let copies = if layout.is_scattered {
        "scattered"
    } else {
        "tiled"
    };
    let slopes = if layout.scales_slopes {
        ", slopes scaled"
    } else {
        ""
    };
    format!(
        "{copies} copies of {0} x {0} texels, {1} NDF images of {2}{slopes}",
        layout.example(),
        layout.images(),
        pixels(layout),
    )
}

/// What the metadata says of surfaces made of copies, a sentence each.
pub(super) fn copies(metadata: &Value) -> Vec<String> {
    let all = metadata["ndf-maps"].as_array().into_iter().flatten();
    all.map(|copies| {
        format!(
            "copies of instance {}: {} seen, {} hidden by others, {:.1} % of the surface covered; {} pixels of NDF images",
            copies["instance"],
            copies["copies"],
            copies["hidden"],
            100.0 * copies["covered"].as_f64().unwrap_or(f64::NAN),
            copies["pixels"],
        )
    })
    .collect()
}

/// What the pixels of NDF images are.
fn pixels(layout: &NdfMapLayout) -> &'static str {
    match layout.pixels {
        NdfPixels::Splines => "splines",
        NdfPixels::Points => "points",
    }
}

/// The level of one cell over the map of `instance`.
fn top(instance: &Instance) -> u32 {
    PyramidLayout::top_of(instance.width, instance.height)
}

/// An instance as a JSON document: what all have, and what its structure has.
pub(super) fn instance_document(instance: &Instance) -> Value {
    let mut document = json!({
        "filter": instance.filter.name(),
        "height": instance.height,
        "kernel": instance.kernel().name(),
        "layer": instance.layer,
        "method": instance.method.name(),
        "number": instance.number,
        "roughness": instance.roughness,
        "width": instance.width,
        "wrap": instance.wrap.name(),
    });
    let structure = match instance.structure {
        Structure::Bins(bins) => json!({
            "binning": bins.grid.binning().name(),
            "bins-per-side": bins.grid.resolution(),
            "index": bins.index.name(),
            "inverse": bins.inverse.name(),
            "keys": bins.key_count,
            "leaf-size": bins.leaf_size,
        }),
        Structure::Pyramid { finest_level } => json!({
            "finest-level": finest_level,
            "top-level": top(instance),
        }),
        Structure::Clusters { .. } => json!({}),
        Structure::Lobes(lattice) => json!({
            "curved": lattice.curved,
            "lobes-per-texel": lattice.per_side * lattice.per_side,
        }),
        Structure::MipLobes(layout) => mip_lobes_document(&layout),
        Structure::NdfMaps(layout) => json!({
            "example": layout.example(),
            "images": layout.images(),
            "pixels": pixels(&layout),
            "scales-slopes": layout.scales_slopes,
            "scattered": layout.is_scattered,
        }),
        Structure::Surface { interpolation } => json!({
            "interpolation": interpolation.name(),
        }),
    };
    if let (Value::Object(document), Value::Object(structure)) = (&mut document, structure) {
        document.extend(structure);
    }
    document
}

/// What the statistics in `metadata` say of the normals, in sentences; none if the package has none.
pub(super) fn normals(metadata: &Value) -> Vec<String> {
    let statistics = &metadata["statistics"];
    let mut lines = Vec::new();
    if let Some(lengths) = statistics["lengths"].as_object() {
        lines.push(format!(
            "normals: length {:.4} on average, {:.4} to {:.4} before normalising",
            number(&lengths["mean"]),
            number(&lengths["shortest"]),
            number(&lengths["longest"])
        ));
    }
    if statistics.is_object() {
        lines.push(format!(
            "normals: mean ({:.4}, {:.4}), mean cosine {:.4}, largest tilt {:.1} degrees, {} clamped, {} repaired",
            number(&statistics["mean"][0]),
            number(&statistics["mean"][1]),
            number(&statistics["mean-cosine"]),
            number(&statistics["largest-tilt-degrees"]),
            statistics["clamped-to-rim"],
            statistics["repaired"]
        ));
    }
    lines
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}
