//! A parallelogram: texels weigh as much as lies in it.
#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use super::{Origin, Region};
use crate::ndf::cluster_tree::lanes::{
    BITS, LANES, LEAST_TERM, Lanes, Place, Spread, Texels, first_bits, get, inverse_root, max, min,
    set, unit,
};
use crate::overlap::{Outline, Parallelogram, TexelBox};

/// Rounding of a coordinate relative to the footprint's or tile's size, with a margin.
const SLACK: f32 = 2e-6;
/// Width in texels below which boxes are weighed in double precision.
const THIN: f64 = 0.05;

/// The variance of places within a texel, in either direction.
const TEXEL_VARIANCE: f32 = 1.0 / 12.0;

/// From this share on a texel counts as whole: single precision has no more to say.
const WHOLE_SHARE: f32 = 1.0 - 1e-5;

/// The share of a texel that lies between two parallel sides at least as far apart as it reaches: a unit square, cut by a line.
#[derive(Clone, Copy, Debug)]
struct Share {
    /// Half the distance of the sides, and half the texel's reach.
    depth: f32,
    long: f32,
    short: f32,
    scale: f32,
}

impl Share {
    fn new([x, y]: [f32; 2], half: f32) -> Self {
        let (x, y) = (x.abs(), y.abs());
        let long = max(x, y);
        // A side that is all but straight; leaning it by this moves no area by more than 3e-4 of a texel.
        let short = max(if x > y { y } else { x }, 1e-3);
        Self {
            depth: half + 0.5 * (long + short),
            long,
            short,
            scale: 0.5 / (long * short),
        }
    }

    /// Of the texel whose middle is at `distance` from the line half-way between the sides.
    ///
    /// With R(x) = max(x, 0)² / 2, a line that has come d across a unit square, of long + short in all, has behind it
    /// `(R(d) - R(d - short) - R(d - long)) / (long short)`, up to the far corner.
    #[inline(always)]
    fn of(&self, distance: f32) -> f32 {
        let depth = self.depth - distance.abs();
        let d = max(min(depth, self.long + self.short), 0.0);
        let (a, b) = (max(d - self.short, 0.0), max(d - self.long, 0.0));
        (d * d - a * a - b * b) * self.scale
    }
}

/// One side of a parallelogram, for the area below it.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// Where it begins, and the x where it ends, from the footprint's centre.
    from: [f32; 2],
    to_x: f32,
    slope: f32,
}

impl Side {
    fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        let run = to[0] - from[0];
        Self {
            from: from.map(|x| x as f32),
            to_x: to[0] as f32,
            slope: if run == 0.0 {
                0.0
            } else {
                // So steep a side spans no width that counts.
                ((to[1] - from[1]) / run).clamp(-1e9, 1e9) as f32
            },
        }
    }

    /// The area below it within the texel whose low corner is (x, y): the integral, over the part of the side's width that is the
    /// texel's, of its height cut off at the texel's. Negative if it runs to the left.
    ///
    /// Heights at either end, a and b, are cut off to a' and b'. The share of the way that is within the texel is
    /// `(b' - a') / (b - a)`, at a mean height of `(a' + b') / 2`, and that above it counts as 1.
    #[inline(always)]
    fn area(&self, x: f32, y: f32) -> f32 {
        let from = self.from[0] - x;
        let (a_x, b_x) = (unit(from), unit(self.to_x - x));
        let base = self.from[1] - y;
        let (a, b) = (
            base + (a_x - from) * self.slope,
            base + (b_x - from) * self.slope,
        );
        let (a_cut, b_cut) = (unit(a), unit(b));
        let climb = b - a;
        let is_level = climb.abs() < 1e-20;
        let inverse = 1.0 / if is_level { 1.0 } else { climb };
        let within = if is_level {
            1.0
        } else {
            (b_cut - a_cut) * inverse
        };
        let above = (max(b, 1.0) - max(a, 1.0)) * inverse;
        (b_x - a_x) * (0.5 * within * (a_cut + b_cut) + above)
    }
}

/// A parallelogram.
#[derive(Clone, Copy, Debug)]
pub(in crate::ndf::cluster_tree) struct BoxRegion<'a> {
    pub footprint: &'a Parallelogram,
    pub outline: Option<&'a Outline>,
    /// Unit vectors across each pair of sides; zero for a side without length.
    across: [[f32; 2]; 2],
    /// Half the distance of each pair of sides, less slack.
    half: [f32; 2],
    /// Half the sides of the bounding box.
    extent: [f32; 2],
    /// The share of a texel between each pair of sides.
    shares: [Share; 2],
    sides: [Side; 4],
    /// Whether no texel meets both sides of a pair, and shares will do.
    is_wide: bool,
    /// Whether texels that are cut are weighed in double precision.
    is_exact: bool,
    /// Texels of clusters that may be weighed as a whole where a side cuts them.
    most_blurred: f32,
    slack: f32,
    unit: f64,
}

impl<'a> BoxRegion<'a> {
    /// `footprint`, which has the outline `outline`; with all texels that are cut weighed in double precision if `exact`, else with
    /// clusters of up to `blur` of its texels weighed as a whole.
    pub fn new(
        footprint: &'a Parallelogram,
        outline: Option<&'a Outline>,
        exact: bool,
        blur: f64,
    ) -> Self {
        let bounds = footprint.bounds();
        let extent = [
            0.5 * (bounds.high[0] - bounds.low[0]),
            0.5 * (bounds.high[1] - bounds.low[1]),
        ];
        let area = footprint.area();
        let [first, second] = footprint.edges();
        let strips = [first, second].map(|[x, y]| {
            let length = libm::sqrt(x * x + y * y);
            if length > 0.0 {
                let across = [(-y / length) as f32, (x / length) as f32];
                (across, 0.5 * area / length)
            } else {
                ([0.0; 2], 0.0)
            }
        });
        let corner = |a: f64, b: f64| {
            [
                0.5 * (a * first[0] + b * second[0]),
                0.5 * (a * first[1] + b * second[1]),
            ]
        };
        let corners = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let [a, b, c, d] = corners;
        let is_thin = strips.iter().any(|(_, half)| 2.0 * half < THIN);
        Self {
            footprint,
            outline,
            across: strips.map(|(across, _)| across),
            half: strips.map(|(_, half)| half as f32),
            shares: strips.map(|(across, half)| Share::new(across, half as f32)),
            sides: [
                Side::new(a, b),
                Side::new(b, c),
                Side::new(c, d),
                Side::new(d, a),
            ],
            is_wide: strips
                .iter()
                .all(|([x, y], half)| *half > 0.5 * f64::from(x.abs() + y.abs()) + 1e-3),
            is_exact: exact || is_thin || outline.is_none(),
            most_blurred: if exact { 0.0 } else { (blur * area) as f32 },
            extent: extent.map(|extent| extent as f32),
            slack: SLACK * ((extent[0] + extent[1]) as f32 + 1024.0),
            // Too thin a footprint has no texel inside: its cut ones are weighed as they are.
            unit: if outline.is_some() {
                footprint.texel_weight()
            } else {
                1.0
            },
        }
    }

    /// How the box `place` lies: beyond the footprint if the first number is above 0, wholly inside if the second is at most 0.
    #[inline(always)]
    pub fn place(&self, place: Place) -> [f32; 2] {
        self.relation(place, 0.0, 0.0)
    }

    /// The exact weight of the texel in `column` and `row`, tile copies counted on, in units of [`Region::unit`].
    #[inline(never)]
    fn exact(&self, column: i64, row: i64) -> f32 {
        let weight = match self.outline {
            Some(outline) => {
                outline.row(self.footprint, row).weight(column) * self.footprint.area()
            }
            None => {
                let low = [column as f64, row as f64];
                self.footprint.weight(&TexelBox {
                    low,
                    high: [low[0] + 1.0, low[1] + 1.0],
                })
            }
        };
        weight as f32
    }

    /// The weights, in double precision, of texels whose bit is set in `wanted`; 0 of others.
    fn exact_weights(
        &self,
        texels: &Texels,
        origin: &Origin,
        first: [u8; 2],
        wanted: u32,
    ) -> Lanes {
        let mut weights = [0.0; LANES];
        let mut rest = wanted;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            // Whole numbers below 128.
            let column = get(&texels.x, lane) as i64 + i64::from(first[0]) + origin.texel[0];
            let row = get(&texels.y, lane) as i64 + i64::from(first[1]) + origin.texel[1];
            set(&mut weights, lane, self.exact(column, row));
        }
        weights
    }
}

impl Region for BoxRegion<'_> {
    const HAS_TAIL: bool = false;

    fn weight_error(&self, _: Place, _: f32) -> f32 {
        1.0
    }

    #[inline(always)]
    fn relation(&self, place: Place, _: f32, _: f32) -> [f32; 2] {
        let [[a_x, a_y], [b_x, b_y]] = self.across;
        let Place {
            x,
            y,
            half_x,
            half_y,
        } = place;
        let a = (x * a_x + y * a_y).abs() - self.half[0];
        let b = (x * b_x + y * b_y).abs() - self.half[1];
        let reach_a = half_x * a_x.abs() + half_y * a_y.abs();
        let reach_b = half_x * b_x.abs() + half_y * b_y.abs();
        let outside = max(
            max(a - reach_a, b - reach_b),
            max(
                x.abs() - half_x - self.extent[0],
                y.abs() - half_y - self.extent[1],
            ),
        );
        let inside = max(a + reach_a, b + reach_b);
        [outside - self.slack, inside + self.slack]
    }

    /// Between each pair of sides: of texels spread evenly to √3 deviations to either side of their mean.
    #[inline(always)]
    fn cluster_weight(&self, place: Place, spread: Spread, _: f32) -> [f32; 2] {
        let (x, y) = (place.x + spread.mean[0], place.y + spread.mean[1]);
        let variance = 8.0 * spread.variance;
        let (xx, yy) = (
            variance * place.half_x * place.half_x,
            variance * place.half_y * place.half_y,
        );
        let share = |[a_x, a_y]: [f32; 2], half: f32| {
            let distance = (x * a_x + y * a_y).abs();
            let scale =
                0.288_675_1 * inverse_root(a_x * a_x * xx + a_y * a_y * yy + TEXEL_VARIANCE);
            let near = unit(0.5 + (half - distance) * scale);
            let far = unit(0.5 + (half + distance) * scale);
            near + far - 1.0
        };
        let [first, second] = self.across;
        let weight = share(first, self.half[0]) * share(second, self.half[1]);
        [max(weight, 0.0), 0.0]
    }

    #[inline(always)]
    fn most_blurred(&self) -> f32 {
        self.most_blurred
    }

    #[inline(always)]
    fn weights(
        &self,
        texels: &Texels,
        origin: &Origin,
        first: [u8; 2],
        count: u32,
        weights: &mut Lanes,
    ) {
        let (low_x, low_y) = (
            origin.offset[0] + f32::from(first[0]),
            origin.offset[1] + f32::from(first[1]),
        );
        if self.is_exact {
            let mut met = 0;
            for lane in 0..LANES {
                let place = Place {
                    x: low_x + texels.x[lane] + 0.5,
                    y: low_y + texels.y[lane] + 0.5,
                    half_x: 0.5,
                    half_y: 0.5,
                };
                let [outside, _] = self.relation(place, 0.0, 0.0);
                let is_met = (outside <= 0.0) & (texels.distances[lane] <= LEAST_TERM);
                met |= if is_met { BITS[lane] } else { 0 };
            }
            *weights = self.exact_weights(texels, origin, first, first_bits(count) & met);
            return;
        }
        if self.is_wide {
            let [[a_x, a_y], [b_x, b_y]] = self.across;
            let [a_share, b_share] = self.shares;
            let mut corners = 0;
            for lane in 0..LANES {
                let (x, y) = (low_x + texels.x[lane] + 0.5, low_y + texels.y[lane] + 0.5);
                let a = a_share.of(x * a_x + y * a_y);
                let b = b_share.of(x * b_x + y * b_y);
                let share = a * b;
                weights[lane] = share;
                // Where a side of either pair may cut the texel, so that a product of shares is not its area.
                let is_corner = (max(a, b) < WHOLE_SHARE) & (share > 0.0);
                corners |= if is_corner { BITS[lane] } else { 0 };
            }
            if corners & first_bits(count) == 0 {
                return;
            }
        }
        let sides = self.sides;
        for lane in 0..LANES {
            let (x, y) = (low_x + texels.x[lane], low_y + texels.y[lane]);
            let [a, b, c, d] = &sides;
            let area = a.area(x, y) + b.area(x, y) + c.area(x, y) + d.area(x, y);
            weights[lane] = unit(area.abs());
        }
    }

    fn unit(&self) -> f64 {
        self.unit
    }
}
