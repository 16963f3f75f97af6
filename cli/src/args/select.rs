//! Which instance of a package answers, and under which setting.

use super::layer;
use crate::exit::{CommandError, Failure};
use clap::Args;
use glintbake_bake::default_filter;
use glintbake_format::model::{
    Filter, Kernel, METHODS, MIP_LANES, Method, beckmann_from_intrinsic, intrinsic_from_beckmann,
};
use glintbake_format::records::Structure;
use glintbake_runtime::ndf::DEFAULT_TOLERANCE;
use glintbake_runtime::{Accuracy, Ndf, Package, Setting, SurfaceNdf};

/// What to evaluate; all of it can be left out.
#[derive(Debug, Args, Clone, Default)]
pub struct SettingArgs {
    /// Layer of a material to answer with, 0 for the top one; the only one that has a map if left out
    #[arg(long, value_name = "N")]
    pub layer: Option<u16>,

    /// Method to answer with, cluster-tree, flake-bins, specular-bins, lean, lobes, analytic, mip-lobes or ndf-maps; the package's first if left
    /// out
    #[arg(long, value_parser = method)]
    pub method: Option<Method>,

    /// Beckmann roughness α: for cluster-tree any from 0.0001 to 1, for lobes, analytic and mip-lobes any from 0.000001 to 10, else one
    /// that was baked; the package's first if left out
    #[arg(
        long,
        value_name = "ALPHA",
        allow_negative_numbers = true,
        conflicts_with = "intrinsic_roughness"
    )]
    pub roughness: Option<f64>,

    /// The same as intrinsic roughness σr = α / √2
    #[arg(long, value_name = "SIGMA", allow_negative_numbers = true)]
    pub intrinsic_roughness: Option<f64>,

    /// How the footprint weighs texels, box (the one filter of ndf-maps) or gaussian (that of lobes, analytic and mip-lobes); the package's default if
    /// left out
    #[arg(long, value_parser = filter)]
    pub filter: Option<Filter>,

    /// How far a Gaussian may range over texels that flake-bins and specular-bins weigh together, as a share of its
    /// peak; 0 weighs every texel exactly [default: 0.125]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, value_parser = tolerance)]
    pub tolerance: Option<f64>,

    /// Kernel of cluster-tree about each normal, beckmann or disk; the package's default if left out
    #[arg(long, value_parser = kernel)]
    pub kernel: Option<Kernel>,

    /// Relative error of cluster-tree to aim at, on average over queries, from 1e-9 to 0.1; the smaller, the slower
    /// [default: 0.002]
    #[arg(long, value_name = "ERROR", allow_negative_numbers = true, value_parser = eps)]
    pub eps: Option<f64>,

    /// Sum of flake-bins over texels with their true normals (Atanasov 2021 eq. 11); needs a package baked with
    /// --exact-normals
    #[arg(long, conflicts_with = "paper")]
    pub exact: bool,

    /// As the method's paper has it: 21 bins of flake-bins (Atanasov 2021 eq. 15) instead of 45, the plain sum of lobes
    /// (Yan 2016), the fitted error functions of analytic (Yan 2014 eq. 9 to 12), levels by area of mip-lobes (Tan 2022 eq. 8)
    #[arg(long)]
    pub paper: bool,
}

/// The method called `name`; for the command line.
pub(super) fn method(name: &str) -> Result<Method, String> {
    Method::from_name(name).ok_or_else(|| {
        let names: Vec<_> = METHODS.iter().map(|method| method.name()).collect();
        format!("the methods are {}", names.join(", "))
    })
}

/// The filter called `name`; for the command line.
pub(super) fn filter(name: &str) -> Result<Filter, String> {
    [Filter::Box, Filter::Gaussian]
        .into_iter()
        .find(|filter| filter.name() == name)
        .ok_or_else(|| "it must be box or gaussian".to_owned())
}

/// The kernel called `name`, of a method that has several; for the command line.
pub(super) fn kernel(name: &str) -> Result<Kernel, String> {
    [Kernel::Beckmann, Kernel::Disk]
        .into_iter()
        .find(|kernel| kernel.name() == name)
        .ok_or_else(|| "it must be beckmann or disk".to_owned())
}

fn eps(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(eps) if (1e-9..=0.1).contains(&eps) => Ok(eps),
        _ => Err("it must be a number from 1e-9 to 0.1".to_owned()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(tolerance) if (0.0..=1.0).contains(&tolerance) => Ok(tolerance),
        _ => Err("it must be a number from 0 to 1".to_owned()),
    }
}

/// Why `option` is refused where `method` answers, and what to do: add to the command line that a tree of `package` answers, and
/// `besides`, if there is one.
fn of_trees_alone(
    option: &str,
    why: &str,
    besides: &str,
    method: Method,
    package: &Package<'_>,
) -> CommandError {
    let remedy = match package.find(Some(Method::ClusterTree), None) {
        Some(_) => format!("add --method cluster-tree{besides}"),
        None => "bake with --method cluster-tree".to_owned(),
    };
    CommandError::new(
        Failure::Usage,
        format!(
            "{option}: {why}, and {} answers; {remedy}, or leave it out",
            method.name()
        ),
    )
}

/// Refuses boxes where `method` answers for Gaussians alone, with a method of `package` that takes them, if there is one.
fn check_boxes(method: Method, package: &Package<'_>) -> Result<(), CommandError> {
    let is_boxed = |method| default_filter(method) == Filter::Box;
    if is_boxed(method) {
        return Ok(());
    }
    let mut others = package.instances().map(|instance| instance.method);
    let remedy = match others.find(|&other| is_boxed(other)) {
        Some(other) => format!("add --method {}", other.name()),
        None => "bake with --method cluster-tree for boxes".to_owned(),
    };
    Err(CommandError::new(
        Failure::Usage,
        format!(
            "--filter box: {} is made for Gaussian footprints; {remedy}, or leave it out",
            method.name()
        ),
    ))
}

/// An instance under a setting, and the words for it.
#[derive(Debug)]
pub struct QuerySettings<'a> {
    /// What answers.
    pub ndf: SurfaceNdf<'a>,
    /// `method=… kernel=… filter=… …`: what a reader of the numbers must know.
    pub description: String,
}

impl SettingArgs {
    /// An option that says how P-NDFs are evaluated, if one is given: not `--paper`, which layered materials have as well.
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--method", self.method.is_some()),
            ("--roughness", self.roughness.is_some()),
            ("--intrinsic-roughness", self.intrinsic_roughness.is_some()),
            ("--filter", self.filter.is_some()),
            ("--tolerance", self.tolerance.is_some()),
            ("--kernel", self.kernel.is_some()),
            ("--eps", self.eps.is_some()),
            ("--exact", self.exact),
        ];
        given
            .iter()
            .find(|(_, is_given)| *is_given)
            .map(|(option, _)| *option)
    }

    /// The instance of `package` these arguments choose.
    ///
    /// # Errors
    /// [`Failure::NotBaked`], with what the package has, if it has no such instance, or section, and
    /// [`Failure::Usage`] for a tolerance without a Gaussian.
    pub fn choose<'a>(&self, package: &Package<'a>) -> Result<QuerySettings<'a>, CommandError> {
        let roughness = self
            .roughness
            .or(self.intrinsic_roughness.map(beckmann_from_intrinsic));
        let layer = layer::choose(package, self.layer)?;
        // A method of every roughness serves one that was not baked, too.
        let of_any_roughness = || {
            package.instances().find(|instance| {
                let is_asked = self.method.is_none_or(|method| method == instance.method);
                let is_layer = layer.is_none_or(|layer| layer == instance.layer);
                is_asked && is_layer && SurfaceNdf::roughness_range(instance.method).is_some()
            })
        };
        let instance = package
            .find_in_layer(layer, self.method, roughness)
            .or_else(of_any_roughness)
            .ok_or_else(|| self.not_baked(package))?;
        self.check(instance.method, roughness, package)?;
        let filter = self.filter.unwrap_or(instance.filter);
        let tolerance = self.tolerance.unwrap_or(DEFAULT_TOLERANCE);
        let tolerance_said = match filter {
            Filter::Box if self.tolerance.is_some() => {
                return Err(CommandError::new(
                    Failure::Usage,
                    "--tolerance: only Gaussian footprints have one; add --filter gaussian, or leave it out",
                ));
            }
            Filter::Gaussian if instance.bins().is_none() && self.tolerance.is_some() => {
                let why = match instance.method {
                    Method::ClusterTree => "has one error for all it does; use --eps instead",
                    _ => "weighs no texels and has none; leave it out",
                };
                return Err(CommandError::new(
                    Failure::Usage,
                    format!("--tolerance: {} {why}", instance.method.name()),
                ));
            }
            Filter::Box => String::new(),
            Filter::Gaussian if instance.bins().is_none() => String::new(),
            // These sum over texels and never weigh any together.
            Filter::Gaussian if self.exact => " tolerance=0".to_owned(),
            Filter::Gaussian => format!(" tolerance={tolerance}"),
        };
        let mut ndf = package
            .ndf(instance.number)?
            .with_filter(filter)
            .with_tolerance(tolerance);
        if self.exact {
            ndf = ndf.with_setting(Setting::Exact)?;
        } else if self.paper {
            ndf = ndf.with_paper_form()?;
        }
        if let (Some(alpha), Some(_)) = (roughness, SurfaceNdf::roughness_range(instance.method)) {
            ndf = ndf.with_roughness(alpha)?;
        }
        let mut kernel = instance.kernel();
        if let SurfaceNdf::ClusterTree(tree) = &mut ndf {
            kernel = self.kernel.unwrap_or(kernel);
            let eps = self.eps.unwrap_or(Accuracy::DEFAULT);
            *tree = tree.with_kernel(kernel)?.with_accuracy(Accuracy::Fast(eps));
        }
        let roughness = ndf
            .instance()
            .roughness
            .map(|alpha| format!(" roughness={alpha}"))
            .unwrap_or_default();
        let structure = match instance.structure {
            Structure::Bins(bins) => format!("bins={}", bins.grid.resolution()),
            Structure::Pyramid { finest_level } => format!("finest-level={finest_level}"),
            Structure::Clusters { .. } => {
                format!("eps={}", self.eps.unwrap_or(Accuracy::DEFAULT))
            }
            Structure::Lobes(lattice) => format!("lobes={}", lattice.name()),
            Structure::MipLobes(layout) => {
                format!("clusters={}", usize::from(layout.blocks) * MIP_LANES)
            }
            Structure::NdfMaps(layout) => format!("example={}", layout.example()),
            Structure::Surface { interpolation } => {
                format!("interpolation={}", interpolation.name())
            }
        };
        let layer = layer
            .map(|layer| format!("layer={layer} "))
            .unwrap_or_default();
        let description = format!(
            "{layer}method={} kernel={} filter={}{tolerance_said}{roughness} {structure} setting={}",
            instance.method.name(),
            kernel.name(),
            filter.name(),
            ndf.setting_name(),
        );
        Ok(QuerySettings { ndf, description })
    }

    /// The same, to be asked for densities with bounds: [`Accuracy::Strict`] of a `cluster-tree`, and said so.
    ///
    /// # Errors
    /// As [`Self::choose`], and [`Failure::Usage`] if what answers has no proof.
    pub fn choose_strict<'a>(
        &self,
        package: &Package<'a>,
    ) -> Result<QuerySettings<'a>, CommandError> {
        let chosen = self.choose(package)?;
        let SurfaceNdf::ClusterTree(tree) = chosen.ndf else {
            let method = chosen.ndf.instance().method;
            let why = "only cluster-tree has bounds that are proved, of its kernel disk";
            let error = of_trees_alone("--strict", why, " --kernel disk", method, package);
            return Err(error);
        };
        if tree.kernel() != Kernel::Disk {
            return Err(CommandError::new(
                Failure::Usage,
                format!(
                    "--strict: bounds are proved for the kernel disk alone, and {} answers; add --kernel disk, or leave it out",
                    tree.kernel().name()
                ),
            ));
        }
        let accuracy = Accuracy::Strict(tree.accuracy().eps());
        Ok(QuerySettings {
            ndf: SurfaceNdf::ClusterTree(tree.with_accuracy(accuracy)),
            description: format!("{} accuracy=strict", chosen.description),
        })
    }

    /// Refuses what `method` does not answer for: options of others, boxes, and a `roughness` out of its range.
    fn check(
        &self,
        method: Method,
        roughness: Option<f64>,
        package: &Package<'_>,
    ) -> Result<(), CommandError> {
        let of_trees = [
            ("--kernel", self.kernel.is_some()),
            ("--eps", self.eps.is_some()),
        ];
        if method != Method::ClusterTree
            && let Some((option, _)) = of_trees.iter().find(|(_, is_given)| *is_given)
        {
            let why = "only cluster-tree has a choice of it";
            return Err(of_trees_alone(option, why, "", method, package));
        }
        if self.filter == Some(Filter::Box) {
            check_boxes(method, package)?;
        }
        match SurfaceNdf::roughness_range(method) {
            Some(range) => self.check_for_any_roughness(method, roughness, range),
            None => Ok(()),
        }
    }

    /// Refuses, for a `method` of every roughness, options of another method and a `roughness` out of `range`.
    fn check_for_any_roughness(
        &self,
        method: Method,
        roughness: Option<f64>,
        [least, most]: [f64; 2],
    ) -> Result<(), CommandError> {
        let has_paper_form = method != Method::ClusterTree;
        let given = [
            ("--exact", "flake-bins", self.exact),
            (
                "--paper",
                "flake-bins, lobes, analytic and mip-lobes",
                self.paper && !has_paper_form,
            ),
        ];
        if let Some((option, owners, _)) = given.iter().find(|(.., is_given)| *is_given) {
            return Err(CommandError::new(
                Failure::NotBaked,
                format!(
                    "{option}: a setting of {owners}, and {} answers, from every texel's own normal; leave it out",
                    method.name()
                ),
            ));
        }
        // Written so that NaN is refused.
        match roughness.filter(|&alpha| !(alpha >= least && alpha <= most)) {
            Some(alpha) => Err(CommandError::new(
                Failure::Usage,
                format!(
                    "{}: Beckmann roughness must lie between {least} and {most}",
                    match self.intrinsic_roughness {
                        Some(sigma) => format!("--intrinsic-roughness {sigma} (roughness {alpha})"),
                        None => format!("--roughness {alpha}"),
                    }
                ),
            )),
            None => Ok(()),
        }
    }

    fn not_baked(&self, package: &Package<'_>) -> CommandError {
        if package.instances().next().is_none() {
            return CommandError::new(
                Failure::NotBaked,
                "the package holds no instance to answer with; bake it again",
            );
        }
        let mut wanted = Vec::new();
        if let Some(method) = self.method {
            wanted.push(format!("method {}", method.name()));
        }
        if let Some(alpha) = self.roughness {
            wanted.push(format!("roughness {alpha}"));
        }
        if let Some(sigma) = self.intrinsic_roughness {
            wanted.push(format!(
                "intrinsic roughness {sigma} (roughness {})",
                beckmann_from_intrinsic(sigma)
            ));
        }
        let baked: Vec<_> = package
            .instances()
            .map(|instance| match instance.roughness {
                _ if SurfaceNdf::roughness_range(instance.method).is_some() => {
                    format!("{} with any roughness", instance.method.name())
                }
                Some(alpha) => format!(
                    "{} with roughness {alpha} (intrinsic {:.6})",
                    instance.method.name(),
                    intrinsic_from_beckmann(alpha)
                ),
                None => match instance.bins() {
                    Some(bins) => format!(
                        "{} with {} bins a side",
                        instance.method.name(),
                        bins.grid.resolution()
                    ),
                    None => instance.method.name().to_owned(),
                },
            })
            .collect();
        CommandError::new(
            Failure::NotBaked,
            format!(
                "{} is not in the package, which holds: {}; choose one of these, or bake again{}",
                wanted.join(" and "),
                baked.join(", "),
                // Another roughness of a method that is there: no need to know it before.
                match self.roughness.or(self.intrinsic_roughness) {
                    Some(_) =>
                        " with the one you need, or with cluster-tree, which answers for all",
                    None => " with the one you need",
                }
            ),
        )
    }
}
