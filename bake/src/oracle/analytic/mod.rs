//! The integral over a piecewise-linear surface of normals \[YHJ*14\] eq. 6, by quadrature.
//!
//! `D(s) = ∫ N(u; c, Σp) N(n(u) - s; σr² I) du` over the endless plane, with Σp the footprint's covariance in texels
//! and (1e-6 texel)² in every direction, and n as [`Interpolation`] says: vertices are at the middles of texels, or
//! quarters of a texel apart with bicubic values, and n is linear on the two triangles of each square between four of
//! them. Indices of *texels* wrap or are clamped, so that the bicubic surface of a clamped map is constant from one
//! texel beyond its outermost middles on. Values are not clamped to the disk: what overshoots it has its density beyond
//! the rim.
//!
//! In coordinates that make the footprint a unit Gaussian the integrand on a triangle is `exp(-|r|² / 2)` with a linear
//! r of four components. It is integrated along one coordinate by error functions, along the other by Gauss-Legendre
//! panels cut at the standard deviations of everything the integrand does, so that no peak within a triangle can be
//! missed.
//!
//! *Copies of wide footprints.* Over evenly spaced copies the sum of a Gaussian is constant but for waves of
//! `2 exp(-2π² σ²)`, σ in tiles. From σ = 1.25, which is 8e-14, one tile stands for all: for all copies if the
//! footprint is that wide in every direction, for those along one axis if it is that wide along it at every place of
//! the other.

mod frame;
mod patch;

use super::binning::place;
use super::direction::half_vector_direction;
use super::double_double::DoubleDouble;
use super::surface::{Border, Surface};
use super::texel_axis::TexelAxis;
use super::weights::MAX_SPAN_TILES;
use crate::normals::NormalMap;
use core::f64::consts::PI;
use core::ops::RangeInclusive;
use frame::{Frame, Reach};
use glintbake_format::model::{Footprint, HalfVector, Interpolation};
use patch::{Patch, REACH, Rules};

pub(super) use frame::FLOOR;

/// Deviation in tiles from which the copies along a direction are integrated.
const EVEN_TILES: f64 = 1.25;

/// One footprint on a surface, for many half vectors and roughnesses.
pub struct Prepared {
    surface: Surface,
    frame: Frame,
    axes: [TexelAxis; 2],
    size: [i64; 2],
    rules: Rules,
}

impl Prepared {
    /// The surface of `map` under the Gaussian `footprint`.
    ///
    /// # Accuracy
    /// Densities above 1e-10 of the kernel's peak `1 / (2π σr²)` are within 2e-12 of themselves, for any footprint and
    /// roughness, as brute force finds; parts further than 10 standard deviations from the footprint or the half vector
    /// are left out.
    ///
    /// # Panics
    /// If a number of the footprint is not finite, the map is empty, or the sum of the footprint's edges on an axis
    /// exceeds half of [`MAX_SPAN_TILES`].
    pub fn new(map: &NormalMap, footprint: &Footprint, interpolation: Interpolation) -> Self {
        Self::with_even_tiles(map, footprint, interpolation, EVEN_TILES)
    }

    /// As [`Self::new`], with the copies along a direction integrated from a deviation of `even_tiles` tiles.
    pub(super) fn with_even_tiles(
        map: &NormalMap,
        footprint: &Footprint,
        interpolation: Interpolation,
        even_tiles: f64,
    ) -> Self {
        let axes = footprint_axes(map, footprint);
        Self {
            surface: Surface::new(map, interpolation),
            frame: Frame::new(map, footprint, &axes, even_tiles),
            axes,
            size: [map.width(), map.height()].map(i64::from),
            rules: Rules::new(),
        }
    }

    /// Density `D(h)` for Beckmann roughness `alpha` (σr = α / √2), per solid angle of h, which is that per area of the
    /// disk; 0 outside the closed unit disk.
    ///
    /// # Cost
    /// Cells of the surface within reach are compared with h one by one, 10 ns each; those within 10 σr of it take
    /// some microseconds each. Copies count, unless the footprint is wide (see the module).
    pub fn ndf(&self, h: HalfVector, alpha: f64) -> f64 {
        if half_vector_direction(h).is_none() {
            return 0.0;
        }
        let variance = 0.5 * alpha * alpha;
        let query = Query {
            prepared: self,
            h: [h.s, h.t],
            deviation: libm::sqrt(variance),
        };
        query.integral() * self.frame.factor / (2.0 * PI * variance)
    }

    /// Density per solid angle of h of a sampler that draws a place, then a normal about the surface's, and gives no
    /// vector beyond the rim: `D(h) (h·n)`.
    pub fn pdf(&self, h: HalfVector, alpha: f64) -> f64 {
        half_vector_direction(h).map_or(0.0, |[.., cosine]| self.ndf(h, alpha) * cosine)
    }

    /// What that sampler makes of four numbers in [0, 1), the first two for the place; `None` beyond the rim.
    pub fn draw(&self, alpha: f64, uniform: [f64; 4]) -> Option<HalfVector> {
        let normal_pair = |first: f64, second: f64| {
            let radius = libm::sqrt(-2.0 * libm::log1p(-first));
            let (sine, cosine) = libm::sincos(2.0 * PI * second);
            [radius * cosine, radius * sine]
        };
        let [a, b, c, d] = uniform;
        // The floor of 1e-6 texel is left out: no texel is that small.
        let [x, y] = place(&self.axes, [normal_pair(a, b), [0.0; 2]]);
        let [s, t] = self.surface.normal(x, y);
        let [by_s, by_t] = normal_pair(c, d).map(|x| libm::sqrt(0.5) * alpha * x);
        let h = HalfVector {
            s: s + by_s,
            t: t + by_t,
        };
        half_vector_direction(h).map(|_| h)
    }
}

/// The axes of `footprint` over `map`.
///
/// # Panics
/// As [`Prepared::new`].
pub(super) fn footprint_axes(map: &NormalMap, footprint: &Footprint) -> [TexelAxis; 2] {
    let Footprint {
        centre,
        edge_1,
        edge_2,
    } = *footprint;
    for axis in 0..2 {
        let span = edge_1[axis].abs() + edge_2[axis].abs();
        assert!(
            centre[axis].is_finite() && span <= 0.5 * MAX_SPAN_TILES,
            "a Gaussian footprint must be finite and span at most {} tiles",
            0.5 * MAX_SPAN_TILES
        );
    }
    [(0, map.width()), (1, map.height())].map(|(i, size): (usize, u32)| {
        TexelAxis::new(centre[i], [edge_1[i], edge_2[i]], size, map.wrap())
    })
}

/// One half vector and roughness.
struct Query<'a> {
    prepared: &'a Prepared,
    h: [f64; 2],
    /// σr.
    deviation: f64,
}

/// A square of the surface, its ends from the footprint's centre and its normals, along the outer axis first.
struct Cell {
    outer: [DoubleDouble; 2],
    inner: [DoubleDouble; 2],
    /// Whether normals change along each axis: they do not without interpolation, nor where the cell has no end.
    is_sloped: [bool; 2],
    normals: [[[f64; 2]; 2]; 2],
}

impl Query<'_> {
    fn integral(&self) -> f64 {
        let Prepared {
            surface,
            frame,
            axes,
            size,
            ..
        } = self.prepared;
        let (outer, inner) = (frame.outer, 1 - frame.outer);
        let tile = |axis: usize| 0..=size[axis] * surface.per_side() - 1;
        let end = REACH * frame.deviation;
        let rows = match frame.reach {
            Reach::Tile => tile(outer),
            Reach::Place | Reach::Line => surface.cells_between(&axes[outer], outer, -end, end),
        };
        let mut sum = DoubleDouble::ZERO;
        for row in rows {
            let borders = surface.borders(&axes[outer], outer, row);
            let ends = closed(borders, [-end, end]);
            if frame.reach != Reach::Place {
                sum = sum + self.strip(row, tile(inner), (borders, ends), [0.0; 2]);
                continue;
            }
            let middles = ends.map(|y| {
                let y = y.value().clamp(-end, end);
                (frame.slope * DoubleDouble::from(y)).value()
            });
            let margin = REACH * frame.spread;
            let range = [
                middles[0].min(middles[1]) - margin,
                middles[0].max(middles[1]) + margin,
            ];
            let cells = surface.cells_between(&axes[inner], inner, range[0], range[1]);
            sum = sum + self.strip(row, cells, (borders, ends), range);
        }
        sum.value()
    }

    /// The cells of a row of the outer axis, those without end reaching as far as `range`.
    fn strip(
        &self,
        row: i64,
        cells: RangeInclusive<i64>,
        (borders, ends): ([Border; 2], [DoubleDouble; 2]),
        range: [f64; 2],
    ) -> DoubleDouble {
        let Prepared {
            surface,
            frame,
            axes,
            ..
        } = self.prepared;
        let inner = 1 - frame.outer;
        let value = |i: i64, j: i64| {
            if frame.outer == 1 {
                surface.value(i, j)
            } else {
                surface.value(j, i)
            }
        };
        let mut sum = DoubleDouble::ZERO;
        for index in cells {
            let normals = if surface.is_flat() {
                [[value(index, row); 2]; 2]
            } else {
                [0, 1].map(|j| [0, 1].map(|i| value(index + i, row + j)))
            };
            if self.is_far(&normals) {
                continue;
            }
            let sides = surface.borders(&axes[inner], inner, index);
            let is_sloped =
                [borders, sides].map(|ends| !surface.is_flat() && ends.iter().all(Option::is_some));
            let cell = Cell {
                outer: ends,
                inner: closed(sides, range),
                is_sloped,
                normals,
            };
            sum = sum + self.cell(&cell);
        }
        sum
    }

    /// Whether no normal between these is within reach of h.
    fn is_far(&self, normals: &[[[f64; 2]; 2]; 2]) -> bool {
        let mut squared = 0.0;
        for axis in 0..2 {
            let values = normals.as_flattened().iter().map(|normal| normal[axis]);
            let low = values.clone().fold(f64::INFINITY, f64::min);
            let high = values.fold(f64::NEG_INFINITY, f64::max);
            let distance = (low - self.h[axis]).max(self.h[axis] - high).max(0.0);
            squared += distance * distance;
        }
        squared > REACH * REACH * self.deviation * self.deviation
    }

    fn cell(&self, cell: &Cell) -> DoubleDouble {
        let [height, width] = [cell.outer, cell.inner].map(|ends| (ends[1] - ends[0]).value());
        if height <= 0.0 || width <= 0.0 {
            return DoubleDouble::ZERO;
        }
        let rectangle = [[0.0, 0.0], [0.0, width], [height, width], [height, 0.0]];
        let corner = |last: usize, outline: &[[f64; 2]]| {
            let sign = [1.0, -1.0][last];
            let (at, beside, below) = (
                cell.normals[last][last],
                cell.normals[last][1 - last],
                cell.normals[1 - last][last],
            );
            let slope = |to: [f64; 2], length: f64, axis: usize| {
                if cell.is_sloped[axis] {
                    [0, 1].map(|k: usize| sign * (to[k] - at[k]) / length)
                } else {
                    [0.0; 2]
                }
            };
            let slopes = [slope(below, height, 0), slope(beside, width, 1)];
            let place = [cell.outer[last], cell.inner[last]];
            DoubleDouble::from(self.polygon(place, at, slopes, outline))
        };
        if cell.is_sloped == [true, true] {
            let first = [[0.0, 0.0], [0.0, width], [height, 0.0]];
            let last = first.map(|[y, x]| [-y, -x]);
            corner(0, &first) + corner(1, &last)
        } else {
            corner(0, &rectangle)
        }
    }

    /// The integral over a polygon about `place`, where the normal is `at` and has the slopes `slopes` along the outer
    /// and the inner axis, with the corners `outline` from there.
    fn polygon(
        &self,
        place: [DoubleDouble; 2],
        at: [f64; 2],
        slopes: [[f64; 2]; 2],
        outline: &[[f64; 2]],
    ) -> f64 {
        let frame = &self.prepared.frame;
        let slope = frame.slope.value();
        let corners = outline
            .iter()
            .map(|&[y, x]| [y / frame.deviation, (x - slope * y) / frame.spread])
            .collect();
        let residual = |along: [f64; 2]| along.map(|x| x / self.deviation);
        let [s, t] = residual([at[0] - self.h[0], at[1] - self.h[1]]);
        let [p_s, p_t] = residual(
            [0, 1].map(|k: usize| (slopes[0][k] + slope * slopes[1][k]) * frame.deviation),
        );
        let [q_s, q_t] = residual(slopes[1].map(|x| x * frame.spread));
        let [y, x] = place;
        let mut patch = Patch {
            corners,
            at: [0.0, 0.0, s, t],
            along_p: [0.0, 0.0, p_s, p_t],
            along_q: [0.0, 0.0, q_s, q_t],
        };
        if frame.reach != Reach::Tile {
            patch.at[0] = y.value() / frame.deviation;
            patch.along_p[0] = 1.0;
        }
        if frame.reach == Reach::Place {
            patch.at[1] = (x - frame.slope * y).value() / frame.spread;
            patch.along_q[1] = 1.0;
        }
        patch.clip();
        patch.integral(&self.prepared.rules)
    }
}

/// The ends of a cell, those it does not have at or beyond the ends of `range`.
fn closed(borders: [Border; 2], range: [f64; 2]) -> [DoubleDouble; 2] {
    [0, 1].map(|end: usize| borders[end].unwrap_or(DoubleDouble::from(range[end])))
}
