//! The studio: soft boxes over a dark room, and small lamps that make flakes glint.

use super::vector::{Vector, add, dot, normalised, scale, smoothstep};
use libm::{cos, sin, sqrt};
use std::f64::consts::PI;

/// A rectangle of soft light, far away.
struct SoftBox {
    /// Towards its middle.
    middle: Vector,
    /// Along its width.
    across: Vector,
    /// Half width and half height as tangents of angles seen from the ball.
    reach: [f64; 2],
    /// Share of the half size over which its edges fade.
    softness: f64,
    radiance: Vector,
}

/// A small round lamp, far away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    direction: Vector,
    axes: [Vector; 2],
    /// Cosine of its angular radius.
    cosine: f64,
    radiance: Vector,
}

/// Angular radius of a lamp.
const LAMP_RADIUS: f64 = 0.03;

/// Where the lamps hang, and how bright each is beside the others: an arc of spots above, two low at the sides.
const LAMPS: [([f64; 3], f64); 9] = [
    ([-0.95, 0.30, 0.35], 0.7),
    ([-0.75, 0.60, 0.55], 0.8),
    ([-0.40, 0.80, 0.62], 1.0),
    ([0.00, 0.88, 0.65], 1.0),
    ([0.40, 0.80, 0.62], 1.0),
    ([0.75, 0.60, 0.55], 0.8),
    ([0.95, 0.30, 0.35], 0.7),
    ([-0.55, -0.35, 0.75], 0.5),
    ([0.50, -0.20, 0.85], 0.5),
];

const LAMP_RADIANCE: Vector = [160.0, 152.0, 140.0];

/// The light around the ball.
pub(super) struct Studio {
    boxes: [SoftBox; 3],
    lamps: [Lamp; LAMPS.len()],
}

impl Studio {
    /// The studio every ball is photographed in.
    pub(super) fn new() -> Self {
        Self {
            boxes: [
                // Key light: large, above left.
                SoftBox::new([-0.62, 0.66, 0.42], [0.70, 0.42], 0.5, [1.6, 1.55, 1.5]),
                // A narrow strip at the right.
                SoftBox::new([0.96, 0.18, 0.10], [0.12, 0.85], 0.6, [1.6, 1.75, 2.0]),
                // Behind and below: lifts the rim off the backdrop.
                SoftBox::new([0.45, -0.50, -0.80], [0.9, 0.5], 1.0, [0.42, 0.40, 0.55]),
            ],
            lamps: LAMPS
                .map(|(direction, power)| Lamp::new(direction, scale(LAMP_RADIANCE, power))),
        }
    }

    /// The lamps.
    pub(super) fn lamps(&self) -> &[Lamp] {
        &self.lamps
    }

    /// Radiance from `direction`, of everything but the lamps.
    pub(super) fn soft(&self, direction: Vector) -> Vector {
        // A room a little lighter above than below.
        let up = 0.5 + 0.5 * direction[1];
        let room = scale([0.30, 0.33, 0.38], 0.12 + up * up);
        self.boxes.iter().fold(room, |sum, soft_box| {
            add(sum, soft_box.radiance_from(direction))
        })
    }

    /// Radiance of the lamps from `direction`.
    pub(super) fn hard(&self, direction: Vector) -> Vector {
        self.lamps.iter().fold([0.0; 3], |sum, lamp| {
            if lamp.shines_from(direction) {
                add(sum, lamp.radiance)
            } else {
                sum
            }
        })
    }
}

impl SoftBox {
    fn new(middle: Vector, reach: [f64; 2], softness: f64, radiance: Vector) -> Self {
        let middle = normalised(middle);
        Self {
            middle,
            across: horizontal(middle),
            reach,
            softness,
            radiance,
        }
    }

    fn radiance_from(&self, direction: Vector) -> Vector {
        let ahead = dot(direction, self.middle);
        if ahead <= 0.0 {
            return [0.0; 3];
        }
        let across = dot(direction, self.across) / ahead;
        let up = dot(direction, cross(self.middle, self.across)) / ahead;
        let fade =
            |place: f64, reach: f64| smoothstep(reach, reach * (1.0 - self.softness), place.abs());
        let share = fade(across, self.reach[0]) * fade(up, self.reach[1]);
        scale(self.radiance, share)
    }
}

impl Lamp {
    fn new(direction: Vector, radiance: Vector) -> Self {
        let direction = normalised(direction);
        let across = horizontal(direction);
        Self {
            direction,
            axes: [across, cross(direction, across)],
            cosine: cos(LAMP_RADIUS),
            radiance,
        }
    }

    /// What every direction of the lamp radiates.
    pub(super) fn radiance(&self) -> Vector {
        self.radiance
    }

    /// Whether `direction` meets the lamp.
    pub(super) fn shines_from(&self, direction: Vector) -> bool {
        dot(direction, self.direction) >= self.cosine
    }

    /// A direction of the lamp, uniform by solid angle, from two uniform numbers in [0, 1).
    pub(super) fn sample(&self, uniform: [f64; 2]) -> Vector {
        let cosine = 1.0 - uniform[0] * (1.0 - self.cosine);
        let sine = sqrt(1.0 - cosine * cosine);
        let angle = 2.0 * PI * uniform[1];
        add(
            scale(self.direction, cosine),
            add(
                scale(self.axes[0], sine * cos(angle)),
                scale(self.axes[1], sine * sin(angle)),
            ),
        )
    }

    /// The density of [`sample`](Self::sample), per steradian.
    pub(super) fn density(&self) -> f64 {
        1.0 / (2.0 * PI * (1.0 - self.cosine))
    }
}

/// A horizontal unit vector perpendicular to `direction`, which must not be vertical.
fn horizontal(direction: Vector) -> Vector {
    normalised([direction[2], 0.0, -direction[0]])
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_shine_from_the_directions_they_are_sampled_in_and_from_no_other() {
        let studio = Studio::new();
        for lamp in studio.lamps() {
            for index in 0..64 {
                let uniform = [
                    (f64::from(index % 8) + 0.5) / 8.0,
                    (f64::from(index / 8) + 0.5) / 8.0,
                ];
                let direction = lamp.sample(uniform);
                assert!((dot(direction, direction) - 1.0).abs() < 1e-12);
                assert!(lamp.shines_from(direction));
                assert_eq!(studio.hard(direction), lamp.radiance());
            }
            let beside = add(lamp.direction, scale(lamp.axes[0], 1.5 * LAMP_RADIUS));
            assert!(!lamp.shines_from(normalised(beside)));
        }
    }

    #[test]
    fn lamps_are_sampled_evenly_over_their_solid_angle() {
        let studio = Studio::new();
        let lamp = &studio.lamps()[0];
        // The half of a cap's solid angle nearest to its middle ends at half of 1 - cosine.
        let inner = 1.0 - 0.5 * (1.0 - lamp.cosine);
        let count = (0..1000)
            .filter(|&index| {
                let direction = lamp.sample([(f64::from(index) + 0.5) / 1000.0, 0.3]);
                dot(direction, lamp.direction) > inner
            })
            .count();
        assert_eq!(count, 500);
        let small_angle = PI * LAMP_RADIUS * LAMP_RADIUS;
        assert!((lamp.density() * small_angle - 1.0).abs() < 1e-3);
    }

    #[test]
    fn lamps_do_not_overlap() {
        // Each lamp is estimated as if it were alone in its directions.
        let studio = Studio::new();
        for (index, lamp) in studio.lamps().iter().enumerate() {
            for other in studio.lamps().iter().skip(index + 1) {
                assert!(dot(lamp.direction, other.direction) < cos(2.0 * LAMP_RADIUS));
            }
        }
    }

    #[test]
    fn soft_light_is_brightest_in_the_boxes_and_nowhere_dark() {
        let studio = Studio::new();
        let key = studio.soft(studio.boxes[0].middle);
        let below = studio.soft([0.0, -1.0, 0.0]);
        assert!(key[1] > 1.0, "{key:?}");
        assert!(below[1] > 0.0 && below[1] < 0.1, "{below:?}");
        let behind = scale(studio.boxes[0].middle, -1.0);
        assert_eq!(studio.boxes[0].radiance_from(behind), [0.0; 3]);
    }
}
