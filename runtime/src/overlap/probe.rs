//! Quick tests of boxes and single texels against a footprint, with all that depends on the footprint alone at hand.

use super::{Outline, Parallelogram, TexelBox};

/// How a box lies to a footprint; outside if neither is true. Not an enumeration, because what comes of it is counted
/// without branches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Relation {
    /// The box lies in the footprint.
    pub inside: bool,
    /// The box may be partly inside.
    pub crossing: bool,
}

/// Relative slack of the inside and outside tests; what they leave undecided is weighed, which is always right.
const SLACK: f64 = 1e-12;

/// Two parallel sides of a footprint, each along `edge` and `half_area / |edge|` from the centre.
///
/// Distances from the centre line are kept multiplied by `|edge|`, `|offset × edge|`, so that neither a vanishing edge
/// nor a vanishing area needs a case of its own.
#[derive(Clone, Copy, Debug)]
struct Strip {
    edge: [f64; 2],
    half_area: f64,
    /// Beyond this distance plus its own reach a box is outside.
    outside: f64,
    /// Within this distance less its own reach a box is between the sides.
    inside: f64,
    /// `outside` and `inside` for the distance of one texel's centre.
    texel_outside: f64,
    texel_inside: f64,
    /// Whether no texel meets both sides.
    wide: bool,
}

impl Strip {
    fn new(edge: [f64; 2], half_area: f64, extent: [f64; 2]) -> Self {
        // Rounding of a distance is relative to its two products, which for a box that meets the bounding box are
        // no more than this and the box's reach together.
        let slack = SLACK * (extent[0] * edge[1].abs() + extent[1] * edge[0].abs());
        let reach = 0.5 * (edge[0].abs() + edge[1].abs());
        let (outside, inside) = (half_area + slack, half_area - slack);
        Self {
            edge,
            half_area,
            outside,
            inside,
            texel_outside: outside + reach * (1.0 + 2.0 * SLACK),
            texel_inside: inside - reach * (1.0 + 2.0 * SLACK),
            wide: half_area > reach,
        }
    }

    #[inline]
    fn distance(&self, offset: [f64; 2]) -> f64 {
        (offset[0] * self.edge[1] - offset[1] * self.edge[0]).abs()
    }

    #[inline]
    fn reach(&self, half: [f64; 2]) -> f64 {
        (half[0] * self.edge[1].abs() + half[1] * self.edge[0].abs()) * (1.0 + 2.0 * SLACK)
    }

    /// The share of a texel at `distance` that lies on the centre's side of the nearer side: a unit square less a
    /// corner, cut by a line.
    fn share(&self, distance: f64) -> f64 {
        let (x, y) = (self.edge[0].abs(), self.edge[1].abs());
        let (long, short) = if x > y { (x, y) } else { (y, x) };
        // How far the line has moved across the square, of `long + short` in all.
        let depth = (self.half_area - distance) + 0.5 * (long + short);
        let left = (long + short) - depth;
        if depth <= 0.0 {
            0.0
        } else if left <= 0.0 {
            1.0
        } else if depth < short {
            0.5 * (depth / short) * (depth / long)
        } else if left < short {
            1.0 - 0.5 * (left / short) * (left / long)
        } else {
            (depth - 0.5 * short) / long
        }
    }
}

/// A footprint as seen from one tile, ready to be tested against many boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe<'a> {
    footprint: &'a Parallelogram,
    outline: Option<&'a Outline>,
    cell: [f64; 2],
    centre: [f64; 2],
    /// Half the sides of the bounding box.
    extent: [f64; 2],
    strips: [Strip; 2],
}

impl<'a> Probe<'a> {
    /// Tests against `footprint`, which has the outline `outline` from whatever tile it is seen.
    pub fn new(footprint: &'a Parallelogram, outline: Option<&'a Outline>) -> Self {
        let extent = footprint.extent;
        let half_area = 0.5 * footprint.area;
        Self {
            footprint,
            outline,
            cell: footprint.cell,
            centre: footprint.centre,
            extent: extent.map(|extent| extent * (1.0 + SLACK)),
            strips: [footprint.edge_1, footprint.edge_2]
                .map(|edge| Strip::new(edge, half_area, extent)),
        }
    }

    /// How `texels` lies to the footprint; crossing in doubt.
    ///
    /// Separating axes: the box's own, and in parameter space a and b, where the box has the half extents
    /// `(hx |e2y| + hy |e2x|) / |e1 × e2|` and `(hx |e1y| + hy |e1x|) / |e1 × e2|`.
    #[inline]
    pub fn relation(&self, texels: &TexelBox) -> Relation {
        // No box is less than a texel, whatever a forest says: where no texel fits, none is inside, and the weight of a
        // whole one, which may be infinite, is never asked for.
        let half = [
            ((texels.high[0] - texels.low[0]) * 0.5).max(0.5),
            ((texels.high[1] - texels.low[1]) * 0.5).max(0.5),
        ];
        let offset = [
            (texels.high[0] + texels.low[0]) * 0.5 - self.cell[0] - self.centre[0],
            (texels.high[1] + texels.low[1]) * 0.5 - self.cell[1] - self.centre[1],
        ];
        let [first, second] = &self.strips;
        let (distance_1, reach_1) = (first.distance(offset), first.reach(half));
        let (distance_2, reach_2) = (second.distance(offset), second.reach(half));
        // Written so that NaN, from infinite sides, decides nothing.
        let outside = (offset[0].abs() > half[0] * (1.0 + SLACK) + self.extent[0])
            | (offset[1].abs() > half[1] * (1.0 + SLACK) + self.extent[1])
            | (distance_1 > first.outside + reach_1)
            | (distance_2 > second.outside + reach_2);
        let inside = (distance_1 + reach_1 < first.inside) & (distance_2 + reach_2 < second.inside);
        Relation {
            inside,
            crossing: !(inside | outside),
        }
    }

    /// How the texel in `column` and `row` lies to the footprint.
    #[inline]
    pub fn texel(&self, column: u16, row: u16) -> Relation {
        let offset = self.texel_offset(column, row);
        let [first, second] = &self.strips;
        let (distance_1, distance_2) = (first.distance(offset), second.distance(offset));
        let outside = (offset[0].abs() > self.extent[0] + 0.5)
            | (offset[1].abs() > self.extent[1] + 0.5)
            | (distance_1 > first.texel_outside)
            | (distance_2 > second.texel_outside);
        let inside = (distance_1 < first.texel_inside) & (distance_2 < second.texel_inside);
        Relation {
            inside,
            crossing: !(inside | outside),
        }
    }

    /// The offset of a texel's centre from the footprint's.
    #[inline]
    fn texel_offset(&self, column: u16, row: u16) -> [f64; 2] {
        [
            (f64::from(column) - self.cell[0]) + (0.5 - self.centre[0]),
            (f64::from(row) - self.cell[1]) + (0.5 - self.centre[1]),
        ]
    }

    /// The weight of the texel in `column` and `row`.
    pub fn weight(&self, column: u16, row: u16) -> f64 {
        let Some(outline) = self.outline else {
            let low = [f64::from(column), f64::from(row)];
            return self.footprint.weight(&TexelBox {
                low,
                high: [low[0] + 1.0, low[1] + 1.0],
            });
        };
        let [first, second] = &self.strips;
        let offset = self.texel_offset(column, row);
        let (distance_1, distance_2) = (first.distance(offset), second.distance(offset));
        // Most texels on the outline meet one side alone.
        let share = if distance_1 < first.texel_inside && second.wide {
            second.share(distance_2)
        } else if distance_2 < second.texel_inside && first.wide {
            first.share(distance_1)
        } else {
            return outline
                .row(self.footprint, i64::from(row))
                .weight(i64::from(column));
        };
        share * self.footprint.texel_weight()
    }
}
