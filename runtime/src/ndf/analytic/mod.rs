//! `analytic`: the integral of the query's Gaussian over the surface of normals itself.
//!
//! Paper: \[YHJ*14\] Yan, Hašan, Jakob, Lawrence, Marschner, Ramamoorthi, "Rendering Glints on High-Resolution Normal-Mapped Specular
//! Surfaces", 2014. Normals are linear on triangles between texels, two or 32 to a texel, or constant on texels; under a Gaussian
//! footprint and a Gaussian kernel each triangle's share of `D(s) = ∫ G_p(u) G_r(n(u) - s) du` (eq. 6) is the integral of a Gaussian
//! of two dimensions over a triangle (eq. 8). That is found to many digits whatever the slope of the normals, or as the paper
//! does ([`TriangleForm`]). Nothing is precomputed for a roughness: one bake serves all.
//!
//! ```text
//! footprint ──placed──► copies ──box_pyramid──► blocks within reach ──cells──► triangles ──integral──► D
//! ```

mod border;
mod cells;
mod gather;
mod global;
mod integral;
mod placed;
mod surface;

pub use global::GlobalNdf;
pub use integral::TriangleForm;
pub(super) use integral::{Shape, mean};

use super::bin_weights::check_finite;
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::microfacet::Masking;
use crate::simd::Instructions;
use cells::Query;
use core::f64::consts::TAU;
use gather::{Gather, Sink, Total};
use glintbake_format::model::{
    Filter, Footprint, HalfVector, Interpolation, intrinsic_from_beckmann,
};
use glintbake_format::records::{Instance, Structure};
use glintbake_format::view::{self, BoxPyramid, Normals};
use glintbake_format::{Container, Fault, Finding};
use placed::{Frame, Placed};
use surface::Surface;

/// Reaches that queries may ask for, in standard deviations.
const REACHES: core::ops::RangeInclusive<f64> = 1.0..=12.0;

/// Reach of a query that names none: what lies beyond is 3e-7 of a point's peak at most, and 4e-6 of all.
const DEFAULT_REACH: f64 = 5.5;

/// The P-NDF of an `analytic` instance.
#[derive(Clone, Copy, Debug)]
pub struct Analytic<'a> {
    instance: Instance,
    surface: Surface<'a>,
    pyramid: BoxPyramid<'a>,
    global: view::GlobalNdf<'a>,
    masking: Masking<'a>,
    roughness: f64,
    reach: f64,
    form: TriangleForm,
    pub(super) filter: Filter,
    instructions: Instructions,
}

impl<'a> Analytic<'a> {
    /// The least and the greatest Beckmann roughness α it answers for.
    pub const ROUGHNESS: [f64; 2] = [1e-6, 10.0];

    /// The P-NDF of `instance` of `container`, which must have been baked for this method.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, QueryError> {
        let damaged = Finding::new(Fault::InstanceField);
        let roughness = instance.roughness.ok_or(damaged)?;
        let Structure::Surface { interpolation } = instance.structure else {
            return Err(damaged.into());
        };
        Ok(Self {
            instance: *instance,
            surface: Surface {
                normals: Normals::of_map(container, instance)?,
                wrap: instance.wrap,
                interpolation,
            },
            pyramid: BoxPyramid::of_map(container, instance)?,
            global: view::GlobalNdf::open(container, instance)?,
            masking: Masking::of_map(container, instance)?,
            roughness,
            reach: DEFAULT_REACH,
            form: TriangleForm::default(),
            filter: instance.filter,
            instructions: Instructions::default(),
        })
    }

    /// The same P-NDF for Beckmann roughness `roughness` (σr = α / √2), 1e-6 to 10; that of the instance unless this says
    /// otherwise. Nothing is computed ahead.
    ///
    /// # Errors
    /// [`QueryError::RoughnessRange`].
    pub fn with_roughness(mut self, roughness: f64) -> Result<Self, QueryError> {
        self.roughness = super::within(Self::ROUGHNESS, roughness)?;
        self.instance.roughness = Some(roughness);
        Ok(self)
    }

    /// The same P-NDF under another filter, which queries refuse unless it is the Gaussian.
    #[must_use]
    pub fn with_filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// The same P-NDF with triangles integrated in this form; the accurate one unless this says otherwise.
    #[must_use]
    pub fn with_form(mut self, form: TriangleForm) -> Self {
        self.form = form;
        self
    }

    /// The same P-NDF cut off at `sigmas` standard deviations of position and normal together, clamped to 1 to 12; 5.5 unless
    /// this says otherwise. The paper cuts each at 5.
    ///
    /// Points farther away than that have `exp(-sigmas² / 2)` of their peak at most; together they have
    /// `(1 + sigmas² / 2) exp(-sigmas² / 2)` of all energy.
    #[must_use]
    pub fn with_reach(mut self, sigmas: f64) -> Self {
        // Written so that NaN becomes the least.
        self.reach = sigmas.max(*REACHES.start()).min(*REACHES.end());
        self
    }

    /// The same P-NDF with these instructions; the fastest unless this says otherwise. Both give the same bits.
    #[must_use]
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.instructions = instructions;
        self
    }

    /// Beckmann's roughness α of the kernel.
    pub const fn roughness(&self) -> f64 {
        self.roughness
    }

    /// The filter asked for; queries refuse all but the Gaussian.
    pub const fn filter(&self) -> Filter {
        self.filter
    }

    /// How triangles are integrated.
    pub const fn form(&self) -> TriangleForm {
        self.form
    }

    /// Where the Gaussians are cut off, in standard deviations.
    pub const fn reach(&self) -> f64 {
        self.reach
    }

    /// How normals continue between texels.
    pub const fn interpolation(&self) -> Interpolation {
        self.surface.interpolation
    }

    /// The NDF of the whole map, for bounces after the first; of the roughness that the instance was baked with.
    pub const fn global(&self) -> GlobalNdf<'a> {
        GlobalNdf::new(self.global)
    }

    fn sigma(&self) -> f64 {
        intrinsic_from_beckmann(self.roughness)
    }

    /// The kernel's density at its middle.
    fn peak(&self) -> f64 {
        1.0 / (TAU * self.sigma() * self.sigma())
    }

    fn placed(&self, footprint: &Footprint) -> Result<Placed, QueryError> {
        if self.filter != Filter::Gaussian {
            return Err(QueryError::FilterUnsupported(self.instance.method));
        }
        let size = [self.instance.width, self.instance.height];
        Placed::new(footprint, size, self.instance.wrap)
    }

    /// Hands `sink` all of the surface within reach.
    fn gather<S: Sink>(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        sink: S,
    ) -> Result<S, QueryError> {
        check_finite(half_vector)?;
        let placed = self.placed(footprint)?;
        if !half_vector.is_on_disk() {
            return Ok(sink);
        }
        let query = Query {
            frame: Frame::new(&placed),
            placed,
            normal: [half_vector.s, half_vector.t],
            scale: 1.0 / self.sigma(),
            reach_squared: self.reach * self.reach,
            form: self.form,
        };
        self.instructions.run(Gather {
            surface: &self.surface,
            pyramid: &self.pyramid,
            query: &query,
            sink,
        })
    }
}

/// Hands each cell on as a facet.
struct Visit<'v> {
    visit: &'v mut dyn FnMut(Facet),
    half_vector: HalfVector,
    sigma: f64,
    peak: f64,
}

impl Sink for Visit<'_> {
    const EACH: bool = true;

    fn add(&mut self, _: f64) {}

    fn cell(&mut self, amount: f64, [s, t]: [f64; 2], share: f64) {
        // Normals of damaged packages may be no numbers, and then are none.
        let is_number = |x: f64| x.is_finite() && x > 0.0;
        let counts = is_number(amount) && is_number(share) && s.is_finite() && t.is_finite();
        if !counts {
            return;
        }
        let normal = HalfVector {
            s: self.half_vector.s + self.sigma * s,
            t: self.half_vector.t + self.sigma * t,
        };
        (self.visit)(Facet {
            normal: normal.direction(),
            density: self.peak * amount / share,
            weight: share,
        });
    }
}

impl Ndf for Analytic<'_> {
    fn instance(&self) -> &Instance {
        &self.instance
    }

    fn masking(&self) -> Masking<'_> {
        self.masking
    }

    /// Visits a facet for each cell within reach, of the mean normal of its corners and the footprint's share on it.
    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        let sink = Visit {
            visit,
            half_vector,
            sigma: self.sigma(),
            peak: self.peak(),
        };
        self.gather(footprint, half_vector, sink)?;
        Ok(())
    }

    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        let Total(sum) = self.gather(footprint, half_vector, Total(0.0))?;
        Ok(sum * self.peak())
    }

    /// The normal of a random point under the footprint, moved by the kernel, \[YHJ*14\] §6.
    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        let [first, second, third, fourth] = uniform;
        let (place, position) = self.placed(footprint)?.draw([first, second]);
        let [s, t] = self.surface.at(place)?;
        // Box and Muller 1958.
        let squared = -2.0 * libm::log1p(-third);
        let radius = self.sigma() * libm::sqrt(squared);
        let (sine, cosine) = libm::sincos(TAU * fourth);
        let drawn = HalfVector {
            s: s + radius * cosine,
            t: t + radius * sine,
        };
        let is_reached = position + squared <= self.reach * self.reach;
        Ok((drawn.is_on_disk() && is_reached).then_some(drawn))
    }

    /// `D (h·n)` with the surface's normal n, as the kernel lies on the disk; D by the accurate form, which is what samples are drawn by.
    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        let [.., cosine] = half_vector.direction();
        let drawn = self.with_form(TriangleForm::Accurate);
        Ok(drawn.eval(footprint, half_vector)? * cosine)
    }
}
