//! The paper's form: the inner integral as error functions, these as six quadratics, \[YHJ*14\] §5.
//!
//! `share = ∫ φ(y) ½ [erf(x₂(y)/√2) - erf(x₁(y)/√2)] dy` over the piece's height, with both bounds linear in y (eq. 9); each
//! half becomes `experf` (eq. 11) and, with erf replaced by quadratics on six parts of [-3, 3], a sum of `expquad` (eq. 12).
//! The paper does not give its quadratics. Ours are continuous and rise, so that no piece has a negative share, and of these
//! the ones of least error, 7.4e-3. That error is absolute: a piece in the tail of the Gaussian has no right digit.

use super::whiten::Whitened;
use core::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

/// Where the error function ends for this form.
const END: f64 = 3.0;

/// Values of the quadratics at 0, ½, 1, … 3.
const VALUES: [f64; 7] = [
    0.0,
    0.515_386_531_587_854_5,
    0.850_140_220_670_140_4,
    0.962_525_372_789_891_9,
    0.999_989_052_571_102_2,
    0.999_993_959_098_946_4,
    1.0,
];

/// c₀, c₁, c₂ of the quadratic between the whole numbers from `x` on, through its values there and halfway.
const fn quadratic(x: f64, [start, half, end]: [f64; 3]) -> [f64; 3] {
    let square = 2.0 * (start + end - 2.0 * half);
    let slope = end - start - square;
    [
        start - slope * x + square * x * x,
        slope - 2.0 * square * x,
        square,
    ]
}

/// Coefficients on [0, 1], [1, 2] and [2, 3].
const QUADRATICS: [[f64; 3]; 3] = {
    let [v_0, v_1, v_2, v_3, v_4, v_5, v_6] = VALUES;
    [
        quadratic(0.0, [v_0, v_1, v_2]),
        quadratic(1.0, [v_2, v_3, v_4]),
        quadratic(2.0, [v_4, v_5, v_6]),
    ]
};

/// Every part: where it begins and ends, and its coefficients; the outer two are constant.
fn parts() -> [(f64, f64, [f64; 3]); 8] {
    let [near, middle, far] = QUADRATICS;
    let mirror = |[constant, slope, square]: [f64; 3]| [-constant, slope, -square];
    [
        (f64::NEG_INFINITY, -END, [-1.0, 0.0, 0.0]),
        (-END, -2.0, mirror(far)),
        (-2.0, -1.0, mirror(middle)),
        (-1.0, 0.0, mirror(near)),
        (0.0, 1.0, near),
        (1.0, 2.0, middle),
        (2.0, END, far),
        (END, f64::INFINITY, [1.0, 0.0, 0.0]),
    ]
}

/// The error function as six quadratics.
fn erf_by_quadratics(x: f64) -> f64 {
    for (_, end, [constant, slope, square]) in parts() {
        if x <= end {
            return constant + x * (slope + x * square);
        }
    }
    1.0
}

/// `∫ exp(-a (x - b)²) (c₀ + c₁ x + c₂ x²) dx` from `from` to `to` ≥ `from`, a > 0, eq. 12.
///
/// In closed form where that is well conditioned; over an interval that is short beside the Gaussian, where it would
/// be a difference of nearly equal numbers, by four nodes, which then leave 1e-10.
pub(super) fn expquad(a: f64, b: f64, c: [f64; 3], from: f64, to: f64) -> f64 {
    const NODES: [[f64; 2]; 4] = [
        [-0.861_136_311_594_052_6, 0.347_854_845_137_453_85],
        [-0.339_981_043_584_856_26, 0.652_145_154_862_546_1],
        [0.339_981_043_584_856_26, 0.652_145_154_862_546_1],
        [0.861_136_311_594_052_6, 0.347_854_845_137_453_85],
    ];
    let root = libm::sqrt(a);
    let (start, end) = (root * (from - b), root * (to - b));
    // e^-400 is nothing.
    if end.is_nan() || start.is_nan() || end <= start || start > 20.0 || end < -20.0 {
        return 0.0;
    }
    let [constant, slope, square] = c;
    if end - start < 0.2 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mut sum = 0.0;
        for [node, weight] in NODES {
            let x = middle + half * node;
            let away = root * (x - b);
            sum += weight * libm::exp(-away * away) * (constant + x * (slope + x * square));
        }
        return sum * half;
    }
    // In v = √a (x - b): x = b + v / √a.
    let [zeroth, first, second] = [
        constant + b * (slope + b * square),
        (slope + 2.0 * b * square) / root,
        square / a,
    ];
    let gaussian = |v: f64| libm::exp(-v * v);
    let moment_0 = 0.5 * libm::sqrt(PI) * erf_difference(start, end);
    let moment_1 = 0.5 * (gaussian(start) - gaussian(end));
    let edge = |v: f64| if v.abs() < 20.0 { v * gaussian(v) } else { 0.0 };
    let moment_2 = 0.5 * (moment_0 + edge(start) - edge(end));
    (zeroth * moment_0 + first * moment_1 + second * moment_2) / root
}

/// `erf(to) - erf(from)`, by the complement where both are on one side.
fn erf_difference(from: f64, to: f64) -> f64 {
    if from > 0.0 {
        libm::erfc(from) - libm::erfc(to)
    } else if to < 0.0 {
        libm::erfc(-to) - libm::erfc(-from)
    } else {
        libm::erf(to) - libm::erf(from)
    }
}

/// `∫ exp(-a (x - b)²) erf(x) dx` between two places in either order, a > 0, eq. 11, with erf as six quadratics.
pub(super) fn experf(a: f64, b: f64, from: f64, to: f64) -> f64 {
    let (low, high, sign) = if from <= to {
        (from, to, 1.0)
    } else {
        (to, from, -1.0)
    };
    let sum: f64 = parts()
        .into_iter()
        .filter(|(start, end, _)| *start < high && *end > low)
        .map(|(start, end, c)| expquad(a, b, c, start.max(low), end.min(high)))
        .sum();
    sign * sum
}

/// The share of a unit Gaussian over the triangle, or with `is_parallelogram` over the parallelogram, of `piece`, in [0, 1];
/// within 7.4e-3, most of it where a bound crosses the middle of the Gaussian. About 0.5 µs.
pub(super) fn share(piece: &Whitened, is_parallelogram: bool) -> f64 {
    let [x, y] = piece.corner;
    let opposite = if is_parallelogram {
        piece.shear
    } else {
        piece.shear - piece.length
    };
    let share =
        below(x + piece.length, opposite, y, piece.height) - below(x, piece.shear, y, piece.height);
    // NaN of absurd sizes is none.
    if share > 0.0 { share.min(1.0) } else { 0.0 }
}

/// Least slope of a bound for which the integral is written in the argument of erf. Below it the bound moves by less than
/// 1e-5 where there is any weight, and erf is a constant.
const LEAST_SLOPE: f64 = 1e-6;

/// `∫ φ(y) ½ erf(x(y)/√2) dy` over a bound from (`x`, `y`) to (`x` + `across`, `y` + `up`), `up` > 0.
fn below(x: f64, across: f64, y: f64, up: f64) -> f64 {
    let slope = across / up;
    if slope.abs() < LEAST_SLOPE {
        let share = 0.5 * erf_difference(y * FRAC_1_SQRT_2, (y + up) * FRAC_1_SQRT_2);
        let there = x + slope * (0.0_f64.clamp(y, y + up) - y);
        return 0.5 * erf_by_quadratics(there * FRAC_1_SQRT_2) * share;
    }
    let (a, b) = (1.0 / (slope * slope), (x - slope * y) * FRAC_1_SQRT_2);
    let integral = experf(a, b, x * FRAC_1_SQRT_2, (x + across) * FRAC_1_SQRT_2);
    // φ(y) dy = e^{-a (t - b)²} / √2π · √2 / slope dt.
    integral * 0.5 * SQRT_2 / (slope * libm::sqrt(2.0 * PI))
}
