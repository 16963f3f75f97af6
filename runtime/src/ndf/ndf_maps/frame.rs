//! A footprint among the texels of the surface, and among those of a copy.
//!
//! All areas are of the footprint's own parameters a and b, a square of area 1: then footprints of no width, and of no size, are
//! nothing special.

use crate::error::QueryError;
use crate::overlap::{Placement, Polygon};
use glintbake_format::model::{Footprint, NdfMapLayout, Wrap};
use glintbake_format::view::Copied;

/// The least width of a footprint that has a length, as a share of that, or in texels.
const THINNEST: f64 = 1e-6;

/// A part of the footprint. What copies and their neighbours cut a square by, again and again, has few corners.
pub(super) type Region = Polygon<16>;

/// A number that changes evenly over the footprint: `constant + slope · (a, b)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub constant: f64,
    pub slope: [f64; 2],
}

impl Plane {
    /// The part of `region` where this is at least `least`.
    pub fn above(&self, least: f64, region: &mut Region) {
        region.clip(self.constant - least, self.slope);
    }

    /// The part of `region` where this is at most `most`.
    pub fn below(&self, most: f64, region: &mut Region) {
        region.clip(most - self.constant, self.slope.map(|x| -x));
    }

    /// The same, negated.
    pub fn negated(&self) -> Self {
        Self {
            constant: -self.constant,
            slope: self.slope.map(|x| -x),
        }
    }

    pub fn at(&self, [a, b]: [f64; 2]) -> f64 {
        self.constant + self.slope[0] * a + self.slope[1] * b
    }

    /// Its least and its greatest value over the footprint.
    pub fn range(&self) -> [f64; 2] {
        let reach = 0.5 * (self.slope[0].abs() + self.slope[1].abs());
        [self.constant - reach, self.constant + reach]
    }
}

/// A footprint in texels of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub centre: [f64; 2],
    pub edges: [[f64; 2]; 2],
}

impl Frame {
    /// `footprint` on a surface of `layout`.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`], [`QueryError::FootprintTooLarge`].
    pub fn new(footprint: &Footprint, layout: &NdfMapLayout) -> Result<Self, QueryError> {
        let Placement {
            cell,
            centre,
            edge_1,
            edge_2,
        } = Placement::new(footprint, layout.size, layout.size, Wrap::Repeat)?;
        let [x, y] = if layout.is_scattered {
            [cell[0] + centre[0], cell[1] + centre[1]]
        } else {
            // Tiled copies need not repeat as texture space does.
            footprint.centre.map(|along| along * f64::from(layout.size))
        };
        Ok(Self {
            centre: [x, y],
            edges: widened([edge_1, edge_2]),
        })
    }

    /// Texels under the footprint.
    pub fn area(&self) -> f64 {
        let [[x_1, y_1], [x_2, y_2]] = self.edges;
        (x_1 * y_2 - x_2 * y_1).abs()
    }

    /// Columns and rows of the surface across the footprint.
    pub fn axes(&self) -> [Plane; 2] {
        let [[x_1, y_1], [x_2, y_2]] = self.edges;
        [
            Plane {
                constant: self.centre[0],
                slope: [x_1, x_2],
            },
            Plane {
                constant: self.centre[1],
                slope: [y_1, y_2],
            },
        ]
    }

    /// Columns and rows of the example of `copied`, which lies `shift` from its place, across the footprint.
    pub fn of_copy(&self, copied: &Copied, shift: [f64; 2], example: f64) -> Local {
        let [[xx, xy], [yx, yy]] = copied.matrix;
        let determinant = xx * yy - xy * yx;
        let rows = [
            [yy / determinant, -xy / determinant],
            [-yx / determinant, xx / determinant],
        ];
        let from = [
            self.centre[0] - copied.centre[0] - shift[0],
            self.centre[1] - copied.centre[1] - shift[1],
        ];
        let dot = |[p, q]: [f64; 2], [x, y]: [f64; 2]| p * x + q * y;
        let [first, second] = self.edges;
        let axes = rows.map(|row| Plane {
            constant: 0.5 * example + dot(row, from),
            slope: [dot(row, first), dot(row, second)],
        });
        Local { axes }
    }
}

/// `edges`, the shorter one moved across the longer if the footprint is a line, or as good as one: a Gaussian over a piece of plane
/// keeps no digits where it has no width, and a millionth of its length changes nothing.
fn widened([first, second]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let square = |[x, y]: [f64; 2]| x * x + y * y;
    let is_first_longer = square(first) >= square(second);
    let (longer, shorter) = if is_first_longer {
        (first, second)
    } else {
        (second, first)
    };
    let length = libm::sqrt(square(longer));
    let least = THINNEST * length.max(1.0);
    let cross = longer[0] * shorter[1] - longer[1] * shorter[0];
    if length == 0.0 || cross.abs() >= least * length {
        return [first, second];
    }
    let across = least.min(length) / length;
    let shorter = [
        shorter[0] - longer[1] * across,
        shorter[1] + longer[0] * across,
    ];
    if is_first_longer {
        [longer, shorter]
    } else {
        [shorter, longer]
    }
}

/// A footprint in texels of an example.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// Column and row, from the example's first corner.
    pub axes: [Plane; 2],
}

impl Local {
    /// The determinant of texels by a and b: texels under the footprint, of either sign; 0 where it is all rounding.
    fn determinant(&self) -> f64 {
        let [x, y] = self.axes;
        let determinant = x.slope[0] * y.slope[1] - x.slope[1] * y.slope[0];
        let first = x.slope[0] * x.slope[0] + y.slope[0] * y.slope[0];
        let second = x.slope[1] * x.slope[1] + y.slope[1] * y.slope[1];
        if determinant * determinant > 1e-22 * first * second {
            determinant
        } else {
            0.0
        }
    }

    /// The share of the footprint that one texel is; infinite if it has no area.
    pub fn texel(&self) -> f64 {
        1.0 / self.determinant().abs()
    }

    /// Whether the square of `side` texels at `low` lies wholly under the footprint, wholly beyond it, or neither is certain.
    pub fn relation(&self, low: [f64; 2], side: f64) -> Option<bool> {
        let [x, y] = self.axes;
        let half = 0.5 * side;
        let middle = [low[0] + half, low[1] + half];
        let is_beyond = |axis: &Plane, low: f64| {
            let [least, most] = axis.range();
            most <= low || least >= low + side
        };
        if is_beyond(&x, low[0]) || is_beyond(&y, low[1]) {
            return Some(false);
        }
        let determinant = self.determinant();
        if determinant == 0.0 {
            return None;
        }
        let from = [middle[0] - x.constant, middle[1] - y.constant];
        let a = (y.slope[1] * from[0] - x.slope[1] * from[1]) / determinant;
        let b = (x.slope[0] * from[1] - y.slope[0] * from[0]) / determinant;
        let reach_a = half * (y.slope[1].abs() + x.slope[1].abs()) / determinant.abs();
        let reach_b = half * (x.slope[0].abs() + y.slope[0].abs()) / determinant.abs();
        let (a, b) = (a.abs(), b.abs());
        if a - reach_a >= 0.5 || b - reach_b >= 0.5 {
            return Some(false);
        }
        (a + reach_a <= 0.5 && b + reach_b <= 0.5).then_some(true)
    }

    /// The part of the footprint over the square of `side` texels at `low`.
    pub fn region(&self, low: [f64; 2], side: f64) -> Region {
        let mut region = Region::UNIT_SQUARE;
        for (axis, low) in self.axes.iter().zip(low) {
            let [least, most] = axis.range();
            if least < low {
                axis.above(low, &mut region);
            }
            if most > low + side {
                axis.below(low + side, &mut region);
            }
        }
        region
    }

    /// The same footprint, `offset` texels to the left and up.
    pub fn moved(&self, offset: [f64; 2]) -> Self {
        let [mut x, mut y] = self.axes;
        x.constant -= offset[0];
        y.constant -= offset[1];
        Self { axes: [x, y] }
    }
}
