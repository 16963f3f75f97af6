//! Gaussian footprints against texels: how much of a Gaussian's weight falls on each.
//!
//! The footprint's Gaussian has its mean at the centre and the covariance `Σ = E Eᵀ`, `E = [e1 e2] / 2` \[YHJ*14\]. It
//! counts within the ellipse `|E⁻¹ (x - c)| ≤` [`RADIUS`]: a texel has weight if it meets the ellipse, and then that
//! of the whole texel. How the weight is found depends on the least standard deviation σ of Σ, in texels:
//!
//! | σ | weight of a texel | error, of the peak |
//! |---|---|---|
//! | ≥ 2 | smoothed density at its centre (`smooth`) | 2.6e-6 (2/σ)⁶ |
//! | 1 to 2, 0.5 to 1 | the same on its 2 × 2, 4 × 4 parts | 2.6e-6 |
//! | < 0.5, down to lines and points | rectangle of the bivariate normal distribution (`thin`) | 1e-9, absolute |
//!
//! Weights of the first two are divided by `1 -` [`LOST`], those of the last, of which the whole texels at the
//! ellipse's ends leave less than 3e-6 to lose, are not; all add up to 1 within 1e-5.
//!
//! Nothing inverts Σ, or takes a difference that vanishes with its determinant: factors come from the edges.

mod exponential;
mod normal;
mod row;
mod smooth;
mod thin;

#[cfg(test)]
mod tests;

pub(crate) use row::GaussianRow;
use thin::Rectangles;

use super::placement::Placement;
use super::{TexelBox, floor};
use crate::error::QueryError;
use core::ops::Range;
use glintbake_format::model::{Footprint, Wrap};
use smooth::Smooth;
use thin::Thin;

/// Where the Gaussian is cut off, in standard deviations.
pub(crate) const RADIUS: f64 = 4.8;
/// The share of the Gaussian beyond [`RADIUS`], `exp(-4.8² / 2)`.
pub(crate) const LOST: f64 = 9.929_504_305_851_081e-6;

/// Least standard deviations, in texels, from which a texel is taken whole, in 2 × 2, and in 4 × 4 parts.
const WHOLE: f64 = 2.0;
const HALVES: f64 = 1.0;
const QUARTERS: f64 = 0.5;

/// Components of edges shorter than this many texels count as zero, which keeps every product within the range of f64.
const SHORTEST: f64 = 1e-100;
/// How much the ellipse is grown, relative, and a chord of it, relative and in texels, before it is taken to whole
/// texels: far more than rounding, so that no texel under a point of the ellipse is missed.
const GROWTH: f64 = 1e-9;
const SLACK: f64 = 1e-12;

/// A Gaussian footprint in texel units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GaussianFootprint {
    /// Whole part of the centre. Apart from the rest, so that the rest keeps all its digits.
    cell: [f64; 2],
    /// The centre relative to `cell`, in [0, 1] but for rounding.
    centre: [f64; 2],
    /// The columns of E.
    half_edges: [[f64; 2]; 2],
    /// Standard deviations along the axes.
    deviation: [f64; 2],
    /// The least standard deviation in any direction.
    least: f64,
    /// The mean of x at y = 1, and the standard deviation of x for a given y.
    lean: f64,
    spread: f64,
    /// How far below the centre the rightmost point of the ellipse of radius 1 lies.
    turn: f64,
    smooth: Smooth,
    /// Takes the place of `smooth` below [`QUARTERS`].
    thin: Option<Thin>,
}

impl GaussianFootprint {
    /// `footprint` on a map of `width` × `height` texels, its centre reduced to the first tile where the map repeats.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`], [`QueryError::FootprintTooLarge`].
    pub fn new(
        footprint: &Footprint,
        width: u32,
        height: u32,
        wrap: Wrap,
    ) -> Result<Self, QueryError> {
        let placement = Placement::new(footprint, width, height, wrap)?;
        let half_edges = [placement.edge_1, placement.edge_2].map(|edge| {
            edge.map(|component| {
                let half = 0.5 * component;
                if half.abs() < SHORTEST { 0.0 } else { half }
            })
        });
        let [[x_1, y_1], [x_2, y_2]] = half_edges;
        let (xx, yy, xy) = (
            x_1 * x_1 + x_2 * x_2,
            y_1 * y_1 + y_2 * y_2,
            x_1 * y_1 + x_2 * y_2,
        );
        let area = cross([x_1, y_1], [x_2, y_2]).abs();
        let deviation = [libm::sqrt(xx), libm::sqrt(yy)];
        // The greater eigenvalue of Σ; the product of both is area².
        let sum = xx + yy;
        let greatest = 0.5 * (sum + libm::sqrt(((sum - 2.0 * area) * (sum + 2.0 * area)).max(0.0)));
        let least = if greatest > 0.0 {
            area / libm::sqrt(greatest)
        } else {
            0.0
        };
        let parts = if least >= WHOLE {
            1
        } else if least >= HALVES {
            2
        } else {
            4
        };
        let (lean, spread) = if yy > 0.0 {
            (xy / yy, area / deviation[1])
        } else {
            (0.0, deviation[0])
        };
        Ok(Self {
            cell: placement.cell,
            centre: placement.centre,
            half_edges,
            deviation,
            least,
            lean,
            spread,
            turn: if xx > 0.0 { xy / deviation[0] } else { 0.0 },
            smooth: Smooth::new([xx, yy, xy], area * area, least, parts),
            thin: (least < QUARTERS).then(|| Thin::new(deviation, xy, area)),
        })
    }

    /// The same footprint seen from the tile that begins at texel (`x`, `y`).
    pub fn relative_to(&self, x: f64, y: f64) -> Self {
        Self {
            cell: [self.cell[0] - x, self.cell[1] - y],
            ..*self
        }
    }

    /// The covariance matrix, in texels²: xx, yy, xy.
    pub fn covariance(&self) -> [f64; 3] {
        let [[x_1, y_1], [x_2, y_2]] = self.half_edges;
        [
            x_1 * x_1 + x_2 * x_2,
            y_1 * y_1 + y_2 * y_2,
            x_1 * y_1 + x_2 * y_2,
        ]
    }

    /// The root of the covariance matrix's determinant: the area of the ellipse of radius 1 over π.
    pub fn determinant_root(&self) -> f64 {
        let [first, second] = self.half_edges;
        cross(first, second).abs()
    }

    /// The least standard deviation in any direction, in tiles of `width` × `height` texels.
    pub fn least_deviation_in_tiles(&self, width: f64, height: f64) -> f64 {
        let [[x_1, y_1], [x_2, y_2]] = self.half_edges.map(|[x, y]| [x / width, y / height]);
        let area = self.determinant_root() / (width * height);
        let sum = x_1 * x_1 + x_2 * x_2 + y_1 * y_1 + y_2 * y_2;
        let greatest = 0.5 * (sum + libm::sqrt(((sum - 2.0 * area) * (sum + 2.0 * area)).max(0.0)));
        if greatest > 0.0 {
            area / libm::sqrt(greatest)
        } else {
            0.0
        }
    }

    /// About how many texels meet the ellipse.
    pub fn support_texels(&self) -> f64 {
        let [width, height] = self.reach();
        core::f64::consts::PI * RADIUS * RADIUS * self.determinant_root() + 4.0 * (width + height)
    }

    /// Weights of rectangles of any size, such as those beyond the border of a clamped map. About as costly as a weight
    /// of a thin Gaussian's texel: 100 ns each.
    pub fn rectangles(&self) -> Rectangles {
        let [_, _, covariance] = self.covariance();
        Rectangles::new(self.deviation, covariance, self.determinant_root())
    }

    /// Where the point (`x`, `y`) lies relative to the centre.
    pub fn centred(&self, x: f64, y: f64) -> [f64; 2] {
        [self.offset(x, 0), self.offset(y, 1)]
    }

    /// The least standard deviation in any direction, in texels.
    pub fn least_deviation(&self) -> f64 {
        self.least
    }

    /// Whether every standard deviation is at least 2 texels, so that texels are taken as a whole.
    pub fn is_smooth(&self) -> bool {
        self.smooth.is_whole()
    }

    /// A box around everything that can hold weight: around the ellipse, not grown to whole texels.
    pub fn bounds(&self) -> TexelBox {
        let [width, height] = self.reach();
        let [x, y] = [self.cell[0] + self.centre[0], self.cell[1] + self.centre[1]];
        TexelBox {
            low: [x - width, y - height],
            high: [x + width, y + height],
        }
    }

    /// Half the sides of the ellipse's bounding box, grown a little.
    fn reach(&self) -> [f64; 2] {
        self.deviation.map(|deviation| {
            let reach = RADIUS * (1.0 + GROWTH) * deviation;
            reach + SLACK * (1.0 + reach)
        })
    }

    /// The rows of texels that can hold weight.
    pub fn rows(&self) -> Range<i64> {
        let [_, reach] = self.reach();
        let origin = self.cell[1] as i64;
        origin + floor(self.centre[1] - reach)..origin + floor(self.centre[1] + reach) + 1
    }

    /// The columns of row `row` of texels that can hold weight: those that meet the ellipse.
    #[inline]
    pub fn row_columns(&self, row: i64) -> Range<i64> {
        self.strip_columns(row, 1)
    }

    /// The columns of texels that can hold weight in any of the `size` ≥ 1 rows from `first_row`.
    pub fn strip_columns(&self, first_row: i64, size: i64) -> Range<i64> {
        let slack = |coordinate: f64| SLACK * (1.0 + coordinate.abs());
        let top = (first_row as f64 - self.cell[1]) - self.centre[1];
        let bottom = top + size as f64;
        let (top, bottom) = (top - slack(top), bottom + slack(bottom));
        let radius = RADIUS * (1.0 + GROWTH);
        let end = radius * self.deviation[1];
        if top > end || bottom < -end {
            return 0..0;
        }
        let (top, bottom) = (top.max(-end).min(end), bottom.min(end).max(-end));
        // Half the chord at height y; x is concave along the ellipse's right side, so its greatest value in the strip
        // is at the ellipse's rightmost point, or at the border nearest to it. Likewise on the left.
        let half_chord = |y: f64| {
            let z = if end > 0.0 {
                y / self.deviation[1]
            } else {
                0.0
            };
            self.spread * libm::sqrt((radius * radius - z * z).max(0.0))
        };
        let turn = radius * self.turn;
        let (to_right, to_left) = (turn.max(top).min(bottom), (-turn).max(top).min(bottom));
        let right = self.lean * to_right + half_chord(to_right);
        let left = self.lean * to_left - half_chord(to_left);
        let origin = self.cell[0] as i64;
        origin + floor(self.centre[0] + left - slack(left))
            ..origin + floor(self.centre[0] + right + slack(right)) + 1
    }

    /// Row `row` of texels, for the weights of many of its texels.
    #[inline]
    pub fn row(&self, row: i64) -> GaussianRow<'_> {
        GaussianRow::new(self, row)
    }

    /// The weight of the texel in column `column` of row `row`: 0 beyond the ellipse.
    #[inline]
    pub fn texel_weight(&self, column: i64, row: i64) -> f64 {
        let [x, y] = [
            self.offset(column as f64 + 0.5, 0),
            self.offset(row as f64 + 0.5, 1),
        ];
        let meets = self
            .smooth
            .meets(x, y)
            .unwrap_or_else(|| self.row_columns(row).contains(&column));
        if !meets {
            return 0.0;
        }
        match &self.thin {
            None => self.smooth.row(y).weight(x),
            Some(thin) => thin.share(
                &thin.columns(x - 0.5, x + 0.5),
                &thin.rows(y - 0.5, y + 0.5),
            ),
        }
    }

    /// Column and row of the texel, of this or any other tile, under a point drawn from the Gaussian within the ellipse
    /// by two numbers in [0, 1).
    ///
    /// A texel is drawn with the probability that is its weight, but for what the ellipse cuts off it, and for the
    /// weight's error. It always has weight.
    pub fn sample(&self, uniform: [f64; 2]) -> [i64; 2] {
        // |z|² of a unit Gaussian is exponential; the inverse of its distribution function, cut off at RADIUS.
        let radius = libm::sqrt(-2.0 * libm::log1p(-uniform[0] * (1.0 - LOST)));
        let (sine, cosine) = libm::sincos(2.0 * core::f64::consts::PI * uniform[1]);
        let [first, second] = self.half_edges;
        let place = |axis: usize, first: f64, second: f64| {
            let offset = radius * (cosine * first + sine * second);
            let [cell, centre] = self.axis(axis);
            cell as i64 + floor(centre + offset)
        };
        [place(0, first[0], second[0]), place(1, first[1], second[1])]
    }

    /// `coordinate` on `axis`, relative to the centre.
    #[inline]
    fn offset(&self, coordinate: f64, axis: usize) -> f64 {
        let [cell, centre] = self.axis(axis);
        (coordinate - cell) - centre
    }

    #[inline]
    fn axis(&self, axis: usize) -> [f64; 2] {
        if axis == 0 {
            [self.cell[0], self.centre[0]]
        } else {
            [self.cell[1], self.centre[1]]
        }
    }
}

/// `a × b`, to the last digits also where its products nearly cancel (Kahan's two fused products).
fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    let product = a[1] * b[0];
    let error = libm::fma(-a[1], b[0], product);
    libm::fma(a[0], b[1], -product) + error
}
