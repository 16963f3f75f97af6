//! Brute force for integrals of Gaussians: halve triangles until nothing changes by more than a deviation.

use super::super::gauss_legendre::GaussLegendre;

/// Standard deviations beyond which a triangle counts as nothing.
const REACH: f64 = 12.0;

/// `∫ exp(-|r|² / 2)` over a triangle of `area`, r linear with the values `corners` at its corners.
pub(super) fn bell_over_triangle<const N: usize>(corners: [[f64; N]; 3], area: f64) -> f64 {
    let rule = GaussLegendre::new(8);
    halved(corners, area, &rule)
}

fn halved<const N: usize>(corners: [[f64; N]; 3], area: f64, rule: &GaussLegendre) -> f64 {
    let mut nearest = 0.0;
    for component in 0..N {
        let values = corners.map(|corner| corner[component]);
        let low = values.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let high = values.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        let distance = low.max(-high).max(0.0);
        nearest += distance * distance;
    }
    if nearest > REACH * REACH {
        return 0.0;
    }
    let mut longest = (0.0, 0);
    for side in 0..3 {
        let (from, to) = (corners[side], corners[(side + 1) % 3]);
        let square: f64 = from.iter().zip(to).map(|(a, b)| (b - a) * (b - a)).sum();
        if square > longest.0 {
            longest = (square, side);
        }
    }
    if longest.0 > 2.0 {
        let [from, to, rest] = [0, 1, 2].map(|step| corners[(longest.1 + step) % 3]);
        let mut middle = from;
        for (x, y) in middle.iter_mut().zip(to) {
            *x = 0.5 * (*x + y);
        }
        return halved([from, middle, rest], 0.5 * area, rule)
            + halved([middle, to, rest], 0.5 * area, rule);
    }
    // Duffy's square: the first corner is stretched to a side.
    let mut sum = 0.0;
    for (a, length) in rule.nodes(0.0, 1.0) {
        for (b, width) in rule.nodes(0.0, 1.0) {
            let mut squared = 0.0;
            for component in 0..N {
                let [p, q, r] = corners.map(|corner| corner[component]);
                let value = p + a * ((q - p) + b * (r - q));
                squared += value * value;
            }
            sum += length * width * a * libm::exp(-0.5 * squared);
        }
    }
    2.0 * area * sum
}

#[test]
fn brute_force_finds_the_gaussian_whole() {
    use core::f64::consts::PI;
    for scale in [1.0, 1e3, 1e5] {
        // A square of 40 deviations about the middle, and one of which only a corner counts.
        let square = |low: f64, high: f64| {
            let corners = [[low, low], [high, low], [high, high], [low, high]];
            let at = |k: usize| corners[k].map(|x: f64| x * 10.0 * libm::sqrt(scale));
            bell_over_triangle([at(0), at(1), at(2)], 1.0)
                + bell_over_triangle([at(0), at(2), at(3)], 1.0)
        };
        let side = 2.0 * 10.0 * libm::sqrt(scale);
        let whole = square(-1.0, 1.0) * side * side / 2.0;
        assert!((whole / (2.0 * PI) - 1.0).abs() < 1e-13, "{scale}: {whole}");
        let quarter = square(0.0, 2.0) * side * side / 2.0;
        assert!((quarter / (0.5 * PI) - 1.0).abs() < 1e-13, "{scale}");
    }
}
