//! A Gaussian footprint on a surface: in texels, with the copies of the map it reaches.

use crate::error::QueryError;
use crate::overlap::{EVEN_TILES, Placement};
use core::f64::consts::TAU;
use core::ops::Range;
use glintbake_format::model::{Footprint, Wrap};

/// Standard deviation, in texels, that every footprint has at least: points and lines then have a density, and nothing else can
/// tell.
const LEAST: f64 = 1e-6;

/// What stands for a deviation where all places weigh alike: the edges of a piece are then so many deviations long, which adds
/// 5e-11 to exponents at most, and keeps the piece a piece where normals do not change.
const EVEN_EDGE: f64 = 1e-5;

/// A footprint on a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// Whole part of the centre, in texels. Apart from the rest, so that the rest keeps all its digits.
    cell: [f64; 2],
    centre: [f64; 2],
    /// `[a, b, c]` such that (x, y) off the centre is `(a x + b y, c y)` deviations away: a triangular inverse of a factor
    /// of the covariance.
    pub whiten: [f64; 3],
    /// How x leans with y, the deviation of x given y, and that of y.
    pub lean: f64,
    pub spread: [f64; 2],
    /// Whether all places weigh alike.
    pub is_even: bool,
    /// Columns and rows of the map.
    pub size: [f64; 2],
    pub wrap: Wrap,
}

impl Placed {
    /// `footprint` on a map of `width` × `height` texels.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`], [`QueryError::FootprintTooLarge`].
    pub fn new(
        footprint: &Footprint,
        [width, height]: [u32; 2],
        wrap: Wrap,
    ) -> Result<Self, QueryError> {
        let placement = Placement::new(footprint, width, height, wrap)?;
        let [[x_1, y_1], [x_2, y_2]] =
            [placement.edge_1, placement.edge_2].map(|edge| edge.map(|component| 0.5 * component));
        let size = [f64::from(width), f64::from(height)];
        let floor = LEAST * LEAST;
        let (xx, yy) = (x_1 * x_1 + x_2 * x_2, y_1 * y_1 + y_2 * y_2);
        let xy = x_1 * y_1 + x_2 * y_2;
        let area = (x_1 * y_2 - x_2 * y_1).abs();
        // det (Σ + floor I), all of it positive.
        let determinant = area * area + floor * (xx + yy + floor);
        let down = libm::sqrt(yy + floor);
        let across = libm::sqrt(determinant) / down;
        let lean = xy / (yy + floor);
        let is_even = wrap == Wrap::Repeat && {
            let [w, h] = size;
            let sum = xx / (w * w) + yy / (h * h);
            let area = area / (w * h);
            let root = libm::sqrt(((sum - 2.0 * area) * (sum + 2.0 * area)).max(0.0));
            let greatest = 0.5 * (sum + root);
            // The product of both variances is area².
            area * area >= EVEN_TILES * EVEN_TILES * greatest && greatest > 0.0
        };
        Ok(Self {
            cell: placement.cell,
            centre: placement.centre,
            whiten: [1.0 / across, -lean / across, 1.0 / down],
            lean,
            spread: [across, down],
            is_even,
            size,
            wrap,
        })
    }

    /// Where (`x`, `y`) lies from the centre, in texels.
    #[inline(always)]
    pub fn offset(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            (x - self.cell[0]) - self.centre[0],
            (y - self.cell[1]) - self.centre[1],
        ]
    }

    /// The centre, in texels; rounded.
    pub fn middle(&self) -> [f64; 2] {
        [self.cell[0] + self.centre[0], self.cell[1] + self.centre[1]]
    }

    /// `offset` in deviations.
    #[inline(always)]
    pub fn whitened(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.whiten;
        [a * x + b * y, c * y]
    }

    /// The footprint's density at its middle times 2π, a texel²: the reciprocal of the root of the covariance's determinant.
    pub fn density(&self) -> f64 {
        let [a, _, c] = self.whiten;
        a * c
    }

    /// A point drawn by two numbers in [0, 1), in texels, and its squared distance in deviations.
    pub fn draw(&self, [first, second]: [f64; 2]) -> ([f64; 2], f64) {
        // Box and Muller 1958.
        let squared = -2.0 * libm::log1p(-first);
        let radius = libm::sqrt(squared);
        let (sine, cosine) = libm::sincos(TAU * second);
        let y = self.spread[1] * radius * sine;
        let x = self.spread[0] * radius * cosine + self.lean * y;
        let place = |axis: usize, offset: f64| {
            let [cell, centre] = if axis == 0 {
                [self.cell[0], self.centre[0]]
            } else {
                [self.cell[1], self.centre[1]]
            };
            cell + (centre + offset)
        };
        ([place(0, x), place(1, y)], squared)
    }

    /// The rows of copies of the map that a Gaussian cut at `reach` deviations meets; cells begin at `shift` texels.
    pub fn copy_rows(&self, shift: f64, reach: f64) -> Range<i64> {
        let [_, y] = self.middle();
        let half = reach * self.spread[1] + 1e-6;
        let side = self.size[1];
        let first = libm::floor((y - shift - half) / side);
        let last = libm::floor((y - shift + half) / side);
        first as i64..last as i64 + 1
    }

    /// The columns of copies in row `row` of copies.
    pub fn copy_columns(&self, row: i64, shift: f64, reach: f64) -> Range<i64> {
        let [x, y] = self.middle();
        let half = reach * self.spread[1] + 1e-6;
        let top = (row as f64 * self.size[1] + shift - y).clamp(-half, half);
        let bottom = ((row as f64 + 1.0) * self.size[1] + shift - y).clamp(-half, half);
        let (one, other) = (self.lean * top, self.lean * bottom);
        let wide = reach * self.spread[0] + 1e-6;
        let side = self.size[0];
        let first = libm::floor((x - shift + one.min(other) - wide) / side);
        let last = libm::floor((x - shift + one.max(other) + wide) / side);
        first as i64..last as i64 + 1
    }
}

/// Where pieces lie, in deviations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Edges of one texel along x and along y.
    pub edges: [[f64; 2]; 2],
    /// What the mean over a piece of one texel² weighs.
    pub weight: f64,
    is_even: bool,
}

impl Frame {
    pub fn new(placed: &Placed) -> Self {
        if placed.is_even {
            return Self {
                edges: [[EVEN_EDGE, 0.0], [0.0, EVEN_EDGE]],
                weight: 1.0 / (placed.size[0] * placed.size[1]),
                is_even: true,
            };
        }
        let [a, b, c] = placed.whiten;
        Self {
            edges: [[a, 0.0], [b, c]],
            weight: placed.density() / TAU,
            is_even: false,
        }
    }

    /// The corner (`x`, `y`), in texels; the origin where all places weigh alike.
    #[inline(always)]
    pub fn corner(&self, placed: &Placed, corner: [f64; 2]) -> [f64; 2] {
        if self.is_even {
            return [0.0; 2];
        }
        placed.whitened(placed.offset(corner))
    }
}
