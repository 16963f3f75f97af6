//! From P-NDF to BRDF.

use super::beckmann::masking;
use super::fresnel::Fresnel;
use super::vector::{dot, normalised};
use crate::error::QueryError;
use crate::ndf::Ndf;
use glintbake_format::model::{Footprint, HalfVector};

/// The BRDF of the patch under `footprint` for unit directions `light` and `view` in tangent space, per steradian.
///
/// `f = F Σ_j W_j D^α(h, b_j) G^α(i, o, h, b_j) / (4 (i·n) (o·n))`, \[AWKK21\] eq. 5 and 15 with the flakes' own
/// masking *inside* the sum; 0 below the horizon. Masking of flakes by other flakes is left to the caller.
/// Reciprocal: light and view may be exchanged.
///
/// # Errors
/// As [`Ndf::facets`].
pub fn eval(
    ndf: &impl Ndf,
    footprint: &Footprint,
    light: [f64; 3],
    view: [f64; 3],
    fresnel: Fresnel,
) -> Result<f64, QueryError> {
    let Some(half) = half_vector(light, view) else {
        return Ok(0.0);
    };
    let roughness = ndf.instance().roughness;
    let mut sum = 0.0;
    ndf.facets(footprint, HalfVector::from_direction(half), &mut |facet| {
        let masking = roughness.map_or(1.0, |roughness| {
            masking(light, half, facet.normal, roughness)
                * masking(view, half, facet.normal, roughness)
        });
        sum += facet.density * facet.weight * masking;
    })?;
    Ok(fresnel.reflectance(dot(light, half)) * sum / (4.0 * light[2] * view[2]))
}

/// A unit direction of incident light drawn for the unit direction `view`, with density [`pdf`], or `None`, which
/// is a sample of value zero. `uniform`: four numbers in [0, 1).
///
/// # Errors
/// As [`Ndf::sample`].
pub fn sample(
    ndf: &impl Ndf,
    footprint: &Footprint,
    view: [f64; 3],
    uniform: [f64; 4],
) -> Result<Option<[f64; 3]>, QueryError> {
    if view[2] <= 0.0 {
        return Ok(None);
    }
    let Some(half) = ndf.sample(footprint, uniform)? else {
        return Ok(None);
    };
    let half = half.direction();
    let cosine = dot(view, half);
    let light = [0, 1, 2].map(|axis: usize| {
        #[expect(
            clippy::indexing_slicing,
            reason = "arrays of three, indexed below three"
        )]
        let component = 2.0 * cosine * half[axis] - view[axis];
        component
    });
    Ok((cosine > 0.0 && light[2] > 0.0).then_some(light))
}

/// The density, per solid angle of `light`, with which [`sample`] draws it: `pdf(h) / (4 (i·h))`.
///
/// # Errors
/// As [`Ndf::pdf`].
pub fn pdf(
    ndf: &impl Ndf,
    footprint: &Footprint,
    light: [f64; 3],
    view: [f64; 3],
) -> Result<f64, QueryError> {
    let Some(half) = half_vector(light, view) else {
        return Ok(0.0);
    };
    let density = ndf.pdf(footprint, HalfVector::from_direction(half))?;
    Ok(density / (4.0 * dot(light, half)))
}

/// The half vector of two directions above the horizon.
fn half_vector(light: [f64; 3], view: [f64; 3]) -> Option<[f64; 3]> {
    if !(light[2] > 0.0 && view[2] > 0.0) {
        return None;
    }
    normalised([light[0] + view[0], light[1] + view[1], light[2] + view[2]])
}
