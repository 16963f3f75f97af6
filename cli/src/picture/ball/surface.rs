//! The ball's surface: where a pixel meets it, which way it faces, and which patch of the map it covers.

use super::vector::{Vector, dot};
use glintbake_format::model::Footprint;
use libm::sqrt;
use std::f64::consts::PI;

/// Radius of the ball, where the picture's half side is 1.
const RADIUS: f64 = 0.86;

/// Orthographic view of a unit ball (x right, y up, z towards the viewer), the map laid on it by the stereographic
/// projection from the point farthest from the viewer.
///
/// The projection is conformal, so tangent frames are orthogonal and normals need no correction; its one pole is
/// behind the ball, so nothing in view is pinched. Texels shrink by up to 2 from the middle to the rim.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// Side of a pixel in radii of the ball.
    pixel: f64,
    /// Tiles per radius in the middle of the picture, along u and along v.
    scale: [f64; 2],
}

/// The middle of the picture shows the middle of the map.
const CENTRE: [f64; 2] = [0.5, 0.5];

/// Pixels in a ball's circumference, for a picture of `side` pixels.
pub(super) fn circumference(side: u32) -> f64 {
    PI * RADIUS * f64::from(side)
}

/// A point of the unit ball and its tangent frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    normal: Vector,
}

impl View {
    /// The view in a picture of `side` pixels, with a map of `width` × `height` texels `tiles` times around the ball
    /// along its rows, and as often along its columns as keeps texels square.
    pub(super) fn new(side: u32, tiles: f64, [width, height]: [f64; 2]) -> Self {
        let along_u = tiles / (2.0 * PI);
        Self {
            pixel: 2.0 / (RADIUS * f64::from(side)),
            scale: [along_u, along_u * width / height],
        }
    }

    /// The place, in radii from the ball's centre, `x` pixels from the left and `y` from the top.
    pub(super) fn place(self, x: f64, y: f64) -> [f64; 2] {
        let edge = 1.0 / RADIUS;
        [x * self.pixel - edge, edge - y * self.pixel]
    }

    /// The share of a pixel centred at `place` that the ball covers; the rim is as good as straight in one pixel.
    pub(super) fn coverage(self, [x, y]: [f64; 2]) -> f64 {
        let inside = (1.0 - sqrt(x * x + y * y)) / self.pixel;
        (inside + 0.5).clamp(0.0, 1.0)
    }

    /// The point of the ball seen at `place`; beyond half a pixel from the rim, the point there.
    ///
    /// A pixel at the rim sees the last half pixel of the ball, not the horizon that its outer edge would see.
    pub(super) fn point(self, [x, y]: [f64; 2]) -> Point {
        let limit = 1.0 - 0.5 * self.pixel.min(1.0);
        let radius = sqrt(x * x + y * y);
        let shrink = if radius > limit { limit / radius } else { 1.0 };
        let (x, y) = (x * shrink, y * shrink);
        Point {
            normal: [x, y, sqrt(1.0 - x * x - y * y)],
        }
    }

    /// The patch of the map that a pixel centred at `point` covers: the image of its square under the projection.
    ///
    /// With `p = 2 x / (1 + z)`, `q = 2 y / (1 + z)` and `z² = 1 - x² - y²`:
    /// `∂p/∂x = 2/(1+z) + 2x²/(z (1+z)²)`, `∂p/∂y = ∂q/∂x = 2xy/(z (1+z)²)`, and so for q.
    pub(super) fn footprint(self, point: Point) -> Footprint {
        let [x, y, z] = point.normal;
        let inverse = 1.0 / (1.0 + z);
        let shear = 2.0 * inverse * inverse / z;
        let cross = shear * x * y;
        // u runs with p, v against q.
        let to_texture = |[p, q]: [f64; 2]| [self.scale[0] * p, -self.scale[1] * q];
        let middle = to_texture([2.0 * x * inverse, 2.0 * y * inverse]);
        let edge = |p: f64, q: f64| to_texture([self.pixel * p, self.pixel * q]);
        Footprint {
            centre: [CENTRE[0] + middle[0], CENTRE[1] + middle[1]],
            edge_1: edge(2.0 * inverse + shear * x * x, cross),
            edge_2: edge(cross, 2.0 * inverse + shear * y * y),
        }
    }
}

impl Point {
    /// The outward normal of the smooth ball.
    pub(super) fn normal(self) -> Vector {
        self.normal
    }

    /// The tangent along +u and the bitangent against +v, both of unit length.
    fn frame(self) -> [Vector; 2] {
        let [x, y, z] = self.normal;
        let a = 1.0 / (1.0 + z);
        [
            [1.0 - x * x * a, -x * y * a, -x],
            [-x * y * a, 1.0 - y * y * a, -y],
        ]
    }

    /// `direction` as the map's normals are given: along tangent, bitangent and normal.
    pub(super) fn to_tangent_space(self, direction: Vector) -> Vector {
        let [tangent, bitangent] = self.frame();
        [
            dot(direction, tangent),
            dot(direction, bitangent),
            dot(direction, self.normal),
        ]
    }

    /// The direction that [`to_tangent_space`](Self::to_tangent_space) takes to `local`.
    pub(super) fn to_view_space(self, local: Vector) -> Vector {
        let [tangent, bitangent] = self.frame();
        [0, 1, 2].map(|axis: usize| {
            local[0] * tangent[axis] + local[1] * bitangent[axis] + local[2] * self.normal[axis]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::vector::{add, scale};
    use super::*;

    /// Places on the ball, in the middle and towards each side of the rim.
    const PLACES: [[f64; 2]; 6] = [
        [0.0, 0.0],
        [0.3, 0.1],
        [-0.5, 0.6],
        [0.7, -0.6],
        [-0.2, -0.95],
        [0.97, 0.0],
    ];

    fn view() -> View {
        View::new(4096, 3.0, [7.0, 7.0])
    }

    #[test]
    fn the_middle_of_the_picture_is_the_middle_of_ball_and_map() {
        let view = View::new(100, 3.0, [8.0, 4.0]);
        let point = view.point(view.place(50.0, 50.0));
        assert_eq!(point.normal(), [0.0, 0.0, 1.0]);
        let footprint = view.footprint(point);
        assert_eq!(footprint.centre, [0.5, 0.5]);
        // A tile is a third of the circumference, π · 0.86 · 100 pixels.
        let pixel = 3.0 / circumference(100);
        assert!((footprint.edge_1[0] - pixel).abs() < 1e-15);
        // Twice as many texels lie in a row as in a column, so a pixel covers twice as much of the map's height.
        assert!((footprint.edge_2[1] + 2.0 * pixel).abs() < 1e-15);
        assert!(footprint.edge_1[1] == 0.0 && footprint.edge_2[0] == 0.0);
    }

    #[test]
    fn edges_are_the_differences_between_neighbouring_pixels() {
        let view = view();
        for [x, y] in PLACES {
            let at = |dx: f64, dy: f64| {
                let step = 0.5 * view.pixel;
                let point = view.point([x + dx * step, y + dy * step]);
                view.footprint(point).centre
            };
            let footprint = view.footprint(view.point([x, y]));
            for (edge, [dx, dy]) in [
                (footprint.edge_1, [1.0, 0.0]),
                (footprint.edge_2, [0.0, 1.0]),
            ] {
                let (far, near) = (at(dx, dy), at(-dx, -dy));
                for axis in [0, 1] {
                    let difference = far[axis] - near[axis];
                    let tolerance = 1e-3 * edge[0].hypot(edge[1]);
                    assert!(
                        (edge[axis] - difference).abs() < tolerance,
                        "at ({x}, {y}): {edge:?}, axis {axis}: {difference}"
                    );
                }
            }
        }
    }

    #[test]
    fn tangents_follow_the_map_and_frames_are_right_handed() {
        let view = view();
        for place in PLACES {
            let point = view.point(place);
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|axis| point.to_view_space(axis));
            for (index, axis) in axes.into_iter().enumerate() {
                for (other, against) in axes.into_iter().enumerate() {
                    let wanted = if index == other { 1.0 } else { 0.0 };
                    assert!((dot(axis, against) - wanted).abs() < 1e-14);
                }
                let back = point.to_tangent_space(axis);
                assert!((back[index] - 1.0).abs() < 1e-14);
            }
            let [tangent, bitangent, normal] = axes;
            let cross_z = tangent[0] * bitangent[1] - tangent[1] * bitangent[0];
            assert!((cross_z - normal[2]).abs() < 1e-14);
            // A small step along a tangent moves along one axis of the map: u for the first, against v for the second.
            for (axis, direction) in [(0, tangent), (1, bitangent)] {
                let moved = add(normal, scale(direction, 1e-6));
                let moved = view.footprint(view.point([moved[0], moved[1]])).centre;
                let centre = view.footprint(point).centre;
                let step = [moved[0] - centre[0], centre[1] - moved[1]];
                assert!(step[axis] > 0.0);
                assert!(step[1 - axis].abs() < 1e-4 * step[axis], "{step:?}");
            }
        }
    }

    #[test]
    fn the_rim_is_covered_half_and_its_points_stay_on_the_ball() {
        let view = View::new(200, 1.0, [7.0, 7.0]);
        assert_eq!(view.coverage([0.2, -0.3]), 1.0);
        assert!((view.coverage([0.6, -0.8]) - 0.5).abs() < 1e-9);
        assert_eq!(view.coverage([0.9, 0.9]), 0.0);
        let area: f64 = (0..200 * 200)
            .map(|index| view.place(f64::from(index % 200) + 0.5, f64::from(index / 200) + 0.5))
            .map(|place| view.coverage(place))
            .sum();
        let disk = PI * (0.5 * RADIUS * 200.0) * (0.5 * RADIUS * 200.0);
        assert!((area / disk - 1.0).abs() < 1e-3, "{area} of {disk} pixels");
        let [x, y, z] = view.point([1.2, 0.4]).normal();
        assert!(z > 0.0 && (x * x + y * y + z * z - 1.0).abs() < 1e-14);
    }
}
