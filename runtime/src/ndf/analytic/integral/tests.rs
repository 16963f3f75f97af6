//! Both forms against brute force: the inner integral in closed form, the outer one by adaptive quadrature.

extern crate std;
use super::paper::{experf, expquad};
use super::wedge::share;
use super::whiten::{Whitened, whiten};
use super::*;

/// Ten nodes of Gauss and Legendre on [0, 1]: half of them, from the middle outwards.
const NODES: [[f64; 2]; 5] = [
    [0.074_437_169_490_815_6, 0.147_762_112_357_376_44],
    [0.216_697_697_064_623_6, 0.134_633_359_654_998_17],
    [0.339_704_784_149_512_2, 0.109_543_181_257_991_02],
    [0.432_531_683_344_492_26, 0.074_725_674_575_290_3],
    [0.486_953_264_258_585_86, 0.033_335_672_154_344_07],
];

fn ten(f: &dyn Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let (middle, length) = (0.5 * (from + to), to - from);
    NODES
        .iter()
        .map(|[node, weight]| weight * (f(middle - node * length) + f(middle + node * length)))
        .sum::<f64>()
        * length
}

/// The integral of `f`, halved until halves agree with the whole.
fn adaptive(f: &dyn Fn(f64) -> f64, from: f64, to: f64, tolerance: f64, depth: u32) -> f64 {
    let middle = 0.5 * (from + to);
    let (whole, low, high) = (ten(f, from, to), ten(f, from, middle), ten(f, middle, to));
    if depth == 0 || (low + high - whole).abs() <= tolerance {
        return low + high;
    }
    adaptive(f, from, middle, tolerance, depth - 1) + adaptive(f, middle, to, tolerance, depth - 1)
}

/// Φ(to) - Φ(from).
fn normal_between(from: f64, to: f64) -> f64 {
    if (to - from).abs() < 0.5 {
        // A difference of nearly equal numbers.
        return ten(&|x| libm::exp(-0.5 * x * x), from, to) / TAU.sqrt();
    }
    let [from, to] = [from, to].map(|x| x * core::f64::consts::FRAC_1_SQRT_2);
    0.5 * if from > 0.0 {
        libm::erfc(from) - libm::erfc(to)
    } else if to < 0.0 {
        libm::erfc(-to) - libm::erfc(-from)
    } else {
        libm::erf(to) - libm::erf(from)
    }
}

/// The share of a triangle, or of a parallelogram, by the rows of the piece.
fn share_by_rows(piece: &Whitened, is_parallelogram: bool) -> f64 {
    let [x, y] = piece.corner;
    let row = |v: f64| {
        let left = x + piece.shear * v;
        let length = piece.length * if is_parallelogram { 1.0 } else { 1.0 - v };
        let height = y + piece.height * v;
        libm::exp(-0.5 * height * height) / TAU.sqrt() * normal_between(left, left + length)
    };
    // No row beyond 12 deviations matters.
    let clip = |to: f64| ((to - y) / piece.height).clamp(0.0, 1.0);
    let (from, to) = (clip(-12.0), clip(12.0));
    // Where it may be sharp: where a bound passes the middle.
    let mut cuts = std::vec![from, to, clip(0.0)];
    for (start, across) in [
        (x, piece.shear),
        (
            x + piece.length,
            if is_parallelogram {
                piece.shear
            } else {
                piece.shear - piece.length
            },
        ),
    ] {
        let middle = -start / across;
        for off in [-12.0, -4.0, -1.0, 0.0, 1.0, 4.0, 12.0] {
            cuts.push((middle + off / across.abs()).clamp(from, to));
        }
    }
    cuts.retain(|cut| cut.is_finite());
    cuts.sort_by(f64::total_cmp);
    let places = (0..=40).map(|i| from + (to - from) * 0.025 * f64::from(i));
    let peak = places
        .chain(cuts.iter().copied())
        .map(row)
        .fold(1e-30, f64::max);
    cuts.windows(2)
        .map(|pair| adaptive(&row, pair[0], pair[1], 3e-15 * peak.min(1.0), 18))
        .sum::<f64>()
        * piece.height
}

/// Numbers that depend on the seed alone.
struct Stream(u64);

impl Stream {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A number of either sign between ten to the `low` and ten to the `high`.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        let size = libm::exp10(self.between(low, high));
        if self.uniform() < 0.5 { -size } else { size }
    }
}

fn random_piece(stream: &mut Stream, low: f64, high: f64) -> Whitened {
    // A corner, or a point of an edge or of the inside, near the origin.
    let (length, height) = (stream.scale(low, high).abs(), stream.scale(low, high).abs());
    let shear = match (stream.uniform() * 4.0) as u32 {
        0 => 0.0,
        1 => length * stream.uniform(),
        2 => length,
        _ => stream.scale(low, high),
    };
    let (a, b) = (stream.between(-0.3, 1.3), stream.between(-0.3, 1.3));
    let [a, b] = [a, b].map(|x| if x < 0.0 { 0.0 } else { x.min(1.0) });
    let off = stream.scale(-3.0, 0.9) * f64::from(u8::from(stream.uniform() < 0.7));
    Whitened {
        corner: [off - a * length - b * shear, 0.5 * off - b * height],
        length,
        shear,
        height,
        residual: 0.0,
    }
}

#[test]
fn shares_are_those_of_brute_force() {
    let mut stream = Stream(1);
    let (mut worst, mut worst_relative) = (0.0_f64, 0.0_f64);
    for _ in 0..3000 {
        let piece = random_piece(&mut stream, -2.0, 1.5);
        for is_parallelogram in [false, true] {
            let exact = share_by_rows(&piece, is_parallelogram);
            let found = share(&piece, is_parallelogram);
            worst = worst.max((found - exact).abs());
            assert!(
                (found - exact).abs() < 1e-13,
                "{piece:?}: {found} for {exact}"
            );
            if exact > 1e-14 {
                worst_relative = worst_relative.max((found / exact - 1.0).abs());
            }
        }
    }
    // Measured 1e-15 and 3e-9.
    assert!(
        worst < 1e-13 && worst_relative < 1e-7,
        "{worst:e} {worst_relative:e}"
    );
}

#[test]
fn slivers_and_huge_pieces_have_their_share() {
    let mut stream = Stream(2);
    for _ in 0..2000 {
        let piece = random_piece(&mut stream, -6.0, 5.0);
        let exact = share_by_rows(&piece, false);
        let found = share(&piece, false);
        let error = (found - exact).abs();
        assert!(
            error < 1e-12 && (error < 3e-13 || error < 1e-4 * exact),
            "{piece:?}: {found} for {exact}"
        );
    }
}

#[test]
fn far_pieces_keep_relative_digits() {
    let mut stream = Stream(3);
    for distance in [2.4, 2.6, 4.0, 5.5, 7.0, 9.0] {
        for _ in 0..300 {
            let (length, height) = (stream.scale(-1.0, 1.5).abs(), stream.scale(-1.0, 1.5).abs());
            let piece = Whitened {
                corner: [-length * stream.uniform(), distance],
                length,
                shear: stream.between(-2.0, 2.0),
                height,
                residual: 0.0,
            };
            let exact = share_by_rows(&piece, false);
            let found = share(&piece, false);
            assert!(
                (found / exact - 1.0).abs() < 1e-6,
                "{piece:?}: {found:e} for {exact:e}"
            );
        }
    }
}

#[test]
fn the_origin_on_corners_and_edges_is_no_special_place() {
    for scale in [0.3, 3.0, 300.0] {
        let at = |a: f64, b: f64| Whitened {
            corner: [-a * scale, -b * scale],
            length: scale,
            shear: 0.0,
            height: scale,
            residual: 0.0,
        };
        for (a, b) in [
            (0.0, 0.0),
            (1.0, 0.0),
            (0.0, 1.0),
            (0.5, 0.0),
            (0.5, 0.5),
            (0.0, 0.3),
        ] {
            let exact = share_by_rows(&at(a, b), false);
            assert!(
                (share(&at(a, b), false) - exact).abs() < 1e-14,
                "{a} {b} {scale}"
            );
            // A hair to the side it is the same.
            for hair in [1e-18, 1e-12, -1e-18, -1e-12] {
                assert!(
                    (share(&at(a + hair, b + 0.7 * hair), false) - exact).abs() < 1e-10 * scale
                );
            }
        }
        // The quarter of the plane at a right corner.
        if scale > 100.0 {
            assert!((share(&at(0.0, 0.0), false) - 0.25).abs() < 1e-15);
            assert!((share(&at(0.5, 0.0), false) - 0.5).abs() < 1e-15);
            assert!((share(&at(0.0, 1.0), false) - 0.125).abs() < 1e-15);
        }
    }
}

/// The mean by the first edge in closed form and the second by adaptive quadrature, in four dimensions.
fn mean_by_rows(corner: Point, edges: [Point; 2], shape: Shape) -> f64 {
    let dot = |a: Point, b: Point| -> f64 { a.iter().zip(&b).map(|(a, b)| a * b).sum() };
    let [first, second] = edges;
    let length = libm::sqrt(dot(first, first));
    let unit = first.map(|x| x / length);
    let row = |v: f64| {
        let start: Point = core::array::from_fn(|i| corner[i] + v * second[i]);
        let along = dot(start, unit);
        let rest: Point = core::array::from_fn(|i| start[i] - along * unit[i]);
        let share = if shape == Shape::Triangle {
            1.0 - v
        } else {
            1.0
        };
        libm::exp(-0.5 * dot(rest, rest)) * normal_between(along, along + share * length)
    };
    let parts = 64;
    let step = 1.0 / f64::from(parts);
    let peak = (0..=8 * parts)
        .map(|i| row(0.125 * step * f64::from(i)))
        .fold(1e-300, f64::max);
    let sum: f64 = (0..parts)
        .map(|i| {
            adaptive(
                &row,
                f64::from(i) * step,
                f64::from(i + 1) * step,
                1e-15 * peak,
                50,
            )
        })
        .sum();
    let area = if shape == Shape::Triangle { 0.5 } else { 1.0 };
    sum * TAU.sqrt() / (length * area)
}

#[test]
fn means_are_those_of_brute_force_at_all_scales() {
    let mut stream = Stream(4);
    for shape in [Shape::Triangle, Shape::Parallelogram] {
        for number in 0..3000 {
            let size = libm::exp10(stream.between(-3.0, 1.5));
            let stiff = libm::exp10(stream.between(-2.0, 1.5));
            let mut normal = || stream.between(-1.0, 1.0) * size * stiff;
            let (a, b, c, d) = (normal(), normal(), normal(), normal());
            // Folded: of rank one, or none.
            let (c, d) = match number % 4 {
                0 => (0.5 * a, 0.5 * b),
                1 => (0.0, 0.0),
                _ => (c, d),
            };
            let edges = [[size, 0.3 * size, a, b], [0.0, -0.7 * size, c, d]];
            let (u, v) = (stream.uniform(), stream.uniform());
            let off = stream.between(0.0, 3.0);
            let corner = core::array::from_fn(|i| {
                off * stream.between(-1.0, 1.0) - u * edges[0][i] - v * edges[1][i]
            });
            let exact = mean_by_rows(corner, edges, shape);
            let found = mean(corner, edges, shape, TriangleForm::Accurate, 1e4);
            assert!(
                (found - exact).abs() <= 1e-7 * exact + 1e-15,
                "{corner:?} {edges:?}: {found:e} for {exact:e}"
            );
        }
    }
}

#[test]
fn stiff_pieces_have_the_mean_of_their_line() {
    // Normals that change along one direction alone, by up to 1e6 σr over the piece, under a wide footprint: the
    // integral across is that of the line on which the normal is right, of √2π over the stiffness.
    for stiff in [1e2, 1e4, 1e6] {
        for spread in [1e-1, 1e-3, 1e-5] {
            let edges = [[spread, 0.0, stiff, 0.5 * stiff], [0.0, spread, 0.0, 0.0]];
            let corner = [0.0, 0.0, -0.25 * stiff, -0.125 * stiff];
            let found = mean(
                corner,
                edges,
                Shape::Parallelogram,
                TriangleForm::Accurate,
                1e3,
            );
            let rate = stiff * 1.25_f64.sqrt();
            // Position adds at most spread² to the exponent.
            let exact = TAU.sqrt() / rate;
            assert!(
                (found / exact - 1.0).abs() < spread * spread + 1e-9,
                "{stiff} {spread}: {found} for {exact}"
            );
            // The triangle's line is three quarters as long, on twice the mean.
            let found = mean(corner, edges, Shape::Triangle, TriangleForm::Accurate, 1e3);
            assert!(
                (found / (1.5 * exact) - 1.0).abs() < spread * spread + 2.0 / stiff,
                "{found} for {exact}"
            );
        }
    }
}

#[test]
fn quadratics_integrate_as_quadrature_says() {
    let mut stream = Stream(5);
    for _ in 0..4000 {
        let a = stream.scale(-8.0, 4.0).abs();
        let b = stream.between(-4.0, 4.0)
            + if stream.uniform() < 0.2 {
                stream.scale(0.0, 4.0)
            } else {
                0.0
            };
        let from = stream.between(-3.0, 3.0);
        let to = from + stream.uniform();
        let c = [
            stream.between(-1.0, 1.0),
            stream.between(-1.0, 1.0),
            stream.between(-1.0, 1.0),
        ];
        let exact = adaptive(
            &|x| libm::exp(-a * (x - b) * (x - b)) * (c[0] + x * (c[1] + x * c[2])),
            from,
            to,
            1e-14,
            20,
        );
        let found = expquad(a, b, c, from, to);
        assert!(
            (found - exact).abs() < 1e-10,
            "{a} {b} {c:?} {from} {to}: {found} for {exact}"
        );
    }
}

#[test]
fn experf_is_that_of_the_error_function_within_its_quadratics() {
    for (a, b, from, to) in [
        (1.0, 0.2, -5.0, 5.0),
        (0.1, -1.0, 0.0, 2.5),
        (40.0, 0.5, -1.0, 3.5),
        (1e-6, 0.0, -100.0, 900.0),
    ] {
        let exact = adaptive(
            &|x| libm::exp(-a * (x - b) * (x - b)) * libm::erf(x),
            from,
            to,
            1e-14,
            40,
        );
        let size = adaptive(&|x| libm::exp(-a * (x - b) * (x - b)), from, to, 1e-12, 20);
        let found = experf(a, b, from, to);
        assert!(
            (found - exact).abs() <= 7.5e-3 * size,
            "{a} {b}: {found} for {exact}"
        );
        assert_eq!(experf(a, b, to, from), -found);
    }
}

#[test]
fn the_papers_form_is_within_its_quadratics_everywhere() {
    let mut stream = Stream(6);
    let mut worst = 0.0_f64;
    for _ in 0..4000 {
        let piece = random_piece(&mut stream, -4.0, 4.0);
        for is_parallelogram in [false, true] {
            let exact = share(&piece, is_parallelogram);
            let found = paper::share(&piece, is_parallelogram);
            assert!((0.0..=1.0).contains(&found), "{piece:?}: {found}");
            worst = worst.max((found - exact).abs());
        }
    }
    assert!((1e-4..7.5e-3).contains(&worst), "{worst}");
}

#[test]
fn what_is_beyond_the_reach_is_nothing_and_absurd_pieces_are_no_nan() {
    let edges = [[0.1, 0.0, 0.2, 0.0], [0.0, 0.1, 0.0, 0.2]];
    for form in [TriangleForm::Accurate, TriangleForm::Paper] {
        let at = |x: f64| mean([x, 0.0, 0.0, 0.0], edges, Shape::Triangle, form, 25.0);
        assert!(at(4.9) > 0.0);
        assert_eq!(at(5.6), 0.0);
        for big in [0.0, 1e-200, 1e100, f64::INFINITY, f64::NAN] {
            for shape in [Shape::Triangle, Shape::Parallelogram] {
                let edges = [[big, 0.0, 1.0, 0.0], [0.0, 1.0, big, 0.0]];
                for corner in [[0.0; 4], [big; 4], [-0.3, -0.2, -big, 1.0]] {
                    let found = mean(corner, edges, shape, form, 30.0);
                    assert!(found >= 0.0 && found.is_finite(), "{big} {found}");
                }
            }
        }
    }
}

#[test]
fn whitening_does_not_depend_on_the_order_of_edges() {
    let (first, second) = ([1.0, 0.0, 3.0, 0.1], [0.2, 0.5, -2.0, 4.0]);
    let one = whiten([0.1, 0.2, 0.3, 0.4], [first, second]).expect("a plane");
    let other = whiten([0.1, 0.2, 0.3, 0.4], [second, first]).expect("a plane");
    assert_eq!(share(&one, false), share(&other, false));
}
