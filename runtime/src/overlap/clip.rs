//! Clipping in parameter space: a box's weight whatever the footprint's shape.
//!
//! The weight of a box is the measure of the (a, b) in [-1/2, 1/2]² for which `c + a e1 + b e2` lies in it: the unit
//! square clipped by at most four half planes. Clipping the *parameters* instead of the parallelogram makes every
//! limit come out by itself: no division by an area that may vanish, collinear edges give the distribution along
//! their line, and two zero edges give all or nothing. Rounding of a weight is of the order of 1e-16 times the
//! ratio of the centre's coordinate to the edges.

use super::polygon::Polygon;
use super::{Parallelogram, TexelBox};

impl Parallelogram {
    /// The share of the footprint's weight that falls on `texels`, in [0, 1].
    ///
    /// Boxes are half open, `low ≤ x < high`, which matters where the footprint has no width.
    pub fn weight(&self, texels: &TexelBox) -> f64 {
        // A square clipped four times.
        let mut polygon = Polygon::<8>::UNIT_SQUARE;
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
