//! Roughnesses, in whichever of both measures.

use clap::Args;
use glintbake_format::model::beckmann_from_intrinsic;

/// Roughnesses of the flakes; defaults are the command's.
#[derive(Debug, Args)]
pub struct RoughnessArgs {
    /// Beckmann roughnesses α of the flakes, with commas between
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "ALPHA",
        allow_negative_numbers = true
    )]
    pub roughness: Vec<f64>,

    /// The same as intrinsic roughnesses σr = α / √2
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "SIGMA",
        allow_negative_numbers = true
    )]
    pub intrinsic_roughness: Vec<f64>,
}

impl RoughnessArgs {
    /// Beckmann roughnesses, however they were given.
    pub fn all(&self) -> Vec<f64> {
        let intrinsic = self.intrinsic_roughness.iter().copied();
        let beckmann = self.roughness.iter().copied();
        beckmann
            .chain(intrinsic.map(beckmann_from_intrinsic))
            .collect()
    }
}
