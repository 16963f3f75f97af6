//! The command line, typed.

mod bake;
mod decode;
mod layer;
mod ndf_maps;
mod reference;
mod report;
mod roughness;
mod select;
mod stress;

pub use bake::BakeArgs;
pub use decode::DecodeArgs;
pub use ndf_maps::{NdfMapArgs, NoiseArgs};
pub use reference::ReferenceArgs;
pub use report::ReportArgs;
pub use roughness::RoughnessArgs;
pub use select::{QuerySettings, SettingArgs};
pub use stress::StressArgs;

use crate::exit::EXIT_CODES_HELP;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use glintbake_samples::{KINDS, Kind, MAX_SIDE};
use std::path::PathBuf;

/// The most threads that can be asked for: beyond any machine, and still quick to start.
const MAX_THREADS: i64 = 1024;

/// Bakes normal maps into memory-mappable .glint packages, and inspects, verifies, queries and pictures them.
#[derive(Debug, Parser)]
#[command(name = "glintbake", version, after_help = EXIT_CODES_HELP, max_term_width = 100)]
pub struct Cli {
    /// Say nothing but results and errors
    #[arg(long, short, global = true)]
    pub quiet: bool,

    /// Threads to use, 0 for one per core; the output does not depend on it
    #[arg(
        long,
        global = true,
        default_value_t = 0,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(..=MAX_THREADS)
    )]
    pub threads: u16,

    /// What to do
    #[command(subcommand)]
    pub command: Command,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make a sample normal map as a PNG
    Sample(SampleArgs),
    /// Bake a normal map, or a layered material of several, into a package
    Bake(Box<BakeArgs>),
    /// Write the explicit normal map that a package stands for as a PNG
    Expand(ExpandArgs),
    /// Say what is in a package
    Inspect(InspectArgs),
    /// Check a package; findings are numbered
    Verify(VerifyArgs),
    /// Evaluate the P-NDF for each row of a table
    Query(QueryArgs),
    /// Draw a picture from a package
    Picture(PictureArgs),
    /// Measure every method on maps of yours: error against run time, memory
    Report(Box<ReportArgs>),
    /// Put methods to the test on stiff and extreme cases, against f64 oracles
    Stress(StressArgs),
}

impl Command {
    /// Whether the command was asked for JSON.
    pub fn wants_json(&self) -> bool {
        match self {
            Self::Sample(arguments) => arguments.json,
            Self::Bake(arguments) => arguments.json,
            Self::Expand(arguments) => arguments.json,
            Self::Inspect(arguments) => arguments.json,
            Self::Verify(arguments) => arguments.json,
            Self::Query(arguments) => arguments.json,
            Self::Picture(arguments) => match &arguments.picture {
                Picture::Ndf(arguments) => arguments.json,
                Picture::Ball(arguments) => arguments.json,
            },
            Self::Report(arguments) => arguments.json,
            Self::Stress(arguments) => arguments.json,
        }
    }
}

/// `sample`
#[derive(Debug, Args)]
pub struct SampleArgs {
    /// What the map shows
    #[arg(value_parser = sample_kind())]
    pub kind: SampleKind,

    /// Side in texels, or two sides as in 512x256
    #[arg(long, default_value = "512", value_parser = size)]
    pub size: (u32, u32),

    /// Seed; the same seed gives the same map on every machine
    #[arg(long, default_value_t = 0)]
    pub seed: u64,

    /// Size of features, as a multiple of the kind's own
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub scale: Option<f64>,

    /// Spread of the normals; each kind has its own default
    #[arg(long, value_name = "SPREAD", allow_negative_numbers = true)]
    pub roughness: Option<f64>,

    /// Features per area, as a multiple of the kind's own; for scratches, dents and the pores of leather
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub density: Option<f64>,

    /// Bits of a channel: 8 or 16
    #[arg(long, default_value_t = 16, value_parser = bits)]
    pub bits: u8,

    /// What copies a noise-map has
    #[command(flatten)]
    pub noise: NoiseArgs,

    /// PNG file to write; of a noise-map, PNG or EXR
    #[arg(long, short)]
    pub output: PathBuf,

    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// What `sample` makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleKind {
    /// A normal map.
    Map(Kind),
    /// Where copies of a tiny map lie.
    NoiseMap,
}

/// The name of [`SampleKind::NoiseMap`].
const NOISE_MAP: &str = "noise-map";

/// A parser that lists the kinds, each with its description, in help and errors.
fn sample_kind() -> impl TypedValueParser<Value = SampleKind> {
    let kinds = KINDS
        .iter()
        .map(|kind| PossibleValue::new(kind.name()).help(kind.description()));
    let noise =
        PossibleValue::new(NOISE_MAP).help("places and transformations of copies, for ndf-maps");
    PossibleValuesParser::new(kinds.chain([noise])).try_map(|name| {
        if name == NOISE_MAP {
            return Ok(SampleKind::NoiseMap);
        }
        Kind::from_name(&name)
            .map(SampleKind::Map)
            .ok_or("it is none of the kinds")
    })
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    let side = |side: &str| match side.parse::<u32>() {
        Ok(texels @ 1..=MAX_SIDE) => Ok(texels),
        _ => Err(format!(
            "a side is a whole number of texels from 1 to {MAX_SIDE}"
        )),
    };
    Ok((side(width)?, side(height)?))
}

fn bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("it must be 8 or 16".to_owned()),
    }
}

/// How a package file is opened.
#[derive(Debug, Args)]
pub struct OpenArgs {
    /// Package file
    pub package: PathBuf,

    /// Read the file instead of mapping it
    #[arg(long)]
    pub no_mmap: bool,

    /// Skip the checksums of the data; opening then reads only what the command needs
    #[arg(long)]
    pub trust: bool,
}

/// `inspect`
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// How to open the package
    #[command(flatten)]
    pub open: OpenArgs,

    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// `expand`
#[derive(Debug, Args)]
pub struct ExpandArgs {
    /// How to open the package
    #[command(flatten)]
    pub open: OpenArgs,

    /// Number of the instance [default: the first]
    #[arg(long, value_name = "N")]
    pub instance: Option<u16>,

    /// Texels along each side of a picture of one tile of texture space, for ndf-maps [default: those of the surface]
    #[arg(long, value_name = "TEXELS")]
    pub size: Option<u32>,

    /// PNG file to write, 16 bits a channel
    #[arg(long, short)]
    pub output: PathBuf,

    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// `verify`
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Package file
    pub package: PathBuf,

    /// Check every element, but no checksum
    #[arg(long, conflicts_with = "full")]
    pub structure: bool,

    /// Check every element, checksum and hash (the default)
    #[arg(long)]
    pub full: bool,

    /// Read the file instead of mapping it
    #[arg(long)]
    pub no_mmap: bool,

    /// Print the findings as JSON
    #[arg(long)]
    pub json: bool,
}

/// `query`
#[derive(Debug, Args)]
pub struct QueryArgs {
    /// How to open the package
    #[command(flatten)]
    pub open: OpenArgs,

    /// Table with the columns u,v,e1u,e1v,e2u,e2v,s,t in any order; lines that begin with # are skipped
    #[arg(long, value_name = "CSV")]
    pub queries: PathBuf,

    /// Table to write, the same with a column ndf; standard output if left out
    #[arg(long, short)]
    pub output: Option<PathBuf>,

    /// What to evaluate
    #[command(flatten)]
    pub settings: SettingArgs,

    /// Refine cluster-tree until --eps is proved, and add a column ndf-bound: how far each density can be from the sum over
    /// texels; needs --kernel disk, and takes several times as long
    #[arg(long)]
    pub strict: bool,

    /// Print a summary as JSON; needs --output
    #[arg(long, requires = "output")]
    pub json: bool,
}

/// `picture`
#[derive(Debug, Args)]
pub struct PictureArgs {
    /// What to draw
    #[command(subcommand)]
    pub picture: Picture,
}

/// The pictures.
#[derive(Debug, Subcommand)]
pub enum Picture {
    /// The P-NDF of one footprint over the projected disk, +t up
    Ndf(PictureNdfArgs),
    /// A ball covered with the map, or the layered material, under small lights
    Ball(PictureBallArgs),
}

/// `picture ndf`
#[derive(Debug, Args)]
pub struct PictureNdfArgs {
    /// How to open the package
    #[command(flatten)]
    pub open: OpenArgs,

    /// Centre of the footprint in tiles
    #[arg(long, value_name = "U,V", default_value = "0.5,0.5", value_parser = pair, allow_hyphen_values = true)]
    pub uv: [f64; 2],

    /// Edge of the square footprint in texels (twice its size σ)
    #[arg(long, default_value_t = 32.0, allow_negative_numbers = true)]
    pub texels: f64,

    /// Magnification: s and t run from -1/ZOOM to 1/ZOOM
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    pub zoom: f64,

    /// Side of the picture in pixels
    #[arg(long, default_value_t = 512)]
    pub pixels: u32,

    /// What to evaluate
    #[command(flatten)]
    pub settings: SettingArgs,

    /// What to draw beside it
    #[command(flatten)]
    pub reference: ReferenceArgs,

    /// PNG file to write
    #[arg(long, short)]
    pub output: PathBuf,

    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// `picture ball`
#[derive(Debug, Args)]
pub struct PictureBallArgs {
    /// How to open the package
    #[command(flatten)]
    pub open: OpenArgs,

    /// How often the map repeats around the ball; by default, so that a texel is a third of a pixel in the middle
    #[arg(long, allow_negative_numbers = true)]
    pub tiles: Option<f64>,

    /// Side of the picture in pixels
    #[arg(long, default_value_t = 512)]
    pub pixels: u32,

    /// What to evaluate
    #[command(flatten)]
    pub settings: SettingArgs,

    /// PNG file to write
    #[arg(long, short)]
    pub output: PathBuf,

    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let wanted = || "two numbers with a comma between, such as 0.5,0.5".to_owned();
    let (first, second) = text.split_once(',').ok_or_else(wanted)?;
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(wanted()),
    };
    Ok([number(first)?, number(second)?])
}
