//! The integral over one polygon on which the normal is linear.
//!
//! The exponent of the integrand is `-|r|² / 2`, where r = (place, normal less half vector) in standard deviations is
//! linear in the coordinates (p, q) of the polygon. Along q, for any p, that is a Gaussian about the foot of the
//! perpendicular: error functions between the polygon's sides. Along p what is left is integrated by Gauss-Legendre
//! panels no wider than anything the integrand does, as the oracle's weights of texels are.

use super::super::gauss_legendre::GaussLegendre;
use super::super::gaussian::normal_between;
use core::f64::consts::PI;

/// Standard deviations beyond which a Gaussian counts as zero: it has fallen to 2e-22 of its peak.
pub(super) const REACH: f64 = 10.0;

/// Deviations along q below which error functions are integrated by nodes: their difference would lose digits.
const SHORT: f64 = 0.05;

/// Deviations along p up to which few nodes do.
const NARROW: f64 = 0.25;

/// Components of r: place along p and along q, normal along s and along t.
type Residual = [f64; 4];

/// The rules of an integral.
#[derive(Clone, Debug)]
pub(super) struct Rules {
    /// Errs by about 1e-19 on a panel of one standard deviation.
    wide: GaussLegendre,
    /// Errs by 1e-15 of the values themselves on panels of [`NARROW`], and less on pieces of [`SHORT`].
    narrow: GaussLegendre,
}

impl Rules {
    pub(super) fn new() -> Self {
        Self {
            wide: GaussLegendre::new(10),
            narrow: GaussLegendre::new(5),
        }
    }
}

/// A convex polygon, and r over it as `at + p along_p + q along_q`.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    pub(super) corners: Vec<[f64; 2]>,
    pub(super) at: Residual,
    pub(super) along_p: Residual,
    pub(super) along_q: Residual,
}

impl Patch {
    /// Leaves of the polygon what lies within [`REACH`] of the place, along the axes whose places count, and moves the
    /// origin there.
    pub(super) fn clip(&mut self) {
        for axis in 0..2 {
            let scale = [self.along_p[0], self.along_q[1]][axis];
            if scale > 0.0 {
                let (low, high) = (-REACH - self.at[axis], REACH - self.at[axis]);
                self.corners = clipped(&self.corners, axis, low, 1.0);
                self.corners = clipped(&self.corners, axis, high, -1.0);
            }
        }
        let Some(&[p, q]) = self.corners.first() else {
            return;
        };
        for corner in &mut self.corners {
            *corner = [corner[0] - p, corner[1] - q];
        }
        for (at, (along_p, along_q)) in self
            .at
            .iter_mut()
            .zip(self.along_p.iter().zip(self.along_q))
        {
            *at += p * along_p + q * along_q;
        }
    }

    /// Whether [`REACH`] ends before any point of the polygon.
    fn is_far(&self) -> bool {
        let mut squared = 0.0;
        for k in 0..4 {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for &[p, q] in &self.corners {
                let value = self.at[k] + p * self.along_p[k] + q * self.along_q[k];
                (low, high) = (low.min(value), high.max(value));
            }
            let distance = low.max(-high).max(0.0);
            squared += distance * distance;
        }
        squared > REACH * REACH
    }

    /// `∫ exp(-|r|² / 2) dp dq` over the polygon.
    pub(super) fn integral(&self, rules: &Rules) -> f64 {
        if self.is_far() {
            return 0.0;
        }
        let mut ends: Vec<f64> = self.corners.iter().map(|corner| corner[0]).collect();
        ends.sort_unstable_by(f64::total_cmp);
        ends.dedup();
        let strip = Strip::new(self);
        ends.windows(2)
            .map(|ends| {
                let (lower, upper) = self.sides(0.5 * (ends[0] + ends[1]));
                strip.integral([ends[0], ends[1]], lower, upper, rules)
            })
            .sum()
    }

    /// The sides of the polygon below and above the places at `p`.
    fn sides(&self, p: f64) -> (Side, Side) {
        let mut sides: Vec<(f64, Side)> = Vec::new();
        for (i, &from) in self.corners.iter().enumerate() {
            let to = self.corners[(i + 1) % self.corners.len()];
            if from[0].min(to[0]) < p && p < from[0].max(to[0]) {
                let side = Side {
                    from,
                    slope: (to[1] - from[1]) / (to[0] - from[0]),
                };
                sides.push((side.at(p), side));
            }
        }
        sides.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        match (sides.first(), sides.last()) {
            (Some(lower), Some(upper)) => (lower.1, upper.1),
            // No f64 lies between the two ends: nothing is between them either.
            _ => (Side::default(), Side::default()),
        }
    }
}

/// The part of a convex polygon where `sign (x - border) >= 0` along `axis`.
fn clipped(corners: &[[f64; 2]], axis: usize, border: f64, sign: f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        let (before, after) = (sign * (from[axis] - border), sign * (to[axis] - border));
        if before >= 0.0 {
            kept.push(from);
        }
        if (before > 0.0 && after < 0.0) || (before < 0.0 && after > 0.0) {
            let share = before / (before - after);
            let mut cut = [0, 1].map(|k: usize| from[k] + share * (to[k] - from[k]));
            cut[axis] = border;
            kept.push(cut);
        }
    }
    kept
}

/// A side of a polygon as q over p.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    from: [f64; 2],
    slope: f64,
}

impl Side {
    fn at(self, p: f64) -> f64 {
        self.from[1] + self.slope * (p - self.from[0])
    }
}

/// The integrand, split into that along q and the rest.
struct Strip {
    /// `|along_q|`: deviations per unit of q.
    rate: f64,
    /// Deviations along q at q = 0: `foot[0] + p foot[1]`.
    foot: [f64; 2],
    /// What of r no q can change, at p = 0 and per unit of p.
    rest: [Residual; 2],
}

impl Strip {
    fn new(patch: &Patch) -> Self {
        let rate = libm::sqrt(dot(patch.along_q, patch.along_q));
        let unit = if rate > 0.0 {
            patch.along_q.map(|x| x / rate)
        } else {
            [0.0; 4]
        };
        let split = |r: Residual| {
            let foot = dot(r, unit);
            let mut rest = r;
            for (x, u) in rest.iter_mut().zip(unit) {
                *x -= foot * u;
            }
            (foot, rest)
        };
        let (at, rest_at) = split(patch.at);
        let (along, rest_along) = split(patch.along_p);
        Self {
            rate,
            foot: [at, along],
            rest: [rest_at, rest_along],
        }
    }

    /// The integral between two p, and q between two sides.
    fn integral(
        &self,
        [mut from, mut to]: [f64; 2],
        lower: Side,
        upper: Side,
        rules: &Rules,
    ) -> f64 {
        let [rest, change] = self.rest;
        let squares = dot(change, change);
        let mut cuts = Vec::new();
        let mut quickest = libm::sqrt(squares);
        let mut step_around = |middle: f64, width: f64, from: f64, to: f64| {
            if width < to - from {
                cuts.extend(
                    (-(REACH as i32)..=REACH as i32)
                        .map(|step| middle + f64::from(step) * width)
                        .filter(|&p| from < p && p < to),
                );
            }
        };
        if squares > 0.0 {
            let middle = -dot(rest, change) / squares;
            let width = 1.0 / libm::sqrt(squares);
            from = from.max(middle - REACH * width);
            to = to.min(middle + REACH * width);
            if from >= to {
                return 0.0;
            }
            step_around(middle, width, from, to);
        }
        // Where a side crosses the foot, error functions change from 0 to 1.
        for side in [lower, upper] {
            let slope = self.rate * side.slope + self.foot[1];
            let start = self.rate * side.at(from) + self.foot[0] + self.foot[1] * from;
            quickest = quickest.max(slope.abs());
            if slope != 0.0 {
                step_around(from - start / slope, 1.0 / slope.abs(), from, to);
            }
        }
        cuts.extend([from, to]);
        cuts.sort_unstable_by(f64::total_cmp);
        let mut sum = 0.0;
        for panel in cuts.windows(2) {
            let rule = if quickest * (panel[1] - panel[0]) < NARROW {
                &rules.narrow
            } else {
                &rules.wide
            };
            for (p, length) in rule.nodes(panel[0], panel[1]) {
                let mut square = 0.0;
                for (x, y) in rest.iter().zip(change) {
                    square += (x + p * y) * (x + p * y);
                }
                if square < REACH * REACH {
                    let foot = self.foot[0] + self.foot[1] * p;
                    let across = self.across(foot, lower.at(p), upper.at(p), rules);
                    sum += length * libm::exp(-0.5 * square) * across;
                }
            }
        }
        sum
    }

    /// `∫ exp(-(foot + rate q)² / 2) dq`.
    fn across(&self, foot: f64, from: f64, to: f64, rules: &Rules) -> f64 {
        if self.rate * (to - from) > SHORT {
            let between = normal_between(foot + self.rate * from, foot + self.rate * to);
            return libm::sqrt(2.0 * PI) / self.rate * between;
        }
        let bell = |q: f64| {
            let z = foot + self.rate * q;
            libm::exp(-0.5 * z * z)
        };
        rules
            .narrow
            .nodes(from, to)
            .map(|(q, length)| length * bell(q))
            .sum()
    }
}

fn dot(a: Residual, b: Residual) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
