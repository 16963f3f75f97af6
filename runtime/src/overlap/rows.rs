//! The rows and columns of a grid that a footprint meets.

use super::Parallelogram;
use core::ops::Range;

impl Parallelogram {
    /// The columns that row `row` of a grid of `width` × `height` texels a cell shares with this footprint: 1 × 1 for
    /// texels, the map's size for tiles.
    ///
    /// Convex, so both are intervals: `touched` may hold weight, `inside` (possibly empty) lies wholly inside.
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
