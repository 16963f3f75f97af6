//! The integral over the surface, against brute force in two dimensions and closed forms.

use super::super::analytic::Prepared;
use super::bells::bell_over_triangle;
use super::{Random, in_texels, varied_map};
use crate::normals::NormalMap;
use core::f64::consts::PI;
use glintbake_format::model::{Footprint, HalfVector, Interpolation, Wrap};

/// The surface and the footprint as the definition has them.
struct Brute<'a> {
    map: &'a NormalMap,
    interpolation: Interpolation,
    centre: [f64; 2],
    edges: [[f64; 2]; 2],
}

/// Catmull and Rom's weights of four values, at x between the second and the third.
fn catmull_rom(x: f64) -> [f64; 4] {
    let (x2, x3) = (x * x, x * x * x);
    [
        0.5 * (-x3 + 2.0 * x2 - x),
        0.5 * (3.0 * x3 - 5.0 * x2 + 2.0),
        0.5 * (-3.0 * x3 + 4.0 * x2 + x),
        0.5 * (x3 - x2),
    ]
}

impl Brute<'_> {
    fn texel(&self, i: i64, j: i64) -> [f64; 2] {
        let size = [self.map.width(), self.map.height()].map(i64::from);
        let [i, j] = [(i, size[0]), (j, size[1])].map(|(index, n)| match self.map.wrap() {
            Wrap::Repeat => index.rem_euclid(n),
            Wrap::Clamp => index.clamp(0, n - 1),
        });
        self.map.texels()[(j * size[0] + i) as usize].map(f64::from)
    }

    fn vertex(&self, column: i64, row: i64) -> [f64; 2] {
        if self.interpolation != Interpolation::CatmullRom {
            return self.texel(column, row);
        }
        let part = |index: i64| catmull_rom(index.rem_euclid(4) as f64 / 4.0);
        let mut sum = [0.0; 2];
        for (down, along) in part(row).into_iter().enumerate() {
            for (right, across) in part(column).into_iter().enumerate() {
                let i = column.div_euclid(4) + right as i64 - 1;
                let j = row.div_euclid(4) + down as i64 - 1;
                let texel = self.texel(i, j);
                for axis in 0..2 {
                    sum[axis] += along * across * texel[axis];
                }
            }
        }
        sum
    }

    /// The surface's normal at the footprint's centre.
    fn normal_at_centre(&self) -> [f64; 2] {
        let (per_side, offset) = match self.interpolation {
            Interpolation::None => (1.0, 0.0),
            Interpolation::Linear => (1.0, 0.5),
            Interpolation::CatmullRom => (4.0, 0.5),
        };
        let place = self.centre.map(|x| (x - offset) * per_side);
        let [column, row] = place.map(|x| libm::floor(x) as i64);
        if self.interpolation == Interpolation::None {
            return self.texel(column, row);
        }
        let [x, y] = place.map(|x| x - libm::floor(x));
        // Barycentric shares of the corners: the upper left and the lower right one are never both there.
        let shares = if x + y < 1.0 {
            [(0, 0, 1.0 - x - y), (1, 0, x), (0, 1, y)]
        } else {
            [(1, 1, x + y - 1.0), (0, 1, 1.0 - x), (1, 0, 1.0 - y)]
        };
        let mut sum = [0.0; 2];
        for (right, down, share) in shares {
            let vertex = self.vertex(column + right, row + down);
            sum = [sum[0] + share * vertex[0], sum[1] + share * vertex[1]];
        }
        sum
    }

    fn density(&self, h: HalfVector, roughness: f64) -> f64 {
        let entry = |i: usize, j: usize| {
            0.25 * (self.edges[0][i] * self.edges[0][j] + self.edges[1][i] * self.edges[1][j])
        };
        let (xx, xy, yy) = (entry(0, 0) + 1e-12, entry(0, 1), entry(1, 1) + 1e-12);
        let deviation = libm::sqrt(xx);
        let spread = libm::sqrt(yy - xy * xy / xx);
        let residual = |x: f64, y: f64, n: [f64; 2]| {
            let (x, y) = (x - self.centre[0], y - self.centre[1]);
            [
                x / deviation,
                (y - xy / xx * x) / spread,
                (n[0] - h.s) / roughness,
                (n[1] - h.t) / roughness,
            ]
        };
        let (per_side, offset) = match self.interpolation {
            Interpolation::None => (1.0, 0.0),
            Interpolation::Linear => (1.0, 0.5),
            Interpolation::CatmullRom => (4.0, 0.5),
        };
        let spacing = 1.0 / per_side;
        let reach = [xx, yy].map(|variance| 12.0 * libm::sqrt(variance));
        let range = |axis: usize| {
            let cell = |place: f64| libm::floor((place - offset) * per_side) as i64;
            cell(self.centre[axis] - reach[axis])..=cell(self.centre[axis] + reach[axis])
        };
        let area = 0.5 * spacing * spacing;
        let mut sum = 0.0;
        for row in range(1) {
            for column in range(0) {
                let corner = |right: i64, down: i64| {
                    let (i, j) = (column + right, row + down);
                    let n = match self.interpolation {
                        Interpolation::None => self.vertex(column, row),
                        _ => self.vertex(i, j),
                    };
                    residual(i as f64 * spacing + offset, j as f64 * spacing + offset, n)
                };
                let [left, right] = [corner(0, 1), corner(1, 0)];
                sum += bell_over_triangle([corner(0, 0), right, left], area);
                sum += bell_over_triangle([corner(1, 1), left, right], area);
            }
        }
        let norm = 2.0 * PI * roughness;
        sum / (norm * norm * deviation * spread)
    }
}

/// The largest relative error at some half vectors about normals under the footprint, of densities above 1e-10 of the
/// kernel's peak, so that steep surfaces, whose densities are far below it, are held to their own.
fn worst(brute: &Brute, roughness: f64) -> f64 {
    let footprint = in_texels(brute.map, brute.centre, brute.edges[0], brute.edges[1]);
    let prepared = Prepared::new(brute.map, &footprint, brute.interpolation);
    let middle = brute.normal_at_centre();
    let texel = brute.centre.map(|x| libm::floor(x) as i64);
    let own = brute.texel(texel[0], texel[1]);
    let between = [0, 1].map(|k: usize| 0.5 * (own[k] + middle[k]));
    let mut error = 0.0_f64;
    for (n, moved) in [
        (middle, [0.0, 0.0]),
        (middle, [1.0, -2.0]),
        (own, [0.3, 0.4]),
        (between, [0.5, 0.0]),
        (between, [-3.0, 3.0]),
    ] {
        let h = HalfVector {
            s: n[0] + moved[0] * roughness,
            t: n[1] + moved[1] * roughness,
        };
        if h.s * h.s + h.t * h.t > 1.0 {
            continue;
        }
        let alpha = core::f64::consts::SQRT_2 * roughness;
        let (density, exact) = (prepared.ndf(h, alpha), brute.density(h, roughness));
        let peak = 1.0 / (2.0 * PI * roughness * roughness);
        if moved == [0.0, 0.0] {
            assert!(exact > 1e-9 * peak, "nothing of {exact} at the middle");
        }
        error = error.max((density - exact).abs() / exact.max(1e-10 * peak));
    }
    error
}

#[test]
fn every_interpolation_and_wrap_is_what_brute_force_finds() {
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let map = varied_map(5, 4, wrap);
        for &interpolation in Interpolation::ALL {
            for (centre, edges) in [
                ([2.3, 1.9], [[0.5, 0.1], [-0.2, 0.7]]),
                ([4.8, 0.2], [[1.3, 0.4], [0.3, 0.2]]),
                ([-0.4, 4.3], [[0.0, 2.0], [0.6, 0.0]]),
            ] {
                let brute = Brute {
                    map: &map,
                    interpolation,
                    centre,
                    edges,
                };
                for roughness in [0.01, 0.2] {
                    let error = worst(&brute, roughness);
                    assert!(
                        error < 1e-11,
                        "{wrap:?} {interpolation:?} {edges:?} {roughness}: {error}"
                    );
                }
            }
        }
    }
}

#[test]
fn footprints_of_any_size_and_shape_are_what_brute_force_finds() {
    let map = varied_map(6, 7, Wrap::Repeat);
    for (edges, roughness) in [
        ([[1e-4, 0.0], [0.0, 1e-4]], 0.01),
        ([[1e-4, 1e-4], [1e-5, 0.0]], 1e-4),
        // A point and lines: as wide as the floor of a millionth of a texel.
        ([[0.0; 2]; 2], 0.02),
        ([[1.0, 0.0], [0.0; 2]], 0.02),
        ([[0.02, 0.05], [0.02, 0.05]], 0.05),
        ([[0.0, 2.0], [1e-3, 0.0]], 0.02),
        ([[4.0, 1.0], [-1.0, 3.0]], 0.1),
        ([[6.0, 1.0], [0.06, 0.02]], 0.002),
    ] {
        for centre in [[2.6, 3.2], [3.0, 2.5]]
            .into_iter()
            // On a diagonal, which matters where nothing else is seen.
            .filter(|&centre| centre[0] < 3.0 || edges[0][0] < 0.1)
        {
            let brute = Brute {
                map: &map,
                interpolation: Interpolation::Linear,
                centre,
                edges,
            };
            let error = worst(&brute, roughness);
            assert!(
                error < 1e-11,
                "{edges:?} {roughness} at {centre:?}: {error}"
            );
        }
    }
}

#[test]
fn steep_folded_and_flat_surfaces_are_what_brute_force_finds() {
    let step = 0.99_f32;
    let maps = [
        // One step, a fold along rows, both ways at once, a mirror, flat but for one texel.
        [[-step, 0.0], [step, 0.0], [-step, 0.0], [step, 0.0]],
        [[0.3, 0.1], [-0.3, -0.1], [0.3, 0.1], [-0.3, -0.1]],
        [[0.0, -step], [0.7, 0.7], [-0.7, 0.7], [0.0, 0.0]],
        [[0.1, 0.0], [-0.1, 0.0], [0.1, 0.2], [-0.1, 0.2]],
        [[0.2, 0.2], [0.2, 0.2], [0.2, 0.2], [0.2001, 0.2]],
    ];
    for texels in maps {
        let map = NormalMap::new(2, 2, Wrap::Clamp, texels.to_vec());
        for roughness in [0.05, 1e-3, 1e-4] {
            for edges in [[[0.8, 0.2], [0.1, 0.6]], [[0.01, 0.0], [0.005, 0.01]]] {
                let brute = Brute {
                    map: &map,
                    interpolation: Interpolation::Linear,
                    centre: [1.05, 0.9],
                    edges,
                };
                let error = worst(&brute, roughness);
                assert!(error < 1e-11, "{texels:?} {roughness} {edges:?}: {error}");
            }
        }
    }
}

#[test]
fn a_plane_of_normals_gives_one_gaussian() {
    // s and t are multiples of powers of two, exact in f32: n(u) = n0 + J u.
    let slope = [[0.0078125, -0.00390625], [0.001953125, 0.01171875]];
    let at = |x: f64, y: f64| {
        [0, 1].map(|k: usize| 0.015625 + slope[0][k] * (x - 16.0) + slope[1][k] * (y - 16.0))
    };
    let texels = (0..32 * 32)
        .map(|k| at(f64::from(k % 32) + 0.5, f64::from(k / 32) + 0.5).map(|x| x as f32))
        .collect();
    let map = NormalMap::new(32, 32, Wrap::Clamp, texels);
    for interpolation in [Interpolation::Linear, Interpolation::CatmullRom] {
        for edges in [
            [[2.0, 0.5], [-0.3, 1.2]],
            [[1e-3, 0.0], [0.0, 1e-3]],
            [[2.5, 1.5], [0.0; 2]],
        ] {
            for roughness in [1e-4, 0.01] {
                let centre = [15.2, 17.1];
                let prepared = Prepared::new(
                    &map,
                    &in_texels(&map, centre, edges[0], edges[1]),
                    interpolation,
                );
                let moved = |edge: [f64; 2]| {
                    [0, 1].map(|k: usize| 0.5 * (slope[0][k] * edge[0] + slope[1][k] * edge[1]))
                };
                let [f, g] = edges.map(moved);
                let entry = |i: usize, j: usize| {
                    let floor = 1e-12 * (slope[0][i] * slope[0][j] + slope[1][i] * slope[1][j]);
                    let kernel = if i == j { roughness * roughness } else { 0.0 };
                    f[i] * f[j] + g[i] * g[j] + floor + kernel
                };
                let [ss, st, tt] = [entry(0, 0), entry(0, 1), entry(1, 1)];
                let determinant = ss * tt - st * st;
                let mean = at(centre[0], centre[1]);
                for z in [[0.0, 0.0], [1.0, 1.0], [-2.0, 1.0]] {
                    let d = [
                        z[0] * libm::sqrt(ss),
                        z[0] * st / libm::sqrt(ss) + z[1] * libm::sqrt(determinant / ss),
                    ];
                    let expected = libm::exp(-0.5 * (z[0] * z[0] + z[1] * z[1]))
                        / (2.0 * PI * libm::sqrt(determinant));
                    let h = HalfVector {
                        s: mean[0] + d[0],
                        t: mean[1] + d[1],
                    };
                    let density = prepared.ndf(h, core::f64::consts::SQRT_2 * roughness);
                    assert!(
                        (density / expected - 1.0).abs() < 1e-10,
                        "{interpolation:?} {edges:?} {roughness} {z:?}: {density} {expected}"
                    );
                    let cosine = libm::sqrt(1.0 - h.s * h.s - h.t * h.t);
                    let drawn = prepared.pdf(h, core::f64::consts::SQRT_2 * roughness);
                    assert!((drawn / (density * cosine) - 1.0).abs() < 1e-14);
                }
            }
        }
    }
}

#[test]
fn a_constant_map_is_one_gaussian_whatever_the_footprint() {
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let map = NormalMap::new(3, 2, wrap, vec![[0.25, -0.5]; 6]);
        for (alpha, moved) in [(1e-4, 0.0), (1e-4, 0.3), (0.1, 0.1), (1.0, 0.3)] {
            let h = HalfVector {
                s: 0.25,
                t: -0.5 + moved * alpha,
            };
            let expected = libm::exp(-moved * moved) / (PI * alpha * alpha);
            for edges in [
                [[0.0; 2]; 2],
                [[1e-4, 0.0], [0.0, 1e-4]],
                [[48.0, 20.0], [1e-3, 2e-4]],
                [[192.0, 0.0], [0.0, 128.0]],
                [[24.0, 0.0], [0.0, 0.1]],
            ] {
                for &interpolation in Interpolation::ALL {
                    let footprint = in_texels(&map, [1.3, -7.0], edges[0], edges[1]);
                    let density = Prepared::new(&map, &footprint, interpolation).ndf(h, alpha);
                    // 1e-16 of (s, t) is 1e-12 deviations of the least kernel.
                    assert!(
                        (density / expected - 1.0).abs() < 2e-11,
                        "{wrap:?} {interpolation:?} {edges:?} {alpha} {moved}: {density} {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn copies_are_integrated_where_footprints_are_wide() {
    let map = varied_map(3, 4, Wrap::Repeat);
    for (edges, bound) in [
        ([[8.0, 1.0], [-1.0, 10.5]], 1e-12),
        ([[9.0, 0.0], [0.0, 0.3]], 1e-12),
        ([[4.0, 1.0], [1.0, 17.0]], 1e-12),
        ([[6.2, 0.0], [0.0, 8.4]], 1e-8),
    ] {
        let footprint = in_texels(&map, [1.7, 0.4], edges[0], edges[1]);
        for &interpolation in &Interpolation::ALL[..2] {
            let each = Prepared::with_even_tiles(&map, &footprint, interpolation, 1e9);
            let even = Prepared::with_even_tiles(&map, &footprint, interpolation, 1.0);
            for (h, alpha) in [([0.1, -0.2], 0.02), ([-0.3, 0.1], 0.3)] {
                let h = HalfVector { s: h[0], t: h[1] };
                let (a, b) = (each.ndf(h, alpha), even.ndf(h, alpha));
                assert!(
                    (a - b).abs() <= bound * a.max(1e-3),
                    "{a} {b} {edges:?} {interpolation:?}"
                );
            }
        }
    }
}

#[test]
fn a_clamped_map_from_far_away_is_its_border() {
    let map = varied_map(4, 4, Wrap::Clamp);
    let corner = map.texels()[15].map(f64::from);
    for &interpolation in Interpolation::ALL {
        let footprint = in_texels(&map, [500.0, 300.0], [30.0, 0.0], [0.0, 20.0]);
        let prepared = Prepared::new(&map, &footprint, interpolation);
        let h = HalfVector {
            s: corner[0],
            t: corner[1],
        };
        let expected = 1.0 / (PI * 0.01);
        assert!((prepared.ndf(h, 0.1) / expected - 1.0).abs() < 1e-13);
        // 200 tiles: half of a plane is beyond each border, and a quarter beyond each corner.
        let wide = Footprint {
            centre: [0.5, 0.5],
            edge_1: [200.0, 0.0],
            edge_2: [0.0, 200.0],
        };
        let prepared = Prepared::new(&map, &wide, interpolation);
        let corners = [0, 3, 12, 15].map(|k: usize| map.texels()[k].map(f64::from));
        let expected: f64 = corners
            .iter()
            .map(|n| {
                let squared = (n[0] - h.s) * (n[0] - h.s) + (n[1] - h.t) * (n[1] - h.t);
                0.25 * libm::exp(-squared / 0.01) / (PI * 0.01)
            })
            .sum();
        // The map and its strips hold about 4 texels / 400 texels of deviation of the weight.
        assert!(
            (prepared.ndf(h, 0.1) / expected - 1.0).abs() < 0.02,
            "{interpolation:?}"
        );
    }
}

#[test]
fn what_the_disk_holds_adds_up_to_one() {
    let mut random = Random(3);
    let texels = (0..12)
        .map(|_| random.vector(0.25).map(|x| x as f32))
        .collect();
    let map = NormalMap::new(4, 3, Wrap::Repeat, texels);
    let footprint = in_texels(&map, [1.2, 2.2], [1.1, 0.4], [-0.3, 0.6]);
    for &interpolation in Interpolation::ALL {
        let prepared = Prepared::new(&map, &footprint, interpolation);
        // Squares of a deviation: their sum over a Gaussian's convolution errs by 2 exp(-2π²).
        let alpha = 0.1 * core::f64::consts::SQRT_2;
        let step = 0.1;
        let count = 10;
        let mut sum = 0.0;
        for row in -count..count {
            for column in -count..count {
                let at = |k: i32| (f64::from(k) + 0.5) * step;
                sum += prepared.ndf(
                    HalfVector {
                        s: at(column),
                        t: at(row),
                    },
                    alpha,
                );
            }
        }
        let energy = sum * step * step;
        assert!((energy - 1.0).abs() < 2e-8, "{interpolation:?}: {energy}");
    }
    let prepared = Prepared::new(&map, &footprint, Interpolation::Linear);
    for outside in [[1.0 + 1e-12, 0.0], [f64::NAN, 0.0]] {
        let h = HalfVector {
            s: outside[0],
            t: outside[1],
        };
        assert_eq!((prepared.ndf(h, 0.5), prepared.pdf(h, 0.5)), (0.0, 0.0));
    }
}
