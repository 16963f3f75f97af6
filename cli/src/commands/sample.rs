//! `sample`: a generated normal map as a PNG, or a noise map as PNG or EXR.

mod noise_map;

use super::paths;
use crate::args::{SampleArgs, SampleKind};
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use crate::picture::png;
use glintbake_samples::{Options, generate};
use serde_json::json;

/// Generates the map and writes it.
///
/// # Errors
/// [`Failure::Usage`] for options out of range, [`Failure::Output`] if the file cannot be written.
pub fn run(arguments: &SampleArgs, console: &Console) -> Result<(), CommandError> {
    let SampleKind::Map(kind) = arguments.kind else {
        return noise_map::run(arguments, console);
    };
    noise_map::refuse_options(arguments)?;
    paths::check(None, &[("--output", &arguments.output)])?;
    let progress = console.progress("generating");
    let defaults = Options::new(kind, 1);
    let (width, height) = arguments.size;
    let options = Options {
        width,
        height,
        seed: arguments.seed,
        scale: arguments.scale.unwrap_or(defaults.scale),
        roughness: arguments.roughness.unwrap_or(defaults.roughness),
        density: arguments.density.unwrap_or(defaults.density),
    };
    let sample = generate(kind, &options)
        .map_err(|error| CommandError::new(Failure::Usage, error.to_string()))?;
    progress.set_message("writing");
    match arguments.bits {
        8 => png::write_rgb8(&arguments.output, width, height, &sample.rgb8())?,
        _ => png::write_rgb16(&arguments.output, width, height, &sample.rgb16())?,
    }
    progress.finish_and_clear();
    let path = arguments.output.display();
    console.line(format_args!(
        "{path}: {} {width} x {height}, seed {}, {} bit, OpenGL green",
        kind.name(),
        arguments.seed,
        arguments.bits
    ));
    console.document(&json!({
        "bits": arguments.bits,
        "density": options.density,
        "height": height,
        "kind": kind.name(),
        "output": path.to_string(),
        "roughness": options.roughness,
        "scale": options.scale,
        "seed": arguments.seed,
        "width": width,
    }));
    Ok(())
}
