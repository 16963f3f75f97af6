//! What plain packages are shown as: a metal with the baked map's facets, under a coloured clear coat.

use super::skin::{Scattering, Skin};
use super::vector::{Vector, add, dot, normalised, scale};
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_runtime::microfacet::beckmann;
use glintbake_runtime::microfacet::brdf;
use glintbake_runtime::microfacet::fresnel::Fresnel;
use glintbake_runtime::{Facet, Ndf, QueryError, SurfaceNdf};
use libm::{exp, log, sqrt};

/// Aluminium at 550 nm.
const METAL: Fresnel = Fresnel::Conductor {
    eta: 0.96,
    kappa: 6.69,
};

/// Lacquer.
const COAT_ETA: f64 = 1.5;
const COAT: Fresnel = Fresnel::Dielectric { eta: COAT_ETA };

/// What the coat lets through on the way down and up again at normal incidence, by colour: blue.
const COAT_COLOUR: Vector = [0.10, 0.34, 0.86];

/// Aluminium with the facets of a P-NDF, under a smooth blue coat.
#[derive(Clone, Copy, Debug)]
pub struct Metal<'a>(pub SurfaceNdf<'a>);

impl Skin for Metal<'_> {
    fn texels(&self) -> [f64; 2] {
        let instance = self.0.instance();
        [instance.width, instance.height].map(f64::from)
    }

    fn samples(&self) -> u32 {
        32
    }

    fn scattering(
        &self,
        footprint: &Footprint,
        light: Vector,
        view: Vector,
    ) -> Result<Scattering, QueryError> {
        let facets = facets(&self.0, footprint, light, view)?;
        if facets.value <= 0.0 {
            return Ok(Scattering::default());
        }
        Ok(Scattering {
            value: scale(coat_transmission(light[2], view[2]), facets.value),
            density: facets.density,
        })
    }

    fn sample(
        &self,
        footprint: &Footprint,
        view: Vector,
        uniform: [f64; 4],
    ) -> Result<Option<Vector>, QueryError> {
        brdf::sample(&self.0, footprint, view, uniform)
    }

    fn worth(
        &self,
        _footprint: &Footprint,
        light: Vector,
        view: Vector,
    ) -> Result<Vector, QueryError> {
        let passed = coat_transmission(light[2], view[2]);
        Ok(scale(passed, single_facet(&self.0, light, view)))
    }

    fn mirror(&self) -> Option<Fresnel> {
        Some(COAT)
    }
}

/// The facets' BRDF times cosine, and the density with which their sampler draws the light's direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Facets {
    value: f64,
    density: f64,
}

/// What the patch under `footprint` does with light from `light`, for unit directions in tangent space.
///
/// The same as `brdf::eval` with [`METAL`], times cosine, and `brdf::pdf`, but both from one search for facets, which is
/// where the time goes; with cavities where the package has no masking.
fn facets(
    ndf: &impl Ndf,
    footprint: &Footprint,
    light: Vector,
    view: Vector,
) -> Result<Facets, QueryError> {
    let mut result = Facets::default();
    if light[2] <= 0.0 || view[2] <= 0.0 {
        return Ok(result);
    }
    let half = normalised(add(light, view));
    let roughness = ndf.instance().roughness;
    ndf.facets(
        footprint,
        HalfVector::from_direction(half),
        &mut |Facet {
                  normal,
                  density,
                  weight,
              }| {
            let masking = roughness.map_or(1.0, |roughness| {
                beckmann::masking(light, half, normal, roughness)
                    * beckmann::masking(view, half, normal, roughness)
            });
            result.value += density * weight * masking;
            result.density += density * weight * dot(half, normal).max(0.0);
        },
    )?;
    let cosine = dot(light, half);
    result.value *= METAL.reflectance(cosine) * map_masking(ndf, light, view) / (4.0 * view[2]);
    result.density /= 4.0 * cosine;
    Ok(result)
}

/// What a light direction drawn by `brdf::sample` is worth: value times cosine over density, if the facet it was
/// drawn from were alone and exactly at the half vector.
///
/// All facets together would have to be searched for. Their masking and `1/(h·b)` average to that of one at h within
/// the order of α², too little to see in the smooth light that this is for.
fn single_facet(ndf: &impl Ndf, light: Vector, view: Vector) -> f64 {
    let half = normalised(add(light, view));
    let masking = ndf.instance().roughness.map_or(1.0, |roughness| {
        beckmann::masking(light, half, half, roughness)
            * beckmann::masking(view, half, half, roughness)
    });
    let cosine = dot(light, half);
    METAL.reflectance(cosine) * masking * map_masking(ndf, light, view) * cosine / view[2]
}

/// What facets leave of light that other facets shadow or mask, in [0, 1]: the map's own masking, or cavities if the
/// package was baked without, so that grazing light does not blow up.
fn map_masking(ndf: &impl Ndf, light: Vector, view: Vector) -> f64 {
    let masking = ndf.masking();
    if masking.is_baked() {
        masking.g(light, view)
    } else {
        cavity_masking(light, view)
    }
}

/// V-cavities (Torrance and Sparrow 1967,
/// Cook and Torrance 1982 eq. 15), in [0, 1].
fn cavity_masking(light: Vector, view: Vector) -> f64 {
    let half = normalised(add(light, view));
    let factor = 2.0 * half[2] / dot(view, half);
    (factor * light[2].min(view[2])).min(1.0)
}

/// What the coat leaves of light that arrives at one cosine and leaves at the other, by colour: Fresnel twice, and absorption
/// along the refracted path. That refraction also turns the light is left out: glints stay where the map puts them.
fn coat_transmission(light: f64, view: f64) -> Vector {
    let cosines = [light, view];
    let mut passed = 1.0;
    let mut path = 0.0;
    for cosine in cosines {
        passed *= 1.0 - COAT.reflectance(cosine);
        path += 0.5 / sqrt(1.0 - (1.0 - cosine * cosine) / (COAT_ETA * COAT_ETA));
    }
    COAT_COLOUR.map(|share| passed * exp(path * log(share)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::fixtures;
    use glintbake_bake::MethodRecipe;
    use glintbake_format::model::Method;

    const PATCH: Footprint = Footprint {
        centre: [0.3, 0.6],
        edge_1: [0.1, 0.02],
        edge_2: [-0.03, 0.08],
    };

    /// Directions drawn from the surface, with a view of their own each.
    fn drawn(ndf: &impl Ndf) -> Vec<(Vector, Vector)> {
        (0..200)
            .filter_map(|index| {
                let fraction = |prime: f64| (f64::from(index) + 0.5) * prime % 1.0;
                let tilt = fraction(0.618) - 0.5;
                let view = normalised([tilt, 0.3, 0.4 + fraction(0.287)]);
                let uniform = [0.7548, 0.5698, 0.8192, 0.6710].map(fraction);
                let light = brdf::sample(ndf, &PATCH, view, uniform).expect("in range")?;
                Some((light, view))
            })
            .collect()
    }

    #[test]
    fn value_and_density_are_those_of_the_runtime() {
        let flakes = MethodRecipe::new(Method::FlakeBins, &[0.1]);
        let unmasked = MethodRecipe {
            masking: false,
            ..flakes.clone()
        };
        let mirrors = MethodRecipe::new(Method::SpecularBins, &[]);
        for recipe in [flakes, unmasked, mirrors] {
            let baked = recipe.masking;
            let bytes = fixtures::package(&fixtures::flake_map(), recipe);
            let ndf = fixtures::ndf(&bytes);
            let directions = drawn(&ndf);
            assert!(directions.len() > 100);
            for (light, view) in directions {
                let seen = facets(&ndf, &PATCH, light, view).expect("in range");
                let cavities = if baked {
                    1.0
                } else {
                    cavity_masking(light, view)
                };
                let value = brdf::eval(&ndf, &PATCH, light, view, METAL).expect("in range")
                    * light[2]
                    * cavities;
                let density = brdf::pdf(&ndf, &PATCH, light, view).expect("in range");
                assert!(density > 0.0);
                assert!((seen.value - value).abs() <= 1e-12 * value);
                assert!((seen.density - density).abs() <= 1e-12 * density);
            }
        }
    }

    #[test]
    fn one_facet_is_worth_what_all_are_to_the_order_of_roughness_squared() {
        for roughness in [0.02, 0.1, 0.2] {
            let bytes = fixtures::flakes(Method::FlakeBins, &[roughness]);
            let ndf = fixtures::ndf(&bytes);
            let (mut one, mut all) = (0.0, 0.0);
            for (light, view) in drawn(&ndf) {
                let exact = facets(&ndf, &PATCH, light, view).expect("in range");
                one += single_facet(&ndf, light, view);
                all += exact.value / exact.density;
            }
            assert!(
                (one / all - 1.0).abs() < 2.0 * roughness * roughness,
                "roughness {roughness}: {one} instead of {all}"
            );
        }
    }

    #[test]
    fn nothing_comes_from_below_the_horizon() {
        let bytes = fixtures::constant([0.0, 0.0], 0.5);
        let ndf = fixtures::ndf(&bytes);
        let above = normalised([0.1, 0.2, 0.9]);
        let below = normalised([0.1, 0.2, -0.1]);
        for (light, view) in [(below, above), (above, below)] {
            let seen = facets(&ndf, &PATCH, light, view).expect("in range");
            assert_eq!(seen, Facets::default());
        }
    }

    #[test]
    fn masking_is_reciprocal_and_vanishes_towards_the_horizon() {
        let steep = normalised([0.3, -0.2, 0.9]);
        let grazing = normalised([0.9, 0.1, 0.02]);
        assert_eq!(cavity_masking(steep, steep), 1.0);
        let there = cavity_masking(steep, grazing);
        assert!((there - cavity_masking(grazing, steep)).abs() < 1e-12);
        assert!(there < 0.1, "{there}");
    }

    #[test]
    fn the_coat_is_blue_clearer_from_above_and_never_adds_light() {
        let middle = coat_transmission(1.0, 1.0);
        // 4 % mirrored on the way in and out each, the rest coloured.
        for (seen, colour) in middle.into_iter().zip(COAT_COLOUR) {
            assert!((seen - 0.96 * 0.96 * colour).abs() < 1e-12);
        }
        let side = coat_transmission(1.0, 0.43);
        for (side, middle) in side.into_iter().zip(middle) {
            assert!(side > 0.0 && side < middle);
        }
        assert!((COAT.reflectance(1.0) - 0.04).abs() < 1e-12);
    }
}
