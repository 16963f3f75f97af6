//! The sum over lobes, against a plain sum by other formulas, and identities.

use super::super::lobes::Prepared;
use super::super::lobes::lattice::seed;
use super::{in_texels, varied_map};
use crate::normals::NormalMap;
use core::f64::consts::PI;
use glintbake_format::model::{Footprint, HalfVector, LobeLattice, Wrap};

const LATTICES: [LobeLattice; 4] = [
    LobeLattice {
        curved: true,
        per_side: 1,
    },
    LobeLattice {
        curved: true,
        per_side: 2,
    },
    LobeLattice {
        curved: false,
        per_side: 1,
    },
    LobeLattice {
        curved: false,
        per_side: 2,
    },
];

/// The definition, with 2 × 2 inverses as they stand, over all lobes within `tiles` copies.
struct Plain<'a> {
    map: &'a NormalMap,
    lattice: LobeLattice,
    centre: [f64; 2],
    /// Σp in texels².
    covariance: [[f64; 2]; 2],
    tiles: i64,
}

type Matrix = [[f64; 2]; 2];

fn product(a: Matrix, b: Matrix) -> Matrix {
    [0, 1].map(|i: usize| [0, 1].map(|j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

fn transposed(a: Matrix) -> Matrix {
    [[a[0][0], a[1][0]], [a[0][1], a[1][1]]]
}

fn inverse(a: Matrix) -> Matrix {
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    [[a[1][1], -a[0][1]], [-a[1][0], a[0][0]]].map(|row| row.map(|x| x / determinant))
}

fn plus(a: Matrix, b: Matrix) -> Matrix {
    [0, 1].map(|i: usize| [0, 1].map(|j: usize| a[i][j] + b[i][j]))
}

fn times(a: Matrix, x: [f64; 2]) -> [f64; 2] {
    a.map(|row| row[0] * x[0] + row[1] * x[1])
}

fn normal(x: [f64; 2], covariance: Matrix) -> f64 {
    let y = times(inverse(covariance), x);
    let determinant = covariance[0][0] * covariance[1][1] - covariance[0][1] * covariance[1][0];
    libm::exp(-0.5 * (x[0] * y[0] + x[1] * y[1])) / (2.0 * PI * libm::sqrt(determinant))
}

impl Plain<'_> {
    /// The raw sum, and the sum of weights.
    fn sums(&self, h: HalfVector, alpha: f64) -> [f64; 2] {
        let spacing = 1.0 / f64::from(self.lattice.per_side);
        let count = self
            .lattice
            .size(self.map.width(), self.map.height())
            .map(i64::from);
        let variance = LobeLattice::DEVIATION * LobeLattice::DEVIATION * spacing * spacing;
        let lobe = [[variance, 0.0], [0.0, variance]];
        let total = plus(lobe, self.covariance);
        let look = product(lobe, inverse(total));
        let seen = product(look, self.covariance);
        let kernel = 0.5 * alpha * alpha;
        let mut sums = [0.0; 2];
        for row in -self.tiles * count[1]..(self.tiles + 1) * count[1] {
            for column in -self.tiles * count[0]..(self.tiles + 1) * count[0] {
                let place = [column, row].map(|index| (index as f64 + 0.5) * spacing);
                let d = [self.centre[0] - place[0], self.centre[1] - place[1]];
                let weight = spacing * spacing * normal(d, total);
                if weight < 1e-22 {
                    continue;
                }
                let (lobe, is_inside) = self.lobe(column, row, count);
                let slope = if is_inside {
                    transposed(lobe.1)
                } else {
                    [[0.0; 2]; 2]
                };
                let shift = times(slope, times(look, d));
                let spread = plus(
                    product(product(slope, seen), transposed(slope)),
                    [[kernel, 0.0], [0.0, kernel]],
                );
                let distance = [h.s - lobe.0[0] - shift[0], h.t - lobe.0[1] - shift[1]];
                sums[0] += weight * normal(distance, spread);
                sums[1] += weight;
            }
        }
        sums
    }

    fn lobe(&self, column: i64, row: i64, count: [i64; 2]) -> (([f64; 2], Matrix), bool) {
        let at = [column, row];
        let is_inside = (0..2).all(|k| (0..count[k]).contains(&at[k]));
        let [column, row] = match self.map.wrap() {
            Wrap::Repeat => at,
            Wrap::Clamp => [0, 1].map(|k: usize| at[k].clamp(0, count[k] - 1)),
        };
        let lobe = seed(self.map, self.lattice, column, row);
        let keeps_slope = is_inside || self.map.wrap() == Wrap::Repeat;
        ((lobe.normal, lobe.slope), keeps_slope)
    }
}

fn covariance(edges: [[f64; 2]; 2]) -> Matrix {
    [0, 1].map(|i: usize| {
        [0, 1].map(|j: usize| 0.25 * (edges[0][i] * edges[0][j] + edges[1][i] * edges[1][j]))
    })
}

/// Half vectors about some normals of the map.
fn half_vectors(map: &NormalMap, alpha: f64) -> Vec<HalfVector> {
    let mut vectors = vec![HalfVector { s: 0.0, t: 0.0 }];
    vectors.extend(map.texels().iter().step_by(5).map(|texel| HalfVector {
        s: f64::from(texel[0]) + 0.7 * alpha,
        t: f64::from(texel[1]) - 0.4 * alpha,
    }));
    vectors
}

#[test]
fn it_is_the_plain_sum() {
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let map = varied_map(5, 4, wrap);
        for lattice in LATTICES {
            for (centre, edges, tiles) in [
                ([2.3, 1.9], [[0.5, 0.1], [-0.2, 0.7]], 2),
                ([0.1, 3.8], [[1e-3, 0.0], [0.0, 1e-3]], 2),
                ([4.0, 0.0], [[4.0, 2.0], [-1.0, 3.0]], 6),
                ([-1.5, 6.0], [[3.0, 0.0], [0.0, 0.2]], 5),
            ] {
                let plain = Plain {
                    map: &map,
                    lattice,
                    centre,
                    covariance: covariance(edges),
                    tiles,
                };
                let footprint = in_texels(&map, centre, edges[0], edges[1]);
                let raw = Prepared::new(&map, &footprint, lattice, false);
                let even = Prepared::new(&map, &footprint, lattice, true);
                for h in half_vectors(&map, 0.1) {
                    let [density, total] = plain.sums(h, 0.1);
                    let scale = density.max(1e-6);
                    assert!(
                        (raw.ndf(h, 0.1) - density).abs() < 1e-11 * scale,
                        "{wrap:?} {lattice:?} {edges:?}: {} {density}",
                        raw.ndf(h, 0.1)
                    );
                    assert!((even.ndf(h, 0.1) - density / total).abs() < 1e-11 * scale / total);
                    assert!((raw.total() / total - 1.0).abs() < 1e-13);
                    let cosine = libm::sqrt(1.0 - h.s * h.s - h.t * h.t);
                    assert!((raw.pdf(h, 0.1) - raw.ndf(h, 0.1) * cosine).abs() <= 1e-14 * scale);
                }
            }
        }
    }
}

#[test]
fn rows_beyond_the_border_are_summed_as_if_one_by_one() {
    let map = varied_map(3, 4, Wrap::Clamp);
    let lattice = LATTICES[1];
    // Deviations of 8 to 15 texels, up to 30 spacings: some rows by Euler and Maclaurin, some by lobes.
    for edges in [[[30.0, 3.0], [-2.0, 16.0]], [[16.5, 0.0], [0.0, 5.0]]] {
        let centre = [9.0, 1.0];
        let plain = Plain {
            map: &map,
            lattice,
            centre,
            covariance: covariance(edges),
            tiles: 50,
        };
        let footprint = in_texels(&map, centre, edges[0], edges[1]);
        let prepared = Prepared::new(&map, &footprint, lattice, false);
        for h in half_vectors(&map, 0.3).into_iter().take(2) {
            let [density, total] = plain.sums(h, 0.3);
            let error = prepared.ndf(h, 0.3) / density - 1.0;
            assert!(error.abs() < 1e-12, "{error} for {edges:?}");
            assert!((prepared.total() / total - 1.0).abs() < 1e-13);
        }
    }
}

#[test]
fn copies_are_integrated_where_footprints_are_wide() {
    let map = varied_map(3, 4, Wrap::Repeat);
    for lattice in [LATTICES[0], LATTICES[1]] {
        for (edges, error_bound) in [
            // Wide everywhere, along columns, along rows, aslant; then narrower, to see that the waves are as stated.
            ([[10.0, 1.0], [-1.0, 13.0]], 1e-13),
            ([[14.0, 0.0], [0.0, 0.3]], 1e-13),
            ([[4.0, 1.0], [1.0, 17.0]], 1e-13),
            ([[6.2, 0.0], [0.0, 8.4]], 1e-8),
        ] {
            let footprint = in_texels(&map, [1.7, 0.4], edges[0], edges[1]);
            let each = Prepared::with_even_tiles(&map, &footprint, lattice, true, 1e9);
            let even = Prepared::with_even_tiles(&map, &footprint, lattice, true, 1.0);
            let raw = Prepared::with_even_tiles(&map, &footprint, lattice, false, 1.0);
            assert!(even.terms() * 4 < each.terms());
            for alpha in [0.02, 0.4] {
                for h in half_vectors(&map, alpha) {
                    let (a, b) = (each.ndf(h, alpha), even.ndf(h, alpha));
                    assert!(
                        (a - b).abs() <= error_bound * a.max(1e-6),
                        "{a} {b} for {edges:?}, roughness {alpha}"
                    );
                    let c = raw.ndf(h, alpha) / raw.total();
                    assert!((b - c).abs() <= 1e-14 * a.max(1e-6));
                }
            }
            assert!((each.total() / even.total() - 1.0).abs() < error_bound);
        }
    }
}

#[test]
fn a_constant_map_is_one_gaussian_whatever_the_footprint() {
    let map = NormalMap::new(3, 2, Wrap::Clamp, vec![[0.25, -0.5]; 6]);
    let repeated = NormalMap::new(3, 2, Wrap::Repeat, vec![[0.25, -0.5]; 6]);
    let h = HalfVector { s: 0.3, t: -0.45 };
    for alpha in [1e-4, 0.1] {
        let expected = libm::exp(-0.005 / (alpha * alpha)) / (PI * alpha * alpha);
        for map in [&map, &repeated] {
            for edges in [
                [[0.0; 2]; 2],
                [[1e-4, 0.0], [0.0, 1e-4]],
                [[1e3, 2e2], [1e-3, 1e-3]],
                [[192.0, 0.0], [0.0, 128.0]],
            ] {
                let footprint = in_texels(map, [1e6 + 0.3, -7.0], edges[0], edges[1]);
                for lattice in LATTICES {
                    let prepared = Prepared::new(map, &footprint, lattice, true);
                    let density = prepared.ndf(h, alpha);
                    assert!(
                        (density - expected).abs() <= 1e-12 * expected,
                        "{density} {expected} {edges:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn ripple_and_energy_are_as_the_papers_lobes_have_them() {
    let map = varied_map(8, 8, Wrap::Repeat);
    for (lattice, at, from, to) in [
        // Under a point: from between four lobes to the middle of one.
        (LATTICES[0], 0.0, 0.88, 0.90),
        (LATTICES[0], 0.5, 1.115, 1.13),
        (LATTICES[1], 0.25, 1.115, 1.13),
    ] {
        let point = in_texels(&map, [4.0 + at, 4.0 + at], [0.0; 2], [0.0; 2]);
        let total = Prepared::new(&map, &point, lattice, false).total();
        assert!((from..to).contains(&total), "{total} at {at}");
    }
    let footprint = in_texels(&map, [3.1, 4.7], [1.1, 0.3], [-0.2, 0.9]);
    for lattice in LATTICES {
        let prepared = Prepared::new(&map, &footprint, lattice, true);
        let side = 80;
        let step = 2.0 / f64::from(side);
        let at = |k: i32| (f64::from(k) + 0.5) * step - 1.0;
        let sum: f64 = (0..side * side)
            .map(|k| {
                prepared.ndf(
                    HalfVector {
                        s: at(k % side),
                        t: at(k / side),
                    },
                    0.08,
                )
            })
            .sum();
        // Normals end 0.6 from the middle, and slopes carry a few of them beyond the rim.
        let energy = sum * step * step;
        assert!((0.98..1.0 + 1e-9).contains(&energy), "{energy}");
        if !lattice.curved {
            assert!((energy - 1.0).abs() < 1e-7, "{energy}");
        }
    }
    for outside in [[1.0 + 1e-12, 0.0], [f64::NAN, 0.0]] {
        let prepared = Prepared::new(&map, &footprint, LATTICES[0], true);
        let h = HalfVector {
            s: outside[0],
            t: outside[1],
        };
        assert_eq!((prepared.ndf(h, 0.5), prepared.pdf(h, 0.5)), (0.0, 0.0));
    }
}

#[test]
fn seeds_are_the_lattices_own() {
    let map = NormalMap::new(
        3,
        2,
        Wrap::Clamp,
        vec![
            [0.0, 0.5],
            [0.25, 0.5],
            [0.75, 0.5],
            [0.0, 0.0],
            [0.25, 0.0],
            [0.75, 0.0],
        ],
    );
    let lobe = seed(&map, LATTICES[0], 1, 0);
    assert_eq!(
        (lobe.normal, lobe.slope),
        ([0.25, 0.5], [[0.375, 0.0], [0.0, -0.25]])
    );
    let flat = seed(&map, LATTICES[2], 1, 0);
    assert_eq!((flat.normal, flat.slope), ([0.25, 0.5], [[0.0; 2]; 2]));
    // A quarter of a texel right of the second middle, and a quarter below the first row's.
    let lobe = seed(&map, LATTICES[1], 3, 1);
    assert_eq!(
        (lobe.normal, lobe.slope),
        ([0.375, 0.375], [[0.5, 0.0], [0.0, -0.5]])
    );
    let corner = seed(&map, LATTICES[1], 0, 0);
    assert_eq!((corner.normal, corner.slope), ([0.0, 0.5], [[0.0; 2]; 2]));
}

#[test]
fn extremes_stay_finite() {
    let map = NormalMap::new(2, 1, Wrap::Repeat, vec![[0.99, 0.0], [-0.99, 0.0]]);
    for edges in [
        [[1.0, 1.0], [1e-6, -1e-6]],
        [[1e-300, 0.0], [0.0, 0.0]],
        [[64.0, 0.0], [0.0, 64.0]],
    ] {
        let footprint = Footprint {
            centre: [1e6 + 0.2, -0.7],
            edge_1: edges[0],
            edge_2: edges[1],
        };
        for lattice in LATTICES {
            let prepared = Prepared::new(&map, &footprint, lattice, true);
            for alpha in [1e-4, 1.0] {
                for s in [0.99, 0.0, -1.0] {
                    let density = prepared.ndf(HalfVector { s, t: 0.0 }, alpha);
                    assert!(density.is_finite() && density >= 0.0);
                }
            }
        }
    }
}
