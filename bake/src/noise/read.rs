//! A noise map from an image.

use super::{MAX_COPIES, NoiseCopy, NoiseError, NoiseMap, NoiseSource, Transform, fault_of};
use crate::image::{self, Format, ImageError, Layout, Limits, Raster, ReadOptions, Samples};
use std::path::Path;

const CENTRE: [&str; 2] = ["center.x", "center.y"];
const MATRIX: [&str; 4] = ["matrix.xx", "matrix.xy", "matrix.yx", "matrix.yy"];
const TRANSFORM: [&str; 4] = [
    "transform.rotation",
    "transform.scale",
    "transform.shear",
    "transform.mirror",
];

/// The noise map in the file at `path`, its layout as the module says.
///
/// # Errors
/// [`NoiseError`], with the pixel where one is at fault: more than [`MAX_COPIES`], other channels, centres beyond the surface,
/// transformations that are singular or no numbers.
pub fn read(path: &Path) -> Result<NoiseMap, NoiseError> {
    let options = |channels: Option<&[&str]>| ReadOptions {
        exr_channels: channels.map(|names| names.iter().map(|&name| name.to_owned()).collect()),
        limits: Limits {
            texels: MAX_COPIES as u64,
            ..Limits::default()
        },
        ..ReadOptions::default()
    };
    let input = image::identify(path)?;
    let is_exr = {
        let mut magic = [0; 4];
        let mut file =
            std::fs::File::open(path).map_err(|source| unreadable(&input.name, &source))?;
        let length = std::io::Read::read(&mut file, &mut magic)
            .map_err(|source| unreadable(&input.name, &source))?;
        magic[..length] == [0x76, 0x2F, 0x31, 0x01]
    };
    let source = NoiseSource::of(&input);
    let file = input.name.as_str();
    let copies = if is_exr {
        let centres = image::read(path, &options(Some(&CENTRE)))?;
        match image::read(path, &options(Some(&MATRIX))) {
            Ok(entries) => of_floats(file, &centres, &entries, |[xx, xy, yx, yy]| {
                [[xx, xy], [yx, yy]]
            })?,
            Err(ImageError::Selection { .. }) => {
                let words =
                    image::read(path, &options(Some(&TRANSFORM))).map_err(|error| match error {
                        ImageError::Selection { .. } => NoiseError::Layout {
                            file: file.to_owned(),
                            reason: format!(
                                "beside {} it needs the channels {}, or {}",
                                CENTRE.join(", "),
                                MATRIX.join(", "),
                                TRANSFORM.join(", ")
                            ),
                        },
                        other => other.into(),
                    })?;
                of_floats(
                    file,
                    &centres,
                    &words,
                    |[rotation, scale, shear, mirror]| {
                        Transform {
                            rotation,
                            scale: [scale; 2],
                            shear,
                            is_mirrored: mirror >= 0.5,
                        }
                        .matrix()
                    },
                )?
            }
            Err(other) => return Err(other.into()),
        }
    } else {
        of_words(file, &image::read(path, &options(None))?)?
    };
    Ok(NoiseMap { copies, source })
}

fn unreadable(name: &str, source: &std::io::Error) -> NoiseError {
    NoiseError::Layout {
        file: name.to_owned(),
        reason: source.to_string(),
    }
}

fn of_floats(
    file: &str,
    centres: &Raster,
    entries: &Raster,
    matrix: impl Fn([f64; 4]) -> [[f64; 2]; 2],
) -> Result<Vec<NoiseCopy>, NoiseError> {
    let (Samples::F32(centres_of), Samples::F32(entries_of)) =
        (centres.samples(), entries.samples())
    else {
        return Err(NoiseError::Layout {
            file: file.to_owned(),
            reason: "its channels are no floating-point numbers".to_owned(),
        });
    };
    let pixels = centres_of.chunks_exact(2).zip(entries_of.chunks_exact(4));
    pixels
        .enumerate()
        .map(|(place, (centre, entries))| {
            let copy = NoiseCopy {
                centre: [0, 1].map(|axis| f64::from(centre[axis])),
                matrix: matrix([0, 1, 2, 3].map(|entry| f64::from(entries[entry]))),
            };
            checked(file, copy, place, centres.header().width as usize)
        })
        .collect()
}

fn of_words(file: &str, raster: &Raster) -> Result<Vec<NoiseCopy>, NoiseError> {
    let (Format::Png, Layout::Rgba, Samples::U16(samples)) = (
        raster.header().format,
        &raster.header().layout,
        raster.samples(),
    ) else {
        return Err(NoiseError::Layout {
            file: file.to_owned(),
            reason: "a noise map is an OpenEXR file, or a PNG of 16 bits with red, green, blue and alpha".to_owned(),
        });
    };
    samples
        .chunks_exact(4)
        .enumerate()
        .map(|(place, pixel)| {
            let [x, y, turn, rest] = [0, 1, 2, 3].map(|channel| f64::from(pixel[channel]));
            let is_mirrored = rest >= 32768.0;
            let scale = (rest - if is_mirrored { 32768.0 } else { 0.0 }) / 2048.0;
            let transform = Transform {
                rotation: turn * (360.0 / 65536.0),
                scale: [scale; 2],
                shear: 0.0,
                is_mirrored,
            };
            let copy = NoiseCopy {
                centre: [x / 65536.0, y / 65536.0],
                matrix: transform.matrix(),
            };
            checked(file, copy, place, raster.header().width as usize)
        })
        .collect()
}

/// `copy`, if it is one.
fn checked(
    file: &str,
    copy: NoiseCopy,
    place: usize,
    width: usize,
) -> Result<NoiseCopy, NoiseError> {
    let [x, y] = copy.centre;
    let is_within = |along: f64| (0.0..=1.0).contains(&along);
    let reason = if !(x.is_finite() && y.is_finite()) {
        Some("the centre is no number".to_owned())
    } else if !(is_within(x) && is_within(y)) {
        Some(format!(
            "the centre ({x}, {y}) lies beyond the surface, which reaches from 0 to 1"
        ))
    } else {
        fault_of(copy.matrix)
    };
    match reason {
        None => Ok(copy),
        Some(reason) => Err(NoiseError::Pixel {
            file: file.to_owned(),
            column: place % width,
            row: place / width,
            reason,
        }),
    }
}
