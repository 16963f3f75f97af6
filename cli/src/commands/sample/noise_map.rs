//! `sample noise-map`: where copies of a tiny map lie.

use crate::args::SampleArgs;
use crate::commands::paths;
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use crate::picture::png;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use glintbake_bake::image::{self, ReadOptions, Samples};
use glintbake_bake::noise::{self, Density, NoiseCopy, NoiseOptions};
use glintbake_bake::package::publish;
use serde_json::json;
use std::io::{BufWriter, Cursor, Write};
use std::path::Path;

/// Copies of a noise map that names no number.
const DEFAULT_INSTANCES: u32 = 4096;

fn usage(message: String) -> CommandError {
    CommandError::new(Failure::Usage, message)
}

/// Refuses what only noise maps have, of another kind.
pub(super) fn refuse_options(arguments: &SampleArgs) -> Result<(), CommandError> {
    let noise = &arguments.noise;
    let given = [
        ("--instances", noise.instances.is_some()),
        ("--rotation", noise.rotation.is_some()),
        ("--scales", noise.scales.is_some()),
        ("--shears", noise.shears.is_some()),
        ("--mirrored", noise.mirrored.is_some()),
        ("--density-map", noise.density_map.is_some()),
    ];
    match given.iter().find(|(_, is_given)| *is_given) {
        None => Ok(()),
        Some((option, _)) => Err(usage(format!(
            "{option}: only a noise-map has copies; leave the option out"
        ))),
    }
}

/// Makes the noise map and writes it.
///
/// # Errors
/// [`Failure::Usage`] for options out of range, [`Failure::Input`] for a density that cannot be read, [`Failure::Output`] if the file
/// cannot be written.
pub(super) fn run(arguments: &SampleArgs, console: &Console) -> Result<(), CommandError> {
    let given = &arguments.noise;
    let output = &arguments.output;
    paths::check(given.density_map.as_deref(), &[("--output", output)])?;
    let of_maps = [
        ("--scale", arguments.scale.is_some()),
        ("--roughness", arguments.roughness.is_some()),
        ("--density", arguments.density.is_some()),
    ];
    if let Some((option, _)) = of_maps.iter().find(|(_, is_given)| *is_given) {
        return Err(usage(format!(
            "{option}: a noise-map has no features; see --scales, --rotation and --density-map"
        )));
    }
    let mut options =
        NoiseOptions::new(given.instances.unwrap_or(DEFAULT_INSTANCES), arguments.seed);
    options.rotation = given.rotation.unwrap_or(options.rotation);
    options.scale = given.scales.unwrap_or(options.scale);
    options.shear = given.shears.unwrap_or(options.shear);
    options.mirrored = given.mirrored.unwrap_or(options.mirrored);
    options.density = given.density_map.as_deref().map(density).transpose()?;
    let noise = noise::generate(&options)?;
    let is_exr = output
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
    let (columns, rows) = sides(noise.copies.len());
    if is_exr {
        write_exr(output, &noise.copies, columns, rows)?;
    } else {
        let isotropic = options.shear == [0.0; 2] && options.scale[1] < 16.0;
        if !isotropic {
            return Err(usage(format!(
                "{}: a PNG has rotations, mirrors and scales below 16 only; write an .exr",
                output.display()
            )));
        }
        write_png(output, &noise.copies, columns, rows)?;
    }
    let path = output.display();
    console.line(format_args!(
        "{path}: {} copies, seed {}, {columns} x {rows} pixels",
        noise.copies.len(),
        arguments.seed
    ));
    console.document(&json!({
        "height": rows,
        "instances": noise.copies.len(),
        "kind": "noise-map",
        "output": path.to_string(),
        "seed": arguments.seed,
        "width": columns,
    }));
    Ok(())
}

/// The squarest picture of exactly `count` pixels.
fn sides(count: usize) -> (usize, usize) {
    let rows = (1..=count)
        .take_while(|rows| rows * rows <= count)
        .filter(|rows| count.is_multiple_of(*rows))
        .last()
        .unwrap_or(1);
    (count / rows, rows)
}

/// How dense copies are, from the brightness of a picture.
fn density(path: &Path) -> Result<Density, CommandError> {
    let raster = image::read(path, &ReadOptions::default())?;
    let channels = raster.header().layout.channels();
    let samples: Vec<f64> = match raster.samples() {
        Samples::U8(samples) => samples.iter().map(|&x| f64::from(x)).collect(),
        Samples::U16(samples) => samples.iter().map(|&x| f64::from(x)).collect(),
        Samples::F32(samples) => samples.iter().map(|&x| f64::from(x)).collect(),
    };
    // Brightness is the first one or three channels; others are alpha.
    let bright = if channels >= 3 { 3 } else { 1 };
    let values = samples
        .chunks_exact(channels)
        .map(|pixel| pixel[..bright].iter().sum::<f64>() / bright as f64)
        .collect();
    Density::new([raster.width(), raster.height()], values)
        .map_err(|error| CommandError::from(error).in_file(path.display()))
}

/// Named channels of 32-bit floats.
fn write_exr(
    path: &Path,
    copies: &[NoiseCopy],
    columns: usize,
    rows: usize,
) -> Result<(), CommandError> {
    let channel = |name: &str, value: &dyn Fn(&NoiseCopy) -> f64| {
        let samples = copies.iter().map(|copy| value(copy) as f32).collect();
        AnyChannel::new(name, FlatSamples::F32(samples))
    };
    let channels = AnyChannels::sort(
        [
            channel("center.x", &|copy| copy.centre[0]),
            channel("center.y", &|copy| copy.centre[1]),
            channel("matrix.xx", &|copy| copy.matrix[0][0]),
            channel("matrix.xy", &|copy| copy.matrix[0][1]),
            channel("matrix.yx", &|copy| copy.matrix[1][0]),
            channel("matrix.yy", &|copy| copy.matrix[1][1]),
        ]
        .into_iter()
        .collect(),
    );
    let layer = Layer::new(
        (columns, rows),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        channels,
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|error| CommandError::new(Failure::Internal, error.to_string()))?;
    publish(path, |file| {
        let mut output = BufWriter::new(file);
        output.write_all(bytes.get_ref())?;
        output.flush()
    })?;
    Ok(())
}

/// Red and green the centre, blue the rotation, alpha mirror and scale.
fn write_png(
    path: &Path,
    copies: &[NoiseCopy],
    columns: usize,
    rows: usize,
) -> Result<(), CommandError> {
    let mut samples = Vec::with_capacity(4 * copies.len());
    for copy in copies {
        let [[xx, xy], [yx, yy]] = copy.matrix;
        let is_mirrored = xx * yy < xy * yx;
        // The second column is the first turned, whether or not that is mirrored: (sin, cos) times the scale.
        let scale = (xy * xy + yy * yy).sqrt();
        let turn = libm::atan2(xy, yy) / core::f64::consts::TAU;
        let whole = |x: f64| libm::round(x) as i64;
        samples.extend([
            (whole(copy.centre[0] * 65536.0) & 0xFFFF) as u16,
            (whole(copy.centre[1] * 65536.0) & 0xFFFF) as u16,
            (whole(turn * 65536.0) & 0xFFFF) as u16,
            whole(scale * 2048.0).clamp(1, 0x7FFF) as u16 | if is_mirrored { 0x8000 } else { 0 },
        ]);
    }
    png::write_rgba16(path, columns as u32, rows as u32, &samples)
}
