//! `lean`: one Gaussian lobe for the footprint, by MIP-mapped moments of the normals.
//!
//! Papers: \[OB10\] Olano and Baker, "LEAN Mapping", 2010: first and second moments of normals are filtered like colours,
//! and give one Gaussian; \[Tok05\] Toksvig, "Mipmapping Normal Maps", 2005, which began it. Here the moments are those
//! of points of the projected disk, and the kernel is a Gaussian there of variance σr² = α²/2:
//! `D(s) = N(s; mean, C + σr² I)`.
//!
//! ```text
//! footprint ──probes──► level and places ──look_up──► mean and covariance ──lobe──► D, samples
//! ```
//!
//! A query looks at 120 cells at most, whatever the footprint. It sees no glint: for the truth under a footprint use a
//! method that keeps every normal.

mod lobe;
mod look_up;

pub use lobe::Lobe;

use super::bin_weights::check_finite;
use super::{Facet, Ndf};
use crate::error::QueryError;
use crate::microfacet::Masking;
use crate::overlap::Placement;
use crate::pyramid::Probes;
use glintbake_format::model::{Filter, Footprint, HalfVector, intrinsic_from_beckmann};
use glintbake_format::records::Instance;
use glintbake_format::view::Pyramid;
use glintbake_format::{Container, Fault, Finding};

/// The P-NDF of a `lean` instance.
#[derive(Clone, Copy, Debug)]
pub struct Lean<'a> {
    instance: Instance,
    pyramid: Pyramid<'a>,
    masking: Masking<'a>,
    /// σr².
    kernel_variance: f64,
    pub(super) filter: Filter,
}

impl<'a> Lean<'a> {
    /// The P-NDF of `instance` of `container`, which must have been baked for this method.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, QueryError> {
        let roughness = instance
            .roughness
            .ok_or(Finding::new(Fault::InstanceField))?;
        let sigma = intrinsic_from_beckmann(roughness);
        Ok(Self {
            instance: *instance,
            pyramid: Pyramid::of_map(container, instance)?,
            masking: Masking::of_map(container, instance)?,
            kernel_variance: sigma * sigma,
            filter: instance.filter,
        })
    }

    /// The same P-NDF under another filter; that of the instance unless this says otherwise.
    #[must_use]
    pub fn with_filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// The filter that weighs footprints.
    pub const fn filter(&self) -> Filter {
        self.filter
    }

    /// The lobe of the patch under `footprint`, kernel included; for many half vectors over one footprint.
    ///
    /// A renderer that lights by an environment needs nothing else: mean and covariance are all there is to `D`. They are
    /// continuous in the footprint.
    ///
    /// # Errors
    /// As [`Ndf::facets`].
    pub fn lobe(&self, footprint: &Footprint) -> Result<Lobe, QueryError> {
        let Instance {
            width,
            height,
            wrap,
            ..
        } = self.instance;
        let placement = Placement::new(footprint, width, height, wrap)?;
        let edges = [placement.edge_1, placement.edge_2];
        let probes = Probes::new(edges, self.filter, self.pyramid.layout);
        let moments = look_up::moments(&self.pyramid, &placement, &probes, wrap)?;
        Ok(Lobe::new(
            moments.mean,
            moments.covariance,
            self.kernel_variance,
        ))
    }
}

impl Ndf for Lean<'_> {
    fn instance(&self) -> &Instance {
        &self.instance
    }

    fn masking(&self) -> Masking<'_> {
        self.masking
    }

    /// Visits one facet, of the footprint's mean normal, whose density is the lobe's.
    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        check_finite(half_vector)?;
        let lobe = self.lobe(footprint)?;
        let density = lobe.density(half_vector);
        if density > 0.0 {
            let [s, t] = lobe.mean();
            visit(Facet {
                normal: HalfVector { s, t }.direction(),
                density,
                weight: 1.0,
            });
        }
        Ok(())
    }

    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        let [.., first, second] = uniform;
        let drawn = self.lobe(footprint)?.sample([first, second]);
        Ok(drawn.is_on_disk().then_some(drawn))
    }

    /// `D (h·n)` with the surface's normal n, as the lobe is a density of the disk itself.
    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        check_finite(half_vector)?;
        let density = self.lobe(footprint)?.density(half_vector);
        let [.., cosine] = half_vector.direction();
        Ok(density * cosine)
    }
}
