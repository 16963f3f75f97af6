//! `stress`

use super::decode::DecodeArgs;
use clap::Args;
use std::path::PathBuf;

/// `stress`
#[derive(Debug, Args)]
pub struct StressArgs {
    /// Package or map to put to the test; without it, every method on built-in worst cases
    #[arg(value_name = "PACKAGE|MAP")]
    pub subject: Option<PathBuf>,

    /// Fewer maps and roughnesses
    #[arg(long)]
    pub quick: bool,

    /// How a map is read
    #[command(flatten)]
    pub decode: DecodeArgs,

    /// Print the results as JSON, with every setting on every map
    #[arg(long)]
    pub json: bool,
}
