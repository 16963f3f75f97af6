//! Layered materials, from the formulas \[XTXW24\] eq. 3 and \[AWKK21\] §6, bottom up.
//!
//! `f = t (f_layer + T f_below) + (1 − t) f_below` for each layer, beginning with darkness below the last. Fresnel's equations are
//! written as Fresnel had them, by sines and tangents of the angles, and normals are those of the texels themselves.

use super::beckmann::beckmann;
use super::direction::{direction, dot};
use super::masking::masking;
use super::weights::box_weights;
use crate::normals::NormalMap;
use core::f64::consts::PI;
use glintbake_format::model::{Footprint, Wrap};

/// What a layer does with light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A dielectric of index `eta`, which lets pass the share `colour` at normal incidence, to and fro.
    Coat {
        /// Index of refraction.
        eta: f64,
        /// By colour.
        colour: [f64; 3],
    },
    /// Metal of reflectance `f0` at normal incidence.
    Glints {
        /// By colour.
        f0: [f64; 3],
    },
    /// A surface of reflectance `f0` at normal incidence over a diffuse one.
    Base {
        /// By colour.
        f0: [f64; 3],
        /// Albedo, by colour.
        diffuse: [f64; 3],
    },
}

/// The normals of a layer.
#[derive(Clone, Copy, Debug)]
pub enum Normals<'m> {
    /// One Beckmann lobe.
    Lobe {
        /// Its roughness.
        alpha: f64,
    },
    /// Flakes with the normals of a map.
    Map {
        /// The map.
        map: &'m NormalMap,
        /// Roughness of each flake.
        alpha: f64,
        /// Whether the map's normals hide each other.
        masked: bool,
    },
}

/// A layer of a material.
#[derive(Clone, Copy, Debug)]
pub struct Layer<'m> {
    /// What it does with light.
    pub kind: Kind,
    /// Its normals.
    pub normals: Normals<'m>,
    /// How often its map repeats along u and v.
    pub scale: [f64; 2],
    /// The share of the footprint that it covers.
    pub opacity: f64,
}

/// What a coat lets pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passed {
    /// By the surface's normal, on the way down and up.
    BothWays,
    /// By the half vector, once: eq. 3.
    HalfVector,
}

/// The BRDF of `layers`, the top first, by colour, for unit directions above the horizon.
///
/// # Panics
/// As [`box_weights`].
pub fn brdf(
    layers: &[Layer<'_>],
    footprint: &Footprint,
    light: [f64; 3],
    view: [f64; 3],
    passed: Passed,
) -> [f64; 3] {
    let Some((top, rest)) = layers.split_first() else {
        return [0.0; 3];
    };
    let below = brdf(rest, footprint, light, view, passed);
    let sum = [0, 1, 2].map(|axis: usize| light[axis] + view[axis]);
    let length = libm::sqrt(dot(sum, sum));
    let half = sum.map(|x| x / length);
    let facets = top.facets(footprint, light, view, half) / (4.0 * light[2] * view[2]);
    [0, 1, 2].map(|colour: usize| {
        let own = top.reflected(colour, facets, dot(light, half), [light[2], view[2]]);
        let through = top.through(colour, dot(light, half), [light[2], view[2]], passed);
        top.opacity * (own + through * below[colour]) + (1.0 - top.opacity) * below[colour]
    })
}

/// The average of `texels`, `width` × `height` numbers of which 255 cover all, under the parallelogram `footprint`.
///
/// # Panics
/// As [`box_weights`], or if there are not as many texels.
pub fn coverage(width: u32, height: u32, texels: &[u8], wrap: Wrap, footprint: &Footprint) -> f64 {
    // Weights are of places alone.
    let places = NormalMap::new(width, height, wrap, vec![[0.0; 2]; texels.len()]);
    box_weights(&places, footprint)
        .iter()
        .map(|weight| {
            let texel = weight.row as usize * width as usize + weight.column as usize;
            weight.weight * f64::from(texels[texel]) / 255.0
        })
        .sum()
}

impl Layer<'_> {
    /// `Σ D G` over the flakes under `footprint`.
    fn facets(
        &self,
        footprint: &Footprint,
        light: [f64; 3],
        view: [f64; 3],
        half: [f64; 3],
    ) -> f64 {
        let of = |normal: [f64; 3], alpha: f64| {
            beckmann(half, normal, alpha)
                * smith(light, half, normal, alpha)
                * smith(view, half, normal, alpha)
        };
        match self.normals {
            Normals::Lobe { alpha } => of([0.0, 0.0, 1.0], alpha),
            Normals::Map { map, alpha, masked } => {
                let [u, v] = self.scale;
                let scaled = |[x, y]: [f64; 2]| [u * x, v * y];
                let footprint = Footprint {
                    centre: scaled(footprint.centre),
                    edge_1: scaled(footprint.edge_1),
                    edge_2: scaled(footprint.edge_2),
                };
                let sum: f64 = box_weights(map, &footprint)
                    .iter()
                    .map(|weight| {
                        let texel = weight.row as usize * map.width() as usize;
                        let [s, t] = map.texels()[texel + weight.column as usize];
                        weight.weight * of(direction(f64::from(s), f64::from(t)), alpha)
                    })
                    .sum();
                let hidden = if masked {
                    masking(map, light) * masking(map, view)
                } else {
                    1.0
                };
                sum * hidden
            }
        }
    }

    fn reflected(&self, colour: usize, facets: f64, cosine: f64, [down, up]: [f64; 2]) -> f64 {
        match self.kind {
            Kind::Coat { eta, .. } => dielectric(cosine, eta) * facets,
            Kind::Glints { f0 } => schlick(f0[colour], cosine) * facets,
            Kind::Base { f0, diffuse } => {
                let lost = |cosine| 1.0 - schlick(f0[colour], cosine);
                schlick(f0[colour], cosine) * facets + lost(down) * lost(up) * diffuse[colour] / PI
            }
        }
    }

    fn through(&self, index: usize, cosine: f64, cosines: [f64; 2], passed: Passed) -> f64 {
        let Kind::Coat { eta, colour } = self.kind else {
            return 0.0;
        };
        let surface = match passed {
            Passed::BothWays => cosines
                .iter()
                .map(|&cosine| 1.0 - dielectric(cosine, eta))
                .product(),
            Passed::HalfVector => 1.0 - dielectric(cosine, eta),
        };
        // Lambert-Beer along both slanted paths, of which two straight ones leave `colour`.
        let paths: f64 = cosines
            .iter()
            .map(|&cosine| 1.0 / libm::cos(libm::asin(libm::sin(libm::acos(cosine)) / eta)))
            .sum();
        surface * libm::exp(0.5 * paths * libm::log(colour[index]))
    }
}

/// Fresnel's equations by the angles θ of incidence and θ' of refraction, sin θ = η sin θ':
/// `(sin²(θ − θ') / sin²(θ + θ') + tan²(θ − θ') / tan²(θ + θ')) / 2`.
fn dielectric(cosine: f64, eta: f64) -> f64 {
    if cosine > 1.0 - 1e-12 {
        let ratio = (eta - 1.0) / (eta + 1.0);
        return ratio * ratio;
    }
    let angle = libm::acos(cosine);
    let refracted = libm::asin(libm::sin(angle) / eta);
    let square = |x: f64| x * x;
    let perpendicular = square(libm::sin(angle - refracted) / libm::sin(angle + refracted));
    let parallel = square(libm::tan(angle - refracted) / libm::tan(angle + refracted));
    0.5 * (perpendicular + parallel)
}

/// `F0 + (1 − F0) (1 − cos θ)⁵`.
fn schlick(f0: f64, cosine: f64) -> f64 {
    f0 + (1.0 - f0) * libm::pow(1.0 - cosine, 5.0)
}

/// Smith's masking of a Beckmann surface by its Λ: `1 / (1 + (exp(−a²) / (a √π) − erfc a) / 2)`, `a = 1 / (α tan θ)`; 0 behind the
/// surface or the facet.
fn smith(direction: [f64; 3], half: [f64; 3], normal: [f64; 3], alpha: f64) -> f64 {
    let cosine = dot(direction, normal);
    if cosine <= 0.0 || dot(direction, half) <= 0.0 {
        return 0.0;
    }
    let sine = libm::sqrt((1.0 - cosine * cosine).max(0.0));
    if sine == 0.0 {
        return 1.0;
    }
    let a = cosine / (alpha * sine);
    let lambda = 0.5 * (libm::exp(-a * a) / (a * libm::sqrt(PI)) - libm::erfc(a));
    1.0 / (1.0 + lambda)
}
