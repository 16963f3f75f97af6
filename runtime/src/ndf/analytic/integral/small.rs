//! Pieces that are small beside the query's Gaussian: a few nodes, without laying them into a plane.

use super::exponential::exp_negative;
use super::{Point, Shape};

/// Least sizes, longest edge times distance or 1, from which the next rule is taken. Errors there, relative: 5e-9, 1e-9, 3e-9.
const SIZES: [f64; 3] = [0.015, 0.25, 1.2];

/// Degree 2: barycentric coordinates less a third.
const THREE: [[f64; 3]; 3] = [
    [-1.0 / 6.0, -1.0 / 6.0, 1.0 / 3.0],
    [-1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0],
    [1.0 / 3.0, -1.0 / 6.0, 1.0 / 3.0],
];

const THIRD: f64 = 1.0 / 3.0;

/// Degree 5 (Radon 1948): two coordinates less a third, and the weight.
const SEVEN: [[f64; 3]; 7] = {
    // (6 ∓ √15) / 21 and (155 ∓ √15) / 1200.
    const A: f64 = 0.101_286_507_323_456_33;
    const B: f64 = 0.470_142_064_105_115_1;
    const V: f64 = 0.125_939_180_544_827_14;
    const W: f64 = 0.132_394_152_788_506_2;
    [
        [0.0, 0.0, 0.225],
        [A - THIRD, A - THIRD, V],
        [A - THIRD, 1.0 - 2.0 * A - THIRD, V],
        [1.0 - 2.0 * A - THIRD, A - THIRD, V],
        [B - THIRD, B - THIRD, W],
        [B - THIRD, 1.0 - 2.0 * B - THIRD, W],
        [1.0 - 2.0 * B - THIRD, B - THIRD, W],
    ]
};

/// Degree 8 (Dunavant 1985), its digits refined by Newton's method on the moments.
const SIXTEEN: [[f64; 3]; 16] = {
    const A: f64 = 0.459_292_588_292_723_2;
    const A_1: f64 = 0.081_414_823_414_553_7;
    const B: f64 = 0.170_569_307_751_760_2;
    const B_1: f64 = 0.658_861_384_496_479_6;
    const C: f64 = 0.050_547_228_317_030_98;
    const C_1: f64 = 0.898_905_543_365_938_1;
    const D: f64 = 0.008_394_777_409_957_605;
    const E: f64 = 0.263_112_829_634_638_1;
    const F: f64 = 0.728_492_392_955_404_3;
    const U: f64 = 0.144_315_607_677_787_17;
    const V: f64 = 0.095_091_634_267_284_62;
    const W: f64 = 0.103_217_370_534_718_25;
    const X: f64 = 0.032_458_497_623_198_08;
    const Y: f64 = 0.027_230_314_174_434_994;
    [
        [0.0, 0.0, U],
        [A - THIRD, A - THIRD, V],
        [A_1 - THIRD, A - THIRD, V],
        [A - THIRD, A_1 - THIRD, V],
        [B - THIRD, B - THIRD, W],
        [B_1 - THIRD, B - THIRD, W],
        [B - THIRD, B_1 - THIRD, W],
        [C - THIRD, C - THIRD, X],
        [C_1 - THIRD, C - THIRD, X],
        [C - THIRD, C_1 - THIRD, X],
        [D - THIRD, E - THIRD, Y],
        [E - THIRD, D - THIRD, Y],
        [D - THIRD, F - THIRD, Y],
        [F - THIRD, D - THIRD, Y],
        [E - THIRD, F - THIRD, Y],
        [F - THIRD, E - THIRD, Y],
    ]
};

/// Squared lengths and products of a piece of four dimensions.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    /// Squared distance of the middle.
    middle: f64,
    /// Products of the middle with both edges.
    slopes: [f64; 2],
    /// |e₁|², e₁·e₂, |e₂|².
    squares: [f64; 3],
    /// The square of the longest edge or diagonal.
    longest: f64,
}

impl Sizes {
    #[inline(always)]
    pub fn new(corner: Point, edges: [Point; 2], shape: Shape) -> Self {
        let share = match shape {
            Shape::Triangle => THIRD,
            Shape::Parallelogram => 0.5,
        };
        let [first, second] = edges;
        let mut middle = corner;
        for ((middle, first), second) in middle.iter_mut().zip(&first).zip(&second) {
            *middle += share * (first + second);
        }
        let squares = [dot(first, first), dot(first, second), dot(second, second)];
        let [one, product, two] = squares;
        let longest = match shape {
            Shape::Triangle => one.max(two).max(one + two - 2.0 * product),
            Shape::Parallelogram => one + two + 2.0 * product.abs(),
        };
        Self {
            middle: dot(middle, middle),
            slopes: [dot(middle, first), dot(middle, second)],
            squares,
            longest,
        }
    }

    /// Whether no point of the piece is nearer than the root of `squared`.
    #[inline(always)]
    pub fn is_beyond(&self, squared: f64) -> bool {
        // |m| ≥ r + l, squared twice, as no point is farther from the middle than the longest edge l.
        if self.middle <= squared {
            return false;
        }
        let gap = self.middle - squared - self.longest;
        gap > 0.0 && gap * gap >= 4.0 * squared * self.longest
    }

    /// The mean of `e^{-|x|²/2}` over the piece, if it is small enough; relative error 1e-8.
    #[inline]
    pub fn mean(&self, shape: Shape) -> Option<f64> {
        let size = self.longest * self.middle.max(1.0);
        let [least, middle, most] = SIZES.map(|size| size * size);
        if size > most {
            return None;
        }
        if size <= least {
            return Some(match shape {
                Shape::Triangle => self.sum(&THREE),
                Shape::Parallelogram => self.halves(&THREE),
            });
        }
        Some(match (shape, size <= middle) {
            (Shape::Triangle, true) => self.sum(&SEVEN),
            (Shape::Triangle, false) => self.sum(&SIXTEEN),
            (Shape::Parallelogram, true) => self.halves(&SEVEN),
            (Shape::Parallelogram, false) => self.halves(&SIXTEEN),
        })
    }

    #[inline(always)]
    fn exponent(&self, x: f64, y: f64) -> f64 {
        let ([one, product, two], [first, second]) = (self.squares, self.slopes);
        let twice = self.middle
            + x * (2.0 * first + x * one + 2.0 * y * product)
            + y * (2.0 * second + y * two);
        // It is a square, but for rounding.
        (0.5 * twice).max(0.0)
    }

    #[inline(always)]
    fn sum<const N: usize>(&self, rule: &[[f64; 3]; N]) -> f64 {
        let mut terms = [0.0; N];
        for (term, [x, y, weight]) in terms.iter_mut().zip(rule) {
            *term = weight * exp_negative(self.exponent(*x, *y));
        }
        total(&terms)
    }

    /// Both halves of a parallelogram: of the lower one corners are (-½, -½), (½, -½) and (-½, ½) off the middle.
    #[inline(always)]
    fn halves<const N: usize>(&self, rule: &[[f64; 3]; N]) -> f64 {
        let mut terms = [0.0; N];
        for (term, [x, y, weight]) in terms.iter_mut().zip(rule) {
            let (x, y) = (x - 1.0 / 6.0, y - 1.0 / 6.0);
            *term =
                weight * (exp_negative(self.exponent(x, y)) + exp_negative(self.exponent(-x, -y)));
        }
        0.5 * total(&terms)
    }
}

#[inline(always)]
fn total(terms: &[f64]) -> f64 {
    let mut sum = 0.0;
    for term in terms {
        sum += term;
    }
    sum
}

#[inline(always)]
fn dot(a: Point, b: Point) -> f64 {
    let ([a_1, a_2, a_3, a_4], [b_1, b_2, b_3, b_4]) = (a, b);
    (a_1 * b_1 + a_2 * b_2) + (a_3 * b_3 + a_4 * b_4)
}
