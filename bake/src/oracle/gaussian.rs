//! Texel weights of a Gaussian footprint, by integrating it over every texel.
//!
//! The Gaussian is split into the distribution along one axis of the map and that along the other given the first.
//! The second is integrated over a texel by error functions, the first by Gauss-Legendre panels no wider than
//! anything the integrand does.

use super::double_double::DoubleDouble;
use super::gauss_legendre::GaussLegendre;
use super::texel_axis::TexelAxis;
use super::weights::{MAX_SPAN_TILES, RowSums, TexelWeight};
use crate::normals::NormalMap;
use core::f64::consts::{FRAC_1_SQRT_2, PI};
use glintbake_format::model::{Footprint, Wrap};
use std::collections::BTreeMap;

/// Standard deviations beyond which the Gaussian counts as zero: 1e-18 of it lies further out on an axis.
const REACH: f64 = 9.0;

/// Nodes of a panel at most one standard deviation wide: the rule errs by about 1e-19 there.
const NODES: usize = 10;

/// `√(1 - ρ²)`, of the correlation ρ of the two axes, below which a footprint is taken as a line.
///
/// A Gaussian this thin differs from its line by about this much, and its panels are as narrow as f64 can place.
const LINE_RATIO: f64 = 1e-13;

/// Standard deviation, in tiles, from which a repeating Gaussian weighs all texels alike.
///
/// The sum of its copies is a Fourier series whose first waves have the amplitude `2 exp(-2π² σ²)`: 1e-19 here.
const EVEN_TILES: f64 = 1.5;

/// Every texel under the Gaussian of `footprint` with its weight: each once, row-major, summing to 1.
///
/// `w_k = ∫_{T_k} G(u) du` with G the Gaussian of mean `centre` and covariance `(e1 e1ᵀ + e2 e2ᵀ) / 4`, on the map as
/// its wrap mode continues it: the weights of all copies of a texel are added, and the border of a clamped map
/// extends without end. Parallel edges, or a vanishing one, give the Gaussian along their line, two vanishing edges
/// the texel at the centre; borders belong to the texel to their right or below. Texels without weight are left out.
///
/// # Accuracy
/// Each weight is within 1e-13 for every footprint: any anisotropy, any finite centre, from points to half of
/// [`MAX_SPAN_TILES`]. Nothing is cut off nearer than 9 standard deviations.
///
/// # Cost
/// Proportional to the texels within 9 standard deviations, all copies counted.
///
/// # Panics
/// If a number of the footprint is not finite, the map is empty, or the sum of its edges on an axis exceeds half of
/// [`MAX_SPAN_TILES`].
pub fn gaussian_weights(map: &NormalMap, footprint: &Footprint) -> Vec<TexelWeight> {
    let Footprint {
        centre,
        edge_1,
        edge_2,
    } = *footprint;
    assert!(
        map.width() > 0 && map.height() > 0,
        "an empty map has no weights"
    );
    for axis in 0..2 {
        let span = edge_1[axis].abs() + edge_2[axis].abs();
        assert!(
            centre[axis].is_finite() && span <= 0.5 * MAX_SPAN_TILES,
            "a Gaussian footprint must be finite and span at most {} tiles",
            0.5 * MAX_SPAN_TILES
        );
    }
    if map.wrap() == Wrap::Repeat && least_deviation(edge_1, edge_2) >= EVEN_TILES {
        return even_weights(map);
    }
    let axis = |i: usize, size| TexelAxis::new(centre[i], [edge_1[i], edge_2[i]], size, map.wrap());
    let (horizontal, vertical) = (axis(0, map.width()), axis(1, map.height()));
    let mut weights = if deviation(&vertical) >= deviation(&horizontal) {
        Conditional::new(&vertical, &horizontal).weights(map.height(), map.width(), false)
    } else {
        Conditional::new(&horizontal, &vertical).weights(map.width(), map.height(), true)
    };
    weights.sort_unstable_by_key(|texel| (texel.row, texel.column));
    weights
}

/// The standard deviation along one axis: half the root of the sum of squares.
fn deviation(axis: &TexelAxis) -> f64 {
    let [first, second] = axis.edges();
    0.5 * libm::sqrt((first * first + second * second).value())
}

/// The least standard deviation in any direction; 0 for parallel edges.
pub(super) fn least_deviation(edge_1: [f64; 2], edge_2: [f64; 2]) -> f64 {
    let sum: f64 = [edge_1, edge_2].iter().flatten().map(|x| x * x).sum();
    let area = edge_1[0] * edge_2[1] - edge_1[1] * edge_2[0];
    // The greater root of `x² - sum x + area²`, and the product of both.
    let greatest = 0.5 * (sum + libm::sqrt((sum * sum - 4.0 * area * area).max(0.0)));
    if greatest > 0.0 {
        0.5 * area.abs() / libm::sqrt(greatest)
    } else {
        0.0
    }
}

fn even_weights(map: &NormalMap) -> Vec<TexelWeight> {
    let weight = 1.0 / (f64::from(map.width()) * f64::from(map.height()));
    (0..map.height())
        .flat_map(|row| {
            (0..map.width()).map(move |column| TexelWeight {
                column,
                row,
                weight,
            })
        })
        .collect()
}

/// A Gaussian as `y ~ N(0, σ²)` along the outer axis and `x ~ N(slope y, spread²)` along the inner, in texels.
struct Conditional<'a> {
    outer: &'a TexelAxis,
    inner: &'a TexelAxis,
    deviation: f64,
    slope: f64,
    spread: f64,
}

impl<'a> Conditional<'a> {
    /// The axis of the greater deviation is the outer one, which keeps `slope` in [-1, 1].
    fn new(outer: &'a TexelAxis, inner: &'a TexelAxis) -> Self {
        let ([x_1, x_2], [y_1, y_2]) = (inner.edges(), outer.edges());
        let deviation = deviation(outer);
        let square = y_1 * y_1 + y_2 * y_2;
        let (slope, spread) = if deviation > 0.0 {
            // det(Σ) = (e1 × e2)² / 16, and the conditional variance is det(Σ) / σ².
            let area = (x_1 * y_2 - y_1 * x_2).abs().value();
            (
                ((x_1 * y_1 + x_2 * y_2) / square).value(),
                0.25 * area / deviation,
            )
        } else {
            (0.0, 0.0)
        };
        Self {
            outer,
            inner,
            deviation,
            slope,
            spread,
        }
    }

    /// The weights by the texels of a map that is `outer_size` long on the outer axis, the horizontal one if
    /// `transposed`.
    fn weights(&self, outer_size: u32, inner_size: u32, transposed: bool) -> Vec<TexelWeight> {
        let texel = |outer: u32, inner: u32, weight: f64| {
            let (row, column) = if transposed {
                (inner, outer)
            } else {
                (outer, inner)
            };
            TexelWeight {
                column,
                row,
                weight,
            }
        };
        // Written so that a point, with 0 on both sides, is a line too.
        if self.spread <= LINE_RATIO * self.slope.abs() * self.deviation {
            let line = self.line_weights();
            return line
                .into_iter()
                .map(|((outer, inner), weight)| texel(outer, inner, weight))
                .collect();
        }
        let reach = REACH * self.deviation;
        let mut strips: Vec<(u32, i64)> = self
            .outer
            .texels_between(-reach, reach)
            .map(|k| (self.outer.fold(k), k))
            .collect();
        strips.sort_unstable();
        debug_assert!(strips.iter().all(|strip| strip.0 < outer_size));

        let rule = GaussLegendre::new(NODES);
        let mut weights = Vec::new();
        let mut sums = RowSums::new(inner_size);
        for copies in strips.chunk_by(|a, b| a.0 == b.0) {
            for &(_, k) in copies {
                self.add_strip(k, &rule, &mut sums);
            }
            let outer = copies[0].0;
            sums.drain(|inner, sum| weights.push(texel(outer, inner, sum.value())));
        }
        weights
    }

    /// Adds the integrals over the texels at place `k` of the outer axis.
    fn add_strip(&self, k: i64, rule: &GaussLegendre, sums: &mut RowSums) {
        let reach = REACH * self.deviation;
        let place =
            |border: Option<DoubleDouble>, end: f64| border.map_or(end, |border| border.value());
        let from = place(self.outer.lower(k), -reach).max(-reach);
        let to = place(self.outer.upper(k), reach).min(reach);
        if from >= to {
            return;
        }
        let means = [self.slope * from, self.slope * to];
        let margin = REACH * self.spread;
        let texels = self.inner.texels_between(
            means[0].min(means[1]) - margin,
            means[0].max(means[1]) + margin,
        );
        let lower = |k| place(self.inner.lower(k), f64::NEG_INFINITY);
        let mut borders: Vec<f64> = texels.clone().map(lower).collect();
        borders.push(place(self.inner.upper(*texels.end()), f64::INFINITY));

        let mut masses = vec![0.0; borders.len() - 1];
        for panel in self.panels(from, to, &borders).windows(2) {
            for (y, length) in rule.nodes(panel[0], panel[1]) {
                let z = y / self.deviation;
                let density = libm::exp(-0.5 * z * z) / (libm::sqrt(2.0 * PI) * self.deviation);
                self.add_slice(self.slope * y, density * length, &borders, &mut masses);
            }
        }
        for (inner, mass) in texels.zip(masses) {
            sums.add(self.inner.fold(inner), DoubleDouble::from(mass));
        }
    }

    /// Adds `weight N(mean, spread²)` to the texels between `borders`.
    fn add_slice(&self, mean: f64, weight: f64, borders: &[f64], masses: &mut [f64]) {
        let margin = REACH * self.spread;
        // One texel more on the left, whose right border is the first that is not too far.
        let first = borders
            .partition_point(|&x| x < mean - margin)
            .saturating_sub(1);
        let deviations = |border: f64| (border - mean) / self.spread;
        let mut left = deviations(borders[first]);
        for (mass, &border) in masses[first..].iter_mut().zip(&borders[first + 1..]) {
            let right = deviations(border);
            *mass += weight * normal_between(left, right);
            if border > mean + margin {
                break;
            }
            left = right;
        }
    }

    /// Where to cut the outer interval, so that on no piece the integrand changes faster than a unit Gaussian on one
    /// standard deviation.
    fn panels(&self, from: f64, to: f64, borders: &[f64]) -> Vec<f64> {
        let mut cuts = vec![from, to];
        let steps = || (-(REACH as i32)..=REACH as i32).map(f64::from);
        cuts.extend(steps().map(|step| step * self.deviation));
        // A border of inner texels is crossed at `border / slope`, within a few widths.
        let width = self.spread / self.slope.abs();
        if width < to - from {
            for border in borders.iter().filter(|border| border.is_finite()) {
                let crossing = border / self.slope;
                cuts.extend(steps().map(|step| crossing + step * width));
            }
        }
        cuts.retain(|&y| from <= y && y <= to);
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.dedup();
        cuts
    }

    /// Weight of each texel by (outer, inner) if the Gaussian lies on the line `x = slope y`.
    fn line_weights(&self) -> BTreeMap<(u32, u32), f64> {
        if self.deviation == 0.0 {
            let centre = (
                self.outer.fold(self.outer.texel_at(0.0)),
                self.inner.fold(self.inner.texel_at(0.0)),
            );
            return BTreeMap::from([(centre, 1.0)]);
        }
        let reach = REACH * self.deviation;
        let mut cuts = vec![-reach, reach];
        let outer = self.outer.texels_between(-reach, reach);
        cuts.extend(outer.map(|k| self.outer.border(k).value()));
        if self.slope != 0.0 {
            let reach = reach * self.slope.abs();
            let inner = self.inner.texels_between(-reach, reach);
            cuts.extend(inner.map(|k| self.inner.border(k).value() / self.slope));
        }
        cuts.retain(|y| y.abs() <= reach);
        cuts.sort_unstable_by(f64::total_cmp);
        let mut weights = BTreeMap::new();
        for piece in cuts.windows(2) {
            let weight = normal_between(piece[0] / self.deviation, piece[1] / self.deviation);
            if weight > 0.0 {
                let middle = 0.5 * (piece[0] + piece[1]);
                let outer = self.outer.texel_at(middle);
                let inner = self.inner.texel_at(self.slope * middle);
                *weights
                    .entry((self.outer.fold(outer), self.inner.fold(inner)))
                    .or_insert(0.0) += weight;
            }
        }
        weights
    }
}

/// The share of a unit Gaussian between `from` and `to`, to the last digits also far out.
pub(super) fn normal_between(from: f64, to: f64) -> f64 {
    let tail = |z: f64| 0.5 * libm::erfc(z.abs() * FRAC_1_SQRT_2);
    let between = if from > 0.0 {
        tail(from) - tail(to)
    } else if to < 0.0 {
        tail(to) - tail(from)
    } else {
        1.0 - tail(from) - tail(to)
    };
    between.max(0.0)
}
