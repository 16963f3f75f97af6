//! A report as data: what `report.json` holds, and what the table, the CSV and the HTML are made from.
//!
//! docs/REPORT.md documents every field for readers of the file.

use crate::measure::subject::surface_name;
use glintbake_format::model::Interpolation;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What `format` of every report says.
pub const FORMAT: &str = "glintbake-report";
/// The version of the fields; rises when one changes its meaning or goes.
pub const VERSION: u32 = 1;

/// A report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Report {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// Whether every row that was planned is there; `false` while the report is made, and after an interruption.
    pub complete: bool,
    /// What was measured with.
    pub head: Head,
    /// One for each input, in the order of the command line.
    pub maps: Vec<MapReport>,
}

/// What a report was measured with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Head {
    /// Version of glintbake.
    pub glintbake: String,
    /// The command line, file names without folders.
    pub command: String,
    /// Seed of footprints and half vectors.
    pub seed: u64,
    /// The processor's name for itself.
    pub processor: String,
    /// Threads the bakes and oracles had; queries are timed on one.
    pub threads: usize,
    /// Operating system and architecture.
    pub target: String,
    /// Instruction sets that the program was compiled for beyond the target's least.
    pub target_features: String,
    /// The compiler.
    pub compiler: String,
    /// Whether the program was compiled with optimisation: times of another mean little.
    pub optimised: bool,
    /// The smallest step of the clock that was seen, in nanoseconds.
    pub clock_resolution_ns: f64,
}

/// What was measured on one map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct MapReport {
    /// File name without folder.
    pub name: String,
    /// BLAKE3 of the file, in hexadecimal.
    pub blake3: String,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What was baked.
    pub packages: Vec<PackageReport>,
    /// What was asked.
    pub rows: Vec<Row>,
    /// Where the error of binned normals comes from.
    pub sources: Vec<ErrorSources>,
    /// What was planned and could not be measured.
    pub skipped: Vec<Skipped>,
}

impl MapReport {
    /// A report without any measurement yet.
    pub fn new(name: String, blake3: String, width: u32, height: u32) -> Self {
        Self {
            name,
            blake3,
            width,
            height,
            packages: Vec::new(),
            rows: Vec::new(),
            sources: Vec::new(),
            skipped: Vec::new(),
        }
    }
}

/// What was planned and could not be measured, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Skipped {
    /// Who.
    pub contestant: Contestant,
    /// What would have been asked; `None` if the contestant was left out of the whole map.
    pub cell: Option<Cell>,
    /// Why.
    pub reason: String,
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.contestant.name())?;
        if let Some(cell) = &self.cell {
            let roughness = cell.roughness.map(|alpha| format!(", α {alpha:.4}"));
            write!(
                f,
                ", {} σ {} x{}{}",
                cell.filter,
                cell.sigma,
                cell.anisotropy,
                roughness.unwrap_or_default()
            )?;
        }
        write!(f, ": {}", self.reason)
    }
}

/// Who answers: a variant of a method, or a baseline.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Contestant {
    /// What it is to the report.
    pub role: Role,
    /// The method's name; of a baseline its own, such as `exact-scan`.
    pub method: String,
    /// The variant among the method's, such as `bins-45`; empty if there is one only.
    pub variant: String,
}

impl Contestant {
    /// Method and variant in one, such as `flake-bins bins-45`.
    pub fn name(&self) -> String {
        if self.variant.is_empty() {
            self.method.clone()
        } else {
            format!("{} {}", self.method, self.variant)
        }
    }
}

/// What a contestant is to a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// A method of the registry, as recommended or with another knob.
    Method,
    /// What a paper prints.
    Paper,
    /// What there is without any of them.
    Baseline,
}

/// What a contestant takes before it answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct PackageReport {
    /// Who.
    pub contestant: Contestant,
    /// Beckmann roughness α it was baked for; `None` for a method without one.
    pub roughness: Option<f64>,
    /// Bytes of the package, or of what a baseline keeps in memory.
    pub bytes: u64,
    /// The same for each texel of the map.
    pub bytes_per_texel: f64,
    /// Seconds from normals to the package's bytes, the fastest of a few bakes.
    pub bake_seconds: f64,
    /// The most memory the bake added to that of the normals, in bytes; `None` where the system does not tell.
    pub bake_peak_bytes: Option<u64>,
}

/// What a contestant answered in one cell of the plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Row {
    /// Who.
    pub contestant: Contestant,
    /// Name of the kernel, within which rows compare: `beckmann`, `disk` or `bin-average`.
    pub kernel: String,
    /// What the truth takes the map for, within which rows compare as well: `texels`, or the interpolation of a surface between
    /// them, `linear` or `catmull-rom`. Older reports are of texels.
    #[serde(default = "texels")]
    pub surface: String,
    /// What was asked.
    #[serde(flatten)]
    pub cell: Cell,
    /// Half vectors asked for.
    pub queries: usize,
    /// Of these, how many are lit: the truth is at least 1e-6 per steradian.
    pub lit: usize,
    /// Against the common truth of the kernel and the surface: of texels, every one with its own normal.
    pub truth: Errors,
    /// Against the method's own model, computed in f64; `None` for baselines, which have none but the truth.
    pub model: Option<Errors>,
    /// The integral of the contestant's pdf over the hemisphere, estimated from half vectors drawn from its model: 1 less
    /// what it loses. `None` for baselines, and where half vectors are uniform.
    pub energy: Option<Energy>,
    /// Run times.
    pub times: Times,
}

fn texels() -> String {
    surface_name(Interpolation::None).to_owned()
}

/// A cell of the plan: a kind of query.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Cell {
    /// `box` or `gaussian`.
    pub filter: String,
    /// Beckmann roughness α; `None` for a kernel without one.
    pub roughness: Option<f64>,
    /// Size σ of the footprint in texels: half its edge, or of an elongated one half the geometric mean of its edges.
    pub sigma: f64,
    /// Long edge over short edge: 1 for turned squares, 8 for turned rectangles of the same area.
    pub anisotropy: f64,
    /// How half vectors were chosen.
    pub half_vectors: HalfVectors,
}

/// How half vectors are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HalfVectors {
    /// Drawn from the truth under the footprint: those that light really meets.
    Found,
    /// Uniform on the projected disk.
    Uniform,
}

/// How far answers are off, over the queries of a cell. Numbers are shares: 0.01 is 1 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Errors {
    /// `Σ |D − D*| / Σ D*`; `None` if no query is lit.
    pub relative_l1: Option<f64>,
    /// Root of the mean square of D − D*, as a share of the mean of D*; `None` if no query is lit.
    pub rms: Option<f64>,
    /// 99th percentile of |D − D*|, as a share of the largest D*; `None` if no query is lit.
    pub percentile_99: Option<f64>,
    /// Largest |D − D*|, as a share of the largest D*; `None` if no query is lit.
    pub worst: Option<f64>,
    /// Largest D where no query is lit, D* being below 1e-6 per steradian; in the same unit.
    pub worst_unlit: f64,
}

/// An estimate with its own uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Energy {
    /// The estimate; 1 is all.
    pub share: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Run times of a row; `None` for what a contestant does not do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Times {
    /// `eval` in random order.
    pub eval: Timing,
    /// `eval` as neighbouring pixels ask: each footprint beside the last.
    pub eval_coherent: Timing,
    /// `sample`, random order.
    pub sample: Option<Timing>,
    /// `pdf`, random order.
    pub pdf: Option<Timing>,
    /// For what is no point sampling: the relative L1 error that point sampling has, by the ones in this report, when it
    /// may take as long as this contestant's `eval`.
    pub point_sampling_error: Option<f64>,
}

/// Nanoseconds a call, over repetitions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Timing {
    /// Median over repetitions.
    pub median_ns: f64,
    /// First quartile.
    pub low_ns: f64,
    /// Third quartile.
    pub high_ns: f64,
    /// Repetitions.
    pub repetitions: usize,
    /// Calls in each.
    pub calls: usize,
}

/// Where the error of moving normals to bins comes from: relative L1 errors against the truth of sums that do one thing
/// wrong at a time, all computed in f64 from the map, over half vectors drawn from the truth under square boxes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct ErrorSources {
    /// Beckmann roughness α.
    pub roughness: f64,
    /// Size σ of the footprint in texels.
    pub sigma: f64,
    /// Queries.
    pub queries: usize,
    /// Every normal at its bin's centre; weights exact, no bin left out.
    pub centres: f64,
    /// True normals and exact weights, but only of the 45 bins around the half vector.
    pub truncation_45: f64,
    /// The same with the paper's 21 bins.
    pub truncation_21: f64,
    /// True normals, no bin left out, but texels on the outline are in or out by their centre.
    pub boundary: f64,
    /// All of it, with 21 bins: what the published structure answers.
    pub published: f64,
    /// Bin centres and exact weights over 45 bins: what `flake-bins` answers.
    pub ours: f64,
}
