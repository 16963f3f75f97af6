//! A ball covered with a layered material.

use super::skin::{Scattering, Skin};
use super::vector::{Vector, scale};
use glintbake_format::model::Footprint;
use glintbake_runtime::microfacet::fresnel::Fresnel;
use glintbake_runtime::{Material, Ndf, QueryError};

/// Texels of a material that has no map: as good as any.
const WITHOUT_MAP: f64 = 512.0;

/// A layered material as a ball shows it: the runtime's BRDF and sampler, nothing added.
#[derive(Clone, Copy, Debug)]
pub struct Layered<'a>(pub Material<'a>);

impl Skin for Layered<'_> {
    /// Those of the first layer that has a map, as often as it repeats.
    fn texels(&self) -> [f64; 2] {
        let of_first = self.0.layers().find_map(|layer| {
            let instance = layer.ndf()?.instance();
            let [u, v] = layer.record().scale.map(f64::from);
            Some([
                u * f64::from(instance.width),
                v * f64::from(instance.height),
            ])
        });
        of_first.unwrap_or([WITHOUT_MAP; 2])
    }

    /// Twice those of one surface, as lobes share them.
    fn samples(&self) -> u32 {
        64
    }

    fn scattering(
        &self,
        footprint: &Footprint,
        light: Vector,
        view: Vector,
    ) -> Result<Scattering, QueryError> {
        let brdf = self.0.eval(footprint, light, view)?;
        if brdf == [0.0; 3] {
            return Ok(Scattering::default());
        }
        Ok(Scattering {
            value: scale(brdf, light[2]),
            density: self.0.pdf(footprint, light, view)?,
        })
    }

    fn sample(
        &self,
        footprint: &Footprint,
        view: Vector,
        uniform: [f64; 4],
    ) -> Result<Option<Vector>, QueryError> {
        self.0.sample(footprint, view, uniform)
    }

    fn worth(
        &self,
        footprint: &Footprint,
        light: Vector,
        view: Vector,
    ) -> Result<Vector, QueryError> {
        let Scattering { value, density } = self.scattering(footprint, light, view)?;
        // What is drawn has a density, but for rounding at the rim of a kernel.
        Ok(if density > 0.0 {
            scale(value, 1.0 / density)
        } else {
            [0.0; 3]
        })
    }

    /// Nothing: the most polished coat is a lobe as well.
    fn mirror(&self) -> Option<Fresnel> {
        None
    }
}
