//! The lobes of an example over parts of a footprint, below the finest tiles.

use super::super::analytic::{Shape, TriangleForm, mean};
use super::frame::{Local, Region};
use core::f64::consts::{PI, TAU};
use glintbake_format::model::{LobeLattice, Wrap};
use glintbake_format::view::NdfMaps;

/// Texels beyond which a lobe counts as nothing: 4.5 standard deviations.
const REACH: f64 = 1.9;

/// Squared standard deviations beyond which a normal counts as nothing, where nothing may err: 4e-8 of the peak.
pub(super) const FARTHEST: f64 = 34.0;

/// The same where densities may err: 1e-4.
pub(super) const FAR: f64 = 18.0;

const VARIANCE: f64 = LobeLattice::DEVIATION * LobeLattice::DEVIATION;

/// The lobes of an example at one normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobes<'q> {
    pub maps: &'q NdfMaps<'q>,
    pub wrap: Wrap,
    pub sigma: f64,
    pub normal: [f64; 2],
    /// Squared standard deviations beyond which a normal counts as nothing.
    pub farthest: f64,
}

/// A lobe's normal and slope, per texel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    pub normal: [f64; 2],
    pub across: [f64; 2],
    pub down: [f64; 2],
}

/// The lobe of texel (`column`, `row`) of the endless example; `None` where the package is damaged.
pub(super) fn lobe(maps: &NdfMaps<'_>, wrap: Wrap, column: i64, row: i64) -> Option<Lobe> {
    let side = i64::from(maps.layout.example());
    let fold = |index: i64| match wrap {
        // A power of two.
        Wrap::Repeat => (index & (side - 1)) as u32,
        Wrap::Clamp => index.clamp(0, side - 1) as u32,
    };
    let normal = |column: i64, row: i64| maps.normal(fold(column), fold(row));
    let halved = |before: [f64; 2], after: [f64; 2]| {
        [0.5 * (after[0] - before[0]), 0.5 * (after[1] - before[1])]
    };
    Some(Lobe {
        normal: normal(column, row)?,
        across: halved(
            normal(column.wrapping_sub(1), row)?,
            normal(column.wrapping_add(1), row)?,
        ),
        down: halved(
            normal(column, row.wrapping_sub(1))?,
            normal(column, row.wrapping_add(1))?,
        ),
    })
}

impl Lobes<'_> {
    /// The integral of the lobes' density over `regions` of the footprint.
    pub fn over(&self, local: &Local, regions: &[Region]) -> f64 {
        let [x, y] = local.axes;
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for region in regions {
            for &corner in region.corners() {
                for (bound, axis) in bounds.iter_mut().zip([x, y]) {
                    let at = axis.at(corner);
                    *bound = [bound[0].min(at), bound[1].max(at)];
                }
            }
        }
        let texels = |[low, high]: [f64; 2]| {
            let first = libm::ceil(low - REACH - 0.5) as i64;
            let last = libm::floor(high + REACH - 0.5) as i64;
            // A tile and what is near: not more, whatever a package says.
            first..last.saturating_add(1).min(first.saturating_add(16))
        };
        let [columns, rows] = bounds.map(texels);
        let mut sum = 0.0;
        for row in rows {
            for column in columns.clone() {
                if let Some(lobe) = lobe(self.maps, self.wrap, column, row)
                    && self.is_near(&lobe)
                {
                    let middle = [column as f64 + 0.5, row as f64 + 0.5];
                    sum += self.lobe_over(&lobe, middle, local, regions);
                }
            }
        }
        sum
    }

    /// Whether `lobe` has anything to say of the normal, wherever it is looked at.
    fn is_near(&self, lobe: &Lobe) -> bool {
        let [s, t] = [
            self.normal[0] - lobe.normal[0],
            self.normal[1] - lobe.normal[1],
        ];
        let own = self.sigma * self.sigma;
        let [[s_x, t_x], [s_y, t_y]] = [lobe.across, lobe.down];
        let ss = own + VARIANCE * (s_x * s_x + s_y * s_y);
        let st = VARIANCE * (s_x * t_x + s_y * t_y);
        let tt = own + VARIANCE * (t_x * t_x + t_y * t_y);
        let squared = tt * s * s - 2.0 * st * s * t + ss * t * t;
        squared <= self.farthest * (ss * tt - st * st)
    }

    fn lobe_over(&self, lobe: &Lobe, middle: [f64; 2], local: &Local, regions: &[Region]) -> f64 {
        let [x, y] = local.axes;
        let (position, normal) = (1.0 / LobeLattice::DEVIATION, 1.0 / self.sigma);
        // In standard deviations of position and normal, where the footprint's point (a, b) lies from the lobe.
        let point = |[a, b]: [f64; 2], [from_x, from_y]: [f64; 2], from: [f64; 2]| {
            let dx = x.slope[0] * a + x.slope[1] * b + from_x;
            let dy = y.slope[0] * a + y.slope[1] * b + from_y;
            [
                dx * position,
                dy * position,
                (lobe.across[0] * dx + lobe.down[0] * dy + from[0]) * normal,
                (lobe.across[1] * dx + lobe.down[1] * dy + from[1]) * normal,
            ]
        };
        let origin = [x.constant - middle[0], y.constant - middle[1]];
        let apart = [
            lobe.normal[0] - self.normal[0],
            lobe.normal[1] - self.normal[1],
        ];
        let mut sum = 0.0;
        for region in regions {
            let corners = region.corners();
            let Some(&first) = corners.first() else {
                continue;
            };
            let corner = point(first, origin, apart);
            if region.is_unit_square() {
                let edges = [[1.0, 0.0], [0.0, 1.0]].map(|edge| point(edge, [0.0; 2], [0.0; 2]));
                let (shape, form) = (Shape::Parallelogram, TriangleForm::Accurate);
                sum += mean(corner, edges, shape, form, self.farthest);
                continue;
            }
            for pair in corners.windows(2).skip(1) {
                let [p, q] = pair else { continue };
                let edge = |to: &[f64; 2]| [to[0] - first[0], to[1] - first[1]];
                let (p, q) = (edge(p), edge(q));
                let area = 0.5 * (p[0] * q[1] - p[1] * q[0]);
                if area > 0.0 {
                    let edges = [p, q].map(|edge| point(edge, [0.0; 2], [0.0; 2]));
                    let form = TriangleForm::Accurate;
                    sum += area * mean(corner, edges, Shape::Triangle, form, self.farthest);
                }
            }
        }
        sum / (TAU * VARIANCE * TAU * self.sigma * self.sigma)
    }
}

/// The amplitude of the sum of all lobes' positions along an axis, `Σ N(u; i + ½, σh²) = 1 - 2 exp(-2π² σh²) cos 2πu + …`, what is left
/// out being 1e-6.
const RIPPLE: f64 = -2.0 * 0.028_447_149_087_636_5;

/// The integral over `region` of the sum of all lobes' positions, which is 1 but for a ripple of texels.
pub(super) fn ripple(local: &Local, region: &Region) -> f64 {
    let [x, y] = local.axes;
    let wave = |of_x: f64, of_y: f64| {
        let constant = TAU * (of_x * x.constant + of_y * y.constant);
        let slope = [0, 1].map(|axis| {
            let [p, q] = if axis == 0 {
                [x.slope[0], y.slope[0]]
            } else {
                [x.slope[1], y.slope[1]]
            };
            TAU * (of_x * p + of_y * q)
        });
        cosine_over(region, constant, slope)
    };
    region.area()
        + RIPPLE * (wave(1.0, 0.0) + wave(0.0, 1.0))
        + 0.5 * RIPPLE * RIPPLE * (wave(1.0, 1.0) + wave(1.0, -1.0))
}

/// The integral over `region` of `cos(constant + slope · p)`.
///
/// Its divergence is that of `slope sin(…) / |slope|²`, so that it is a sum over edges of mean sines; where the phase hardly changes,
/// of the mean cosine of edges' middles and corners instead, exact to the fourth order.
fn cosine_over(region: &Region, constant: f64, slope: [f64; 2]) -> f64 {
    let corners = region.corners();
    let Some(&first) = corners.first() else {
        return 0.0;
    };
    let square = slope[0] * slope[0] + slope[1] * slope[1];
    let phase = |p: [f64; 2]| constant + slope[0] * p[0] + slope[1] * p[1];
    let at_first = phase(first);
    let spread = corners
        .iter()
        .map(|&corner| (phase(corner) - at_first).abs())
        .fold(0.0, f64::max);
    let mut sum = 0.0;
    if spread < 0.05 {
        for pair in corners.windows(2).skip(1) {
            let [p, q] = pair else { continue };
            let area = 0.5
                * ((p[0] - first[0]) * (q[1] - first[1]) - (p[1] - first[1]) * (q[0] - first[0]));
            let middle = |p: [f64; 2], q: [f64; 2]| libm::cos(0.5 * (phase(p) + phase(q)));
            sum += area / 3.0 * (middle(first, *p) + middle(*p, *q) + middle(*q, first));
        }
        return sum;
    }
    let Some(&last) = corners.last() else {
        return 0.0;
    };
    let mut from = last;
    for &to in corners {
        let (low, high) = (phase(from), phase(to));
        let half = 0.5 * (high - low);
        let flat = if half.abs() < 1e-4 {
            1.0 - half * half / 6.0
        } else {
            libm::sin(half) / half
        };
        let outward = slope[0] * (to[1] - from[1]) - slope[1] * (to[0] - from[0]);
        sum += outward * libm::sin(0.5 * (low + high)) * flat;
        from = to;
    }
    sum / square
}

/// The greatest sum of all lobes' positions.
pub(super) const GREATEST_RIPPLE: f64 = (1.0 - RIPPLE) * (1.0 - RIPPLE);

/// The sum of all lobes' positions at the point (`x`, `y`) of the example.
pub(super) fn ripple_at([x, y]: [f64; 2]) -> f64 {
    let wave = |along: f64| 1.0 + RIPPLE * libm::cos(2.0 * PI * along);
    wave(x) * wave(y)
}
