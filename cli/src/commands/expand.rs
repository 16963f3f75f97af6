//! `expand`: the explicit normal map that a package stands for, as a PNG.

use super::{open, paths};
use crate::args::ExpandArgs;
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use crate::picture::png;
use crate::rebuild;
use glintbake_bake::normals::NormalMap;
use glintbake_format::records::Structure;
use glintbake_runtime::{Instance, Package};
use glintbake_samples::Sample;
use serde_json::json;

/// The most points along a side of an expanded surface.
const MAX_SIDE: u32 = 16384;

/// The normals of the surface of `instance`.
fn explicit(
    arguments: &ExpandArgs,
    package: &Package<'_>,
    instance: &Instance,
) -> Result<NormalMap, CommandError> {
    let path = &arguments.open.package;
    let wanted =
        |message: String| CommandError::new(Failure::Usage, message).in_file(path.display());
    let (number, method) = (instance.number, instance.method.name());
    let is_copied = matches!(instance.structure, Structure::NdfMaps(_));
    let map = match (is_copied, arguments.size) {
        (true, size) => {
            let size = size.unwrap_or(instance.width);
            if !(1..=MAX_SIDE).contains(&size) {
                return Err(wanted(format!(
                    "--size {size}: give 1 to {MAX_SIDE} points along a side"
                )));
            }
            rebuild::ndf_maps::explicit(package.container(), instance, size).map(Some)
        }
        (false, Some(size)) => {
            return Err(wanted(format!(
                "--size {size}: the surface of instance {number}, {method}, has texels of its own; leave the option out"
            )));
        }
        (false, None) => rebuild::normal_map(package.container(), instance),
    };
    map.map_err(|finding| CommandError::from(finding).in_file(path.display()))?
        .ok_or_else(|| {
            wanted(format!(
                "instance {number} of {method} keeps no texel's own normal"
            ))
        })
}

/// Writes the normals of every texel of the surface.
///
/// # Errors
/// [`Failure::Usage`] if the package has no such instance or keeps no texel's normal, [`Failure::Output`] if the file cannot be
/// written.
pub fn run(arguments: &ExpandArgs, console: &Console) -> Result<(), CommandError> {
    let path = &arguments.open.package;
    paths::check(Some(path), &[("--output", &arguments.output)])?;
    let bytes = open::checked(&arguments.open)?;
    let package = open::package(path, &bytes)?;
    let wanted =
        |message: String| CommandError::new(Failure::Usage, message).in_file(path.display());
    let mut instances = package.instances();
    let instance = match arguments.instance {
        None => instances.next(),
        Some(number) => instances.find(|instance| instance.number == number),
    };
    let instance = instance.ok_or_else(|| {
        wanted(format!(
            "there is no instance {}; `glintbake inspect` lists them",
            arguments.instance.unwrap_or(1)
        ))
    })?;
    let progress = console.progress("expanding");
    let map = explicit(arguments, &package, &instance)?;
    let (width, height) = (map.width(), map.height());
    let sample = Sample {
        width,
        height,
        normals: map.texels().to_vec(),
    };
    progress.set_message("writing");
    png::write_rgb16(&arguments.output, width, height, &sample.rgb16())?;
    progress.finish_and_clear();
    let output = arguments.output.display();
    console.line(format_args!(
        "{output}: {width} x {height} texels of instance {}, {}, 16 bit, OpenGL green",
        instance.number,
        instance.method.name(),
    ));
    console.document(&json!({
        "height": height,
        "instance": instance.number,
        "method": instance.method.name(),
        "output": output.to_string(),
        "width": width,
    }));
    Ok(())
}
