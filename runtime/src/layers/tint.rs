//! Reflection and transmission by colour.

use crate::microfacet::fresnel::Fresnel;

/// Schlick's approximation for each colour of `f0` at `cosine`.
pub(super) fn schlick(f0: [f64; 3], cosine: f64) -> [f64; 3] {
    f0.map(|f0| Fresnel::Schlick { f0 }.reflectance(cosine))
}

/// What is left of light that passes a coat of index `eta` to and fro, by `colour`, which is what is left at normal incidence:
/// `colour^l` with l half the sum of both paths, in thicknesses of the coat.
pub(super) fn absorbed(colour: [f64; 3], eta: f64, cosines: [f64; 2]) -> [f64; 3] {
    if colour == [1.0; 3] {
        return colour;
    }
    let [down, up] = cosines.map(|cosine| {
        let sine_squared = (1.0 - cosine * cosine).max(0.0) / (eta * eta);
        1.0 / libm::sqrt((1.0 - sine_squared).max(0.0))
    });
    let length = 0.5 * (down + up);
    colour.map(|share| {
        if share == 1.0 {
            1.0
        } else {
            libm::pow(share, length)
        }
    })
}

/// The mean of three colours.
pub(super) fn mean([red, green, blue]: [f64; 3]) -> f64 {
    (red + green + blue) / 3.0
}
