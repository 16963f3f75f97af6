//! Convex polygons without an allocator.

/// A convex polygon of at most `N` corners, which turn left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon<const N: usize> {
    corners: [[f64; 2]; N],
    count: usize,
}

impl<const N: usize> Polygon<N> {
    /// All a and b in [-1/2, 1/2].
    pub const UNIT_SQUARE: Self = {
        let mut corners = [[0.0; 2]; N];
        if let Some((square, _)) = corners.split_first_chunk_mut() {
            *square = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        }
        Self { corners, count: 4 }
    };

    /// No corners.
    pub const EMPTY: Self = Self {
        corners: [[0.0; 2]; N],
        count: 0,
    };

    /// Whether it is [`UNIT_SQUARE`](Self::UNIT_SQUARE).
    pub fn is_unit_square(&self) -> bool {
        self.corners() == Self::UNIT_SQUARE.corners()
    }

    /// Whether nothing is left.
    pub const fn is_empty(&self) -> bool {
        self.count < 3
    }

    /// The corners in order.
    pub fn corners(&self) -> &[[f64; 2]] {
        self.corners.get(..self.count).unwrap_or_default()
    }

    /// Keeps the part where `constant + slope · p ≥ 0` (Sutherland and Hodgman).
    pub fn clip(&mut self, constant: f64, slope: [f64; 2]) {
        let side = |p: [f64; 2]| constant + slope[0] * p[0] + slope[1] * p[1];
        let mut kept = Self::EMPTY;
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
        // A convex polygon gains at most one corner a clip; rounding cannot add more than there is room for, and if it did,
        // leaving a repeated corner out would change the area by rounding only.
        if let Some(slot) = self.corners.get_mut(self.count) {
            *slot = corner;
            self.count += 1;
        }
    }

    /// The area, at least 0.
    pub fn area(&self) -> f64 {
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
