//! `inspect`: what is in a package.

use super::describe::{self, bytes_per_texel};
use super::open;
use crate::args::InspectArgs;
use crate::exit::CommandError;
use crate::output::{Console, human_bytes};
use glintbake_format::records::OPACITY;
use glintbake_runtime::Package;
use serde_json::{Value, json};

/// Prints header, instances, sections and metadata.
///
/// # Errors
/// [`CommandError`] if the package cannot be read or is damaged.
pub fn run(arguments: &InspectArgs, console: &Console) -> Result<(), CommandError> {
    let path = &arguments.open.package;
    let bytes = open::checked(&arguments.open)?;
    let package = open::package(path, &bytes)?;
    let metadata = describe::metadata(&package).map_err(|error| error.in_file(path.display()))?;
    let in_file = |error: CommandError| error.in_file(path.display());
    if console.json() {
        let layers = describe::layer_documents(&package).map_err(in_file)?;
        console.document(&document(&package, metadata, layers));
    } else {
        let layers = describe::layers(&package).map_err(in_file)?;
        print(
            &package,
            &metadata,
            &layers,
            console,
            &path.display().to_string(),
        );
    }
    Ok(())
}

fn document(package: &Package<'_>, metadata: Value, layers: Vec<Value>) -> Value {
    let container = package.container();
    let header = container.header();
    let sections: Vec<_> = container
        .entries()
        .iter()
        .map(|entry| {
            json!({
                "bytes": entry.length.get(),
                "bytes-per-texel": bytes_per_texel(package, entry.length.get()),
                "crc32": format!("{:08x}", entry.crc.get()),
                "critical": entry.is_critical(),
                "element-size": entry.element_size.get(),
                "elements": entry.count.get(),
                "instance": entry.instance.get(),
                "kind": entry.kind.to_string(),
                "layer": entry.layer.get(),
                "offset": entry.offset.get(),
                "ordinal": entry.ordinal.get(),
            })
        })
        .collect();
    let total = container.bytes().len() as u64;
    json!({
        "bytes": total,
        "bytes-per-texel": bytes_per_texel(package, total),
        "content-hash": hex(&header.content_hash),
        "instances": package.instances().map(|instance| describe::instance_document(&instance)).collect::<Vec<_>>(),
        "layers": layers,
        "metadata": metadata,
        "recipe-hash": hex(&header.recipe_hash),
        "sections": sections,
        "version": [header.major.get(), header.minor.get()],
    })
}

fn print(
    package: &Package<'_>,
    metadata: &Value,
    layers: &[String],
    console: &Console,
    path: &str,
) {
    let container = package.container();
    let header = container.header();
    let total = container.bytes().len() as u64;
    console.result(format_args!(
        "{path}: glintbake package version {}.{}, {}, {:.2} bytes a texel",
        header.major.get(),
        header.minor.get(),
        human_bytes(total),
        bytes_per_texel(package, total)
    ));
    for instance in package.instances() {
        console.result(format_args!("  {}", describe::instance(&instance)));
    }
    for layer in layers {
        console.result(format_args!("  {layer}"));
    }
    console.result("  section  instance    elements  size         bytes a texel");
    for entry in container.entries() {
        let instance = match entry.instance.get() {
            0 if entry.kind == OPACITY => format!("layer {}", entry.layer.get()),
            0 => "all".to_owned(),
            number => number.to_string(),
        };
        console.result(format_args!(
            "  {:7}  {instance:8}  {:>10}  {:11}  {:.3}",
            entry.kind.to_string(),
            entry.count.get(),
            human_bytes(entry.length.get()),
            bytes_per_texel(package, entry.length.get())
        ));
    }
    print_metadata(metadata, console);
    console.result(format_args!("  recipe  {}", hex(&header.recipe_hash)));
    console.result(format_args!("  content {}", hex(&header.content_hash)));
}

fn print_metadata(metadata: &Value, console: &Console) {
    for input in metadata["inputs"].as_array().into_iter().flatten() {
        console.result(format_args!(
            "  input {}, {} bytes, BLAKE3 {}",
            input["name"].as_str().unwrap_or("?"),
            input["bytes"],
            input["blake3"].as_str().unwrap_or("?")
        ));
    }
    for line in describe::normals(metadata) {
        console.result(format_args!("  {line}"));
    }
    for (place, layer) in (0..).zip(metadata["material"].as_array().into_iter().flatten()) {
        for line in describe::normals(layer) {
            console.result(format_args!("  layer {place}: {line}"));
        }
    }
    for chosen in metadata["chosen"].as_array().into_iter().flatten() {
        console.result(format_args!(
            "  index: {} for instance {}: {}",
            chosen["inverse"].as_str().unwrap_or("?"),
            chosen["instance"],
            chosen["reason"].as_str().unwrap_or("?")
        ));
    }
    for quilted in metadata["quilted"].as_array().into_iter().flatten() {
        console.result(format_args!(
            "  quilt of instance {}: {} patches of {} texels, for {} of which no block was within {}: one of the least bad was \
             taken; along cuts texels differ by {:.3} of what any two do",
            quilted["instance"],
            quilted["patches"],
            quilted["patch"],
            quilted["forced"],
            quilted["tolerance"],
            quilted["mean-error"].as_f64().unwrap_or(f64::NAN),
        ));
    }
    for line in describe::copies(metadata) {
        console.result(format_args!("  {line}"));
    }
    for left_out in metadata["left-out"].as_array().into_iter().flatten() {
        console.result(format_args!(
            "  left out: {} of instance {}: {}",
            left_out["section"].as_str().unwrap_or("?"),
            left_out["instance"],
            left_out["reason"].as_str().unwrap_or("?")
        ));
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
