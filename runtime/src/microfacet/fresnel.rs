//! How much light a mirror facet reflects.

use libm::sqrt;

/// What a facet is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fresnel {
    /// Reflects everything: for looking at the distribution alone.
    Perfect,
    /// Glass, lacquer, water: relative index of refraction η > 0 (inside over outside). Exact.
    Dielectric {
        /// Relative index of refraction.
        eta: f64,
    },
    /// Metal: complex index of refraction η + iκ relative to the outside. Exact.
    Conductor {
        /// Real part.
        eta: f64,
        /// Imaginary part (extinction).
        kappa: f64,
    },
    /// Schlick's approximation with reflectance `f0` at normal incidence.
    Schlick {
        /// Reflectance at normal incidence, in [0, 1].
        f0: f64,
    },
}

impl Fresnel {
    /// The reflectance, in [0, 1], at `cosine` (in [0, 1]) between light and facet normal, unpolarised.
    pub fn reflectance(self, cosine: f64) -> f64 {
        let cosine = cosine.clamp(0.0, 1.0);
        match self {
            Self::Perfect => 1.0,
            Self::Dielectric { eta } => dielectric(cosine, eta),
            Self::Conductor { eta, kappa } => conductor(cosine, eta, kappa),
            Self::Schlick { f0 } => {
                let m = 1.0 - cosine;
                let squared = m * m;
                f0 + (1.0 - f0) * squared * squared * m
            }
        }
    }
}

/// Fresnel equations for a real index; 1 beyond the critical angle.
fn dielectric(cosine: f64, eta: f64) -> f64 {
    let sine_squared = (1.0 - cosine * cosine) / (eta * eta);
    if sine_squared >= 1.0 {
        return 1.0;
    }
    let transmitted = sqrt(1.0 - sine_squared);
    let parallel = (eta * cosine - transmitted) / (eta * cosine + transmitted);
    let perpendicular = (cosine - eta * transmitted) / (cosine + eta * transmitted);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Fresnel equations for a complex index, in the real form with a² + b² = |η² - κ² - sin²θ + 2iηκ|.
fn conductor(cosine: f64, eta: f64, kappa: f64) -> f64 {
    let squared = cosine * cosine;
    let sine_squared = 1.0 - squared;
    let real = eta * eta - kappa * kappa - sine_squared;
    let modulus = sqrt(real * real + 4.0 * eta * eta * kappa * kappa);
    let a = sqrt((0.5 * (modulus + real)).max(0.0));
    let perpendicular =
        (modulus + squared - 2.0 * cosine * a) / (modulus + squared + 2.0 * cosine * a);
    let grazing = squared * modulus + sine_squared * sine_squared;
    let mixed = 2.0 * cosine * a * sine_squared;
    let parallel = perpendicular * (grazing - mixed) / (grazing + mixed);
    0.5 * (perpendicular + parallel)
}
