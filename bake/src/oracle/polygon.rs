//! Convex polygons and what an axis-aligned strip leaves of them.

use super::double_double::DoubleDouble;

/// A convex polygon by its corners in order, in texels; empty if it has none.
pub(super) struct Polygon {
    corners: Vec<[DoubleDouble; 2]>,
}

impl Polygon {
    /// The parallelogram `a edge_1 + b edge_2`, a, b in [-1/2, 1/2].
    pub(super) fn parallelogram(edge_1: [DoubleDouble; 2], edge_2: [DoubleDouble; 2]) -> Self {
        let corner = |sign_1: f64, sign_2: f64| {
            [0, 1].map(|axis| {
                (DoubleDouble::from(sign_1) * edge_1[axis]
                    + DoubleDouble::from(sign_2) * edge_2[axis])
                    .half()
            })
        };
        Self {
            corners: vec![
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
        }
    }

    /// The part with `lower <= coordinate <= upper` on `axis`; a `None` does not cut.
    pub(super) fn strip(
        &self,
        axis: usize,
        lower: Option<DoubleDouble>,
        upper: Option<DoubleDouble>,
    ) -> Self {
        let mut corners = self.corners.clone();
        if let Some(lower) = lower {
            corners = cut(&corners, axis, lower, |distance| {
                distance >= DoubleDouble::ZERO
            });
        }
        if let Some(upper) = upper {
            corners = cut(&corners, axis, upper, |distance| {
                distance <= DoubleDouble::ZERO
            });
        }
        Self { corners }
    }

    /// Area, whatever the orientation.
    pub(super) fn area(&self) -> DoubleDouble {
        let Some((origin, others)) = self.corners.split_first() else {
            return DoubleDouble::ZERO;
        };
        // A fan about a corner: the products are of the size of the polygon, not of its distance from the centre.
        let twice = others.windows(2).fold(DoubleDouble::ZERO, |sum, pair| {
            let [p, q] = [0, 1].map(|i| [0, 1].map(|axis| pair[i][axis] - origin[axis]));
            sum + (p[0] * q[1] - p[1] * q[0])
        });
        twice.half().abs()
    }

    /// Least and greatest coordinate on `axis`, or `None` if the polygon is empty.
    pub(super) fn range(&self, axis: usize) -> Option<(DoubleDouble, DoubleDouble)> {
        range_of(self.corners.iter().map(|corner| corner[axis]))
    }

    /// Least and greatest coordinate on the other axis among the corners that lie exactly at `place` on `axis`.
    pub(super) fn side_at(
        &self,
        axis: usize,
        place: DoubleDouble,
    ) -> Option<(DoubleDouble, DoubleDouble)> {
        let on_side = self.corners.iter().filter(|corner| corner[axis] == place);
        range_of(on_side.map(|corner| corner[1 - axis]))
    }
}

fn range_of(
    mut coordinates: impl Iterator<Item = DoubleDouble>,
) -> Option<(DoubleDouble, DoubleDouble)> {
    let first = coordinates.next()?;
    Some(coordinates.fold((first, first), |(least, greatest), x| {
        (
            if x < least { x } else { least },
            if x > greatest { x } else { greatest },
        )
    }))
}

/// One step of Sutherland and Hodgman (1974): the corners left of a cut at `place`.
///
/// New corners lie exactly at `place`, so that neighbouring strips share them and their areas add up.
fn cut(
    corners: &[[DoubleDouble; 2]],
    axis: usize,
    place: DoubleDouble,
    keeps: impl Fn(DoubleDouble) -> bool,
) -> Vec<[DoubleDouble; 2]> {
    let mut kept = Vec::with_capacity(corners.len() + 2);
    for (i, &to) in corners.iter().enumerate() {
        let from = corners[(i + corners.len() - 1) % corners.len()];
        let (from_distance, to_distance) = (from[axis] - place, to[axis] - place);
        if keeps(from_distance) != keeps(to_distance) {
            let fraction = from_distance / (from_distance - to_distance);
            let mut crossing = [place; 2];
            crossing[1 - axis] = from[1 - axis] + fraction * (to[1 - axis] - from[1 - axis]);
            kept.push(crossing);
        }
        if keeps(to_distance) {
            kept.push(to);
        }
    }
    kept
}
