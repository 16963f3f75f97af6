//! The integral of a Gaussian over a texel, slowly: error functions on one axis, fine panels on the other.

use super::super::GaussianFootprint;
use super::std::vec;
use super::{Random, gaussian};
use core::f64::consts::{FRAC_1_SQRT_2, PI};

/// Nodes in [-1, 1] and weights of the Gauss-Legendre rule of five nodes.
const RULE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// The share of the whole Gaussian of `footprint` over one texel, within 1e-12.
///
/// Along the axis of the greater deviation the Gaussian is cut into panels of at most a quarter of anything it does
/// there; on the other axis it is a difference of error functions.
pub(super) fn share(footprint: &GaussianFootprint, column: i64, row: i64) -> f64 {
    let [[x_1, y_1], [x_2, y_2]] = footprint.half_edges;
    let low = [
        column as f64 - footprint.cell[0] - footprint.centre[0],
        row as f64 - footprint.cell[1] - footprint.centre[1],
    ];
    let [wide, high] = [x_1 * x_1 + x_2 * x_2, y_1 * y_1 + y_2 * y_2];
    let (outer, inner) = if wide >= high { (0, 1) } else { (1, 0) };
    let deviation = libm::sqrt(wide.max(high));
    let slope = (x_1 * y_1 + x_2 * y_2) / (deviation * deviation);
    let area = libm::fma(x_1, y_2, -(y_1 * x_2)) + libm::fma(-y_1, x_2, y_1 * x_2);
    let spread = area.abs() / deviation;

    let (from, to) = (
        low[outer].max(-9.0 * deviation),
        (low[outer] + 1.0).min(9.0 * deviation),
    );
    if from >= to {
        return 0.0;
    }
    let mut cuts = vec![from, to];
    let steps = || (-36..=36).map(|step| f64::from(step) * 0.25);
    cuts.extend(steps().map(|step| step * deviation));
    for border in [low[inner], low[inner] + 1.0] {
        cuts.extend(steps().map(|step| (border + step * spread) / slope));
    }
    cuts.retain(|t| (from..=to).contains(t));
    cuts.sort_unstable_by(f64::total_cmp);
    let below = |z: f64| 0.5 * libm::erfc(-z * FRAC_1_SQRT_2);
    let mut sum = 0.0;
    for panel in cuts.windows(2) {
        let (middle, half) = (0.5 * (panel[0] + panel[1]), 0.5 * (panel[1] - panel[0]));
        for (node, weight) in RULE {
            let t = middle + half * node;
            let z = t / deviation;
            let density = libm::exp(-0.5 * z * z) / (libm::sqrt(2.0 * PI) * deviation);
            let inner_low = (low[inner] - slope * t) / spread;
            let inner_high = (low[inner] + 1.0 - slope * t) / spread;
            sum += half * weight * density * (below(inner_high) - below(inner_low));
        }
    }
    sum
}

#[test]
fn the_reference_agrees_with_sums_over_points() {
    // 64 × 64 points a texel: the midpoint rule errs by (1/64 σ)² / 12 of the peak.
    let mut random = Random(1);
    for _ in 0..40 {
        let short = random.between(0.4, 2.0);
        let long = short * random.between(1.0, 8.0);
        let centre = [random.between(10.0, 12.0), random.between(10.0, 12.0)];
        let footprint = gaussian(centre, long, short, random.between(0.0, 2.0 * PI));
        let [first, second] = footprint.half_edges;
        let determinant = first[0] * second[1] - first[1] * second[0];
        let (column, row) = (random.whole(9, 14), random.whole(9, 14));
        let mut sum = 0.0;
        for point in 0..64 * 64 {
            let x = column as f64 + (f64::from(point % 64) + 0.5) / 64.0 - centre[0];
            let y = row as f64 + (f64::from(point / 64) + 0.5) / 64.0 - centre[1];
            let a = (x * second[1] - y * second[0]) / determinant;
            let b = (y * first[0] - x * first[1]) / determinant;
            sum += libm::exp(-0.5 * (a * a + b * b));
        }
        let peak = 1.0 / (2.0 * PI * determinant.abs());
        let error = (share(&footprint, column, row) - sum * peak / 4096.0).abs();
        let tolerance = peak / (12.0 * 4096.0 * short * short);
        assert!(error < tolerance, "{error} instead of {tolerance}");
    }
}
