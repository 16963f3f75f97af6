//! The accurate form: the share of a unit Gaussian of two dimensions over a convex polygon, by the edges.
//!
//! The wedge between the origin and an edge at distance h from it, from y₁ to y₂ along its line, holds
//!
//! ```text
//! W = 1/2π ∫ (1 - e^{-r²/2}) h/r² dy,    r² = h² + y²,      W = θ/2π - I,    I = 1/2π ∫ e^{-r²/2} h/r² dy
//! ```
//!
//! with θ its angle. Wedges of all edges add up to the polygon's share, signed by the side of the origin. That of W is an entire function of
//! y, narrow nowhere, so that few nodes of Gauss and Legendre give all digits, wherever the origin lies: on an edge or on a
//! corner too. When the polygon is far from the origin the angles add up to zero, and I alone, which is as small as the
//! share itself, keeps its *relative* digits. Complete lines are complementary error functions. This is Owen's T, between
//! any two points of a line instead of from its foot.

use super::exponential::exp_negative;
use super::whiten::Whitened;
use core::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Squared distance of the origin from which on e^{-r²/2}, 2e-17, counts as nothing.
const NOTHING: f64 = 77.0;

/// Squared distance of a polygon from which on it is summed by I.
const FAR: f64 = 6.25;

/// Longest part of an edge that the nodes span: their error is then 1e-15 of W, and 1e-9 of I at the least distance and less
/// beyond.
const LONGEST: f64 = 3.0;

/// Nodes of Gauss and Legendre on [-1, 1], and halves of their weights.
const NODES: [f64; 12] = [
    -0.981_560_634_246_719_3,
    -0.904_117_256_370_474_9,
    -0.769_902_674_194_304_7,
    -0.587_317_954_286_617_4,
    -0.367_831_498_998_180_2,
    -0.125_233_408_511_468_9,
    0.125_233_408_511_468_9,
    0.367_831_498_998_180_2,
    0.587_317_954_286_617_4,
    0.769_902_674_194_304_7,
    0.904_117_256_370_474_9,
    0.981_560_634_246_719_3,
];
const HALF_WEIGHTS: [f64; 12] = [
    0.023_587_668_193_255_914,
    0.053_469_662_997_659_22,
    0.080_039_164_271_673_11,
    0.101_583_713_361_532_96,
    0.116_746_268_269_177_4,
    0.124_573_522_906_701_39,
    0.124_573_522_906_701_39,
    0.116_746_268_269_177_4,
    0.101_583_713_361_532_96,
    0.080_039_164_271_673_11,
    0.053_469_662_997_659_22,
    0.023_587_668_193_255_914,
];

/// An edge on its line: distance of the origin, positive on the left, and the ends along it from the origin's foot.
#[derive(Clone, Copy)]
struct Edge {
    distance: f64,
    from: f64,
    to: f64,
}

impl Edge {
    fn new(start: [f64; 2], edge: [f64; 2]) -> Self {
        let length = libm::sqrt(edge[0] * edge[0] + edge[1] * edge[1]);
        let [x, y] = edge.map(|component| component / length);
        let from = start[0] * x + start[1] * y;
        Self {
            distance: start[0] * y - start[1] * x,
            from,
            to: from + length,
        }
    }

    /// Squared distance of the origin from the edge itself.
    fn squared_distance(&self) -> f64 {
        let beyond = self.from.max(-self.to).max(0.0);
        self.distance * self.distance + beyond * beyond
    }

    /// W, signed.
    fn wedge(&self) -> f64 {
        let h = self.distance;
        let room = NOTHING - h * h;
        if room <= 0.0 {
            return self.angle(self.from, self.to) / TAU;
        }
        let end = libm::sqrt(room);
        if self.from <= -end && self.to >= end {
            return self.angle(self.from, self.to) / TAU - h.signum() * half_beyond(h.abs());
        }
        let (from, to) = (self.from.clamp(-end, end), self.to.clamp(-end, end));
        let mut sum = 0.0;
        if self.from < from {
            sum += self.angle(self.from, self.to.min(-end));
        }
        if self.to > to {
            sum += self.angle(self.from.max(end), self.to);
        }
        sum += integrate(from, to, Near(h));
        sum / TAU
    }

    /// I, signed; meant for an edge that is [`FAR`], of a polygon at squared distance `nearest`.
    fn tail(&self, nearest: f64) -> f64 {
        let h = self.distance;
        // Relative to what the polygon holds near its nearest point.
        let room = NOTHING + nearest - h * h;
        if room <= 0.0 {
            return 0.0;
        }
        let end = libm::sqrt(room);
        if self.from <= -end && self.to >= end {
            return h.signum() * half_beyond(h.abs());
        }
        let (from, to) = (self.from.clamp(-end, end), self.to.clamp(-end, end));
        integrate(from, to, Far(h)) / TAU
    }

    /// The angle between two points of the line, signed.
    fn angle(&self, from: f64, to: f64) -> f64 {
        let h = self.distance;
        libm::atan2(h * (to - from), h * h + from * to)
    }
}

/// The share beyond a line at `distance` ≥ 0 from the origin.
fn half_beyond(distance: f64) -> f64 {
    0.5 * libm::erfc(distance * FRAC_1_SQRT_2)
}

/// What is integrated along a line at a distance from the origin. No closure, which compilers do not see through here.
trait Integrand: Copy {
    fn at(self, y: f64) -> f64;
}

/// That of W.
#[derive(Clone, Copy)]
struct Near(f64);

impl Integrand for Near {
    #[inline(always)]
    fn at(self, y: f64) -> f64 {
        let Self(h) = self;
        let r_squared = h * h + y * y;
        let x = 0.5 * r_squared;
        // (1 - e^-x) / 2x; by its series where the difference loses digits.
        let series = 0.5 - x * (0.25 - x * (1.0 / 12.0 - x * (1.0 / 48.0 - x * (1.0 / 240.0))));
        let quotient = (1.0 - exp_negative(x)) / r_squared;
        h * if x < 3e-3 { series } else { quotient }
    }
}

/// That of I.
#[derive(Clone, Copy)]
struct Far(f64);

impl Integrand for Far {
    #[inline(always)]
    fn at(self, y: f64) -> f64 {
        let Self(h) = self;
        let r_squared = h * h + y * y;
        h * exp_negative(0.5 * r_squared) / r_squared
    }
}

/// The integral of `integrand` between two places, in parts of at most [`LONGEST`].
#[inline(always)]
fn integrate(from: f64, to: f64, integrand: impl Integrand) -> f64 {
    let length = to - from;
    // NaN has no length either.
    if length.is_nan() || length <= 0.0 {
        return 0.0;
    }
    // At most 2 √(77 + 77) / 3, as polygons much farther away have been left out.
    let parts = libm::ceil(length / LONGEST).clamp(1.0, 16.0);
    let step = length / parts;
    let mut sum = 0.0;
    for part in 0..parts as u32 {
        let middle = from + (f64::from(part) + 0.5) * step;
        // Two loops, as the first then becomes vector instructions.
        let mut values = [0.0; 12];
        for (value, node) in values.iter_mut().zip(&NODES) {
            *value = integrand.at(middle + 0.5 * step * node);
        }
        for (value, weight) in values.iter().zip(&HALF_WEIGHTS) {
            sum += value * weight;
        }
    }
    sum * step
}

/// The share of a unit Gaussian over the triangle, or with `is_parallelogram` over the parallelogram, of `piece`; in [0, 1].
///
/// Within 1e-13, of slivers 1e5 long within 1e-12; and where the origin is farther than 2.5, within 1e-6 of itself. 100 to 500 ns.
pub(super) fn share(piece: &Whitened, is_parallelogram: bool) -> f64 {
    let [x, y] = piece.corner;
    let (length, shear, height) = (piece.length, piece.shear, piece.height);
    let first = Edge::new([x, y], [length, 0.0]);
    let last = Edge::new([x + shear, y + height], [-shear, -height]);
    if is_parallelogram {
        share_of([
            first,
            Edge::new([x + length, y], [shear, height]),
            Edge::new([x + length + shear, y + height], [-length, 0.0]),
            last,
        ])
    } else {
        share_of([
            first,
            Edge::new([x + length, y], [shear - length, height]),
            last,
        ])
    }
}

fn share_of<const N: usize>(edges: [Edge; N]) -> f64 {
    let mut is_inside = true;
    let mut least = f64::INFINITY;
    let mut nearest = f64::INFINITY;
    for edge in &edges {
        is_inside &= edge.distance >= 0.0;
        least = least.min(edge.distance);
        nearest = nearest.min(edge.squared_distance());
    }
    if is_inside && least * least >= NOTHING {
        return 1.0;
    }
    let share = if !is_inside && nearest >= FAR {
        if nearest >= 2.0 * NOTHING {
            return 0.0;
        }
        -edges.iter().map(|edge| edge.tail(nearest)).sum::<f64>()
    } else {
        edges.iter().map(Edge::wedge).sum::<f64>()
    };
    share.clamp(0.0, 1.0)
}
