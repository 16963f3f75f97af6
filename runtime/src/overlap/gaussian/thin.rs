//! Weights of texels that are large against the Gaussian's width: rectangles of the bivariate normal distribution.
//!
//! In units of its standard deviations along the axes a Gaussian is a standard bivariate normal distribution of some
//! correlation ρ, and a texel's weight is the sum of its distribution function B at two corners less that at the other
//! two. `∂B/∂ρ` is the density at the corner (Plackett 1954), so that, with `r = sin θ`,
//!
//! ```text
//! B(h, k; ρ) = Φ(h) Φ(k) + 1/2π ∫_0^{asin ρ} exp(-(h - k)²/(2 cos²θ) - h k/(1 + sin θ)) dθ
//! B(h, k; ρ) = Φ(min(h, k)) - 1/2π ∫_0^{√(1 - ρ²)} exp(-(h - k)²/(2 x²) - h k/(1 + √(1 - x²))) dx/√(1 - x²)
//! ```
//!
//! The first is smooth up to ρ = 0.98. The second, from the other end, is used beyond, after Genz (2004, "Numerical
//! computation of rectangular bivariate and trivariate normal and t probabilities", §2.4): the first terms of
//! the slowly varying factor's series in x² are integrated in closed form, and only the rest by quadrature. ρ = 1 is
//! the Gaussian on a line. A negative correlation is a positive one with the y axis turned round.

use super::exponential::exp_negative;
use super::normal::{SQRT_TAU, normal, tail_ratio};
use core::f64::consts::PI;

/// Standard deviations beyond which nothing is left: Φ(-7) is 1e-12.
const FAR: f64 = 7.0;
const FAR_SQUARE: f64 = 0.5 * FAR * FAR;
/// What stands for a border that is infinitely many standard deviations away: Φ is 0 and 1 there.
const INFINITE: f64 = 40.0;

/// Values of `√(1 - ρ²)` from which the first integral takes eight nodes, and sixteen; below, the second takes four, and
/// below the last none. Errors of a corner, by comparison with 80 nodes: 3e-11, 2e-11, 3e-11, 1e-11.
const LOOSE: f64 = 0.6;
const BROAD: f64 = 0.2;
const NARROW: f64 = 0.06;

/// Nodes in (0, 1) and weights of Gauss-Legendre rules.
const FOUR: [[f64; 2]; 4] = [
    [0.069_431_844_202_973_71, 0.173_927_422_568_726_9],
    [0.330_009_478_207_571_9, 0.326_072_577_431_273_1],
    [0.669_990_521_792_428_1, 0.326_072_577_431_273_1],
    [0.930_568_155_797_026_2, 0.173_927_422_568_726_9],
];
const EIGHT: [[f64; 2]; 8] = [
    [0.019_855_071_751_231_856, 0.050_614_268_145_188_09],
    [0.101_666_761_293_186_58, 0.111_190_517_226_687_23],
    [0.237_233_795_041_835_5, 0.156_853_322_938_943_7],
    [0.408_282_678_752_175_1, 0.181_341_891_689_181],
    [0.591_717_321_247_825, 0.181_341_891_689_181],
    [0.762_766_204_958_164_5, 0.156_853_322_938_943_7],
    [0.898_333_238_706_813_5, 0.111_190_517_226_687_23],
    [0.980_144_928_248_768_2, 0.050_614_268_145_188_09],
];
const SIXTEEN: [[f64; 2]; 16] = [
    [0.005_299_532_504_175_031, 0.013_576_229_705_877_029],
    [0.027_712_488_463_383_7, 0.031_126_761_969_323_888],
    [0.067_184_398_806_084_12, 0.047_579_255_841_246_45],
    [0.122_297_795_822_498_5, 0.062_314_485_627_766_97],
    [0.191_061_877_798_678_11, 0.074_797_994_408_288_41],
    [0.270_991_611_171_386_3, 0.084_578_259_697_501_28],
    [0.359_198_224_610_370_54, 0.091_301_707_522_461_8],
    [0.452_493_745_081_181_3, 0.094_725_305_227_534_24],
    [0.547_506_254_918_818_8, 0.094_725_305_227_534_24],
    [0.640_801_775_389_629_5, 0.091_301_707_522_461_8],
    [0.729_008_388_828_613_6, 0.084_578_259_697_501_28],
    [0.808_938_122_201_321_9, 0.074_797_994_408_288_41],
    [0.877_702_204_177_501_6, 0.062_314_485_627_766_97],
    [0.932_815_601_193_915_9, 0.047_579_255_841_246_45],
    [0.972_287_511_536_616_3, 0.031_126_761_969_323_888],
    [0.994_700_467_495_825, 0.013_576_229_705_877_029],
];

/// A Gaussian by its standard deviations along the axes, in texels, and their correlation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thin {
    deviation: [f64; 2],
    /// Whether x falls where y rises.
    falls: bool,
    correlation: Correlation,
}

#[derive(Clone, Copy, Debug)]
enum Correlation {
    None,
    Loose([BroadNode; 8]),
    Broad([BroadNode; 16]),
    /// `√(1 - ρ²)`, and the nodes.
    Narrow(f64, [NarrowNode; 4]),
    /// Without nodes; 0 for a line.
    Line(f64),
}

/// Factors of `(h - k)²` and `h k` in the exponent, and the weight with all that does not depend on h and k.
#[derive(Clone, Copy, Debug)]
struct BroadNode {
    difference: f64,
    product: f64,
    weight: f64,
}

/// At a node x of the second integral.
#[derive(Clone, Copy, Debug)]
struct NarrowNode {
    /// `(1 - ρ²) / 2x²`.
    difference: f64,
    /// `1 / (1 + √(1 - x²))`.
    product: f64,
    square: f64,
    /// `1 / √(1 - x²)`.
    inverse_root: f64,
    weight: f64,
}

/// The part of one axis that a row or a column of texels covers, in standard deviations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    low: f64,
    high: f64,
    below_low: f64,
    below_high: f64,
}

impl Interval {
    fn new(low: f64, high: f64) -> Self {
        Self {
            low,
            high,
            below_low: normal(low),
            below_high: normal(high),
        }
    }
}

/// A border in standard deviations; of a Gaussian without any, on which side of the centre it lies, the centre being
/// above a border that it lies on.
fn standard(border: f64, deviation: f64) -> f64 {
    if deviation > 0.0 {
        (border / deviation).clamp(-INFINITE, INFINITE)
    } else if border > 0.0 {
        INFINITE
    } else {
        -INFINITE
    }
}

impl Thin {
    /// The Gaussian with these standard deviations, covariance xy, and root of the covariance matrix's determinant.
    pub fn new(deviation: [f64; 2], covariance: f64, determinant_root: f64) -> Self {
        let product = deviation[0] * deviation[1];
        let correlation = if covariance == 0.0 || product == 0.0 {
            Correlation::None
        } else {
            // Its own quotient: 1 - ρ² would have no digits left.
            let ratio = determinant_root / product;
            let correlation = (covariance / product).abs();
            if ratio >= LOOSE {
                Correlation::Loose(EIGHT.map(|node| BroadNode::new(node, correlation)))
            } else if ratio >= BROAD {
                Correlation::Broad(SIXTEEN.map(|node| BroadNode::new(node, correlation)))
            } else if ratio >= NARROW {
                Correlation::Narrow(ratio, FOUR.map(|node| NarrowNode::new(node, ratio)))
            } else {
                Correlation::Line(ratio)
            }
        };
        Self {
            deviation,
            falls: covariance < 0.0,
            correlation,
        }
    }

    /// The columns from `low` to `high`, in texels from the centre.
    pub fn columns(&self, low: f64, high: f64) -> Interval {
        let [deviation, _] = self.deviation;
        Interval::new(standard(low, deviation), standard(high, deviation))
    }

    /// The rows from `low` to `high`, in texels from the centre; turned round if the correlation is negative.
    pub fn rows(&self, low: f64, high: f64) -> Interval {
        let [_, deviation] = self.deviation;
        let (low, high) = (standard(low, deviation), standard(high, deviation));
        if self.falls {
            Interval::new(-high, -low)
        } else {
            Interval::new(low, high)
        }
    }

    /// The share of the Gaussian that lies in `columns` and `rows`, in [0, 1].
    pub fn share(&self, columns: &Interval, rows: &Interval) -> f64 {
        let (x, y) = (columns, rows);
        let share = match &self.correlation {
            Correlation::None => independent(x, y),
            Correlation::Loose(nodes) => broad(nodes, x, y),
            Correlation::Broad(nodes) => broad(nodes, x, y),
            Correlation::Narrow(ratio, nodes) => narrow(*ratio, nodes, x, y),
            Correlation::Line(ratio) => narrow(*ratio, &[], x, y),
        };
        share.clamp(0.0, 1.0)
    }
}

/// Rectangles under a Gaussian that need not be thin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangles(Thin);

impl Rectangles {
    pub(super) fn new(deviation: [f64; 2], covariance: f64, determinant_root: f64) -> Self {
        Self(Thin::new(deviation, covariance, determinant_root))
    }

    /// The share of the Gaussian, nothing cut off, that lies between the columns `columns` and rows `rows`, in texels
    /// from the centre; either may be without end.
    pub fn share(&self, columns: [f64; 2], rows: [f64; 2]) -> f64 {
        self.0.share(
            &self.0.columns(columns[0], columns[1]),
            &self.0.rows(rows[0], rows[1]),
        )
    }
}

fn independent(x: &Interval, y: &Interval) -> f64 {
    (x.below_high - x.below_low) * (y.below_high - y.below_low)
}

impl BroadNode {
    /// With `v = tan(θ/2)` everything is rational: `sin θ = 2v/(1 + v²)`, `cos θ = (1 - v²)/(1 + v²)`,
    /// `dθ = 2 dv/(1 + v²)`; and nodes are nearer to where the integrand is steep than over θ.
    fn new([node, weight]: [f64; 2], correlation: f64) -> Self {
        let end = correlation / (1.0 + libm::sqrt((1.0 - correlation) * (1.0 + correlation)));
        let v = end * node;
        let (plus, minus) = (1.0 + v * v, 1.0 - v * v);
        let inverse_cosine = plus / minus;
        Self {
            difference: 0.5 * inverse_cosine * inverse_cosine,
            product: plus / ((1.0 + v) * (1.0 + v)),
            weight: weight * end / (PI * plus),
        }
    }
}

/// The share in `x` and `y` by the first integral, of the four corners together.
fn broad(nodes: &[BroadNode], x: &Interval, y: &Interval) -> f64 {
    let is_far = |interval: &Interval| interval.low.abs().min(interval.high.abs()) > FAR;
    if is_far(x) || is_far(y) {
        return independent(x, y);
    }
    // Four corners at a time, which is two vectors of two.
    let corners = [
        (x.high, y.high),
        (x.low, y.low),
        (x.high, y.low),
        (x.low, y.high),
    ];
    let differences = corners.map(|(h, k)| (h - k) * (h - k));
    let products = corners.map(|(h, k)| h * k);
    let mut excess = 0.0;
    for node in nodes {
        let mut exponents = differences.map(|difference| difference * node.difference);
        for (exponent, product) in exponents.iter_mut().zip(products) {
            *exponent += product * node.product;
        }
        let [high_high, low_low, high_low, low_high] = exponents.map(exp_negative);
        excess += node.weight * ((high_high - high_low) + (low_low - low_high));
    }
    independent(x, y) + excess
}

impl NarrowNode {
    fn new([node, weight]: [f64; 2], ratio: f64) -> Self {
        let x = ratio * node;
        let root = libm::sqrt((1.0 - x) * (1.0 + x));
        Self {
            difference: 0.5 / (node * node),
            product: 1.0 / (1.0 + root),
            square: x * x,
            inverse_root: 1.0 / root,
            weight: weight * ratio / (2.0 * PI),
        }
    }
}

/// The share in `x` and `y` by the second integral, corner by corner.
fn narrow(ratio: f64, nodes: &[NarrowNode], x: &Interval, y: &Interval) -> f64 {
    let below =
        |h, below_h, k, below_k| f64::min(below_h, below_k) - narrow_deficit(ratio, nodes, h, k);
    let [high, low] = [(x.high, x.below_high), (x.low, x.below_low)].map(|(h, below_h)| {
        below(h, below_h, y.high, y.below_high) - below(h, below_h, y.low, y.below_low)
    });
    high - low
}

/// How much B(h, k) falls short of its value for a line.
fn narrow_deficit(ratio: f64, nodes: &[NarrowNode], h: f64, k: f64) -> f64 {
    let distance = (h - k).abs();
    let scaled = distance / ratio;
    let (product, scaled_square) = (h * k, scaled * scaled);
    // Where h k is negative, -h k ≤ (h - k)²/4: no exponent below is less than this one, none is negative.
    let least = 0.5 * (scaled_square + product);
    // Not so for the NaN of 0 / 0 either: a corner on a line of no width.
    let is_near = least < FAR_SQUARE;
    if !is_near {
        return 0.0;
    }
    // exp(-h k/(1 + √(1 - x²)))/√(1 - x²) = exp(-h k/2) (1 + c x² (1 + d x²) + …)
    let (c, d) = ((4.0 - product) / 8.0, (12.0 - product) / 16.0);
    let (square, distance_square) = (ratio * ratio, distance * distance);
    let polynomial = c * (1.0 - d * distance_square / 5.0) / 3.0;
    let edge = 1.0 - (distance_square - square) * polynomial + c * d * square * square / 5.0;
    let tail = tail_ratio(scaled) * SQRT_TAU * scaled * (1.0 - distance_square * polynomial);
    let closed = exp_negative(least) * (edge - tail);
    let mut rest = 0.0;
    for node in nodes {
        let difference = scaled_square * node.difference;
        let whole = exp_negative(difference + product * node.product) * node.inverse_root;
        let series = exp_negative(difference + 0.5 * product)
            * (1.0 + c * node.square * (1.0 + d * node.square));
        rest += node.weight * (whole - series);
    }
    ratio / (2.0 * PI) * closed + rest
}
