//! The footprint as the baselines see it: a parallelogram in texels, separating axes, exact clipping.
//!
//! Plain geometry written apart from the runtime's, which weighs rows by coverage. For footprints that have an area.

use glintbake_format::model::Footprint;
use std::ops::Range;

/// How a box of texels lies to a footprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// They share no area.
    Outside,
    /// All of the box lies under the footprint.
    Inside,
    /// Neither.
    Crossing,
}

/// A footprint of some area on one tile of a repeating map, in texels from that tile's corner.
///
/// A point is `centre + a e1 + b e2`; `a` and `b` are linear in the point, and lie in [-1/2, 1/2] within.
#[derive(Clone, Copy, Debug)]
pub struct Parallelogram {
    centre: [f64; 2],
    /// Half the width and height of the bounding box.
    extent: [f64; 2],
    /// Gradients of `a` and `b`.
    gradients: [[f64; 2]; 2],
    /// Half of what `a` and `b` change over one texel.
    texel_reach: [f64; 2],
    area: f64,
}

/// Slack in texels of a row's columns: a texel too many at its ends costs a clip, one too few costs weight.
const SLACK: f64 = 1e-9;

impl Parallelogram {
    /// `footprint` on a repeating map of `width` × `height` texels, its centre moved to the first tile.
    ///
    /// # Panics
    /// If the footprint has no area.
    pub fn new(footprint: &Footprint, width: u32, height: u32) -> Self {
        let size = [f64::from(width), f64::from(height)];
        let scale = |[x, y]: [f64; 2]| [x * size[0], y * size[1]];
        let centre = scale(footprint.centre.map(|x| x - x.floor()));
        let (first, second) = (scale(footprint.edge_1), scale(footprint.edge_2));
        let turn = first[0] * second[1] - first[1] * second[0];
        assert!(turn.abs() > 0.0, "baselines need a footprint with an area");
        let gradients = [
            [second[1] / turn, -second[0] / turn],
            [-first[1] / turn, first[0] / turn],
        ];
        Self {
            centre,
            extent: [0, 1].map(|axis| (first[axis].abs() + second[axis].abs()) * 0.5),
            gradients,
            texel_reach: gradients.map(|[x, y]| (x.abs() + y.abs()) * 0.5),
            area: turn.abs(),
        }
    }

    /// The footprint as seen from each tile of `width` × `height` texels that it shares area with.
    pub fn copies(self, width: u32, height: u32) -> impl Iterator<Item = Self> {
        let size = [f64::from(width), f64::from(height)];
        let [columns, rows] = [0, 1].map(|axis| {
            let first = (self.centre[axis] - self.extent[axis]) / size[axis];
            let last = (self.centre[axis] + self.extent[axis]) / size[axis];
            first.floor() as i64..last.floor() as i64 + 1
        });
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
            .map(move |(column, row)| Self {
                centre: [
                    self.centre[0] - column as f64 * size[0],
                    self.centre[1] - row as f64 * size[1],
                ],
                ..self
            })
            .filter(move |copy| copy.relation([0.0; 2], size) != Relation::Outside)
    }

    /// Area in texels.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// How the box from `low` to `high` lies to the footprint, by separating axes.
    #[inline]
    pub fn relation(&self, low: [f64; 2], high: [f64; 2]) -> Relation {
        let half = [0, 1].map(|axis| (high[axis] - low[axis]) * 0.5);
        let middle = [0, 1].map(|axis| (high[axis] + low[axis]) * 0.5 - self.centre[axis]);
        let reach = self
            .gradients
            .map(|[x, y]| x.abs() * half[0] + y.abs() * half[1]);
        self.relation_at(middle, half, reach)
    }

    /// How the texel in column `column` and row `row` lies to the footprint.
    #[inline]
    pub fn texel_relation(&self, [column, row]: [u16; 2]) -> Relation {
        let middle = [
            f64::from(column) + 0.5 - self.centre[0],
            f64::from(row) + 0.5 - self.centre[1],
        ];
        self.relation_at(middle, [0.5; 2], self.texel_reach)
    }

    /// For a box of half size `half` around `middle` (from the centre), over which `a` and `b` change by ± `reach`.
    #[inline]
    fn relation_at(&self, middle: [f64; 2], half: [f64; 2], reach: [f64; 2]) -> Relation {
        let distance = self.parameters(middle).map(f64::abs);
        let outside = (middle[0].abs() >= self.extent[0] + half[0])
            | (middle[1].abs() >= self.extent[1] + half[1])
            | (distance[0] >= 0.5 + reach[0])
            | (distance[1] >= 0.5 + reach[1]);
        let inside = (distance[0] + reach[0] <= 0.5) & (distance[1] + reach[1] <= 0.5);
        if outside {
            Relation::Outside
        } else if inside {
            Relation::Inside
        } else {
            Relation::Crossing
        }
    }

    /// `a` and `b` of a point given from the centre.
    #[inline]
    fn parameters(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.gradients
            .map(|gradient| gradient[0] * x + gradient[1] * y)
    }

    /// The rows of a map of `height` rows that the bounding box meets.
    pub fn rows(&self, height: u32) -> Range<u32> {
        let low = (self.centre[1] - self.extent[1]).max(0.0);
        let high = (self.centre[1] + self.extent[1]).min(f64::from(height));
        low as u32..high.ceil() as u32
    }

    /// The columns, of a map of `width`, of row `row` whose texels share area with the footprint, and those of them,
    /// possibly none, whose texels lie wholly inside.
    ///
    /// Separating axes solved for the column: on each axis the texels that touch, and those within, are an interval.
    pub fn columns(&self, row: u32, width: u32) -> (Range<u32>, Range<u32>) {
        let y = f64::from(row) + 0.5 - self.centre[1];
        // Intervals of the texel's middle, from the centre.
        let mut touched = [-self.extent[0] - 0.5, self.extent[0] + 0.5];
        let mut inside = touched;
        for ([gradient, slope], reach) in self.gradients.into_iter().zip(self.texel_reach) {
            let along = slope * y;
            if gradient.abs() * (self.extent[0] + 1.0) < 1e-12 {
                // The parameter does not change along the row.
                if along.abs() >= 0.5 + reach {
                    return (0..0, 0..0);
                }
                if along.abs() + reach > 0.5 {
                    inside[1] = f64::NEG_INFINITY;
                }
                continue;
            }
            let middle = -along / gradient;
            let touches = (0.5 + reach) / gradient.abs();
            let within = (0.5 - reach) / gradient.abs();
            touched = [
                touched[0].max(middle - touches),
                touched[1].min(middle + touches),
            ];
            inside = [
                inside[0].max(middle - within),
                inside[1].min(middle + within),
            ];
        }
        // From middles to columns; a float-to-integer cast saturates, and rounds down what is not negative.
        let base = self.centre[0] - 0.5;
        let first = |x: f64| (base + x).ceil().max(0.0) as u32;
        let end = |x: f64| (base + x + 1.0).max(0.0) as u32;
        let touched_first = first(touched[0] - SLACK).min(width);
        let touched_end = end(touched[1] + SLACK).clamp(touched_first, width);
        let inside_first = first(inside[0] + SLACK).clamp(touched_first, touched_end);
        let inside_end = end(inside[1] - SLACK).clamp(inside_first, touched_end);
        (touched_first..touched_end, inside_first..inside_end)
    }

    /// The area that the texel in column `column` and row `row` shares with the footprint, in texels.
    ///
    /// The texel clipped by those sides of the footprint that cross it (Sutherland and Hodgman).
    pub fn clipped_area(&self, [column, row]: [u16; 2]) -> f64 {
        let corner = [
            f64::from(column) - self.centre[0],
            f64::from(row) - self.centre[1],
        ];
        let middle = self.parameters([corner[0] + 0.5, corner[1] + 0.5]);
        let mut polygon = Polygon::TEXEL;
        for ((parameter, gradient), reach) in
            middle.into_iter().zip(self.gradients).zip(self.texel_reach)
        {
            // At the texel's corner, from which the polygon is measured.
            let at_corner = gradient[0] * corner[0] + gradient[1] * corner[1];
            if parameter + reach > 0.5 {
                polygon.clip(0.5 - at_corner, [-gradient[0], -gradient[1]]);
            }
            if parameter - reach < -0.5 {
                polygon.clip(0.5 + at_corner, gradient);
            }
        }
        polygon.area()
    }
}

/// A texel clipped up to four times: a convex polygon of at most eight corners.
struct Polygon {
    corners: [[f64; 2]; 8],
    count: usize,
}

impl Polygon {
    const TEXEL: Self = Self {
        corners: [
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
            [0.0; 2],
            [0.0; 2],
            [0.0; 2],
            [0.0; 2],
        ],
        count: 4,
    };

    /// Keeps the part where `constant + gradient · p ≥ 0`.
    fn clip(&mut self, constant: f64, gradient: [f64; 2]) {
        if self.count == 0 {
            return;
        }
        let height = |[x, y]: [f64; 2]| constant + gradient[0] * x + gradient[1] * y;
        let mut kept = Self {
            corners: [[0.0; 2]; 8],
            count: 0,
        };
        let mut from = self.corners[self.count - 1];
        let mut from_height = height(from);
        for &to in &self.corners[..self.count] {
            let to_height = height(to);
            if (from_height >= 0.0) != (to_height >= 0.0) {
                let share = from_height / (from_height - to_height);
                kept.push([
                    from[0] + share * (to[0] - from[0]),
                    from[1] + share * (to[1] - from[1]),
                ]);
            }
            if to_height >= 0.0 {
                kept.push(to);
            }
            (from, from_height) = (to, to_height);
        }
        *self = kept;
    }

    fn push(&mut self, corner: [f64; 2]) {
        // A convex polygon gains a corner a clip; what rounding adds to that is of no area.
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    fn area(&self) -> f64 {
        let corners = &self.corners[..self.count];
        let Some(&[x, y]) = corners.first() else {
            return 0.0;
        };
        let twice: f64 = corners
            .windows(2)
            .map(|pair| (pair[0][0] - x) * (pair[1][1] - y) - (pair[0][1] - y) * (pair[1][0] - x))
            .sum();
        (0.5 * twice).max(0.0)
    }
}
