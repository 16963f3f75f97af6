//! `picture`: what a package looks like.

use super::{lattice, open, paths, reference};
use crate::args::{Picture, PictureArgs, PictureBallArgs, PictureNdfArgs, SettingArgs};
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use crate::picture::{ball, binning, ndf, png};
use glintbake_format::model::Footprint;
use glintbake_runtime::{Composition, Material, Ndf};
use serde_json::json;

/// The largest side of a picture in pixels.
const MAX_PIXELS: u32 = 16_384;

/// Draws the picture.
///
/// # Errors
/// [`Failure::Usage`] for sizes out of range, and whatever opening, querying and writing fail with.
pub fn run(arguments: &PictureArgs, console: &Console) -> Result<(), CommandError> {
    match &arguments.picture {
        Picture::Ndf(arguments) => run_ndf(arguments, console),
        Picture::Ball(arguments) => run_ball(arguments, console),
    }
}

fn run_ndf(arguments: &PictureNdfArgs, console: &Console) -> Result<(), CommandError> {
    let path = &arguments.open.package;
    paths::check(Some(path), &[("--output", &arguments.output)])?;
    check_pixels(arguments.pixels)?;
    positive("--zoom", arguments.zoom)?;
    if !(arguments.texels.is_finite() && arguments.texels >= 0.0) {
        return Err(usage("--texels", "a number of texels, 0 or more"));
    }
    let bytes = open::checked(&arguments.open)?;
    let chosen = open::choose(&arguments.open, &arguments.settings, &bytes)?;
    let progress = console.progress("drawing");
    let instance = chosen.ndf.instance();
    let footprint = Footprint::square(
        arguments.uv,
        arguments.texels,
        instance.width,
        instance.height,
    );
    let (width, picture, counted) = match &arguments.reference.reference {
        None => {
            let picture = ndf::draw(&chosen.ndf, &footprint, arguments.pixels, arguments.zoom)?;
            (arguments.pixels, picture, None)
        }
        Some(image) => {
            let reference = reference::read(image, &arguments.reference, &chosen.ndf)?;
            let (side, zoom) = (arguments.pixels, arguments.zoom);
            let pair = binning::draw(&chosen.ndf, &footprint, side, zoom, &reference)?;
            let counted = reference::Counted::new(&reference, &pair);
            (pair.width, pair.picture, Some(counted))
        }
    };
    png::write_rgb8(&arguments.output, width, arguments.pixels, &picture.pixels)?;
    progress.finish_and_clear();
    lattice::warn_of_query(console, &arguments.open, &chosen, &bytes);
    let output = arguments.output.display();
    let reach = 1.0 / arguments.zoom;
    let sigma = arguments.texels / 2.0;
    console.line(format_args!(
        "{output}: {}\n  footprint at ({}, {}), edge {} texels (σ {sigma}); s and t from {} to {reach}; \
         D up to {:.4}; integral {:.4} over the picture",
        chosen.description,
        arguments.uv[0],
        arguments.uv[1],
        arguments.texels,
        -reach,
        picture.peak,
        picture.integral
    ));
    if let Some(counted) = &counted {
        console.line(format_args!("  {counted}"));
    }
    let mut document = json!({
        "integral": picture.integral,
        "output": output.to_string(),
        "peak": picture.peak,
        "setting": chosen.description,
        "sigma": sigma,
        "texels": arguments.texels,
        "uv": arguments.uv,
        "zoom": arguments.zoom,
    });
    if let Some(counted) = &counted {
        document["reference"] = counted.document();
    }
    console.document(&document);
    Ok(())
}

fn run_ball(arguments: &PictureBallArgs, console: &Console) -> Result<(), CommandError> {
    let path = &arguments.open.package;
    paths::check(Some(path), &[("--output", &arguments.output)])?;
    check_pixels(arguments.pixels)?;
    if let Some(tiles) = arguments.tiles {
        positive("--tiles", tiles)?;
    }
    let bytes = open::checked(&arguments.open)?;
    let options = ball::Options {
        side: arguments.pixels,
        tiles: arguments.tiles,
    };
    let settings = &arguments.settings;
    // One layer is drawn as the package of its map would be.
    let material = match settings.layer {
        None => open::material(&arguments.open, &bytes)?,
        Some(_) => None,
    };
    let (picture, description) = match material {
        Some(material) => {
            let progress = console.progress("drawing");
            let (material, description) = composed(material, settings)?;
            let picture = ball::draw(&ball::Layered(material), &options)?;
            progress.finish_and_clear();
            (picture, description)
        }
        None => {
            let chosen = open::choose(&arguments.open, settings, &bytes)?;
            let progress = console.progress("drawing");
            let picture = ball::draw(&ball::Metal(chosen.ndf), &options)?;
            progress.finish_and_clear();
            lattice::warn_of_query(console, &arguments.open, &chosen, &bytes);
            (picture, chosen.description)
        }
    };
    png::write_rgb8(
        &arguments.output,
        picture.side,
        picture.side,
        &picture.pixels,
    )?;
    let output = arguments.output.display();
    console.line(format_args!(
        "{output}: {description}, {:.3} tiles around the ball",
        picture.tiles
    ));
    console.document(&json!({
        "output": output.to_string(),
        "setting": description,
        "tiles": picture.tiles,
    }));
    Ok(())
}

/// `material` as `settings` have it, and the words for it.
fn composed<'a>(
    material: Material<'a>,
    settings: &SettingArgs,
) -> Result<(Material<'a>, String), CommandError> {
    if let Some(option) = settings.first_given() {
        return Err(CommandError::new(
            Failure::Usage,
            format!(
                "{option}: a layered material says itself how its layers are evaluated; leave the option out, or draw one layer \
                 with --layer"
            ),
        ));
    }
    let (composition, setting) = if settings.paper {
        (Composition::HalfVector, "paper")
    } else {
        (Composition::BothWays, "default")
    };
    let kinds: Vec<_> = material
        .layers()
        .map(|layer| layer.record().kind.name())
        .collect();
    let description = format!("layers={} setting={setting}", kinds.join(","));
    Ok((material.with_composition(composition), description))
}

fn usage(option: &str, wanted: &str) -> CommandError {
    CommandError::new(Failure::Usage, format!("{option}: it must be {wanted}"))
}

fn positive(option: &str, value: f64) -> Result<(), CommandError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(usage(option, "a number above 0"))
    }
}

fn check_pixels(pixels: u32) -> Result<(), CommandError> {
    if (1..=MAX_PIXELS).contains(&pixels) {
        Ok(())
    } else {
        Err(usage(
            "--pixels",
            &format!("a number of pixels from 1 to {MAX_PIXELS}"),
        ))
    }
}
