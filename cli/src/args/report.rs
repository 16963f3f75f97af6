//! `report`

use super::decode::DecodeArgs;
use super::roughness::RoughnessArgs;
use super::select::{filter, method};
use crate::exit::{CommandError, Failure};
use crate::measure::plan::{Effort, Plan};
use crate::measure::subject;
use crate::report::compare::Thresholds;
use clap::Args;
use glintbake_bake::{MethodRecipe, Recipe};
use glintbake_format::model::{Filter, METHODS, Method, beckmann_from_intrinsic};
use std::path::PathBuf;

/// Intrinsic roughnesses of a full report, from needles on which binned normals show to blunt flakes.
const FULL_ROUGHNESS: [f64; 3] = [0.005, 0.02, 0.08];
/// Intrinsic roughness of a quick one.
const QUICK_ROUGHNESS: [f64; 1] = [0.005];
/// The largest size σ: footprints have edges of at most 256 tiles, which this is of a map of one texel.
const MOST_SIGMA: f64 = 65_536.0;

/// `report`
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Normal maps or height maps, read as `bake` reads them
    #[arg(required = true)]
    pub images: Vec<PathBuf>,

    /// Folder for report.json, report.csv and report.html; made if it is not there
    #[arg(long, short, default_value = "report", value_name = "FOLDER")]
    pub output: PathBuf,

    /// A first look, some 15 s for a map of 512 x 512: boxes, intrinsic roughness 0.005 instead of 0.005, 0.02 and 0.08
    /// unless one is named, fewer queries, shorter timings
    #[arg(long)]
    pub quick: bool,

    /// Methods to measure, with commas between: flake-bins, specular-bins, lean, cluster-tree, lobes, analytic, mip-lobes, ndf-maps; all if left
    /// out
    #[arg(long, value_delimiter = ',', value_parser = method)]
    pub method: Vec<Method>,

    /// By default intrinsic 0.005, 0.02 and 0.08; 0.005 with --quick
    #[command(flatten)]
    pub roughness: RoughnessArgs,

    /// How footprints weigh texels: box, gaussian, or both with a comma between [default: both; box with --quick]
    #[arg(long, value_delimiter = ',', value_parser = filter)]
    pub filter: Vec<Filter>,

    /// Sizes σ of footprints in texels, half their edges, with commas between
    /// [default: a quarter of a texel, four times that, and so on up to the map]
    #[arg(long, value_delimiter = ',', value_name = "TEXELS", value_parser = sigma, allow_negative_numbers = true)]
    pub sigma: Vec<f64>,

    /// Seed of footprints and half vectors
    #[arg(long, default_value_t = 7)]
    pub seed: u64,

    /// Say what is slower, larger or worse than in this report.json
    #[arg(long, value_name = "JSON")]
    pub compare: Option<PathBuf>,

    /// Fail with exit code 1 if anything is worse than that by more, as in error:5%,bytes:2%,time:50%
    #[arg(long, value_name = "LIMITS", requires = "compare")]
    pub fail_on: Option<Thresholds>,

    /// How the images are read
    #[command(flatten)]
    pub decode: DecodeArgs,

    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

fn sigma(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(sigma) if sigma > 0.0 && sigma <= MOST_SIGMA => Ok(sigma),
        _ => Err(format!("it must be a number above 0, at most {MOST_SIGMA}")),
    }
}

/// `values`, or `defaults` if there are none.
fn or<T: Copy>(values: &[T], defaults: &[T]) -> Vec<T> {
    if values.is_empty() { defaults } else { values }.to_vec()
}

impl ReportArgs {
    /// What is measured.
    ///
    /// # Errors
    /// [`Failure::Usage`] if anything cannot be baked or is named twice.
    pub fn plan(&self) -> Result<Plan, CommandError> {
        let given = self.roughness.all();
        let defaults: Vec<f64> = if self.quick {
            QUICK_ROUGHNESS.map(beckmann_from_intrinsic).to_vec()
        } else {
            FULL_ROUGHNESS.map(beckmann_from_intrinsic).to_vec()
        };
        let both = [Filter::Box, Filter::Gaussian];
        let plan = Plan {
            methods: or(&self.method, METHODS),
            roughness: or(&given, &defaults),
            filters: or(&self.filter, if self.quick { &both[..1] } else { &both }),
            sigmas: self.sigma.clone(),
            seed: self.seed,
            effort: if self.quick {
                Effort::QUICK
            } else {
                Effort::FULL
            },
        };
        named_once("--method", &plan.methods, |method| method.name().to_owned())?;
        named_once("--filter", &plan.filters, |filter| filter.name().to_owned())?;
        named_once("--sigma", &plan.sigmas, f64::to_string)?;
        let methods = plan
            .methods
            .iter()
            .map(|&method| MethodRecipe {
                roughness: if subject::find(method).is_rough() {
                    plan.roughness.clone()
                } else {
                    Vec::new()
                },
                ..MethodRecipe::new(method, &[])
            })
            .collect();
        glintbake_bake::check(&Recipe::new(methods))?;
        Ok(plan)
    }
}

fn named_once<T: PartialEq>(
    option: &str,
    values: &[T],
    name: impl Fn(&T) -> String,
) -> Result<(), CommandError> {
    for (place, value) in values.iter().enumerate() {
        if values[..place].contains(value) {
            return Err(CommandError::new(
                Failure::Usage,
                format!("{option} {}: it is named twice", name(value)),
            ));
        }
    }
    Ok(())
}
