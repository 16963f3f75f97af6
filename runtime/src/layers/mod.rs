//! Layered materials: a coat over flakes over paint, answered as one BRDF.
//!
//! Papers: \[XTXW24\] §6.4, whose eq. 3 is `f = f_below (1 − F_coat) + f_coat` and whose layers have normals, and P-NDFs, of their
//! own; \[AWKK21\] §6, whose car paint is a coat over flakes over a diffuse and glossy base, flakes covering what a MIP map of
//! one channel says.
//!
//! From the bottom up, with the share t that a layer covers under the footprint:
//!
//! ```text
//! f = t (f_layer + T f_below) + (1 − t) f_below          below the last layer is black
//!
//! coat     f_layer = F(i·h) D G / (4 (i·n) (o·n))        F of a dielectric, exact
//!          T = (1 − F(i·n)) (1 − F(o·n)) c^l             l = (1 / cos θt(i) + 1 / cos θt(o)) / 2, by colour c
//! glints   f_layer = F0(i·h) D G / (4 (i·n) (o·n))       F0: Schlick's approximation, by colour
//!          T = 0
//! base     f_layer = F0(i·h) D G / (4 (i·n) (o·n)) + (1 − F0(i·n)) (1 − F0(o·n)) c / π
//!          T = 0
//! ```
//!
//! D and G are those of the layer's P-NDF, masking inside the sum as [`brdf::eval`] has it, or Beckmann's of a roughness. T is
//! what a coat lets pass on the way down *and* up, at the surface's normal: eq. 3 leaves open which angle its Fresnel term is of, and with
//! the half vector's, once, a white base under polished glass sends out up to 1.2 times the light that arrives.
//! [`Composition::HalfVector`] is that form. Both are reciprocal.
//!
//! Left out: refraction's turning of directions in the coat, light that goes to and fro between layers.
//!
//! [`brdf::eval`]: crate::microfacet::brdf::eval

mod choice;
mod layer;
mod lobe;
mod opacity;
mod tint;

pub use layer::Layer;

use crate::error::QueryError;
use crate::microfacet::brdf::half_vector;
use crate::ndf::SurfaceNdf;
use choice::Choice;
use glintbake_format::Container;
use glintbake_format::model::Footprint;
use glintbake_format::records::{MATERIAL, MAX_LAYERS};
use glintbake_format::view::MaterialLayers;

/// What a coat lets pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Composition {
    /// `(1 − F(i·n)) (1 − F(o·n))`: light passes the coat twice. Keeps energy.
    #[default]
    BothWays,
    /// `1 − F(i·h)`: \[XTXW24\] eq. 3 with the half vector's angle, at which `f_coat` has its Fresnel term. Brighter, and more
    /// than arrives at grazing angles.
    HalfVector,
}

/// A layered material over borrowed bytes; at most eight layers, no allocation.
///
/// ```no_run
/// use glintbake_runtime::model::Footprint;
/// use glintbake_runtime::Package;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let bytes = std::fs::read("car-paint.glint")?;
/// let material = Package::open(&bytes)?.material()?;
/// // The pixel's patch in the material's own unit square, and directions along tangent, bitangent and normal.
/// let patch = Footprint { centre: [0.3, 0.7], edge_1: [0.01, 0.0], edge_2: [0.0, 0.01] };
/// let (sun, eye) = ([0.6, 0.0, 0.8], [0.0, 0.0, 1.0]);
/// let [red, green, blue] = material.eval(&patch, sun, eye)?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Material<'a> {
    layers: [Option<Layer<'a>>; MAX_LAYERS],
    composition: Composition,
}

impl<'a> Material<'a> {
    /// The material of `container`. O(layers × instances); no data is read.
    ///
    /// # Errors
    /// [`QueryError::NotBaked`] if the package holds none, [`QueryError::Damaged`] if a layer is none, or its instance or a
    /// section is missing or of the wrong size.
    pub fn open(container: &Container<'a>) -> Result<Self, QueryError> {
        let records = MaterialLayers::open(container)?.ok_or(QueryError::NotBaked {
            section: MATERIAL,
            option: "a material file (.toml) in place of the image",
        })?;
        let mut layers = [None; MAX_LAYERS];
        for ((place, record), slot) in (0..).zip(records.iter()).zip(&mut layers) {
            *slot = Some(Layer::open(container, place, record?)?);
        }
        Ok(Self {
            layers,
            composition: Composition::default(),
        })
    }

    /// The same material with coats that let pass what `composition` says.
    #[must_use]
    pub const fn with_composition(mut self, composition: Composition) -> Self {
        self.composition = composition;
        self
    }

    /// The same material with P-NDFs as `change` makes them from those that are there and the places of their layers: of another
    /// accuracy, setting or roughness.
    ///
    /// # Errors
    /// What `change` fails with.
    pub fn with_ndfs(
        mut self,
        change: impl Fn(usize, SurfaceNdf<'a>) -> Result<SurfaceNdf<'a>, QueryError>,
    ) -> Result<Self, QueryError> {
        for (place, layer) in self.layers.iter_mut().flatten().enumerate() {
            if let Some(ndf) = layer.ndf() {
                layer.ndf = Some(change(place, *ndf)?);
            }
        }
        Ok(self)
    }

    /// Its layers, the top first.
    pub fn layers(&self) -> impl Iterator<Item = &Layer<'a>> {
        self.layers.iter().flatten()
    }

    /// The BRDF of the patch under `footprint` for the unit directions `incoming` (towards the light) and `outgoing` (towards
    /// the viewer) in tangent space, by colour (linear red, green, blue), per steradian, without the cosine; each at least 0,
    /// and 0 below the horizon. `footprint` is in the material's unit square, of which a layer's map fills the `scale`-th
    /// part. Reciprocal: both directions may be exchanged. One walk of each layer that is not covered.
    ///
    /// # Errors
    /// As [`Ndf::facets`](crate::Ndf::facets), of the footprint as layers see it.
    pub fn eval(
        &self,
        footprint: &Footprint,
        incoming: [f64; 3],
        outgoing: [f64; 3],
    ) -> Result<[f64; 3], QueryError> {
        check_finite(footprint)?;
        let Some(half) = half_vector(incoming, outgoing) else {
            return Ok([0.0; 3]);
        };
        let mut sum = [0.0; 3];
        let mut left = [1.0; 3];
        for layer in self.layers() {
            let footprint = layer.placed(footprint);
            let opacity = layer.opacity(&footprint)?;
            if opacity > 0.0 {
                let own = layer.reflected(&footprint, incoming, outgoing, half)?;
                let passed = layer.passed(incoming, outgoing, half, self.composition);
                for (((sum, left), own), passed) in
                    sum.iter_mut().zip(&mut left).zip(own).zip(passed)
                {
                    *sum += *left * opacity * own;
                    *left *= (1.0 - opacity) + opacity * passed;
                }
            }
            if left == [0.0; 3] {
                break;
            }
        }
        Ok(sum)
    }

    /// A unit direction of incident light drawn for the unit direction `outgoing` with density [`pdf`](Self::pdf), or `None`,
    /// which is a sample of value zero. `uniform`: four numbers in [0, 1), of which the first also chooses among layers: three
    /// quarters of the samples go where the layers' Fresnel terms at `outgoing` and what covers them send the light, a quarter to
    /// all that are seen alike.
    ///
    /// # Errors
    /// As [`Ndf::sample`](crate::Ndf::sample).
    pub fn sample(
        &self,
        footprint: &Footprint,
        outgoing: [f64; 3],
        uniform: [f64; 4],
    ) -> Result<Option<[f64; 3]>, QueryError> {
        check_finite(footprint)?;
        let [first, second, third, fourth] = uniform;
        let is_above = outgoing[2] > 0.0;
        let Some((place, lobe, first)) = is_above
            .then(|| Choice::new(self.layers(), footprint, outgoing))
            .transpose()?
            .and_then(|choice| choice.pick(first))
        else {
            return Ok(None);
        };
        match self.layers().nth(place) {
            Some(layer) => {
                let uniform = [first, second, third, fourth];
                lobe.sample(layer, &layer.placed(footprint), outgoing, uniform)
            }
            None => Ok(None),
        }
    }

    /// The density, per solid angle of `incoming`, with which [`sample`](Self::sample) draws it for `outgoing`; it integrates to
    /// 1 less the probability of `None`.
    ///
    /// # Errors
    /// As [`Ndf::pdf`](crate::Ndf::pdf).
    pub fn pdf(
        &self,
        footprint: &Footprint,
        incoming: [f64; 3],
        outgoing: [f64; 3],
    ) -> Result<f64, QueryError> {
        check_finite(footprint)?;
        let Some(half) = half_vector(incoming, outgoing) else {
            return Ok(0.0);
        };
        let choice = Choice::new(self.layers(), footprint, outgoing)?;
        let mut sum = 0.0;
        for (place, layer) in self.layers().enumerate() {
            let footprint = layer.placed(footprint);
            for (lobe, share) in choice.of_layer(place) {
                if share > 0.0 {
                    sum += share * lobe.pdf(layer, &footprint, incoming, outgoing, half)?;
                }
            }
        }
        Ok(sum)
    }
}

/// Refuses footprints that layers without a map would not look at.
fn check_finite(footprint: &Footprint) -> Result<(), QueryError> {
    let coordinates = [footprint.centre, footprint.edge_1, footprint.edge_2];
    if coordinates.as_flattened().iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(QueryError::NotFinite)
    }
}
