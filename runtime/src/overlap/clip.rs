//! Clipping in parameter space: a box's weight whatever the footprint's shape.
//!
//! The weight of a box is the measure of the (a, b) in [-1/2, 1/2]² for which `c + a e1 + b e2` lies in it: the unit
//! square clipped by at most four half planes. Clipping the *parameters* instead of the parallelogram makes every
//! limit come out by itself: no division by an area that may vanish, collinear edges give the distribution along
//! their line, and two zero edges give all or nothing. Rounding of a weight is of the order of 1e-16 times the
//! ratio of the centre's coordinate to the edges.

use super::{Parallelogram, TexelBox};

impl Parallelogram {
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
