//! Footprint against texels: how much of a box footprint's weight falls on an axis-aligned box of texels.
//!
//! The weight of a box is the measure of the (a, b) in [-1/2, 1/2]² for which `c + a e1 + b e2` lies in it: the unit
//! square clipped by at most four half planes. Clipping the *parameters* instead of the parallelogram makes every
//! limit come out by itself: no division by an area that may vanish, collinear edges give the distribution along
//! their line, and two zero edges give all or nothing. Rounding of a weight is of the order of 1e-16 times the
//! ratio of the centre's coordinate to the edges.

use crate::error::QueryError;
use core::ops::Range;
use glintbake_format::model::{Footprint, MAX_EDGE_TILES, Wrap};

/// A box in texel units; sides may be infinite where the map is clamped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TexelBox {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

/// How a box lies to a footprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// They share no area.
    Outside,
    /// The box may be partly inside.
    Crossing,
    /// The box lies in the footprint.
    Inside,
}

/// A box footprint in texel units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parallelogram {
    /// Whole part of the centre. Apart from the rest, so that the rest keeps all its digits.
    cell: [f64; 2],
    /// The centre relative to `cell`, in [0, 1] but for rounding.
    centre: [f64; 2],
    edge_1: [f64; 2],
    edge_2: [f64; 2],
    /// Half the width and height of the bounding box.
    extent: [f64; 2],
    /// |e1 × e2|: the area in texels.
    area: f64,
}

/// Relative slack of the inside and outside tests; a box they leave undecided is clipped, which is always right.
const SLACK: f64 = 1e-12;

impl Parallelogram {
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
        let Footprint {
            centre,
            edge_1,
            edge_2,
        } = *footprint;
        if ![centre, edge_1, edge_2]
            .iter()
            .flatten()
            .all(|coordinate| coordinate.is_finite())
        {
            return Err(QueryError::NotFinite);
        }
        if [edge_1, edge_2]
            .iter()
            .flatten()
            .any(|coordinate| coordinate.abs() > MAX_EDGE_TILES)
        {
            return Err(QueryError::FootprintTooLarge);
        }
        // Exact: a tile number is subtracted from a coordinate of the same magnitude, before anything is scaled.
        let reduce = |coordinate: f64| match wrap {
            Wrap::Repeat => coordinate - libm::floor(coordinate),
            // Beyond this no footprint reaches the map, and border texels extend without end.
            Wrap::Clamp => coordinate.clamp(-4.0 * MAX_EDGE_TILES, 4.0 * MAX_EDGE_TILES),
        };
        let size = [f64::from(width), f64::from(height)];
        let scale = |[x, y]: [f64; 2]| [x * size[0], y * size[1]];
        // The product of centre and size is rounded to the nearest f64, and can land on a texel's border though the
        // centre lies before it; the fused remainder brings back what rounding took.
        let centre = centre.map(reduce);
        let product = scale(centre);
        let rest = [
            libm::fma(centre[0], size[0], -product[0]),
            libm::fma(centre[1], size[1], -product[1]),
        ];
        let cell = product.map(libm::floor);
        let (edge_1, edge_2) = (scale(edge_1), scale(edge_2));
        Ok(Self {
            cell,
            centre: [
                (product[0] - cell[0]) + rest[0],
                (product[1] - cell[1]) + rest[1],
            ],
            edge_1,
            edge_2,
            extent: [
                (edge_1[0].abs() + edge_2[0].abs()) * 0.5,
                (edge_1[1].abs() + edge_2[1].abs()) * 0.5,
            ],
            area: (edge_1[0] * edge_2[1] - edge_1[1] * edge_2[0]).abs(),
        })
    }

    /// The same footprint seen from the tile that begins at texel (`x`, `y`).
    pub fn relative_to(&self, x: f64, y: f64) -> Self {
        Self {
            cell: [self.cell[0] - x, self.cell[1] - y],
            ..*self
        }
    }

    /// The point at parameters (`a`, `b`) in [-1/2, 1/2]², in texels.
    fn point(&self, a: f64, b: f64) -> [f64; 2] {
        let [x, y] = self.offset(a, b);
        [self.cell[0] + x, self.cell[1] + y]
    }

    /// The same point relative to the centre's texel.
    fn offset(&self, a: f64, b: f64) -> [f64; 2] {
        [
            self.centre[0] + a * self.edge_1[0] + b * self.edge_2[0],
            self.centre[1] + a * self.edge_1[1] + b * self.edge_2[1],
        ]
    }

    /// Column and row of the texel, of this or any other tile, under the point at parameters (`a`, `b`).
    pub fn texel(&self, a: f64, b: f64) -> [i64; 2] {
        let [x, y] = self.offset(a, b);
        [
            self.cell[0] as i64 + libm::floor(x) as i64,
            self.cell[1] as i64 + libm::floor(y) as i64,
        ]
    }

    /// Weight of one texel that lies wholly inside.
    pub fn texel_weight(&self) -> f64 {
        1.0 / self.area
    }

    /// Area in texels.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The bounding box.
    pub fn bounds(&self) -> TexelBox {
        TexelBox {
            low: [
                self.cell[0] + self.centre[0] - self.extent[0],
                self.cell[1] + self.centre[1] - self.extent[1],
            ],
            high: [
                self.cell[0] + self.centre[0] + self.extent[0],
                self.cell[1] + self.centre[1] + self.extent[1],
            ],
        }
    }

    /// How `texels` lies to this footprint; [`Relation::Crossing`] in doubt.
    ///
    /// Separating axes: the box's own, and in parameter space a and b, where the box has the half extents
    /// `(hx |e2y| + hy |e2x|) / |e1 × e2|` and `(hx |e1y| + hy |e1x|) / |e1 × e2|`. Everything is kept multiplied
    /// by the area, so that a vanishing area needs no case of its own.
    #[inline]
    pub fn relation(&self, texels: &TexelBox) -> Relation {
        let half = [
            (texels.high[0] - texels.low[0]) * 0.5,
            (texels.high[1] - texels.low[1]) * 0.5,
        ];
        let offset = [
            (texels.high[0] + texels.low[0]) * 0.5 - self.cell[0] - self.centre[0],
            (texels.high[1] + texels.low[1]) * 0.5 - self.cell[1] - self.centre[1],
        ];
        for axis in [0, 1] {
            // Written so that NaN, from infinite sides, decides nothing.
            #[expect(clippy::indexing_slicing, reason = "a literal index below 2")]
            let (distance, reach) = (offset[axis].abs(), half[axis] + self.extent[axis]);
            if distance > reach * (1.0 + SLACK) {
                return Relation::Outside;
            }
        }
        let mut inside = true;
        for [x, y] in [self.edge_1, self.edge_2] {
            let distance = (offset[0] * y - offset[1] * x).abs();
            let reach = half[0] * y.abs() + half[1] * x.abs();
            let slack = SLACK * ((offset[0] * y).abs() + (offset[1] * x).abs() + reach);
            let half_area = 0.5 * self.area;
            if distance > reach + half_area + slack {
                return Relation::Outside;
            }
            inside &= distance + reach + slack < half_area;
        }
        if inside {
            Relation::Inside
        } else {
            Relation::Crossing
        }
    }

    /// The share of the footprint's weight that falls on `texels`, in [0, 1].
    ///
    /// Boxes are half open, `low ≤ x < high`, which matters where the footprint has no width.
    pub fn weight(&self, texels: &TexelBox) -> f64 {
        let mut polygon = Polygon::UNIT_SQUARE;
        for axis in [0, 1] {
            #[expect(clippy::indexing_slicing, reason = "a literal index below 2")]
            let (low, high, centre, slope) = (
                texels.low[axis] - self.cell[axis],
                texels.high[axis] - self.cell[axis],
                self.centre[axis],
                [self.edge_1[axis], self.edge_2[axis]],
            );
            let reach = (slope[0].abs() + slope[1].abs()) * 0.5;
            // Above the low side: centre - low + a e1 + b e2 ≥ 0.
            let above = centre - low;
            if above + reach < 0.0 {
                return 0.0;
            }
            if above - reach < 0.0 {
                polygon.clip(above, slope);
            }
            // Below the high side: high - centre - a e1 - b e2 > 0.
            let below = high - centre;
            if below + reach <= 0.0 {
                return 0.0;
            }
            if below - reach < 0.0 {
                polygon.clip(below, slope.map(|edge| -edge));
            }
        }
        polygon.area()
    }

    /// The columns that row `row` of unit height and `unit` texels shares with this footprint.
    ///
    /// Convex, so both are intervals: `touched` may hold weight, `inside` (possibly empty) lies wholly inside.
    /// Units of columns and rows: `width` × `height` texels, so that whole tiles can be asked for as well.
    pub fn row_span(&self, row: f64, width: f64, height: f64) -> RowSpan {
        let top = row * height;
        let bottom = top + height;
        // An edge that runs along the row's border within rounding must not be missed by the row it lies in.
        let margin = 1e-9 * (1.0 + top.abs());
        let corners = [
            self.point(-0.5, -0.5),
            self.point(0.5, -0.5),
            self.point(0.5, 0.5),
            self.point(-0.5, 0.5),
        ];
        let mut touched = Interval::EMPTY;
        let mut at_top = Interval::EMPTY;
        let mut at_bottom = Interval::EMPTY;
        let mut from = corners[3];
        for to in corners {
            let (upper, lower) = if from[1] <= to[1] {
                (from, to)
            } else {
                (to, from)
            };
            if upper[1] <= bottom + margin && lower[1] >= top - margin {
                let rise = lower[1] - upper[1];
                let at = |y: f64| {
                    if rise > 0.0 {
                        let fraction = ((y - upper[1]) / rise).clamp(0.0, 1.0);
                        upper[0] + fraction * (lower[0] - upper[0])
                    } else {
                        upper[0]
                    }
                };
                if rise > 0.0 {
                    touched.add(at((top - margin).max(upper[1])));
                    touched.add(at((bottom + margin).min(lower[1])));
                    if upper[1] <= top {
                        at_top.add(at(top));
                    }
                    if lower[1] >= bottom {
                        at_bottom.add(at(bottom));
                    }
                } else {
                    touched.add(upper[0]);
                    touched.add(lower[0]);
                }
            }
            from = to;
        }
        // One part in 10⁹ of slack on either side: a column too many costs a clip, one too few costs energy.
        let slack = 1e-9 * (1.0 + touched.low.abs().max(touched.high.abs()) / width);
        let touched = touched.scaled(1.0 / width);
        let inside = Interval {
            low: at_top.low.max(at_bottom.low),
            high: at_top.high.min(at_bottom.high),
        }
        .scaled(1.0 / width);
        let touched = if touched.low <= touched.high {
            libm::floor(touched.low - slack) as i64..libm::floor(touched.high + slack) as i64 + 1
        } else {
            0..0
        };
        let inside = if inside.low < inside.high && self.area > 0.0 {
            let first = libm::ceil(inside.low + slack) as i64;
            first..(libm::floor(inside.high - slack) as i64).max(first)
        } else {
            touched.start..touched.start
        };
        RowSpan { touched, inside }
    }

    /// The rows of `height` texels that may hold weight.
    pub fn rows(&self, height: f64) -> Range<i64> {
        let bounds = self.bounds();
        let slack = 1e-9 * (1.0 + bounds.low[1].abs().max(bounds.high[1].abs()) / height);
        libm::floor(bounds.low[1] / height - slack) as i64
            ..libm::floor(bounds.high[1] / height + slack) as i64 + 1
    }
}

/// The columns a row shares with a footprint; `inside` is part of `touched`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RowSpan {
    pub touched: Range<i64>,
    pub inside: Range<i64>,
}

#[derive(Clone, Copy)]
struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    const EMPTY: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    fn add(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    fn scaled(self, factor: f64) -> Self {
        Self {
            low: self.low * factor,
            high: self.high * factor,
        }
    }
}

/// A convex polygon of at most eight corners: a square clipped four times.
struct Polygon {
    corners: [[f64; 2]; 8],
    count: usize,
}

impl Polygon {
    const UNIT_SQUARE: Self = Self {
        corners: [
            [-0.5, -0.5],
            [0.5, -0.5],
            [0.5, 0.5],
            [-0.5, 0.5],
            [0.0; 2],
            [0.0; 2],
            [0.0; 2],
            [0.0; 2],
        ],
        count: 4,
    };

    fn corners(&self) -> &[[f64; 2]] {
        self.corners.get(..self.count).unwrap_or_default()
    }

    /// Keeps the part where `constant + slope · p ≥ 0` (Sutherland and Hodgman).
    fn clip(&mut self, constant: f64, slope: [f64; 2]) {
        let side = |p: [f64; 2]| constant + slope[0] * p[0] + slope[1] * p[1];
        let mut kept = Self {
            corners: [[0.0; 2]; 8],
            count: 0,
        };
        let Some(&last) = self.corners().last() else {
            return;
        };
        let (mut from, mut from_side) = (last, side(last));
        for &to in self.corners() {
            let to_side = side(to);
            if (from_side >= 0.0) != (to_side >= 0.0) {
                // The two sides differ in sign, so the divisor is not zero and the fraction is in [0, 1].
                let fraction = from_side / (from_side - to_side);
                kept.push([
                    from[0] + fraction * (to[0] - from[0]),
                    from[1] + fraction * (to[1] - from[1]),
                ]);
            }
            if to_side >= 0.0 {
                kept.push(to);
            }
            (from, from_side) = (to, to_side);
        }
        *self = kept;
    }

    fn push(&mut self, corner: [f64; 2]) {
        // A convex polygon gains at most one corner a clip; rounding cannot add a ninth, and if it did, leaving
        // a repeated corner out would change the area by rounding only.
        if let Some(slot) = self.corners.get_mut(self.count) {
            *slot = corner;
            self.count += 1;
        }
    }

    fn area(&self) -> f64 {
        let corners = self.corners();
        let Some(&first) = corners.first() else {
            return 0.0;
        };
        // Fan from the first corner: differences keep the rounding relative to the polygon's own size.
        let mut twice = 0.0;
        for pair in corners.windows(2) {
            if let [p, q] = pair {
                twice +=
                    (p[0] - first[0]) * (q[1] - first[1]) - (p[1] - first[1]) * (q[0] - first[0]);
            }
        }
        (0.5 * twice).max(0.0)
    }
}
