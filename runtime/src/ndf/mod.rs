//! The methods: each answers `eval`, `sample` and `pdf` for a footprint and a half vector.
//!
//! One file per method, of the method's name; [`SurfaceNdf`] is the registry.

mod analytic;
mod batch;
mod bin_weights;
mod box_pyramid;
mod cluster_tree;
mod flake_bins;
mod lean;
mod lobes;
mod mip_lobes;
mod ndf_maps;
mod specular_bins;

pub use analytic::{Analytic, GlobalNdf, TriangleForm};
pub use batch::{BatchError, Queries};
pub use bin_weights::{DEFAULT_TOLERANCE, Lookup};
pub use cluster_tree::{Accuracy, Bounded, ClusterTree};
pub use flake_bins::{FlakeBins, Setting};
pub use lean::{Lean, Lobe};
pub use lobes::Lobes;
pub use mip_lobes::MipLobes;
pub use ndf_maps::NdfMaps;
pub use specular_bins::SpecularBins;

use crate::error::QueryError;
use crate::microfacet::Masking;
use crate::microfacet::vector::dot;
use glintbake_format::Container;
use glintbake_format::model::{Filter, Footprint, HalfVector, Method, Neighbourhood};
use glintbake_format::records::Instance;

/// One term of a P-NDF: facets of one normal, or so near that the method treats them as one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Unit normal the facets' own distribution is centred at.
    pub normal: [f64; 3],
    /// Density of that distribution at the queried half vector, per steradian: `D^α(h, normal)`.
    pub density: f64,
    /// Share of the footprint these facets cover, in [0, 1].
    pub weight: f64,
}

/// The normal distribution function of the patch under a footprint.
pub trait Ndf {
    /// What was baked: map size, method, roughness.
    fn instance(&self) -> &Instance;

    /// What the map's normals hide of each other, by direction; [`Masking::NONE`] if it was not baked.
    fn masking(&self) -> Masking<'_> {
        Masking::NONE
    }

    /// Calls `visit` for every facet whose density at `half_vector` the method counts; `D` is the sum of
    /// density × weight. This is what a BRDF needs to keep masking inside the sum, \[AWKK21\] eq. 15.
    ///
    /// # Errors
    /// [`QueryError`] on footprints that are not finite or too large, and on damaged packages.
    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError>;

    /// Writes [`eval`](Self::eval) of each of `queries` to its place in `densities`.
    ///
    /// # Errors
    /// [`BatchError`]: arrays of different lengths, or the first query without an answer.
    fn eval_batch(&self, queries: &Queries<'_>, densities: &mut [f64]) -> Result<(), BatchError> {
        batch::answer(queries, densities, |footprint, half_vector| {
            self.eval(footprint, half_vector)
        })
    }

    /// Writes [`pdf`](Self::pdf) of each of `queries` to its place in `densities`, as [`eval_batch`](Self::eval_batch).
    ///
    /// # Errors
    /// As [`eval_batch`](Self::eval_batch).
    fn pdf_batch(&self, queries: &Queries<'_>, densities: &mut [f64]) -> Result<(), BatchError> {
        batch::answer(queries, densities, |footprint, half_vector| {
            self.pdf(footprint, half_vector)
        })
    }

    /// The density `D` of the footprint's facet normals at `half_vector`, per steradian, ≥ 0; 0 outside the disk.
    ///
    /// # Errors
    /// As [`facets`](Self::facets).
    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        let mut sum = 0.0;
        self.facets(footprint, half_vector, &mut |facet| {
            sum += facet.density * facet.weight;
        })?;
        Ok(sum)
    }

    /// A half vector drawn with density [`pdf`](Self::pdf) from four uniform numbers in [0, 1), or `None` with the
    /// probability that the pdf leaves over.
    ///
    /// `None` is a sample of value zero, not a reason to draw again: what a method truncates (far tails, facets
    /// below the horizon) is missing from `eval` and `pdf` alike, and an estimator that counts it as zero is
    /// unbiased for `eval`. That makes sampler and pdf agree exactly without a table of kept masses.
    ///
    /// # Errors
    /// As [`facets`](Self::facets).
    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError>;

    /// The density, per solid angle of the half vector, with which [`sample`](Self::sample) draws `half_vector`:
    /// the sum of density × weight × (h · normal), the factor that \[AWKK21\] eq. 18 leaves out; of a method whose
    /// kernel lies on the disk, with the surface's normal in place of the facet's.
    ///
    /// # Errors
    /// As [`facets`](Self::facets).
    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        let direction = half_vector.direction();
        let mut sum = 0.0;
        self.facets(footprint, half_vector, &mut |facet| {
            sum += facet.density * facet.weight * dot(direction, facet.normal).max(0.0);
        })?;
        Ok(sum)
    }
}

/// The P-NDF of an instance, by whichever method it was baked for.
#[derive(Clone, Copy, Debug)]
pub enum SurfaceNdf<'a> {
    /// Binned NDF over an inverse bin map, \[AWKK21\].
    FlakeBins(FlakeBins<'a>),
    /// Equal-solid-angle bins over an inverse bin map, \[ABKK20\].
    SpecularBins(SpecularBins<'a>),
    /// One Gaussian lobe from MIP-mapped moments, \[OB10\].
    Lean(Lean<'a>),
    /// Moments of clusters in a tree over positions and normals, ours.
    ClusterTree(ClusterTree<'a>),
    /// Gaussian lobes of position and normal, \[YHMR16\].
    Lobes(Lobes<'a>),
    /// Integrals over a surface of normals, \[YHJ*14\].
    Analytic(Analytic<'a>),
    /// Clustered lobes of the levels of a quilted surface, \[TZX22\].
    MipLobes(MipLobes<'a>),
    /// NDF images of the tiles of an example, whose copies make up the surface, \[XTXW24\].
    NdfMaps(NdfMaps<'a>),
}

impl<'a> SurfaceNdf<'a> {
    /// The P-NDF of `instance` of `container`.
    ///
    /// # Errors
    /// [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, QueryError> {
        Ok(match instance.method {
            Method::FlakeBins => Self::FlakeBins(FlakeBins::open(container, instance)?),
            Method::SpecularBins => Self::SpecularBins(SpecularBins::open(container, instance)?),
            Method::Lean => Self::Lean(Lean::open(container, instance)?),
            Method::ClusterTree => Self::ClusterTree(ClusterTree::open(container, instance)?),
            Method::Lobes => Self::Lobes(Lobes::open(container, instance)?),
            Method::Analytic => Self::Analytic(Analytic::open(container, instance)?),
            Method::MipLobes => Self::MipLobes(MipLobes::open(container, instance)?),
            Method::NdfMaps => Self::NdfMaps(NdfMaps::open(container, instance)?),
        })
    }

    /// The same P-NDF under another setting.
    ///
    /// # Errors
    /// [`QueryError::SettingUnsupported`] if the method has no settings, [`QueryError::NotBaked`] if the setting
    /// needs a section the package was baked without.
    pub fn with_setting(self, setting: Setting) -> Result<Self, QueryError> {
        match self {
            Self::FlakeBins(ndf) => ndf.with_setting(setting).map(Self::FlakeBins),
            Self::SpecularBins(_) => Err(QueryError::SettingUnsupported(Method::SpecularBins)),
            Self::Lean(_) => Err(QueryError::SettingUnsupported(Method::Lean)),
            Self::ClusterTree(_) => Err(QueryError::SettingUnsupported(Method::ClusterTree)),
            Self::Lobes(_) => Err(QueryError::SettingUnsupported(Method::Lobes)),
            Self::Analytic(_) => Err(QueryError::SettingUnsupported(Method::Analytic)),
            Self::MipLobes(_) => Err(QueryError::SettingUnsupported(Method::MipLobes)),
            Self::NdfMaps(_) => Err(QueryError::SettingUnsupported(Method::NdfMaps)),
        }
    }

    /// The setting's word for the header of results, `default` where the method has none.
    pub fn setting_name(&self) -> &'static str {
        match self {
            Self::FlakeBins(ndf) => ndf.setting().name(),
            Self::Lobes(ndf) if ndf.is_raw_sum() => "paper",
            Self::MipLobes(ndf) if ndf.has_levels_by_area() => "paper",
            Self::SpecularBins(_)
            | Self::Lean(_)
            | Self::ClusterTree(_)
            | Self::Lobes(_)
            | Self::MipLobes(_)
            | Self::NdfMaps(_) => "default",
            Self::Analytic(ndf) => ndf.form().name(),
        }
    }

    /// The least and the greatest Beckmann roughness α that `method` answers for, whatever was baked; `None` if it answers for what
    /// was baked alone.
    pub const fn roughness_range(method: Method) -> Option<[f64; 2]> {
        match method {
            Method::FlakeBins | Method::SpecularBins | Method::Lean | Method::NdfMaps => None,
            Method::ClusterTree => Some(ClusterTree::ROUGHNESS),
            Method::Lobes => Some(Lobes::ROUGHNESS),
            Method::Analytic => Some(Analytic::ROUGHNESS),
            Method::MipLobes => Some(MipLobes::ROUGHNESS),
        }
    }

    /// The same P-NDF for Beckmann roughness `alpha` (σr = α / √2), which methods with a
    /// [`roughness_range`](Self::roughness_range) take; that of the instance unless this says otherwise. Nothing is computed ahead.
    ///
    /// # Errors
    /// [`QueryError::RoughnessRange`] if `alpha` is out of that range, [`QueryError::SettingUnsupported`] of methods without one.
    pub fn with_roughness(self, alpha: f64) -> Result<Self, QueryError> {
        match self {
            Self::FlakeBins(_) => Err(QueryError::SettingUnsupported(Method::FlakeBins)),
            Self::SpecularBins(_) => Err(QueryError::SettingUnsupported(Method::SpecularBins)),
            Self::Lean(_) => Err(QueryError::SettingUnsupported(Method::Lean)),
            Self::ClusterTree(ndf) => ndf.with_roughness(alpha).map(Self::ClusterTree),
            Self::Lobes(ndf) => ndf.with_roughness(alpha).map(Self::Lobes),
            Self::Analytic(ndf) => ndf.with_roughness(alpha).map(Self::Analytic),
            Self::MipLobes(ndf) => ndf.with_roughness(alpha).map(Self::MipLobes),
            Self::NdfMaps(_) => Err(QueryError::SettingUnsupported(Method::NdfMaps)),
        }
    }

    /// The same P-NDF as the method's paper has it: the 21 bins of `flake-bins` (\[AWKK21\] eq. 15), the plain sum of `lobes`
    /// (\[YHMR16\]), the fitted error functions of `analytic` (\[YHJ*14\] eq. 9 to 12), `mip-lobes` of levels by area (\[TZX22\] eq. 8). Its
    /// [`setting_name`](Self::setting_name) is `paper` then.
    ///
    /// # Errors
    /// [`QueryError::SettingUnsupported`] of methods that have one form only.
    pub fn with_paper_form(self) -> Result<Self, QueryError> {
        match self {
            Self::Lobes(ndf) => Ok(Self::Lobes(ndf.with_raw_sum(true))),
            Self::Analytic(ndf) => Ok(Self::Analytic(ndf.with_form(TriangleForm::Paper))),
            Self::MipLobes(ndf) => Ok(Self::MipLobes(ndf.with_levels_by_area(true))),
            other => other.with_setting(Setting::Binned(Neighbourhood::Bins21)),
        }
    }

    /// The same P-NDF under another filter; that of the instance unless this says otherwise.
    #[must_use]
    pub fn with_filter(mut self, filter: Filter) -> Self {
        match &mut self {
            Self::FlakeBins(ndf) => ndf.how.filter = filter,
            Self::SpecularBins(ndf) => ndf.how.filter = filter,
            Self::Lean(ndf) => ndf.filter = filter,
            Self::ClusterTree(ndf) => ndf.filter = filter,
            Self::Lobes(ndf) => *ndf = ndf.with_filter(filter),
            Self::Analytic(ndf) => ndf.filter = filter,
            Self::MipLobes(ndf) => *ndf = ndf.with_filter(filter),
            Self::NdfMaps(ndf) => *ndf = ndf.with_filter(filter),
        }
        self
    }

    /// The same P-NDF, Gaussian footprints weighed within `tolerance`, [`DEFAULT_TOLERANCE`] unless this says otherwise.
    ///
    /// A block or a tile of texels counts by its number of them times the Gaussian's average over it if the Gaussian, in
    /// units of its peak, ranges over it by at most `tolerance`, or less where it has more texels than the Gaussian's
    /// own area; tiles, if all of them stand for their texels, at 3.5 times that, with the Gaussian's slope over them.
    /// Where every block stands for its texels, the Gaussian ends at 3.7 standard deviations instead of 4.8. Errors of
    /// blocks have either sign, so that those of densities are far smaller (the default to 0.6 % in relative L1 on the
    /// sample maps). 0 weighs every texel exactly. Means nothing for boxes, for lists of positions and for the exact
    /// setting, which never approximate, for `lean`, which weighs no texels, and for `cluster-tree`, which has an
    /// [`Accuracy`] instead.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        match &mut self {
            Self::FlakeBins(ndf) => ndf.how.tolerance = tolerance,
            Self::SpecularBins(ndf) => ndf.how.tolerance = tolerance,
            Self::Lean(_)
            | Self::ClusterTree(_)
            | Self::Lobes(_)
            | Self::Analytic(_)
            | Self::MipLobes(_)
            | Self::NdfMaps(_) => {}
        }
        self
    }

    /// The filter that weighs footprints.
    pub const fn filter(&self) -> Filter {
        match self {
            Self::FlakeBins(ndf) => ndf.filter(),
            Self::SpecularBins(ndf) => ndf.how.filter,
            Self::Lean(ndf) => ndf.filter(),
            Self::ClusterTree(ndf) => ndf.filter(),
            Self::Lobes(ndf) => ndf.filter(),
            Self::Analytic(ndf) => ndf.filter(),
            Self::MipLobes(ndf) => ndf.filter(),
            Self::NdfMaps(ndf) => ndf.filter(),
        }
    }

    fn method(&self) -> &dyn Ndf {
        match self {
            Self::FlakeBins(ndf) => ndf,
            Self::SpecularBins(ndf) => ndf,
            Self::Lean(ndf) => ndf,
            Self::ClusterTree(ndf) => ndf,
            Self::Lobes(ndf) => ndf,
            Self::Analytic(ndf) => ndf,
            Self::MipLobes(ndf) => ndf,
            Self::NdfMaps(ndf) => ndf,
        }
    }
}

impl Ndf for SurfaceNdf<'_> {
    fn instance(&self) -> &Instance {
        self.method().instance()
    }

    fn masking(&self) -> Masking<'_> {
        self.method().masking()
    }

    fn facets(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        visit: &mut dyn FnMut(Facet),
    ) -> Result<(), QueryError> {
        self.method().facets(footprint, half_vector, visit)
    }

    fn eval(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        self.method().eval(footprint, half_vector)
    }

    fn sample(
        &self,
        footprint: &Footprint,
        uniform: [f64; 4],
    ) -> Result<Option<HalfVector>, QueryError> {
        self.method().sample(footprint, uniform)
    }

    fn pdf(&self, footprint: &Footprint, half_vector: HalfVector) -> Result<f64, QueryError> {
        self.method().pdf(footprint, half_vector)
    }
}

/// `roughness`, if it lies between the least and the greatest of `range`.
fn within([least, most]: [f64; 2], roughness: f64) -> Result<f64, QueryError> {
    // Of what is not a number either comparison fails.
    if roughness >= least && roughness <= most {
        Ok(roughness)
    } else {
        Err(QueryError::RoughnessRange { least, most })
    }
}
