//! What the command line asks for.

use glintbake_format::model::{Filter, Kernel};
use glintbake_runtime::Accuracy;
use std::path::PathBuf;
use std::str::FromStr;

/// How half vectors are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halves {
    /// A normal under the footprint, moved by the kernel.
    Footprint,
    /// Anywhere on the disk.
    Uniform,
}

/// What the command line asks for.
#[derive(Clone, Debug)]
pub struct Options {
    /// Maps by name; all if empty.
    pub names: Vec<String>,
    /// A folder with more maps.
    pub maps: Option<PathBuf>,
    /// Texels along a side of sample maps.
    pub size: u32,
    /// Sizes σ of footprints in texels.
    pub sigmas: Vec<f64>,
    /// Intrinsic roughnesses σr.
    pub roughness: Vec<f64>,
    /// Long edge over short edge.
    pub anisotropy: f64,
    /// How half vectors are drawn.
    pub halves: Halves,
    /// How footprints weigh texels.
    pub filter: Filter,
    /// The kernel.
    pub kernel: Kernel,
    /// Queries of a cell.
    pub queries: usize,
    /// The error that the tree is asked for.
    pub eps: f64,
    /// Whether the tree has a raster of normals beside it.
    pub raster: bool,
    /// Whether the tree makes do without wide vectors.
    pub portable: bool,
    /// Whether the paper's structure takes part.
    pub with_paper: bool,
    /// Where rows go besides.
    pub csv: Option<PathBuf>,
}

impl Options {
    /// What `arguments` ask for.
    ///
    /// # Errors
    /// A message about the first that cannot be.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self {
            names: Vec::new(),
            maps: None,
            size: 2048,
            sigmas: vec![0.25, 1.0, 4.0, 16.0, 64.0, 256.0],
            roughness: vec![0.0025, 0.005, 0.02, 0.08, 0.15],
            anisotropy: 1.0,
            halves: Halves::Footprint,
            filter: Filter::Box,
            kernel: Kernel::Beckmann,
            queries: 2000,
            eps: Accuracy::DEFAULT,
            raster: false,
            portable: false,
            with_paper: true,
            csv: None,
        };
        while let Some(argument) = arguments.next() {
            let option = argument.as_str();
            let mut value = || {
                let value = arguments.next();
                value.ok_or_else(|| format!("{option} needs a value"))
            };
            match option {
                // Cargo adds it.
                "--bench" => {}
                "--maps" => options.maps = Some(value()?.into()),
                "--size" => options.size = number(option, &value()?)?,
                "--sigmas" => options.sigmas = numbers(option, &value()?)?,
                "--rough" => options.roughness = numbers(option, &value()?)?,
                "--shape" => {
                    let shapes = [("square", 1.0), ("8:1", 8.0)];
                    options.anisotropy = one_of(option, &value()?, &shapes)?;
                }
                "--halves" => {
                    let halves = [
                        ("footprint", Halves::Footprint),
                        ("uniform", Halves::Uniform),
                    ];
                    options.halves = one_of(option, &value()?, &halves)?;
                }
                "--filter" => {
                    let filters = [("box", Filter::Box), ("gaussian", Filter::Gaussian)];
                    options.filter = one_of(option, &value()?, &filters)?;
                }
                "--kernel" => {
                    let kernels = [("beckmann", Kernel::Beckmann), ("disk", Kernel::Disk)];
                    options.kernel = one_of(option, &value()?, &kernels)?;
                }
                "--queries" => options.queries = number(option, &value()?)?,
                "--eps" => options.eps = number(option, &value()?)?,
                "--csv" => options.csv = Some(value()?.into()),
                "--raster" => options.raster = true,
                "--portable" => options.portable = true,
                "--no-paper" => options.with_paper = false,
                _ if option.starts_with('-') => {
                    return Err(format!("{option}: not an option; see the head of the file"));
                }
                name => options.names.push(name.to_owned()),
            }
        }
        if options.queries == 0 {
            return Err("--queries: ask one at least".to_owned());
        }
        Ok(options)
    }

    /// Whether the map `name` is asked for.
    pub fn wants(&self, name: &str) -> bool {
        self.names.is_empty() || self.names.iter().any(|wanted| wanted == name)
    }
}

fn number<T: FromStr>(option: &str, text: &str) -> Result<T, String> {
    text.parse()
        .map_err(|_| format!("{option}: {text} is no number"))
}

fn numbers(option: &str, text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(|text| number(option, text)).collect()
}

fn one_of<T: Copy>(option: &str, text: &str, values: &[(&str, T)]) -> Result<T, String> {
    let found = values.iter().find(|(name, _)| *name == text);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<_> = values.iter().map(|(name, _)| *name).collect();
        format!("{option}: {text} is none of {}", names.join(", "))
    })
}
