//! One layer: what it reflects itself, and what it lets pass.

use super::Composition;
use super::lobe;
use super::opacity;
use super::tint::{absorbed, mean, schlick};
use crate::error::QueryError;
use crate::microfacet::brdf::{MaskingPlacement, masked_density};
use crate::microfacet::fresnel::Fresnel;
use crate::microfacet::vector::dot;
use crate::ndf::SurfaceNdf;
use core::f64::consts::PI;
use glintbake_format::model::{Filter, Footprint};
use glintbake_format::records::{LayerKind, LayerNormals, MATERIAL, MaterialLayer};
use glintbake_format::view::Opacity;
use glintbake_format::{Container, Fault, Finding, SectionId};

/// A layer of a material, ready to be queried.
#[derive(Clone, Copy, Debug)]
pub struct Layer<'a> {
    record: MaterialLayer,
    pub(super) ndf: Option<SurfaceNdf<'a>>,
    opacity: Option<Opacity<'a>>,
}

impl<'a> Layer<'a> {
    /// The layer of `record`, at place `place` of the material of `container`.
    pub(super) fn open(
        container: &Container<'a>,
        place: u16,
        record: MaterialLayer,
    ) -> Result<Self, QueryError> {
        let ndf = match record.normals {
            LayerNormals::Lobe(_) => None,
            LayerNormals::Instance(number) => {
                let missing = Finding::new(Fault::MaterialInstance)
                    .within(SectionId::shared(MATERIAL))
                    .at(u64::from(place));
                let instance = container
                    .instances()
                    .filter_map(Result::ok)
                    .find(|instance| instance.number == number)
                    .ok_or(missing)?;
                Some(SurfaceNdf::open(container, &instance)?)
            }
        };
        Ok(Self {
            record,
            ndf,
            opacity: Opacity::open(container, place, &record)?,
        })
    }

    /// What was baked: kind, colours, scale.
    pub const fn record(&self) -> &MaterialLayer {
        &self.record
    }

    /// The P-NDF of its normals; `None` if they are distributed by one lobe.
    pub const fn ndf(&self) -> Option<&SurfaceNdf<'a>> {
        self.ndf.as_ref()
    }

    /// `footprint`, of the material's unit square, as the layer's maps have it.
    pub fn placed(&self, footprint: &Footprint) -> Footprint {
        let [u, v] = self.record.scale.map(f64::from);
        let scaled = |[x, y]: [f64; 2]| [x * u, y * v];
        Footprint {
            centre: scaled(footprint.centre),
            edge_1: scaled(footprint.edge_1),
            edge_2: scaled(footprint.edge_2),
        }
    }

    /// The share of the patch under `footprint`, which is [`placed`](Self::placed), that the layer covers, in [0, 1].
    /// Continuous in the footprint; at most 120 cells of a MIP map.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`], [`QueryError::FootprintTooLarge`] or [`QueryError::Damaged`], of layers with an opacity map.
    pub fn opacity(&self, footprint: &Footprint) -> Result<f64, QueryError> {
        let whole = f64::from(self.record.opacity);
        let filter = self.ndf.as_ref().map_or(Filter::Box, SurfaceNdf::filter);
        match &self.opacity {
            Some(map) if whole > 0.0 => Ok(whole * opacity::average(map, footprint, filter)?),
            _ => Ok(whole),
        }
    }

    /// Beckmann roughness of its lobe, of a layer that has no P-NDF.
    pub(super) fn lobe_roughness(&self) -> f64 {
        match self.record.normals {
            LayerNormals::Lobe(roughness) => f64::from(roughness),
            LayerNormals::Instance(_) => 0.0,
        }
    }

    /// Its own BRDF where it covers the surface, by colour, for two directions above the horizon and their half vector.
    pub(super) fn reflected(
        &self,
        footprint: &Footprint,
        incoming: [f64; 3],
        outgoing: [f64; 3],
        half: [f64; 3],
    ) -> Result<[f64; 3], QueryError> {
        let density = match &self.ndf {
            Some(ndf) => {
                let inside = MaskingPlacement::Inside;
                masked_density(ndf, footprint, incoming, outgoing, half, inside)?
            }
            None => lobe::masked_density(self.lobe_roughness(), incoming, outgoing, half),
        };
        let cosines = [incoming[2], outgoing[2]];
        let facets = 4.0 * cosines[0] * cosines[1];
        let gloss = self
            .fresnel(dot(incoming, half))
            .map(|reflectance| reflectance * density / facets);
        Ok(if self.is_diffuse() {
            let [down, up] = cosines.map(|cosine| self.fresnel(cosine));
            let mut sum = gloss;
            for (((sum, down), up), colour) in
                sum.iter_mut().zip(down).zip(up).zip(self.record.colour)
            {
                *sum += (1.0 - down) * (1.0 - up) * f64::from(colour) / PI;
            }
            sum
        } else {
            gloss
        })
    }

    /// What it lets pass to what lies below and back, by colour, where it covers the surface.
    pub(super) fn passed(
        &self,
        incoming: [f64; 3],
        outgoing: [f64; 3],
        half: [f64; 3],
        composition: Composition,
    ) -> [f64; 3] {
        if !self.lets_pass() {
            return [0.0; 3];
        }
        let cosines = [incoming[2], outgoing[2]];
        let surface = match composition {
            Composition::BothWays => {
                let [down, up] = cosines.map(|cosine| 1.0 - self.coat(cosine));
                down * up
            }
            Composition::HalfVector => 1.0 - self.coat(dot(incoming, half)),
        };
        self.absorbed(cosines).map(|share| surface * share)
    }

    /// Whether a diffuse lobe lies under its gloss.
    pub(super) fn is_diffuse(&self) -> bool {
        self.record.kind == LayerKind::Base && self.record.colour != [0.0; 3]
    }

    /// Whether light can pass where it covers the surface.
    pub(super) fn lets_pass(&self) -> bool {
        self.record.kind == LayerKind::Coat
    }

    /// What part of light its facets and its diffuse lobe send out at `cosine`, and what part it lets pass to and fro, about, on
    /// average over colours.
    pub(super) fn estimates(&self, cosine: f64) -> [f64; 3] {
        let gloss = mean(self.fresnel(cosine));
        let colour = mean(self.record.colour.map(f64::from));
        match self.record.kind {
            LayerKind::Coat => {
                let passed = (1.0 - gloss) * (1.0 - gloss);
                [gloss, 0.0, passed * mean(self.absorbed([cosine; 2]))]
            }
            LayerKind::Glints | LayerKind::Base => [gloss, (1.0 - gloss) * colour, 0.0],
        }
    }

    fn fresnel(&self, cosine: f64) -> [f64; 3] {
        match self.record.kind {
            LayerKind::Coat => [self.coat(cosine); 3],
            LayerKind::Glints | LayerKind::Base => schlick(self.record.f0.map(f64::from), cosine),
        }
    }

    fn coat(&self, cosine: f64) -> f64 {
        let eta = f64::from(self.record.ior);
        Fresnel::Dielectric { eta }.reflectance(cosine)
    }

    fn absorbed(&self, cosines: [f64; 2]) -> [f64; 3] {
        let colour = self.record.colour.map(f64::from);
        absorbed(colour, f64::from(self.record.ior), cosines)
    }
}
