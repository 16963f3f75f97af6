//! `cluster-tree`: one structure for every roughness, both kernels and both kinds of footprint.
//!
//! This project's own: docs/cluster-tree.md has the structure, the analysis of errors and the comparison with the papers.
//! `D(s) = Σ_k w_k K(s - t_k)` is a sum over points of position and normal. A tree over these points keeps, for each
//! cluster, a box and the moments of its normals, which answer for any kernel much wider than the cluster:
//!
//! - a cluster whose normals are all too far from s, or that the footprint misses, is *skipped*;
//! - one that is narrow beside the kernel, and under one weight of the footprint, is *accepted* as a Gaussian;
//! - any other is *opened*, in the end down to single texels with their own normals and exact weights.
//!
//! ```text
//! footprint ──cover──► tiles ──walk──► clusters and texels ──lobe──► D, facets
//!                                 region: weights
//! ```

mod accuracy;
mod border;
mod cover;
mod find;
mod lanes;
mod lobe;
mod raster;
mod region;
mod sinks;
mod strict;
mod walk;

pub use accuracy::Accuracy;
pub use strict::Bounded;

use super::bin_weights::check_finite;
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::microfacet::{Masking, beckmann};
use crate::overlap::{GaussianFootprint, Outline, Parallelogram};
use crate::scan::MapShape;
use crate::simd::Instructions;
use accuracy::Knobs;
use core::f64::consts::{PI, TAU};
use cover::{under_box, under_gaussian, whole_map};
use glintbake_format::model::{
    Filter, Footprint, HalfVector, Kernel, Wrap, intrinsic_from_beckmann,
};
use glintbake_format::records::Instance;
use glintbake_format::view::{ClusterTree as Tree, Raster};
use glintbake_format::{Container, Fault, Finding};
use lobe::{Beckmann, Disk, Lobe, NarrowBeckmann};
use region::{BoxRegion, GaussianRegion, Region};
use sinks::{Sum, Visit};
use walk::{Centre, Sink, Walk};

/// Least deviation of a Gaussian, in tiles, from which its copies add up to the same everywhere, within 6e-9.
const EVEN_DEVIATION: f64 = 1.0;

/// What pdf counts down to: terms of e^-this.
const PDF_REACH: f32 = 16.0;

/// Below this eps a strict answer opens everything.
const LEAST_EPS: f64 = 1e-8;

/// The P-NDF of a `cluster-tree` instance.
#[derive(Clone, Copy, Debug)]
pub struct ClusterTree<'a> {
    instance: Instance,
    tree: Tree<'a>,
    raster: Option<Raster<'a>>,
    masking: Masking<'a>,
    kernel: Kernel,
    /// Beckmann's α.
    roughness: f64,
    pub(super) filter: Filter,
    accuracy: Accuracy,
    instructions: Instructions,
}

impl<'a> ClusterTree<'a> {
    /// The least and the greatest Beckmann roughness α it answers for.
    pub const ROUGHNESS: [f64; 2] = [1e-4, 1.0];

    /// The P-NDF of `instance` of `container`, which must have been baked for this method.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, QueryError> {
        let roughness = instance
            .roughness
            .ok_or(Finding::new(Fault::InstanceField))?;
        Ok(Self {
            instance: *instance,
            tree: Tree::of_map(container, instance)?,
            raster: Raster::of_map(container, instance)?,
            masking: Masking::of_map(container, instance)?,
            kernel: instance.kernel(),
            roughness,
            filter: instance.filter,
            accuracy: Accuracy::default(),
            instructions: Instructions::default(),
        })
    }

    /// The same P-NDF for Beckmann roughness `alpha` (intrinsic roughness α / √2), whatever was baked; the instance's unless this
    /// says otherwise. Nothing is computed ahead, so every call may have another.
    ///
    /// # Errors
    /// [`QueryError::RoughnessRange`] if `alpha` does not lie between 1e-4 and 1.
    pub fn with_roughness(mut self, alpha: f64) -> Result<Self, QueryError> {
        self.roughness = super::within(Self::ROUGHNESS, alpha)?;
        self.instance.roughness = Some(alpha);
        Ok(self)
    }

    /// The same P-NDF of another kernel, Beckmann's or the disk's; that of the instance unless this says otherwise.
    ///
    /// # Errors
    /// [`QueryError::KernelUnsupported`] of the average over bins, which this method does not have.
    pub fn with_kernel(mut self, kernel: Kernel) -> Result<Self, QueryError> {
        if kernel == Kernel::BinAverage {
            return Err(QueryError::KernelUnsupported(self.instance.method));
        }
        self.kernel = kernel;
        Ok(self)
    }

    /// The same P-NDF under another filter; that of the instance unless this says otherwise.
    #[must_use]
    pub fn with_filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// The same P-NDF within another error; [`Accuracy::default`] unless this says otherwise.
    #[must_use]
    pub fn with_accuracy(mut self, accuracy: Accuracy) -> Self {
        self.accuracy = accuracy;
        self
    }

    /// The same P-NDF by other instructions; the fastest unless this says otherwise. Both give the same bits.
    #[must_use]
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.instructions = instructions;
        self
    }

    /// The kernel densities are of.
    pub const fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Beckmann's roughness α of the kernel; its σr is α / √2.
    pub const fn roughness(&self) -> f64 {
        self.roughness
    }

    /// The filter that weighs footprints.
    pub const fn filter(&self) -> Filter {
        self.filter
    }

    /// The error asked for.
    pub const fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    /// The raster, if there is one and its rounding is within the error asked for.
    fn raster(&self) -> Option<&Raster<'a>> {
        let sigma = intrinsic_from_beckmann(self.roughness);
        self.raster
            .as_ref()
            .filter(|raster| raster::is_fine_enough(raster, sigma, self.accuracy.eps()))
    }

    /// Whether a footprint is small enough to be scanned, if there is a raster.
    fn is_scanned(&self, footprint: &Footprint) -> Result<bool, QueryError> {
        let (shape, sigma) = (self.shape(), intrinsic_from_beckmann(self.roughness));
        let (width, height) = (shape.width, shape.height);
        Ok(match self.filter {
            Filter::Box => {
                let placed = Parallelogram::new(footprint, width, height, shape.wrap)?;
                raster::serves_box(shape, &placed, sigma)
            }
            Filter::Gaussian => {
                let placed = GaussianFootprint::new(footprint, width, height, shape.wrap)?;
                raster::serves_gaussian(shape, &placed, sigma)
            }
        })
    }

    fn shape(&self) -> MapShape {
        MapShape {
            width: self.instance.width,
            height: self.instance.height,
            wrap: self.instance.wrap,
        }
    }

    /// Hands `sink` all that adds to the density at `half_vector`, in units of the peak.
    fn sum<S: Sink>(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        knobs: Knobs,
        raster: Option<&Raster<'a>>,
        sink: S,
    ) -> Result<S, QueryError> {
        let knobs = match self.filter {
            Filter::Box => {
                let [[a, b], [c, d]] = [footprint.edge_1, footprint.edge_2];
                let size = f64::from(self.instance.width) * f64::from(self.instance.height);
                knobs.for_box((a * d - b * c).abs() * size)
            }
            Filter::Gaussian => knobs,
        };
        let sigma = intrinsic_from_beckmann(self.roughness);
        let centre = Centre {
            point: [half_vector.s, half_vector.t],
            scale: 1.0 / sigma,
        };
        match self.kernel {
            Kernel::Disk => self.under(footprint, half_vector, centre, Disk, knobs, raster, sink),
            Kernel::Beckmann | Kernel::BinAverage => {
                let limit = knobs.limits.exponent;
                if let Some(lobe) = NarrowBeckmann::new(half_vector, sigma, limit) {
                    return self.under(footprint, half_vector, centre, lobe, knobs, raster, sink);
                }
                let lobe = Beckmann::new(half_vector, sigma);
                self.under(footprint, half_vector, centre, lobe, knobs, raster, sink)
            }
        }
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "what a query is made of, and what may answer it"
    )]
    fn under<L: Lobe, S: Sink>(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        centre: Centre,
        lobe: L,
        knobs: Knobs,
        raster: Option<&Raster<'a>>,
        sink: S,
    ) -> Result<S, QueryError> {
        let (shape, tree, instructions) = (self.shape(), &self.tree, self.instructions);
        let sigma = 1.0 / centre.scale;
        match self.filter {
            Filter::Box => {
                let placed = Parallelogram::new(footprint, shape.width, shape.height, shape.wrap)?;
                if !half_vector.is_on_disk() {
                    return Ok(sink);
                }
                if let Some(raster) = raster
                    && raster::serves_box(shape, &placed, sigma)
                {
                    let query = raster::Query::new(raster, tree, shape, centre, lobe, knobs);
                    return raster::under_box(&query, &placed, sink);
                }
                let outline = Outline::new(&placed);
                let region = BoxRegion::new(&placed, outline.as_ref(), S::STRICT, knobs.blur);
                let mut walk =
                    Walk::new(tree, region, lobe, centre, knobs.limits, instructions, sink);
                walk.set_unit(region.unit());
                under_box(shape, tree, &region, &mut walk)?;
                if shape.wrap == Wrap::Clamp && !shape.holds(&placed) {
                    border::under_box(tree, &placed, &mut walk)?;
                }
                Ok(walk.sink)
            }
            Filter::Gaussian => {
                let placed =
                    GaussianFootprint::new(footprint, shape.width, shape.height, shape.wrap)?;
                if !half_vector.is_on_disk() {
                    return Ok(sink);
                }
                if let Some(raster) = raster
                    && raster::serves_gaussian(shape, &placed, sigma)
                {
                    let query = raster::Query::new(raster, tree, shape, centre, lobe, knobs);
                    return raster::under_gaussian(&query, &placed, sink);
                }
                let region = GaussianRegion::new(&placed, knobs.weight);
                let mut walk =
                    Walk::new(tree, region, lobe, centre, knobs.limits, instructions, sink);
                let size = [f64::from(shape.width), f64::from(shape.height)];
                if shape.wrap == Wrap::Repeat
                    && placed.least_deviation_in_tiles(size[0], size[1]) >= EVEN_DEVIATION
                {
                    walk.set_unit(1.0 / (size[0] * size[1]));
                    whole_map(tree, 1.0, &mut walk)?;
                    walk.run()?;
                    return Ok(walk.sink);
                }
                walk.set_unit(region.unit());
                let limit = knobs.limits.exponent;
                under_gaussian(shape, tree, &placed, &region, limit, &mut walk)?;
                if shape.wrap == Wrap::Clamp {
                    border::under_gaussian(tree, &placed, &mut walk)?;
                }
                Ok(walk.sink)
            }
        }
    }

    /// The density at `half_vector`, and a bound of its distance from the sum over the texels of the map as it was baked.
    ///
    /// The bound is proved, in docs/cluster-tree.md, and counts what was skipped, clusters that stand for their texels, rounding in
    /// records, weights and arithmetic. With [`Accuracy::Strict`] the answer is refined until the bound is small enough; else the
    /// answer is that of [`Ndf::eval`]. A half vector beyond the disk has density 0 within 0.
    ///
    /// # Errors
    /// As [`Ndf::facets`], and [`QueryError::KernelUnsupported`] unless the kernel is the disk's.
    pub fn eval_bounded(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
    ) -> Result<Bounded, QueryError> {
        if self.kernel != Kernel::Disk {
            return Err(QueryError::KernelUnsupported(self.instance.method));
        }
        check_finite(half_vector)?;
        let scanned = match self.accuracy {
            Accuracy::Fast(_) => self.raster(),
            Accuracy::Strict(_) => self.raster.as_ref(),
        };
        if let Some(raster) = scanned
            && self.is_scanned(footprint)?
        {
            // Texels that are read anyway may as well count.
            let knobs = match self.accuracy {
                Accuracy::Fast(eps) => Knobs::of(eps, self.filter),
                Accuracy::Strict(_) => Knobs::finest(),
            };
            let sink = strict::Strict::new();
            let sum = self.sum(footprint, half_vector, knobs, Some(raster), sink)?;
            let bounded = sum.finish(self, knobs, half_vector);
            match self.accuracy {
                // Rounding of the raster may be too much of a narrow lobe; the tree's leaves round less.
                Accuracy::Strict(wanted) if bounded.bound > wanted * bounded.density => {}
                _ => return Ok(bounded),
            }
        }
        let mut eps = self.accuracy.eps();
        loop {
            let is_finest = eps < LEAST_EPS;
            let knobs = if is_finest {
                Knobs::finest()
            } else {
                Knobs::of(eps, self.filter)
            };
            let sink = strict::Strict::new();
            let sum = self.sum(footprint, half_vector, knobs, None, sink)?;
            let bounded = sum.finish(self, knobs, half_vector);
            match self.accuracy {
                Accuracy::Strict(wanted)
                    if bounded.bound > wanted * bounded.density && !is_finest =>
                {
                    eps *= 0.01;
                }
                _ => return Ok(bounded),
            }
        }
    }

    /// Visits facets as [`Ndf::facets`] does, within `knobs`.
    fn facets_within(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        knobs: Knobs,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        check_finite(half_vector)?;
        let sink = Visit {
            visit,
            half_vector,
            sigma: intrinsic_from_beckmann(self.roughness),
            peak: self.peak(),
            unit: 1.0,
        };
        self.sum(footprint, half_vector, knobs, self.raster(), sink)?;
        Ok(())
    }

    /// Whether a texel of the normal `normal` counts at `half_vector` in [`Ndf::pdf`], whatever rounding does.
    fn is_within_reach(&self, normal: HalfVector, half_vector: HalfVector) -> bool {
        let sigma = intrinsic_from_beckmann(self.roughness);
        let s = ((normal.s - half_vector.s) / sigma) as f32;
        let t = ((normal.t - half_vector.t) / sigma) as f32;
        let [exponent, factor] = match self.kernel {
            Kernel::Disk => Disk.exponent(s, t),
            Kernel::Beckmann | Kernel::BinAverage => {
                Beckmann::new(half_vector, sigma).exponent(s, t)
            }
        };
        exponent <= PDF_REACH - 0.5 && factor > 0.0
    }

    /// The density of the kernel at its middle: 1 / (π α²) = 1 / (2π σr²).
    fn peak(&self) -> f64 {
        1.0 / (PI * self.roughness * self.roughness)
    }

    /// The texel, of the map, that two numbers in [0, 1) choose by the footprint's weight.
    fn texel_under(
        &self,
        footprint: &Footprint,
        uniform: [f64; 2],
    ) -> Result<(u32, u32), QueryError> {
        let shape = self.shape();
        Ok(match self.filter {
            Filter::Box => {
                let placed = Parallelogram::new(footprint, shape.width, shape.height, shape.wrap)?;
                shape.texel_at(&placed, uniform[0] - 0.5, uniform[1] - 0.5)
            }
            Filter::Gaussian => {
                let placed =
                    GaussianFootprint::new(footprint, shape.width, shape.height, shape.wrap)?;
                shape.fold(placed.sample(uniform))
            }
        })
    }
}

impl Ndf for ClusterTree<'_> {
    fn instance(&self) -> &Instance {
        &self.instance
    }

    fn masking(&self) -> Masking<'_> {
        self.masking
    }

    /// Visits a facet for each texel that is near enough, and one for each cluster that stands for its texels.
    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        let knobs = Knobs::of(self.accuracy.eps(), self.filter);
        self.facets_within(footprint, half_vector, knobs, visit)
    }

    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        if let Accuracy::Strict(_) = self.accuracy {
            return Ok(self.eval_bounded(footprint, half_vector)?.density);
        }
        check_finite(half_vector)?;
        let knobs = Knobs::of(self.accuracy.eps(), self.filter);
        let sum = self.sum(footprint, half_vector, knobs, self.raster(), Sum::NONE)?;
        Ok(sum.total * self.peak())
    }

    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        let [first, second, third, fourth] = uniform;
        let (column, row) = self.texel_under(footprint, [first, second])?;
        let [s, t] = match self.raster() {
            Some(raster) => raster.normal(column, row)?,
            None => find::normal(&self.tree, column, row)?.normal,
        };
        let normal = HalfVector { s, t };
        let drawn = match self.kernel {
            Kernel::Disk => {
                // Box and Muller 1958; σr √(-2 ln(1 - ξ)) is α √(-ln(1 - ξ)).
                let radius = self.roughness * libm::sqrt(-libm::log1p(-third));
                let (sine, cosine) = libm::sincos(TAU * fourth);
                HalfVector {
                    s: s + radius * cosine,
                    t: t + radius * sine,
                }
            }
            Kernel::Beckmann | Kernel::BinAverage => {
                let direction =
                    beckmann::sample(normal.direction(), self.roughness, [third, fourth]);
                if direction[2] <= 0.0 {
                    return Ok(None);
                }
                HalfVector::from_direction(direction)
            }
        };
        // What is drawn has a density: 1e-7 of the kernel lies beyond.
        Ok((drawn.is_on_disk() && self.is_within_reach(normal, drawn)).then_some(drawn))
    }

    /// Of the disk's kernel `D (h·n)` with the surface's normal n; of Beckmann's the sum of its terms times `h·t_k`.
    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        check_finite(half_vector)?;
        let direction = half_vector.direction();
        // Samples reach further than densities count, and none of them may have a density of 0.
        let knobs = Knobs::of(self.accuracy.eps(), self.filter).reaching(PDF_REACH);
        if self.kernel == Kernel::Disk {
            let [.., cosine] = direction;
            let sum = self.sum(footprint, half_vector, knobs, self.raster(), Sum::NONE)?;
            return Ok(sum.total * self.peak() * cosine);
        }
        let mut sum = 0.0;
        self.facets_within(footprint, half_vector, knobs, &mut |facet| {
            let cosine = crate::microfacet::vector::dot(direction, facet.normal);
            sum += facet.density * facet.weight * cosine.max(0.0);
        })?;
        Ok(sum)
    }
}
