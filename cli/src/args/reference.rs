//! What `picture ndf` sets beside a package's answer.

use super::bake::interpolation;
use super::decode::DecodeArgs;
use clap::Args;
use glintbake_format::model::Interpolation;
use std::path::PathBuf;

/// The most samples that can be asked for: an hour or so.
const MOST_SAMPLES: f64 = 1e11;

/// A P-NDF by counting samples.
#[derive(Debug, Args)]
pub struct ReferenceArgs {
    /// Map the package was baked from: what samples of it add up to is drawn to the right, in the same colours (binning, Yan
    /// 2014 Fig. 9); for the kernel disk and the filter gaussian
    #[arg(long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,

    /// Samples of --reference to draw [default: 2e7]
    #[arg(long, value_name = "N", value_parser = samples, requires = "reference")]
    pub samples: Option<u64>,

    /// How normals of --reference continue between texels: none, linear or catmull-rom [default: as those of analytic;
    /// linear for lobes, else none]
    #[arg(long, value_name = "KIND", value_parser = interpolation, requires = "reference")]
    pub interpolate: Option<Interpolation>,

    /// How --reference is read
    #[command(flatten)]
    pub decode: DecodeArgs,
}

impl ReferenceArgs {
    /// Samples of a reference that is asked for without a number of them.
    pub const SAMPLES: u64 = 20_000_000;
}

fn samples(text: &str) -> Result<u64, String> {
    match text.parse::<f64>() {
        Ok(samples) if (1.0..=MOST_SAMPLES).contains(&samples) && samples.fract() == 0.0 => {
            Ok(samples as u64)
        }
        _ => Err(format!(
            "it must be a whole number from 1 to {MOST_SAMPLES:e}, such as 2e7"
        )),
    }
}
