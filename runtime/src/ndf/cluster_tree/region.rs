//! The footprint as nodes and leaves see it: which boxes of texels it misses, covers or cuts, and what it weighs them.
//!
//! Boxes are tested in single precision relative to the footprint's centre, with slack for all rounding: what is in doubt counts
//! as cut. A texel that is cut by one side has a share in closed form, all sixteen of a leaf at once; those at corners, and of
//! footprints narrower than a texel, are weighed in double precision.

use super::lanes::{Child, LANES, Lanes, Places, Texels, each, get, max, set};
use crate::overlap::{GaussianFootprint, Outline, Parallelogram, TexelBox};

/// Rounding of a coordinate relative to the footprint's or tile's size, with a margin.
const SLACK: f32 = 2e-6;

/// A tile of the tree as the footprint sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    /// First column and row, tile copies counted on.
    pub texel: [i64; 2],
    /// The same relative to the footprint's centre, in texels.
    pub offset: [f32; 2],
}

/// How sixteen boxes lie: a bit each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Relations {
    /// May hold weight.
    pub meets: u32,
    /// All its texels have one weight.
    pub inside: u32,
}

/// A footprint.
pub(super) trait Region {
    /// Whether texels beyond those that are met have weight.
    const HAS_TAIL: bool;

    /// How far the mean product of weight and term of a cluster's texels can be from `weight` times their mean term, as a share
    /// of the greatest term, in units of [`unit`](Self::unit).
    fn weight_error(&self, child: &Child, offset: [f32; 2], unit: f32, weight: f32) -> f32;

    /// How boxes lie whose normals are at least `exponents` away; those beyond `limit` in all are missed.
    fn relations(&self, places: &Places, exponents: &Lanes, limit: f32) -> Relations;

    /// The mean weight of the cluster that `child` tells of, in a tile at `offset` with positions in `unit` texels, if it hardly
    /// depends on where the cluster's texels lie, or `always`; `exponent` is the least of its normals. Not asked of a cluster
    /// that is inside.
    fn cluster_weight(
        &self,
        child: &Child,
        offset: [f32; 2],
        unit: f32,
        exponent: f32,
        always: bool,
    ) -> Option<f32>;

    /// What texels weigh, in units of [`unit`](Self::unit), those whose bit is set in `wanted`; others any number.
    fn weights(&self, texels: &Texels, origin: &Origin, first: [u8; 2], wanted: u32) -> Lanes;

    /// The weight of a texel that counts 1 in sums.
    fn unit(&self) -> f64;
}

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
            scale: 1.0 / (long * short),
        }
    }

    /// Of the texel whose middle is at `distance` from the line half-way between the sides.
    ///
    /// With R(x) = max(x, 0)² / 2, a line that has come d across a unit square, of long + short in all, has behind it
    /// `(R(d) - R(d - short) - R(d - long)) / (long short)`, up to the far corner.
    #[inline(always)]
    fn of(&self, distance: f32) -> f32 {
        let depth = self.depth - distance.abs();
        let whole = self.long + self.short;
        let d = if depth < whole { depth } else { whole };
        let ramp = |x: f32| {
            let x = max(x, 0.0);
            0.5 * x * x
        };
        (ramp(d) - ramp(d - self.short) - ramp(d - self.long)) * self.scale
    }
}

/// A parallelogram.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxRegion<'a> {
    pub footprint: &'a Parallelogram,
    pub outline: Option<&'a Outline>,
    /// Unit vectors across each pair of sides; zero for a side without length.
    across: [[f32; 2]; 2],
    /// Half the distance of each pair of sides.
    half: [f32; 2],
    /// Half the sides of the bounding box.
    extent: [f32; 2],
    /// The share of a texel between each pair of sides.
    shares: [Share; 2],
    /// Whether no texel meets both sides of a pair, and shares will do.
    is_wide: bool,
    /// Greatest coordinate that is met, for slack.
    size: f32,
    unit: f64,
}

impl<'a> BoxRegion<'a> {
    /// `footprint`, which has the outline `outline`; with all texels that are cut weighed in double precision if `exact`.
    pub fn new(footprint: &'a Parallelogram, outline: Option<&'a Outline>, exact: bool) -> Self {
        let bounds = footprint.bounds();
        let extent = [
            0.5 * (bounds.high[0] - bounds.low[0]),
            0.5 * (bounds.high[1] - bounds.low[1]),
        ];
        let area = footprint.area();
        let strips = footprint.edges().map(|[x, y]| {
            let length = libm::sqrt(x * x + y * y);
            if length > 0.0 {
                let across = [(-y / length) as f32, (x / length) as f32];
                (across, (0.5 * area / length) as f32)
            } else {
                ([0.0; 2], 0.0)
            }
        });
        Self {
            footprint,
            outline,
            across: strips.map(|(across, _)| across),
            half: strips.map(|(_, half)| half),
            shares: strips.map(|(across, half)| Share::new(across, half)),
            is_wide: !exact
                && outline.is_some()
                && strips
                    .iter()
                    .all(|([x, y], half)| *half > 0.5 * (x.abs() + y.abs()) + 1e-3),
            extent: extent.map(|extent| extent as f32),
            size: (extent[0] + extent[1]) as f32 + 1024.0,
            // Too thin a footprint has no texel inside: its cut ones are weighed as they are.
            unit: if outline.is_some() {
                footprint.texel_weight()
            } else {
                1.0
            },
        }
    }

    /// The exact weight of the texel in `column` and `row`, tile copies counted on, in units of [`Region::unit`].
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

    #[inline(always)]
    fn lanes(&self, places: &Places) -> (Lanes, Lanes) {
        let [[a_x, a_y], [b_x, b_y]] = self.across;
        // How far inside the farthest corner, and how far outside the nearest, lies of either pair of sides.
        let slack = SLACK * self.size;
        let mut inside = [0.0; LANES];
        let outside = each(|lane| {
            let (x, y) = (get(&places.x, lane), get(&places.y, lane));
            let (half_x, half_y) = (get(&places.half_x, lane), get(&places.half_y, lane));
            let a = (x * a_x + y * a_y).abs();
            let b = (x * b_x + y * b_y).abs();
            let reach_a = half_x * a_x.abs() + half_y * a_y.abs();
            let reach_b = half_x * b_x.abs() + half_y * b_y.abs();
            let strips = max(a - reach_a - self.half[0], b - reach_b - self.half[1]);
            let bounds = max(
                x.abs() - half_x - self.extent[0],
                y.abs() - half_y - self.extent[1],
            );
            max(strips, bounds) - slack
        });
        for (lane, inside) in inside.iter_mut().enumerate() {
            let (x, y) = (get(&places.x, lane), get(&places.y, lane));
            let (half_x, half_y) = (get(&places.half_x, lane), get(&places.half_y, lane));
            let a = (x * a_x + y * a_y).abs() + half_x * a_x.abs() + half_y * a_y.abs();
            let b = (x * b_x + y * b_y).abs() + half_x * b_x.abs() + half_y * b_y.abs();
            *inside = max(a - self.half[0], b - self.half[1]) + slack;
        }
        (outside, inside)
    }
}

impl Region for BoxRegion<'_> {
    const HAS_TAIL: bool = false;

    fn weight_error(&self, _: &Child, _: [f32; 2], _: f32, _: f32) -> f32 {
        1.0
    }

    #[inline(always)]
    fn relations(&self, places: &Places, _: &Lanes, _: f32) -> Relations {
        let (outside, inside) = self.lanes(places);
        let inside = if self.outline.is_some() {
            super::lanes::at_most(&inside, 0.0)
        } else {
            0
        };
        Relations {
            meets: super::lanes::at_most(&outside, 0.0),
            inside,
        }
    }

    #[inline(always)]
    fn cluster_weight(&self, _: &Child, _: [f32; 2], _: f32, _: f32, _: bool) -> Option<f32> {
        None
    }

    #[inline(always)]
    fn weights(&self, texels: &Texels, origin: &Origin, first: [u8; 2], wanted: u32) -> Lanes {
        let [first_x, first_y] = first.map(f32::from);
        let corner = [
            origin.offset[0] + first_x + 0.5,
            origin.offset[1] + first_y + 0.5,
        ];
        let (mut both, mut weights) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let x = corner[0] + get(&texels.x, lane);
            let y = corner[1] + get(&texels.y, lane);
            let a = self.shares[0].of(x * self.across[0][0] + y * self.across[0][1]);
            let b = self.shares[1].of(x * self.across[1][0] + y * self.across[1][1]);
            set(&mut weights, lane, a * b);
            // Negative where a side of either pair may cut the texel, so that a product of shares is not its area.
            set(&mut both, lane, max(a, b) - WHOLE_SHARE);
        }
        let whole = !super::lanes::at_most(&both, 0.0);
        let any = !super::lanes::at_most(&weights, 0.0);
        // Of a narrow footprint the exact weight also tells what is outside.
        let mut corners = if self.is_wide {
            any & wanted & !whole
        } else {
            wanted
        };
        while corners != 0 {
            let lane = corners.trailing_zeros() as usize;
            corners &= corners - 1;
            // Whole numbers below 128.
            let column = get(&texels.x, lane) as i64 + i64::from(first[0]) + origin.texel[0];
            let row = get(&texels.y, lane) as i64 + i64::from(first[1]) + origin.texel[1];
            set(&mut weights, lane, self.exact(column, row));
        }
        weights
    }

    fn unit(&self) -> f64 {
        self.unit
    }
}

/// A Gaussian.
#[derive(Clone, Copy, Debug)]
pub(super) struct GaussianRegion<'a> {
    footprint: &'a GaussianFootprint,
    /// `|L x|²` is the squared distance from the centre in standard deviations: rows of L, of the Gaussian and a texel convolved.
    root: [[f32; 2]; 2],
    /// Covariance of the Gaussian and a texel convolved: xx, yy, xy.
    covariance: [f32; 3],
    /// Root of its determinant.
    area: f32,
    /// Whether the convolution is a texel's weight; else that is integrated.
    is_smooth: bool,
    /// How far the exponent may range over a cluster that is taken as a whole.
    tolerance: f32,
    unit: f64,
}

impl<'a> GaussianRegion<'a> {
    pub fn new(footprint: &'a GaussianFootprint, tolerance: f64) -> Self {
        let [xx, yy, xy] = footprint.covariance();
        // Of a texel, 1/12 in either direction.
        let texel = 1.0 / 12.0;
        let determinant = footprint.determinant_root() * footprint.determinant_root()
            + texel * (xx + yy)
            + texel * texel;
        let (xx, yy) = (xx + texel, yy + texel);
        let deviation = libm::sqrt(xx);
        let root = libm::sqrt(determinant);
        let is_smooth = footprint.is_smooth();
        Self {
            footprint,
            root: [
                [(1.0 / deviation) as f32, 0.0],
                [(-xy / (deviation * root)) as f32, (deviation / root) as f32],
            ],
            covariance: [xx as f32, yy as f32, xy as f32],
            area: root as f32,
            is_smooth,
            tolerance: tolerance as f32,
            // A texel at the peak.
            unit: if is_smooth {
                1.0 / (core::f64::consts::TAU * root)
            } else {
                1.0
            },
        }
    }

    /// Least and greatest exponents over a box.
    #[inline(always)]
    fn range(&self, x: f32, y: f32, half_x: f32, half_y: f32) -> (f32, f32) {
        let [[a, _], [b, c]] = self.root;
        let (u, v) = ((a * x).abs(), (b * x + c * y).abs());
        let (reach_u, reach_v) = (a * half_x, b.abs() * half_x + c * half_y);
        let (low_u, low_v) = (max(u - reach_u, 0.0), max(v - reach_v, 0.0));
        let (high_u, high_v) = (u + reach_u, v + reach_v);
        (
            0.5 * (low_u * low_u + low_v * low_v),
            0.5 * (high_u * high_u + high_v * high_v),
        )
    }

    /// The least exponent over a box of texels, for tiles.
    pub fn least(&self, middle: [f64; 2], half: [f64; 2]) -> f32 {
        let (least, _) = self.range(
            middle[0] as f32,
            middle[1] as f32,
            half[0] as f32,
            half[1] as f32,
        );
        least
    }
}

impl Region for GaussianRegion<'_> {
    const HAS_TAIL: bool = true;

    fn weight_error(&self, child: &Child, offset: [f32; 2], unit: f32, weight: f32) -> f32 {
        let sides = child.more.map(|more| unit * (f32::from(more) + 1.0));
        let middle = [
            offset[0] + unit * f32::from(child.first[0]) + 0.5 * sides[0],
            offset[1] + unit * f32::from(child.first[1]) + 0.5 * sides[1],
        ];
        let (least, most) = self.range(middle[0], middle[1], 0.5 * sides[0], 0.5 * sides[1]);
        let (high, low) = (
            super::lanes::exponential(-least),
            super::lanes::exponential(-most),
        );
        // Weights range from `low` to `high`, and so does their mean; term and weight may go together.
        (high - low) + max((weight - low).abs(), (high - weight).abs())
    }

    #[inline(always)]
    fn relations(&self, places: &Places, exponents: &Lanes, limit: f32) -> Relations {
        let least = each(|lane| {
            let (least, _) = self.range(
                get(&places.x, lane),
                get(&places.y, lane),
                get(&places.half_x, lane),
                get(&places.half_y, lane),
            );
            least + get(exponents, lane)
        });
        Relations {
            meets: super::lanes::at_most(&least, limit),
            inside: 0,
        }
    }

    #[inline(always)]
    fn cluster_weight(
        &self,
        child: &Child,
        offset: [f32; 2],
        unit: f32,
        exponent: f32,
        always: bool,
    ) -> Option<f32> {
        if !self.is_smooth {
            return None;
        }
        let sides = child.more.map(|more| unit * (f32::from(more) + 1.0));
        let low = [
            offset[0] + unit * f32::from(child.first[0]),
            offset[1] + unit * f32::from(child.first[1]),
        ];
        let (least, most) = self.range(
            low[0] + 0.5 * sides[0],
            low[1] + 0.5 * sides[1],
            0.5 * sides[0],
            0.5 * sides[1],
        );
        // What is small matters less.
        if !always && most - least > self.tolerance * (1.0 + 0.5 * (exponent + least)) {
            return None;
        }
        let x = low[0] + child.place[0] * sides[0];
        let y = low[1] + child.place[1] * sides[1];
        // The cluster's places as a Gaussian that is as much longer than wide as its box.
        let variance = 2.0 * child.place_variance;
        let [xx, yy, xy] = self.covariance;
        let (a, b) = (
            xx + variance * sides[0] * sides[0],
            yy + variance * sides[1] * sides[1],
        );
        let determinant = a * b - xy * xy;
        let root = super::lanes::inverse_root(determinant);
        let square = (b * x * x - 2.0 * xy * x * y + a * y * y) * root * root;
        Some(self.area * root * super::lanes::exponential(-0.5 * max(square, 0.0)))
    }

    #[inline(always)]
    fn weights(&self, texels: &Texels, origin: &Origin, first: [u8; 2], wanted: u32) -> Lanes {
        if self.is_smooth {
            let [[a, _], [b, c]] = self.root;
            let corner = [
                origin.offset[0] + f32::from(first[0]) + 0.5,
                origin.offset[1] + f32::from(first[1]) + 0.5,
            ];
            return each(|lane| {
                let x = corner[0] + get(&texels.x, lane);
                let y = corner[1] + get(&texels.y, lane);
                let (u, v) = (a * x, b * x + c * y);
                super::lanes::exponential(-0.5 * (u * u + v * v))
            });
        }
        each(|lane| {
            if wanted >> lane & 1 == 0 {
                return 0.0;
            }
            let column = get(&texels.x, lane) as i64 + i64::from(first[0]) + origin.texel[0];
            let row = get(&texels.y, lane) as i64 + i64::from(first[1]) + origin.texel[1];
            self.footprint.texel_weight(column, row) as f32
        })
    }

    fn unit(&self) -> f64 {
        self.unit
    }
}
