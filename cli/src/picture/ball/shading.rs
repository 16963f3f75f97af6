//! The light that one pixel of the ball sends to the viewer: one footprint, many directions.
//!
//! Lamps are met twice, from their side and from the surface's, and each way weighs by how likely both are to find
//! the direction: narrow flakes find lamps, broad ones are found by them, so that glints are crisp at any roughness.
//! Soft light is met from the surface alone. The map is filtered by the footprint, not by the directions; these only
//! turn the ball's own frame within the pixel.

use super::sequence::Sequence;
use super::skin::{Scattering, Skin};
use super::studio::{Lamp, Studio};
use super::surface::{Point, View};
use super::vector::{Vector, add, dot, scale, tint};
use glintbake_format::model::Footprint;
use glintbake_runtime::QueryError;
use glintbake_runtime::microfacet::fresnel::Fresnel;

/// Towards the viewer.
const VIEWER: Vector = [0.0, 0.0, 1.0];

/// Points on each lamp; a power of two.
const LAMP_POINTS: u32 = 2;

/// Positions along each side of a pixel at which the clear coat is looked at.
const COAT_POSITIONS: u32 = 3;

/// The ball's skin under the studio's light.
pub(super) struct Shading<'a, S> {
    pub(super) skin: &'a S,
    pub(super) studio: &'a Studio,
    pub(super) view: View,
}

impl<S: Skin> Shading<'_, S> {
    /// Linear radiance of pixel (`x`, `y`), whose centre must lie on the ball or within a pixel of its rim.
    pub(super) fn pixel(&self, x: u32, y: u32) -> Result<Vector, QueryError> {
        self.radiance([f64::from(x), f64::from(y)], Sequence::of_pixel(x, y))
    }

    /// Linear radiance of the pixel whose upper left corner is at `corner`, estimated with `sequence`.
    fn radiance(&self, corner: [f64; 2], sequence: Sequence) -> Result<Vector, QueryError> {
        let centre = self
            .view
            .point(self.view.place(corner[0] + 0.5, corner[1] + 0.5));
        let footprint = self.view.footprint(centre);
        let mirrored = self.skin.mirror().map(|coat| self.coat(corner, coat));
        let mut sum = mirrored.unwrap_or_default();
        let mut pairs = 0;
        for lamp in self.studio.lamps() {
            for index in 0..LAMP_POINTS {
                let [jitter, on_lamp] =
                    [0, 1].map(|pair| sequence.point(pairs + pair, index, LAMP_POINTS));
                let point = self.within(corner, jitter);
                sum = add(sum, self.lamp_light(lamp, &footprint, point, on_lamp)?);
            }
            pairs += 2;
        }
        let samples = self.skin.samples();
        for index in 0..samples {
            let [jitter, patch, facet] =
                [0, 1, 2].map(|pair| sequence.point(pairs + pair, index, samples));
            let uniform = [patch[0], patch[1], facet[0], facet[1]];
            let point = self.within(corner, jitter);
            sum = add(sum, self.surface_light(&footprint, point, uniform)?);
        }
        Ok(sum)
    }

    /// The point of the ball at fraction `jitter` of the pixel at `corner`: its frame turns within the pixel.
    fn within(&self, corner: [f64; 2], jitter: [f64; 2]) -> Point {
        let place = self
            .view
            .place(corner[0] + jitter[0], corner[1] + jitter[1]);
        self.view.point(place)
    }

    fn lamp_light(
        &self,
        lamp: &Lamp,
        footprint: &Footprint,
        point: Point,
        uniform: [f64; 2],
    ) -> Result<Vector, QueryError> {
        let light = lamp.sample(uniform);
        let scattering = self.scattering(footprint, point, light)?;
        Ok(self.sent_by(lamp, scattering))
    }

    fn surface_light(
        &self,
        footprint: &Footprint,
        point: Point,
        uniform: [f64; 4],
    ) -> Result<Vector, QueryError> {
        let view = point.to_tangent_space(VIEWER);
        let Some(local) = self.skin.sample(footprint, view, uniform)? else {
            return Ok([0.0; 3]);
        };
        let worth = self.skin.worth(footprint, local, view)?;
        let light = point.to_view_space(local);
        let share = 1.0 / f64::from(self.skin.samples());
        let mut sum = scale(tint(self.studio.soft(light), worth), share);
        for lamp in self.studio.lamps() {
            if lamp.shines_from(light) {
                let scattering = self.skin.scattering(footprint, local, view)?;
                sum = add(sum, self.sent_by(lamp, scattering));
            }
        }
        Ok(sum)
    }

    /// What a point of `lamp` sends to the viewer, weighed for how often it is met in both ways: see [`mixture`].
    fn sent_by(&self, lamp: &Lamp, scattering: Scattering) -> Vector {
        if scattering.value == [0.0; 3] {
            return [0.0; 3];
        }
        let met = mixture(lamp.density(), scattering.density, self.skin.samples());
        scale(tint(lamp.radiance(), scattering.value), 1.0 / met)
    }

    fn scattering(
        &self,
        footprint: &Footprint,
        point: Point,
        light: Vector,
    ) -> Result<Scattering, QueryError> {
        let view = point.to_tangent_space(VIEWER);
        let light = point.to_tangent_space(light);
        self.skin.scattering(footprint, light, view)
    }

    /// The mirror image of the studio in the smooth `coat` over the pixel at `corner`.
    fn coat(&self, corner: [f64; 2], coat: Fresnel) -> Vector {
        let mut sum = [0.0; 3];
        let count = f64::from(COAT_POSITIONS);
        for position in 0..COAT_POSITIONS * COAT_POSITIONS {
            let jitter = [position % COAT_POSITIONS, position / COAT_POSITIONS]
                .map(|index| (f64::from(index) + 0.5) / count);
            let normal = self.within(corner, jitter).normal();
            let cosine = dot(normal, VIEWER);
            let mirrored = add(scale(normal, 2.0 * cosine), scale(VIEWER, -1.0));
            let light = add(self.studio.soft(mirrored), self.studio.hard(mirrored));
            sum = add(sum, scale(light, coat.reflectance(cosine)));
        }
        scale(sum, 1.0 / (count * count))
    }
}

/// The density of drawing a direction from a lamp and from the surface together, each as often as it is drawn:
/// one over it weighs both kinds of samples (the balance heuristic, Veach 1997, §9.2).
fn mixture(lamp: f64, surface: f64, samples: u32) -> f64 {
    f64::from(LAMP_POINTS) * lamp + f64::from(samples) * surface
}

#[cfg(test)]
mod tests {
    use super::super::metal::Metal;
    use super::super::vector::normalised;
    use super::*;
    use crate::picture::fixtures;

    /// The corner of the pixel whose middle lies at `place`, in radii of the ball.
    fn corner_at(view: View, place: [f64; 2]) -> [f64; 2] {
        let origin = view.place(0.0, 0.0);
        let pixel = view.place(1.0, 0.0)[0] - origin[0];
        [
            (place[0] - origin[0]) / pixel - 0.5,
            (origin[1] - place[1]) / pixel - 0.5,
        ]
    }

    /// The radiance of the point in the middle of the pixel at `corner`, by a plain sum over half vectors.
    fn reference<S: Skin>(shading: &Shading<'_, S>, corner: [f64; 2], reach: f64) -> Vector {
        const STEPS: u32 = 600;
        let point = shading.within(corner, [0.5, 0.5]);
        let view = point.to_tangent_space(VIEWER);
        let footprint = shading.view.footprint(point);
        let step = 2.0 * reach / f64::from(STEPS);
        let mut sum = [0.0; 3];
        for index in 0..STEPS * STEPS {
            let [s, t] =
                [index % STEPS, index / STEPS].map(|place| (f64::from(place) + 0.5) * step - reach);
            let half = [s, t, libm::sqrt(1.0 - s * s - t * t)];
            let cosine = dot(half, view);
            let light = add(scale(half, 2.0 * cosine), scale(view, -1.0));
            let scattering = shading
                .skin
                .scattering(&footprint, light, view)
                .expect("in range");
            if scattering.value != [0.0; 3] {
                let light = point.to_view_space(light);
                let radiance = add(shading.studio.soft(light), shading.studio.hard(light));
                // A half vector's solid angle is ds dt / h_z, the light's 4 (i·h) times that.
                let weight = 4.0 * cosine * step * step / half[2];
                sum = add(sum, scale(tint(radiance, scattering.value), weight));
            }
        }
        let mirrored = shading.skin.mirror().map(|coat| shading.coat(corner, coat));
        add(sum, mirrored.unwrap_or_default())
    }

    #[test]
    fn pixels_estimate_the_integral_over_all_light() {
        // So many pixels that the ball does not turn within one.
        let side = 16_384;
        for roughness in [0.01, 0.04, 0.15] {
            let bytes = fixtures::constant([0.0, 0.0], roughness);
            let metal = Metal(fixtures::ndf(&bytes));
            let shading = Shading {
                skin: &metal,
                studio: &Studio::new(),
                view: View::new(side, 1.0, [8.0, 8.0]),
            };
            let lamp = shading.studio.lamps()[3].sample([0.0, 0.0]);
            let mirror = normalised(add(lamp, VIEWER));
            // On a lamp's highlight, half a lobe beside it, and where soft light prevails.
            for [dx, dy] in [[0.0, 0.0], [0.5 * roughness, 0.0], [-0.4, -0.1]] {
                let place = [mirror[0] + dx, mirror[1] + dy];
                let corner = corner_at(shading.view, place);
                let expected = reference(&shading, corner, (4.5 * roughness).min(0.6));
                let mut sum = [0.0; 3];
                let count = 2048;
                for index in 0..count {
                    let sequence = Sequence::of_pixel(index, 1);
                    sum = add(sum, shading.radiance(corner, sequence).expect("in range"));
                }
                for (sum, expected) in sum.into_iter().zip(expected) {
                    let mean = sum / f64::from(count);
                    assert!(
                        (mean / expected - 1.0).abs() < 0.03,
                        "roughness {roughness}, {place:?}: {mean} instead of {expected}"
                    );
                }
            }
        }
    }
}
