//! What a ball can be covered with.

use super::vector::Vector;
use glintbake_format::model::Footprint;
use glintbake_runtime::QueryError;
use glintbake_runtime::microfacet::fresnel::Fresnel;

/// A surface under small lights and large ones, as a ball is drawn with it.
///
/// Directions are unit vectors along tangent, bitangent and normal; `light` points to the light, `view` to the viewer. Colours are
/// linear red, green, blue.
pub trait Skin: Sync {
    /// Texels in the unit square, along u and along v: what a ball is scaled by.
    fn texels(&self) -> [f64; 2];

    /// Directions drawn from the surface for each pixel; a power of two.
    fn samples(&self) -> u32;

    /// The BRDF times cosine, and the density with which [`sample`](Self::sample) draws `light`.
    ///
    /// # Errors
    /// [`QueryError`] of the package behind it.
    fn scattering(
        &self,
        footprint: &Footprint,
        light: Vector,
        view: Vector,
    ) -> Result<Scattering, QueryError>;

    /// A direction of light, or `None`, which is a sample of value zero.
    ///
    /// # Errors
    /// As [`scattering`](Self::scattering).
    fn sample(
        &self,
        footprint: &Footprint,
        view: Vector,
        uniform: [f64; 4],
    ) -> Result<Option<Vector>, QueryError>;

    /// What a drawn direction is worth in smooth light: value over density.
    ///
    /// # Errors
    /// As [`scattering`](Self::scattering).
    fn worth(
        &self,
        footprint: &Footprint,
        light: Vector,
        view: Vector,
    ) -> Result<Vector, QueryError>;

    /// What the surface mirrors besides, without spreading it.
    fn mirror(&self) -> Option<Fresnel>;
}

/// BRDF times cosine, and the density with which the sampler draws the light's direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scattering {
    /// By colour, per steradian.
    pub value: Vector,
    /// Per steradian.
    pub density: f64,
}
