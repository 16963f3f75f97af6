//! The model of `lean`, from the definition over texels \[OB10\] \[Tok05\].
//!
//! *Cells.* Level l cuts the tile evenly into `max(1, ⌊W / 2^l⌋) × max(1, ⌊H / 2^l⌋)` cells, up to the level of one cell.
//! A cell has the mean and the covariance of the normals under it, each texel weighed by its area within.
//!
//! *Probes.* The footprint's covariance is `κ (e1 e1ᵀ + e2 e2ᵀ)` in texels, κ = 1/12 for a box and 1/4 for a Gaussian. A
//! principal axis of variance v is as wide as a box of that variance: √(12 v). Probes have the width
//! `w = max(short, long / A, 2^finest)` with A = 15 for boxes and 7.9 for Gaussians, and level log2 w, at most the top. They
//! stand along the long axis.
//! A box of length L > w is cut into pieces of length w from its middle outwards; the last on either side is what is left.
//! A probe stands in the middle of each and weighs as much as it is long; the last pair where all of them, each a box of
//! width w, have the second moment of the whole. A Gaussian first has the probes' own spread taken
//! away: what remains, τ² = (L² - w²) / 12, is spread over the places k h, h = min(w, 1.75 τ), |k h| < 3.5 τ, by the weights
//! `exp(-(kh)² / 2τ²) - exp(-3.5² / 2)`.
//!
//! *Look-up.* A probe is the bilinear mixture of the four cells about it, with shares linear between the two levels about
//! its own. `D` is the Gaussian of the mixture's mean and covariance, plus σr² = α² / 2.

use super::direction::half_vector_direction;
use super::double_double::DoubleDouble;
use crate::normals::NormalMap;
use core::f64::consts::PI;
use glintbake_format::model::{Filter, Footprint, HalfVector, Wrap};

/// Mean, covariance and weight of a part of a mixture.
type Part = ([f64; 2], [f64; 3], f64);

/// The lobe of one footprint, for many half vectors.
#[derive(Clone, Copy, Debug)]
pub struct Prepared {
    mean: [f64; 2],
    /// Variance of s, covariance, variance of t, kernel included.
    covariance: [f64; 3],
}

impl Prepared {
    /// The lobe of `footprint` by the pyramid of `map` from `finest_level` up, for Beckmann roughness `alpha`.
    ///
    /// # Cost
    /// Every cell looked at is averaged over its texels anew.
    ///
    /// # Panics
    /// If the footprint is not finite, or the pyramid has no such level.
    pub fn new(
        map: &NormalMap,
        footprint: &Footprint,
        filter: Filter,
        alpha: f64,
        finest_level: u32,
    ) -> Self {
        let size = [map.width(), map.height()].map(f64::from);
        let top = libm::floor(libm::log2(size[0].max(size[1]))) as u32;
        assert!(
            finest_level <= top,
            "the pyramid has no level {finest_level}"
        );
        let texels = |edge: [f64; 2]| [edge[0] * size[0], edge[1] * size[1]];
        let edges = [texels(footprint.edge_1), texels(footprint.edge_2)];
        assert!(
            [footprint.centre, edges[0], edges[1]]
                .as_flattened()
                .iter()
                .all(|number| number.is_finite()),
            "a footprint must be finite"
        );
        let (angle, [long, short]) = principal(edges);
        let (kappa, most) = match filter {
            Filter::Box => (1.0 / 12.0, 15.0),
            Filter::Gaussian => (0.25, 7.9),
        };
        let widths = [long, short].map(|root| libm::sqrt(12.0 * kappa) * root);
        let finest = libm::exp2(f64::from(finest_level));
        let width = widths[1].max(widths[0] / most).max(finest);
        let level = libm::log2(width).min(f64::from(top));
        let below = libm::floor(level);
        let levels: [(u32, f64); 2] = [
            (below as u32, 1.0 - (level - below)),
            ((below as u32 + 1).min(top), level - below),
        ];
        let places = match filter {
            Filter::Box => box_places(widths[0], width),
            Filter::Gaussian => gaussian_places(widths[0], width),
        };
        let mut mixture = Mixture::default();
        for (place, weight) in places {
            // In tiles: the whole part of the centre means nothing where tiles repeat, and must not take digits.
            let step = [libm::cos(angle), libm::sin(angle)];
            let at = [0, 1].map(|axis: usize| {
                let centre = footprint.centre[axis];
                let centre = match map.wrap() {
                    Wrap::Repeat => centre - libm::trunc(centre),
                    Wrap::Clamp => centre.clamp(-1e4, 1e4),
                };
                centre + place * step[axis] / size[axis]
            });
            for (level, share) in levels {
                mixture.add_bilinear(map, level, at, weight * share);
            }
        }
        let (mean, [ss, st, tt]) = mixture.moments();
        let kernel = 0.5 * alpha * alpha;
        Self {
            mean,
            covariance: [ss + kernel, st, tt + kernel],
        }
    }

    /// The mean (s, t).
    pub fn mean(&self) -> [f64; 2] {
        self.mean
    }

    /// Variance of s, covariance, variance of t, kernel included.
    pub fn covariance(&self) -> [f64; 3] {
        self.covariance
    }

    /// Density `D(h)` per solid angle of h, which is that per area of the disk; 0 outside the closed unit disk.
    pub fn ndf(&self, h: HalfVector) -> f64 {
        if half_vector_direction(h).is_none() {
            return 0.0;
        }
        let [ss, st, tt] = self.covariance;
        let determinant = (DoubleDouble::product(ss, tt) - DoubleDouble::product(st, st)).value();
        let (s, t) = (h.s - self.mean[0], h.t - self.mean[1]);
        let squares = DoubleDouble::product(tt * s, s) - DoubleDouble::product(2.0 * st * s, t)
            + DoubleDouble::product(ss * t, t);
        libm::exp(-0.5 * squares.value() / determinant) / (2.0 * PI * libm::sqrt(determinant))
    }

    /// Density per solid angle of h of a sampler of the Gaussian that gives no vector beyond the rim: `D(h) (h·n)`.
    pub fn pdf(&self, h: HalfVector) -> f64 {
        half_vector_direction(h).map_or(0.0, |[.., cosine]| self.ndf(h) * cosine)
    }
}

/// Angle of the long principal axis of `e1 e1ᵀ + e2 e2ᵀ`, and the lengths of the half axes of the ellipse
/// `{a e1 + b e2: a² + b² = 1}`, the longer first.
///
/// By Jacobi's rotation: with a turned by θ, `e1 cos θ + e2 sin θ` and `e2 cos θ - e1 sin θ` are at right angles, and are the
/// two half axes.
pub(super) fn principal([e1, e2]: [[f64; 2]; 2]) -> (f64, [f64; 2]) {
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let turn = 0.5 * libm::atan2(2.0 * dot(e1, e2), dot(e1, e1) - dot(e2, e2));
    let (cos, sin) = (libm::cos(turn), libm::sin(turn));
    let first = [0, 1].map(|axis: usize| e1[axis] * cos + e2[axis] * sin);
    let long = libm::hypot(first[0], first[1]);
    // The product of both is the area; the second axis of a needle would be all rounding.
    let area = DoubleDouble::product(e1[0], e2[1]) - DoubleDouble::product(e1[1], e2[0]);
    let short = if long > 0.0 {
        area.value().abs() / long
    } else {
        0.0
    };
    (libm::atan2(first[1], first[0]), [long, short])
}

/// Places along the long axis and their weights, for a box of length `long` and probes of width `width`.
pub(super) fn box_places(long: f64, width: f64) -> Vec<(f64, f64)> {
    if long <= width {
        return vec![(0.0, 1.0)];
    }
    let mut places = Vec::new();
    let mut end = -0.5 * width;
    while end < 0.5 * long {
        let next = (end + width).min(0.5 * long);
        let (middle, share) = (0.5 * (end + next), (next - end) / long);
        places.push((middle, share));
        // The piece in the middle is its own mirror image.
        if end > 0.0 {
            places.push((-middle, share));
        }
        end = next;
    }
    let spread = |places: &[(f64, f64)]| -> f64 {
        places
            .iter()
            .map(|(place, share)| share * place * place)
            .sum()
    };
    let inner = places.len() - 2;
    let wanted = (long * long - width * width) / 12.0 - spread(&places[..inner]);
    for (place, share) in &mut places[inner..] {
        let moved = libm::sqrt(wanted.max(0.0) / (2.0 * *share)).min(0.5 * long);
        *place = libm::copysign(moved, *place);
    }
    places
}

/// Places along the long axis and their weights, for a Gaussian as wide as a box of length `long` and probes of `width`.
pub(super) fn gaussian_places(long: f64, width: f64) -> Vec<(f64, f64)> {
    let variance = (long * long - width * width) / 12.0;
    if variance <= 0.0 {
        return vec![(0.0, 1.0)];
    }
    let end = 3.5 * libm::sqrt(variance);
    let step = width.min(0.5 * end);
    let mut places = Vec::new();
    for k in -7..=7 {
        let place = f64::from(k) * step;
        let bell = |x: f64| libm::exp(-0.5 * x * x / variance);
        if place.abs() < end {
            places.push((place, bell(place) - bell(end)));
        }
    }
    let sum: f64 = places.iter().map(|(_, weight)| weight).sum();
    places
        .into_iter()
        .map(|(place, weight)| (place, weight / sum))
        .collect()
}

/// Mean and covariance of the normals under cell (`column`, `row`) of `level`, by the area of each texel within it.
pub(super) fn cell_moments(
    map: &NormalMap,
    level: u32,
    column: u32,
    row: u32,
) -> ([f64; 2], [f64; 3]) {
    let mut texels = Mixture::default();
    let columns = overlaps(map.width(), cells(map.width(), level), column);
    for (j, height) in overlaps(map.height(), cells(map.height(), level), row) {
        for &(i, width) in &columns {
            let [s, t] =
                map.texels()[j as usize * map.width() as usize + i as usize].map(f64::from);
            texels.parts.push(([s, t], [0.0; 3], width * height));
        }
    }
    texels.moments()
}

/// Cells of `level` along a side of `size` texels.
fn cells(size: u32, level: u32) -> u32 {
    (f64::from(size) / libm::exp2(f64::from(level))).max(1.0) as u32
}

/// The texels of a side of `size` that cell `cell` of `count` meets, each with the length it has in the cell, in texels.
fn overlaps(size: u32, count: u32, cell: u32) -> Vec<(u32, f64)> {
    let length = f64::from(size) / f64::from(count);
    let (start, end) = (f64::from(cell) * length, f64::from(cell + 1) * length);
    (0..size)
        .map(|texel| {
            let (low, high) = (f64::from(texel), f64::from(texel) + 1.0);
            (texel, high.min(end) - low.max(start))
        })
        // What rounding lets cells reach into their neighbours' texels.
        .filter(|&(_, overlap)| overlap > 1e-9)
        .collect()
}

/// Weighted normals, each a point or itself a distribution.
#[derive(Clone, Debug, Default)]
struct Mixture {
    parts: Vec<Part>,
}

impl Mixture {
    /// Adds the four cells of `level` about the point `at`, in tiles.
    fn add_bilinear(&mut self, map: &NormalMap, level: u32, at: [f64; 2], weight: f64) {
        let shares = |axis: usize, size: u32| {
            let count = cells(size, level);
            let place = at[axis] * f64::from(count) - 0.5;
            let lower = libm::floor(place);
            let cell = |number: f64| {
                let count = f64::from(count);
                match map.wrap() {
                    Wrap::Repeat => (number - count * libm::floor(number / count)) as u32,
                    Wrap::Clamp => number.clamp(0.0, count - 1.0) as u32,
                }
            };
            [
                (cell(lower), lower + 1.0 - place),
                (cell(lower + 1.0), place - lower),
            ]
        };
        let columns = shares(0, map.width());
        for (row, down) in shares(1, map.height()) {
            for (column, across) in columns {
                let share = weight * across * down;
                if share > 0.0 {
                    let (mean, covariance) = cell_moments(map, level, column, row);
                    self.parts.push((mean, covariance, share));
                }
            }
        }
    }

    /// Mean and covariance (ss, st, tt) of the whole: the mean first, then the law of total covariance.
    fn moments(&self) -> ([f64; 2], [f64; 3]) {
        let weight: f64 = self.parts.iter().map(|part| part.2).sum();
        let sum = |term: &dyn Fn(&Part) -> f64| {
            let add = |sum: DoubleDouble, part| sum + DoubleDouble::from(term(part));
            self.parts.iter().fold(DoubleDouble::ZERO, add).value() / weight
        };
        let mean = [0, 1].map(|axis: usize| sum(&|(point, _, share)| share * point[axis]));
        let covariance = [(0, 0), (0, 1), (1, 1)].map(|(a, b): (usize, usize)| {
            sum(&|(point, own, share)| {
                share * (own[a + b] + (point[a] - mean[a]) * (point[b] - mean[b]))
            })
        });
        (mean, covariance)
    }
}
