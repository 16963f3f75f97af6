//! One lobe's closed form against quadrature.

use super::super::double_double::DoubleDouble;
use super::super::lobes::position::Position;
use super::super::lobes::spread::Spread;
use super::Random;
use super::bells::bell_over_triangle;
use core::f64::consts::PI;
use glintbake_format::model::LobeLattice;

/// One lobe about the origin: `∫ N(u; centre, Σp) N(u; 0, σh² I) N(s; J u, σr² I) du`.
#[derive(Clone, Copy, Debug)]
struct One {
    centre: [f64; 2],
    factors: [[f64; 2]; 2],
    slope: [[f64; 2]; 2],
    deviation: f64,
    roughness: f64,
}

impl One {
    fn closed_form(&self, s: [f64; 2]) -> f64 {
        let exact = |x: [f64; 2]| x.map(DoubleDouble::from);
        let position = Position::new(self.deviation, self.factors.map(exact));
        let (columns, determinant) = position.seen();
        let spread = Spread::new(self.slope, columns, determinant);
        let look = position.look(exact(self.centre));
        let d =
            [0, 1].map(|k: usize| s[k] - self.slope[0][k] * look[0] - self.slope[1][k] * look[1]);
        position.density(exact(self.centre)) * spread.density(d, self.roughness * self.roughness)
    }

    /// Over z, with `u = centre + E z`.
    fn quadrature(&self, s: [f64; 2]) -> f64 {
        let residual = |z: [f64; 2]| {
            let u = [0, 1].map(|k: usize| {
                self.centre[k] + self.factors[0][k] * z[0] + self.factors[1][k] * z[1]
            });
            let n = [0, 1].map(|k: usize| {
                (self.slope[0][k] * u[0] + self.slope[1][k] * u[1] - s[k]) / self.roughness
            });
            [
                z[0],
                z[1],
                u[0] / self.deviation,
                u[1] / self.deviation,
                n[0],
                n[1],
            ]
        };
        let side = 9.5;
        let corners = [[-side, -side], [side, -side], [side, side], [-side, side]].map(residual);
        let area = 2.0 * side * side;
        let sum = bell_over_triangle([corners[0], corners[1], corners[2]], area)
            + bell_over_triangle([corners[0], corners[2], corners[3]], area);
        let norm = 2.0 * PI * self.deviation * self.roughness;
        sum / (2.0 * PI * norm * norm)
    }

    /// The most likely s, moved by so many deviations of the kernel.
    fn near(&self, moved: [f64; 2]) -> [f64; 2] {
        let position = Position::new(
            self.deviation,
            self.factors.map(|factor| factor.map(DoubleDouble::from)),
        );
        let look = position.look(self.centre.map(DoubleDouble::from));
        [0, 1].map(|k: usize| {
            self.slope[0][k] * look[0] + self.slope[1][k] * look[1] + self.roughness * moved[k]
        })
    }
}

#[test]
fn one_lobe_is_its_integral() {
    let deviation = LobeLattice::DEVIATION;
    let mut random = Random(11);
    let mut cases = Vec::new();
    for size in [1e-4, 0.3, 3.0] {
        for steep in [0.0, 0.1, 10.0] {
            let one = One {
                centre: random.vector(0.6),
                factors: [random.vector(size), random.vector(0.5 * size)],
                slope: [random.vector(steep), random.vector(steep)],
                deviation,
                roughness: 0.05,
            };
            let [x, _] = one.slope;
            // A general slope, one of rank 1, and none along rows.
            for slope in [one.slope, [x, x.map(|s| -0.7 * s)], [x, [0.0; 2]]] {
                cases.push(One { slope, ..one });
            }
        }
    }
    let one = cases[4];
    for factors in [
        // A point, lines, nearly parallel edges, needles.
        [[0.0; 2]; 2],
        [[2.0, 1.0], [0.0; 2]],
        [[2.0, 1.0], [-4.0, -2.0]],
        [[2.0, 1.0], [-4.0, -2.0 - 1e-9]],
        [[3.0, 4.0], [-4e-6, 3e-6]],
        [[0.0, 20.0], [2e-5, 0.0]],
    ] {
        cases.push(One { factors, ..one });
    }
    // Stiff: |J| σh / σr up to 1e6.
    for stiff in [1e3, 1e6] {
        let steep = stiff / deviation;
        let one = One {
            centre: [0.2, -0.1],
            factors: [[0.5, 0.2], [-0.1, 0.6]],
            slope: [[0.8 * steep, 0.1 * steep], [-0.2 * steep, 0.9 * steep]],
            deviation,
            roughness: 1.0,
        };
        cases.push(one);
        cases.push(One {
            factors: [[1e-4, 0.0], [0.0, 2e-4]],
            ..one
        });
        cases.push(One {
            slope: [[steep, 0.5 * steep], [0.0, 0.0]],
            factors: [[0.5, 0.0], [0.0, 0.7]],
            ..one
        });
    }
    let mut worst = 0.0_f64;
    for one in cases {
        for moved in [[0.0, 0.0], [1.0, -0.5], [-2.0, 2.5]] {
            let s = one.near(moved);
            let (closed, exact) = (one.closed_form(s), one.quadrature(s));
            let error = (closed / exact - 1.0).abs();
            // Beyond what brute force itself resolves of a stiff slope: 1e-16 of its thousands of deviations.
            assert!(error < 2e-9, "{error} of {exact} for {one:?} at {s:?}");
            if one.slope.as_flattened().iter().all(|x| x.abs() < 100.0) {
                worst = worst.max(error);
            }
        }
    }
    assert!(worst < 1e-11, "{worst}");
}
