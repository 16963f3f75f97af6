//! Coordinates of the hemisphere in which what a method answers is tame: a lobe is a few units wide, a bin a square.

use glintbake_bake::oracle::specular_bins::{normal_at, square_of};
use glintbake_format::model::HalfVector;
use std::f64::consts::TAU;

/// A map between points of the plane and half vectors, and what it does to solid angles.
#[derive(Clone, Copy, Debug)]
pub enum Chart {
    /// Slopes about a direction in units of `scale`: the point at distance r is the half vector whose angle θ to the
    /// direction has `tan θ = scale r`. Covers the hemisphere about the direction.
    Slopes {
        /// The direction, and two others that make a right-handed frame with it.
        frame: [[f64; 3]; 3],
        /// The tangent that is one unit.
        scale: f64,
    },
    /// The square of equal solid angles, \[ABKK20\] §2: one bin is a unit square. Covers the hemisphere.
    Bins {
        /// Bins a side.
        bins: u32,
    },
}

impl Chart {
    /// Slopes about `centre`, one unit being a tangent of `scale`.
    pub fn slopes(centre: HalfVector, scale: f64) -> Self {
        let [s, t, z] = centre.direction();
        let share = 1.0 / (1.0 + z);
        Self::Slopes {
            frame: [
                [1.0 - s * s * share, -s * t * share, -s],
                [-s * t * share, 1.0 - t * t * share, -t],
                [s, t, z],
            ],
            scale,
        }
    }

    /// The point of `half_vector`, or `None` if the chart does not cover it.
    pub fn point(&self, half_vector: HalfVector) -> Option<[f64; 2]> {
        match *self {
            Self::Slopes { frame, scale } => {
                let direction = half_vector.direction();
                let [x, y, z] = frame.map(|axis| dot(axis, direction));
                (z > 0.0).then(|| [x / (z * scale), y / (z * scale)])
            }
            Self::Bins { bins } => Some(square_of(half_vector).map(|x| x * f64::from(bins))),
        }
    }

    /// The half vector at `point` with the solid angle of a unit square there, or `None` below the horizon.
    pub fn half_vector(&self, [x, y]: [f64; 2]) -> Option<(HalfVector, f64)> {
        match *self {
            Self::Slopes { frame, scale } => {
                let (a, b) = (x * scale, y * scale);
                let cosine = 1.0 / (1.0 + a * a + b * b).sqrt();
                let direction = [0, 1, 2].map(|axis| {
                    cosine * (a * frame[0][axis] + b * frame[1][axis] + frame[2][axis])
                });
                let half_vector = HalfVector::from_direction(direction);
                (direction[2] > 0.0 && half_vector.is_on_disk())
                    .then_some((half_vector, scale * scale * cosine * cosine * cosine))
            }
            Self::Bins { bins } => {
                let side = f64::from(bins);
                let place = [x / side, y / side];
                let is_inside = place.iter().all(|part| (0.0..1.0).contains(part));
                is_inside.then(|| (normal_at(place), TAU / (side * side)))
            }
        }
    }

    /// The place nearest to `x` where a window may end: on a border of bins if there are any.
    pub fn snap(&self, x: f64) -> f64 {
        match self {
            Self::Slopes { .. } => x,
            Self::Bins { .. } => x.round(),
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_half_vectors_are_each_others_and_solid_angles_add_up() {
        let centre = HalfVector { s: 0.3, t: -0.2 };
        for chart in [Chart::slopes(centre, 0.01), Chart::Bins { bins: 20 }] {
            let middle = chart.point(centre).expect("the centre is covered");
            for (x, y) in [(0.0, 0.0), (1.3, -0.4), (-2.0, 2.5)] {
                let point = [middle[0] + x, middle[1] + y];
                let (half_vector, angle) = chart.half_vector(point).expect("above the horizon");
                let back = chart.point(half_vector).expect("covered");
                assert!((back[0] - point[0]).abs() + (back[1] - point[1]).abs() < 1e-9);
                // The solid angle of a small square, by the cross product of its sides.
                let step = 1e-4;
                let [right, up] = [[step, 0.0], [0.0, step]].map(|[dx, dy]| {
                    let moved = chart.half_vector([point[0] + dx, point[1] + dy]);
                    let [a, b] = [moved.expect("above").0, half_vector].map(HalfVector::direction);
                    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
                });
                let cross = [
                    right[1] * up[2] - right[2] * up[1],
                    right[2] * up[0] - right[0] * up[2],
                    right[0] * up[1] - right[1] * up[0],
                ];
                let area = dot(cross, cross).sqrt() / (step * step);
                assert!((area / angle - 1.0).abs() < 1e-3, "{area} {angle}");
            }
        }
        assert!(
            Chart::slopes(centre, 1.0)
                .half_vector([99.0, 0.0])
                .is_none()
        );
        assert_eq!(Chart::Bins { bins: 3 }.snap(1.2), 1.0);
    }
}
