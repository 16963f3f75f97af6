//! Options of `ndf-maps`, and of the noise maps that go with it.

use crate::exit::{CommandError, Failure};
use clap::Args;
use glintbake_bake::noise::{self, NoiseOptions, Transform};
use glintbake_bake::{NdfCopies, NdfMapRecipe};
use std::path::PathBuf;
use std::sync::Arc;

/// Where copies of an example lie, and what their images are.
#[derive(Debug, Args)]
pub struct NdfMapArgs {
    /// Texels along a side of the surface that copies of the map make up, for ndf-maps [default: those of the map, if copies
    /// are tiled]
    #[arg(long, value_name = "TEXELS")]
    pub size: Option<u32>,

    /// Noise map that says where copies of the map lie, and how: an EXR file or a 16-bit PNG; see docs/ndf-maps.md
    #[arg(long, value_name = "FILE", conflicts_with_all = ["tiled", "instances"])]
    pub noise: Option<PathBuf>,

    /// Scatter so many copies by chance, by --seed, turned any way and half of them mirrored, as `sample noise-map` does
    #[arg(long, value_name = "N", conflicts_with = "tiled")]
    pub instances: Option<u32>,

    /// Lay copies close to each other, which is what ndf-maps does unless told otherwise
    #[arg(long)]
    pub tiled: bool,

    /// How tiled copies lie, with commas between: rotate=DEGREES (counter-clockwise), scale=FACTOR or scale=XxY, shear=FACTOR, mirror
    #[arg(long, value_name = "HOW", value_parser = transform, conflicts_with_all = ["noise", "instances"])]
    pub transform: Option<Transform>,

    /// Let the scale and shear of copies change the slopes of their normals, not only where they are
    #[arg(long)]
    pub scale_slopes: bool,

    /// Pixels along a side of each NDF image, as in Xing 2024 (128 or 256), instead of splines as fine as the roughness needs
    #[arg(long, value_name = "N", conflicts_with = "ndf_pitch")]
    pub ndf_pixels: Option<u32>,

    /// Distance of the nodes of NDF images, in standard deviations of the kernel [default: 1]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub ndf_pitch: Option<f64>,

    /// Normal of what no copy covers, as s,t [default: 0,0]
    #[arg(long, value_name = "S,T", value_parser = ground, allow_hyphen_values = true)]
    pub ground: Option<[f64; 2]>,

    /// Beckmann roughness of what no copy covers [default: that of the kernel]
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true)]
    pub ground_roughness: Option<f64>,
}

impl NdfMapArgs {
    /// The surface that is asked for, if any option is given; `seed` is what chance begins with.
    ///
    /// # Errors
    /// If the noise map cannot be read or made.
    pub fn recipe(&self, seed: u64) -> Result<Option<NdfMapRecipe>, CommandError> {
        let copies = match (&self.noise, self.instances) {
            (Some(path), _) => {
                let noise = noise::read(path)
                    .map_err(|error| CommandError::from(glintbake_bake::BakeError::from(error)))?;
                NdfCopies::Scattered(Arc::new(noise))
            }
            (None, Some(instances)) => {
                let noise = noise::generate(&NoiseOptions::new(instances, seed))
                    .map_err(|error| CommandError::new(Failure::Usage, error.to_string()))?;
                NdfCopies::Scattered(Arc::new(noise))
            }
            (None, None) => NdfCopies::Tiled(self.transform.unwrap_or_default()),
        };
        let recipe = NdfMapRecipe {
            size: self.size,
            copies,
            scales_slopes: self.scale_slopes,
            pitch: self.ndf_pitch,
            paper_pixels: self.ndf_pixels,
            ground: self.ground.unwrap_or_default(),
            ground_roughness: self.ground_roughness,
        };
        let is_given = self.tiled || recipe != NdfMapRecipe::default();
        Ok(is_given.then_some(recipe))
    }
}

/// A transformation in words.
fn transform(text: &str) -> Result<Transform, String> {
    let number = |text: &str| {
        text.parse::<f64>()
            .map_err(|_| format!("{text} is no number"))
    };
    let mut transform = Transform::default();
    for part in text.split(',') {
        match part.split_once('=') {
            Some(("rotate", value)) => transform.rotation = number(value)?,
            Some(("shear", value)) => transform.shear = number(value)?,
            Some(("scale", value)) => {
                let (x, y) = value.split_once('x').unwrap_or((value, value));
                transform.scale = [number(x)?, number(y)?];
            }
            None if part == "mirror" => transform.is_mirrored = true,
            _ => {
                return Err(format!(
                    "{part} is none of rotate=DEGREES, scale=FACTOR, shear=FACTOR, mirror"
                ));
            }
        }
    }
    match noise::fault_of(transform.matrix()) {
        None => Ok(transform),
        Some(fault) => Err(fault),
    }
}

/// A point of the disk.
fn ground(text: &str) -> Result<[f64; 2], String> {
    let parsed = text
        .split_once(',')
        .and_then(|(s, t)| Some([s.trim().parse().ok()?, t.trim().parse().ok()?]));
    parsed.ok_or_else(|| "give s and t, as in 0,0".to_owned())
}

/// What chance may do to copies.
#[derive(Debug, Args)]
pub struct NoiseArgs {
    /// Copies of a noise map
    #[arg(long, value_name = "N")]
    pub instances: Option<u32>,

    /// Least and greatest rotation of copies, in degrees, as in 0..90 [default: 0..360]
    #[arg(long, value_name = "RANGE", value_parser = range, allow_hyphen_values = true)]
    pub rotation: Option<[f64; 2]>,

    /// Least and greatest scale of copies, as in 0.5..2 [default: 1..1]
    #[arg(long, value_name = "RANGE", value_parser = range, allow_hyphen_values = true)]
    pub scales: Option<[f64; 2]>,

    /// Least and greatest shear of copies [default: 0..0]
    #[arg(long, value_name = "RANGE", value_parser = range, allow_hyphen_values = true)]
    pub shears: Option<[f64; 2]>,

    /// Share of copies that are mirrored [default: 0.5]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub mirrored: Option<f64>,

    /// Picture that is bright where there are many copies
    #[arg(long, value_name = "FILE")]
    pub density_map: Option<PathBuf>,
}

/// A number, or two with dots between.
fn range(text: &str) -> Result<[f64; 2], String> {
    let (low, high) = text.split_once("..").unwrap_or((text, text));
    match (low.parse(), high.parse()) {
        (Ok(low), Ok(high)) => Ok([low, high]),
        _ => Err("give the least and the greatest, as in 0.5..2".to_owned()),
    }
}
