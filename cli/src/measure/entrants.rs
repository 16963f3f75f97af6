//! Who answers the queries of a report: packages of every method and variant, and the baselines.

use super::baselines::exact_scan::ExactScan;
use super::baselines::paper_forest::{LEAF_SIZE, PaperForest, PaperLookup, Traversal};
use super::baselines::point_sampling::PointSampling;
use super::machine::PeakMemory;
use super::plan::Plan;
use super::subject::{self, Subject, Variant};
use crate::report::document::{Contestant, PackageReport, Role, Skipped};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::{BakeError, MethodRecipe, Recipe, bake};
use glintbake_format::model::{
    BinGrid, Binning, Filter, Footprint, HalfVector, Interpolation, Kernel, Neighbourhood, Wrap,
    disk_grid_resolution,
};
use glintbake_runtime::microfacet::beckmann;
use glintbake_runtime::{Ndf, Package, QueryError, SurfaceNdf};
use std::cell::RefCell;
use std::time::Instant;

/// Points a query of naive point sampling.
const POINTS: [u32; 3] = [1, 16, 256];

/// What is there to answer queries on one map.
#[derive(Debug)]
pub struct Field<'m> {
    map: &'m NormalMap,
    baked: Vec<Baked>,
    scan: Option<ExactScan>,
    forests: Vec<(f64, PaperForest)>,
    /// What each of them takes.
    pub packages: Vec<PackageReport>,
    /// What does not fit the map.
    pub skipped: Vec<Skipped>,
}

/// A variant of a method, baked.
#[derive(Debug)]
struct Baked {
    contestant: Contestant,
    recipe: MethodRecipe,
    bytes: Vec<u8>,
}

/// One who answers, for one roughness and filter.
pub struct Entrant<'a> {
    /// Who.
    pub contestant: Contestant,
    /// Rows compare within it.
    pub kernel: Kernel,
    /// What its truth takes the map for; rows compare within it, too.
    pub surface: Interpolation,
    /// Beckmann's α, if the kernel has one.
    pub roughness: Option<f64>,
    /// The method with the variant; `None` for baselines.
    pub subject: Option<(&'static dyn Subject, Variant)>,
    /// The answers.
    pub answers: Box<dyn Answers + 'a>,
}

/// Answers to queries.
pub trait Answers {
    /// D.
    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError>;

    /// A half vector; `None` if the contestant does not sample.
    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Option<Result<Option<HalfVector>, QueryError>> {
        let _ = (footprint, uniform);
        None
    }

    /// The density of [`sample`](Self::sample); `None` likewise.
    fn pdf(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
    ) -> Option<Result<f64, QueryError>> {
        let _ = (footprint, half_vector);
        None
    }
}

impl Answers for SurfaceNdf<'_> {
    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        Ndf::eval(self, footprint, half_vector)
    }

    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Option<Result<Option<HalfVector>, QueryError>> {
        Some(Ndf::sample(self, footprint, uniform))
    }

    fn pdf(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
    ) -> Option<Result<f64, QueryError>> {
        Some(Ndf::pdf(self, footprint, half_vector))
    }
}

/// A function of footprint and half vector that never fails.
struct Baseline<F>(F);

impl<F: Fn(&Footprint, HalfVector) -> f64> Answers for Baseline<F> {
    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        Ok(self.0(footprint, half_vector))
    }
}

impl<'m> Field<'m> {
    /// Bakes every variant that `plan` asks for on `map`, and builds the baselines.
    ///
    /// # Errors
    /// [`BakeError`] if the map or a roughness is out of range.
    pub fn new(map: &'m NormalMap, plan: &Plan) -> Result<Self, BakeError> {
        let mut field = Self {
            map,
            baked: Vec::new(),
            scan: None,
            forests: Vec::new(),
            packages: Vec::new(),
            skipped: Vec::new(),
        };
        for &filter in &plan.filters {
            for &method in &plan.methods {
                let subject = subject::find(method);
                let variants = subject.variants(filter);
                if variants.is_empty() {
                    field.skipped.push(Skipped {
                        contestant: Contestant {
                            role: Role::Method,
                            method: method.name().to_owned(),
                            variant: String::new(),
                        },
                        cell: None,
                        reason: subject::unanswered(method, filter),
                    });
                }
                for variant in variants {
                    for roughness in roughnesses(subject, plan) {
                        field.bake(&variant, roughness, plan.effort.bakes)?;
                    }
                }
            }
        }
        if plan
            .filters
            .iter()
            .all(|&filter| kernels(plan, filter).is_empty())
        {
            return Ok(field);
        }
        if map.wrap() == Wrap::Repeat {
            field.build_scan();
            field.build_forests(plan);
        } else {
            field.skipped.extend(
                [baseline("exact-scan", ""), paper_forest()].map(|contestant| Skipped {
                    contestant,
                    cell: None,
                    reason: "it is for maps that repeat".to_owned(),
                }),
            );
        }
        let normals = size_of_val(map.texels()) as u64;
        for points in POINTS {
            let sampling = field.package(point_sampling(points), None, normals, 0.0, Some(0));
            field.packages.push(sampling);
        }
        Ok(field)
    }

    fn bake(
        &mut self,
        variant: &Variant,
        roughness: Option<f64>,
        bakes: usize,
    ) -> Result<(), BakeError> {
        let contestant = contestant(variant);
        let recipe = variant.recipe_for(roughness.unwrap_or_default());
        let is_done = |baked: &Baked| baked.contestant == contestant && baked.recipe == recipe;
        let is_skipped = |skipped: &Skipped| skipped.contestant == contestant;
        if self.baked.iter().any(is_done) || self.skipped.iter().any(is_skipped) {
            return Ok(());
        }
        let whole = Recipe::new(vec![recipe.clone()]);
        let mut seconds = f64::INFINITY;
        let mut peak = None;
        let mut bytes = Vec::new();
        for _ in 0..bakes {
            let watch = PeakMemory::watch();
            let start = Instant::now();
            bytes = match bake(self.map, &whole, None) {
                Ok(plan) => plan.to_bytes(),
                // Roughness is checked before; what is left is the variant's, such as a level that a small map lacks.
                Err(error @ BakeError::Option { .. }) => {
                    self.skipped.push(Skipped {
                        contestant,
                        cell: None,
                        reason: error.to_string(),
                    });
                    return Ok(());
                }
                Err(error) => return Err(error),
            };
            seconds = seconds.min(start.elapsed().as_secs_f64());
            peak = peak.max(watch.added());
        }
        self.packages.push(self.package(
            contestant.clone(),
            roughness,
            bytes.len() as u64,
            seconds,
            peak,
        ));
        self.baked.push(Baked {
            contestant,
            recipe,
            bytes,
        });
        Ok(())
    }

    fn build_scan(&mut self) {
        let watch = PeakMemory::watch();
        let start = Instant::now();
        let scan = ExactScan::new(self.map);
        let seconds = start.elapsed().as_secs_f64();
        let bytes = scan.bytes();
        self.packages.push(self.package(
            baseline("exact-scan", ""),
            None,
            bytes,
            seconds,
            watch.added(),
        ));
        self.scan = Some(scan);
    }

    fn build_forests(&mut self, plan: &Plan) {
        let filters = &plan.filters;
        if !filters
            .iter()
            .any(|&filter| kernels(plan, filter).contains(&Kernel::Beckmann))
        {
            return;
        }
        for &roughness in &plan.roughness {
            let Some(grid) = BinGrid::new(Binning::DiskGrid, disk_grid_resolution(roughness))
            else {
                continue;
            };
            let watch = PeakMemory::watch();
            let start = Instant::now();
            let forest = PaperForest::new(self.map, grid, LEAF_SIZE);
            let seconds = start.elapsed().as_secs_f64();
            let texels = self.map.texels().len() as f64;
            // Sampling needs the bin map besides, an integer a texel.
            let bytes = ((forest.bytes_per_texel() + 4.0) * texels) as u64;
            let report = self.package(
                paper_forest(),
                Some(roughness),
                bytes,
                seconds,
                watch.added(),
            );
            self.packages.push(report);
            self.forests.push((roughness, forest));
        }
    }

    fn package(
        &self,
        contestant: Contestant,
        roughness: Option<f64>,
        bytes: u64,
        bake_seconds: f64,
        bake_peak_bytes: Option<u64>,
    ) -> PackageReport {
        PackageReport {
            contestant,
            roughness,
            bytes,
            bytes_per_texel: bytes as f64 / self.map.texels().len() as f64,
            bake_seconds,
            bake_peak_bytes,
        }
    }

    /// Everyone who answers with footprints weighed by `filter`.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] of a package just baked, which would be a defect.
    pub fn entrants(&self, plan: &Plan, filter: Filter) -> Result<Vec<Entrant<'_>>, QueryError> {
        let mut entrants = Vec::new();
        for &method in &plan.methods {
            let subject = subject::find(method);
            for roughness in roughnesses(subject, plan) {
                for variant in subject.variants(filter) {
                    let (contestant, recipe) = (
                        contestant(&variant),
                        variant.recipe_for(roughness.unwrap_or_default()),
                    );
                    let baked = self
                        .baked
                        .iter()
                        .find(|baked| baked.contestant == contestant && baked.recipe == recipe);
                    let Some(baked) = baked else { continue };
                    let package = Package::open(&baked.bytes).map_err(QueryError::Damaged)?;
                    entrants.push(Entrant {
                        contestant,
                        kernel: variant.kernel(),
                        surface: subject.surface(&variant),
                        roughness,
                        answers: Box::new(variant.ask(package.ndf(1)?, filter)?),
                        subject: Some((subject, variant)),
                    });
                }
            }
        }
        for kernel in kernels(plan, filter) {
            for &roughness in &plan.roughness {
                self.add_baselines(kernel, roughness, filter, &mut entrants);
            }
        }
        Ok(entrants)
    }

    fn add_baselines<'a>(
        &'a self,
        kernel: Kernel,
        roughness: f64,
        filter: Filter,
        entrants: &mut Vec<Entrant<'a>>,
    ) {
        let mut add = |contestant, answers: Box<dyn Answers + 'a>| {
            entrants.push(Entrant {
                contestant,
                kernel,
                surface: Interpolation::None,
                roughness: Some(roughness),
                subject: None,
                answers,
            });
        };
        if let Some(scan) = &self.scan {
            let eval = move |footprint: &Footprint, half_vector| {
                scan.eval(footprint, half_vector, filter, kernel, roughness)
            };
            add(baseline("exact-scan", ""), Box::new(Baseline(eval)));
        }
        for points in POINTS {
            let sampling = PointSampling {
                map: self.map,
                points,
            };
            let eval = move |footprint: &Footprint, half_vector| {
                sampling.eval(footprint, half_vector, filter, kernel, roughness)
            };
            add(point_sampling(points), Box::new(Baseline(eval)));
        }
        let forest = self.forests.iter().find(|(baked, _)| *baked == roughness);
        if let (Kernel::Beckmann, Filter::Box, Some((_, forest))) = (kernel, filter, forest) {
            let grid = BinGrid::new(Binning::DiskGrid, disk_grid_resolution(roughness))
                .expect("the forest was built for it");
            let lookup = RefCell::new(PaperLookup::new(forest, Traversal::Together));
            let eval = move |footprint: &Footprint, half_vector: HalfVector| {
                let direction = half_vector.direction();
                let mut sum = 0.0;
                lookup.borrow_mut().bin_weights(
                    footprint,
                    half_vector,
                    Neighbourhood::Bins21,
                    &mut |column, row, weight| {
                        let centre = grid.centre(column, row);
                        sum += weight * beckmann::density(direction, centre, roughness);
                    },
                );
                sum
            };
            add(paper_forest(), Box::new(Baseline(eval)));
        }
    }
}

/// The kernels that methods of `plan` answer with for texels under `filter`: those that baselines are for.
fn kernels(plan: &Plan, filter: Filter) -> Vec<Kernel> {
    let mut kernels = Vec::new();
    for &method in &plan.methods {
        let subject = subject::find(method);
        if !subject.is_rough() {
            continue;
        }
        let variants = subject.variants(filter).into_iter();
        let of_texels = variants.filter(|variant| subject.surface(variant) == Interpolation::None);
        for kernel in of_texels.map(|variant| variant.kernel()) {
            if !kernels.contains(&kernel) {
                kernels.push(kernel);
            }
        }
    }
    kernels
}

/// The roughnesses that `subject` is baked for.
fn roughnesses(subject: &dyn Subject, plan: &Plan) -> Vec<Option<f64>> {
    if subject.is_rough() {
        plan.roughness.iter().copied().map(Some).collect()
    } else {
        vec![None]
    }
}

fn contestant(variant: &Variant) -> Contestant {
    Contestant {
        role: if variant.is_paper {
            Role::Paper
        } else {
            Role::Method
        },
        method: variant.recipe.method.name().to_owned(),
        variant: variant.name.clone(),
    }
}

/// A faithful build of the structure of \[AWKK21\] §5.4, with 21 bins.
fn paper_forest() -> Contestant {
    Contestant {
        role: Role::Paper,
        method: "paper-forest".to_owned(),
        variant: "21 bins".to_owned(),
    }
}

fn point_sampling(points: u32) -> Contestant {
    let name = match points {
        1 => "1 point".to_owned(),
        _ => format!("{points} points"),
    };
    baseline("point-sampling", &name)
}

fn baseline(method: &str, variant: &str) -> Contestant {
    Contestant {
        role: Role::Baseline,
        method: method.to_owned(),
        variant: variant.to_owned(),
    }
}
