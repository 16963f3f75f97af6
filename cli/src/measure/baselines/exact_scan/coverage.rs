//! What a box covers of each texel of a square, exactly, in closed form and without a branch by texel.
//!
//! With the box as `|a| ≤ 1/2` and `|b| ≤ 1/2`, a and b linear, a square inside both strips weighs 1. Where the sides of
//! one strip alone run, each of the two cuts off a half-plane's share of a texel. Where both do, near corners, the area is
//! Green's: for each side of the box, the integral over x of its height within the texel. Places are told from the square
//! in double precision and go on in single precision from there, so that no footprint is too large for it.

use super::{LANES, Lanes, Region, SIDE, max, min};
use glintbake_format::model::Footprint;

/// Slack in texels of what counts as touched.
const SLACK: f64 = 1e-9;
/// Least change of a parameter along the minor axis, beside that along the major one.
const LEAST_TILT: f32 = 1e-6;

/// `|g · p| ≤ 1/2`.
#[derive(Clone, Copy, Debug)]
struct Strip {
    gradient: [f64; 2],
    /// How much the parameter changes from a square's middle.
    reach: f64,
    /// One over the gradient's first part; infinite if the strip lies along rows.
    inverse: f64,
    /// Texels along the major axis per parameter.
    scale: f64,
    /// The gradient times the scale.
    slope: [f32; 2],
    /// Change along the minor axis beside that along the major one.
    tilt: f32,
}

/// A side of the box, from a corner to the next, the box at its left.
#[derive(Clone, Copy, Debug)]
struct Side {
    from: [f64; 2],
    to: f64,
    slope: f64,
}

/// A box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coverage {
    centre: [f64; 2],
    extent: [f64; 2],
    strips: [Strip; 2],
    sides: [Side; 4],
    inverse_area: f32,
}

impl Coverage {
    /// `footprint` on a map of `size`.
    ///
    /// # Panics
    /// If the footprint has no area.
    pub(super) fn new(footprint: &Footprint, size: [u32; 2]) -> Self {
        let size = size.map(f64::from);
        let scale = |[x, y]: [f64; 2]| [x * size[0], y * size[1]];
        let centre = scale(footprint.centre.map(|x| x - x.floor()));
        let (first, mut second) = (scale(footprint.edge_1), scale(footprint.edge_2));
        let mut turn = first[0] * second[1] - first[1] * second[0];
        assert!(turn.abs() > 0.0, "baselines need a footprint with an area");
        if turn < 0.0 {
            (second, turn) = (second.map(|x| -x), -turn);
        }
        let gradients = [
            [second[1] / turn, -second[0] / turn],
            [-first[1] / turn, first[0] / turn],
        ];
        let corner = |a: f64, b: f64| [0, 1].map(|axis| a * first[axis] + b * second[axis]);
        let corners = [
            corner(-0.5, -0.5),
            corner(0.5, -0.5),
            corner(0.5, 0.5),
            corner(-0.5, 0.5),
        ];
        Self {
            centre,
            extent: [0, 1].map(|axis| (first[axis].abs() + second[axis].abs()) * 0.5),
            strips: gradients.map(Strip::new),
            sides: [0, 1, 2, 3].map(|side| Side::new(corners[side], corners[(side + 1) % 4])),
            inverse_area: (1.0 / turn) as f32,
        }
    }
}

impl Strip {
    fn new(gradient: [f64; 2]) -> Self {
        let [x, y] = gradient.map(f64::abs);
        let major = x.max(y);
        Self {
            gradient,
            reach: 0.5 * SIDE as f64 * (x + y),
            inverse: 1.0 / gradient[0],
            scale: 1.0 / major,
            slope: gradient.map(|part| (part / major) as f32),
            tilt: ((x.min(y) / major) as f32).max(LEAST_TILT),
        }
    }

    #[inline(always)]
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.gradient[0] * x + self.gradient[1] * y
    }

    /// Sets what of each texel lies in the strip, of a square whose middle has parameter `at`.
    #[inline(always)]
    fn weigh(&self, at: f64, inverse_area: f32, weights: &mut Lanes) {
        // Distances of the middle from both sides, in texels along the major axis.
        let above = ((0.5 - at) * self.scale) as f32;
        let below = ((0.5 + at) * self.scale) as f32;
        let half = 0.5 * self.tilt;
        let (inner, outer) = (0.5 - half, 0.5 + half);
        let bend = 0.5 / self.tilt;
        for lane in 0..LANES {
            let [x, y] = OFFSETS[lane];
            let offset = self.slope[0] * x + self.slope[1] * y;
            let one = share(above - offset, inner, outer, half, bend, self.tilt);
            let other = share(below + offset, inner, outer, half, bend, self.tilt);
            weights[lane] = (one + other) * inverse_area;
        }
    }
}

/// From the middle of a square to the middles of its texels.
const OFFSETS: [[f32; 2]; LANES] = {
    let mut offsets = [[0.0; 2]; LANES];
    let mut lane = 0;
    while lane < LANES {
        let middle = 0.5 * (SIDE - 1) as f32;
        offsets[lane] = [(lane % SIDE) as f32 - middle, (lane / SIDE) as f32 - middle];
        lane += 1;
    }
    offsets
};

/// The share of a texel at one side of a line, less 1/2, for a middle `distance` from it along the major axis.
///
/// The integral from 0 of a trapezoid: 1 up to `inner`, 0 from `outer` on, with `tilt = outer - inner`.
#[inline(always)]
fn share(distance: f32, inner: f32, outer: f32, half: f32, bend: f32, tilt: f32) -> f32 {
    let far = distance.abs();
    let rest = min(max(outer - far, 0.0), tilt);
    let share = min(far, inner) + (half - rest * rest * bend);
    share.copysign(distance)
}

impl Side {
    fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        let along = to[0] - from[0];
        // No area is under a side that stands upright.
        let slope = (to[1] - from[1]) / along;
        Self {
            from,
            to: to[0],
            slope: if slope.abs() < 1e9 { slope } else { 0.0 },
        }
    }

    /// Adds the integral of the side's height within each texel of the square around `middle`, over x and from right to left.
    #[inline(always)]
    fn add(&self, middle: [f64; 2], sums: &mut Lanes) {
        let from = (self.from[0] - middle[0]) as f32;
        let to = (self.to - middle[0]) as f32;
        let height = (self.from[1] - middle[1] - self.slope * (self.from[0] - middle[0])) as f32;
        let slope = self.slope as f32;
        for lane in 0..LANES {
            let [x, y] = OFFSETS[lane];
            let (left, right) = (x - 0.5, x + 0.5);
            let first = min(max(from, left), right);
            let last = min(max(to, left), right);
            let base = height - (y - 0.5);
            let one = base + slope * first;
            let other = base + slope * last;
            let (low, high) = (min(one, other), max(one, other));
            // The mean over [low, high] of heights clamped to [0, 1]. All differences are of one sign, so that their
            // ratio is as exact as they are.
            let (bottom, top) = (min(max(low, 0.0), 1.0), min(max(high, 0.0), 1.0));
            let within = (top - bottom) * 0.5 * (top + bottom);
            let beyond = max(high, 1.0) - max(low, 1.0);
            let change = high - low;
            let mean = if change > 0.0 {
                (within + beyond) / change
            } else {
                bottom
            };
            sums[lane] += (first - last) * mean;
        }
    }
}

impl Region for Coverage {
    #[inline(always)]
    fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        (self.centre, self.extent)
    }

    #[inline(always)]
    fn span(&self, y: f64) -> [f64; 2] {
        let reach = self.extent[0] + 0.5 * SIDE as f64 + SLACK;
        let mut span = [-reach, reach];
        for strip in &self.strips {
            // Along rows the quotient is infinite or not a number, and says nothing.
            let middle = -strip.gradient[1] * y * strip.inverse;
            let touches = (0.5 + strip.reach) * strip.inverse.abs() + SLACK;
            let [from, to] = [middle - touches, middle + touches];
            span = [span[0].max(from), span[1].min(to)];
        }
        span
    }

    #[inline(always)]
    fn left(&self, _: [f64; 2]) -> f64 {
        1.0
    }

    #[inline(always)]
    fn weigh(&self, middle: [f64; 2], weights: &mut Lanes) {
        let [first, second] = &self.strips;
        let (a, b) = (first.at(middle), second.at(middle));
        let in_first = a.abs() + first.reach <= 0.5;
        let in_second = b.abs() + second.reach <= 0.5;
        match (in_first, in_second) {
            (true, true) => *weights = [self.inverse_area; LANES],
            (false, true) => first.weigh(a, self.inverse_area, weights),
            (true, false) => second.weigh(b, self.inverse_area, weights),
            (false, false) => {
                let mut sums = [0.0; LANES];
                for side in &self.sides {
                    side.add(middle, &mut sums);
                }
                for lane in 0..LANES {
                    weights[lane] = max(sums[lane], 0.0) * self.inverse_area;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::parallelogram::{Parallelogram, Relation};
    use super::*;

    #[test]
    fn weights_are_clipped_areas() {
        let size = [1024, 1024];
        let mut cut = 0;
        // Edges and angles between them; upright ones, flat ones and needles among them.
        let shapes = [
            ([0.3, 0.2], 0.5 * TURN),
            ([3.0, 3.0], 0.5 * TURN),
            ([7.0, 2.0], 0.31 * TURN),
            ([40.0, 0.05], 0.5 * TURN),
            ([300.0, 0.7], 0.01 * TURN),
            ([500.0, 411.0], -0.4 * TURN),
        ];
        for ([long, short], between) in shapes {
            for step in 0..24 {
                // Multiples of 15 degrees; the second half a bit off them.
                let off = if step < 12 { 0.0 } else { 1e-5 };
                let angle = f64::from(step % 12) * TURN / 12.0 + off;
                let edge = |length: f64, angle: f64| {
                    [length * angle.cos() / 1024.0, length * angle.sin() / 1024.0]
                };
                let footprint = Footprint {
                    centre: [0.5 + 1.3e-4 * f64::from(step), 0.5 + 7e-5],
                    edge_1: edge(long, angle),
                    edge_2: edge(short, angle + between),
                };
                let coverage = Coverage::new(&footprint, size);
                let exact = Parallelogram::new(&footprint, size[0], size[1]);
                for row in 0..256_u16 {
                    let y = f64::from(4 * row) + 2.0 - coverage.centre[1];
                    let [from, to] = coverage.span(y);
                    for column in 0..256_u16 {
                        let x = f64::from(4 * column) + 2.0 - coverage.centre[0];
                        let mut weights = [0.0; LANES];
                        if x >= from && x <= to {
                            coverage.weigh([x, y], &mut weights);
                        }
                        for (lane, weight) in weights.into_iter().enumerate() {
                            let texel = [
                                4 * column + (lane % SIDE) as u16,
                                4 * row + (lane / SIDE) as u16,
                            ];
                            let area = match exact.texel_relation(texel) {
                                Relation::Outside => 0.0,
                                Relation::Inside => 1.0,
                                Relation::Crossing => {
                                    cut += 1;
                                    exact.clipped_area(texel)
                                }
                            };
                            let found = f64::from(weight) * exact.area();
                            assert!(
                                (found - area).abs() < 2e-6,
                                "{long} × {short}, {angle}: {found} for {area} at {texel:?}"
                            );
                        }
                    }
                }
            }
        }
        assert!(cut > 10_000, "{cut}");
    }

    /// Half of one.
    const TURN: f64 = std::f64::consts::PI;
}
