//! Exact coverage of texels by a footprint's outline, one row of texels at a time, in texture space.
//!
//! As in a scan converter with exact coverage: within a row each side of the outline is a straight cut, the texture
//! right of the left cuts and left of the right ones is covered, and the part of a texel right of a cut is the mean
//! of a clamped linear function. Nothing is clipped and no polygon is built.

use super::{Parallelogram, floor};
use core::ops::Range;

/// Least area, relative to `E (1 + E)` for a bounding box of largest side `E`, of a footprint that has an
/// [`Outline`].
///
/// Coordinates are kept relative to the centre's texel, so a side is drawn at most about `2 ε (1 + E)` beside its
/// place (ε = 2⁻⁵³). Along an outline of length at most `4 E` that moves at most `8 ε E (1 + E)` texels of coverage,
/// so the weights of all texels together are off by at most `8 ε 2¹⁰ ≈ 1e-12`. Thinner footprints are clipped in
/// parameter space, where rounding does not grow with thinness.
const LEAST_AREA: f64 = 1.0 / 1024.0;

/// One side of the outline that is not horizontal.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// The upper end, relative to the centre's texel.
    top: [f64; 2],
    bottom: [f64; 2],
    /// Change of x per texel of y.
    slope: f64,
}

impl Side {
    const NONE: Self = Self {
        top: [0.0, f64::INFINITY],
        bottom: [0.0, f64::NEG_INFINITY],
        slope: 0.0,
    };

    /// The piece of this side between `top` and `bottom`.
    fn cut(&self, top: f64, bottom: f64) -> Cut {
        let top = self.top[1].max(top);
        let bottom = self.bottom[1].min(bottom);
        let height = bottom - top;
        if height <= 0.0 {
            return Cut::NONE;
        }
        let (least, greatest) = if self.top[0] <= self.bottom[0] {
            (self.top[0], self.bottom[0])
        } else {
            (self.bottom[0], self.top[0])
        };
        // `max` and `min` also take the NaN of 0 × ∞ for an end: a side that is all but horizontal.
        let at = |y: f64| {
            (self.top[0] + (y - self.top[1]) * self.slope)
                .max(least)
                .min(greatest)
        };
        let (x, y) = (at(top), at(bottom));
        Cut {
            low: x.min(y),
            high: x.max(y),
            height,
        }
    }
}

/// The piece of a side within a row: from column `low` to `high`, relative to the centre's texel.
#[derive(Clone, Copy, Debug)]
struct Cut {
    low: f64,
    high: f64,
    height: f64,
}

impl Cut {
    const NONE: Self = Self {
        low: 0.0,
        high: 0.0,
        height: 0.0,
    };

    /// The area right of the cut and within the texel that ends at `border`.
    #[inline]
    fn right_of(&self, border: f64) -> f64 {
        if self.height <= 0.0 {
            return 0.0;
        }
        // Widths right of the cut, at its two ends, before they are clamped to the texel.
        let least = border - self.high;
        let greatest = border - self.low;
        let (from, to) = (least.clamp(0.0, 1.0), greatest.clamp(0.0, 1.0));
        let length = greatest - least;
        // The mean of the clamped width. Summing pieces whose lengths add up to `length` keeps it right however
        // short the cut is.
        let mean = if from < to {
            let ramp = (to - from) * (to + from) * 0.5;
            let full = greatest.max(1.0) - least.max(1.0);
            (ramp + full) / length
        } else {
            to
        };
        mean * self.height
    }
}

/// The sides of a footprint that is not too thin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    left: [Side; 2],
    right: [Side; 2],
    texel_weight: f64,
}

impl Outline {
    /// The outline of `footprint`, or `None` if its area is too small for its length.
    pub fn new(footprint: &Parallelogram) -> Option<Self> {
        let size = 2.0 * footprint.extent[0].max(footprint.extent[1]);
        // Written so that a point, with 0 on both sides, has none.
        if footprint.area <= LEAST_AREA * size * (1.0 + size) {
            return None;
        }
        let mut outline = Self {
            left: [Side::NONE; 2],
            right: [Side::NONE; 2],
            texel_weight: footprint.texel_weight(),
        };
        let (first, second) = (footprint.edge_1, footprint.edge_2);
        let turn = first[0] * second[1] - first[1] * second[0];
        // The copy of an edge that lies half the other edge further is shifted by -turn / 2y along x.
        let corner = |a: f64, b: f64| footprint.offset(a, b);
        let sides = [
            (first, turn, [corner(-0.5, 0.5), corner(0.5, 0.5)], 0),
            (first, -turn, [corner(-0.5, -0.5), corner(0.5, -0.5)], 0),
            (second, -turn, [corner(0.5, -0.5), corner(0.5, 0.5)], 1),
            (second, turn, [corner(-0.5, -0.5), corner(-0.5, 0.5)], 1),
        ];
        for (edge, turn, [from, to], slot) in sides {
            if edge[1] == 0.0 {
                continue;
            }
            let (top, bottom) = if edge[1] > 0.0 {
                (from, to)
            } else {
                (to, from)
            };
            let side = Side {
                top,
                bottom,
                slope: edge[0] / edge[1],
            };
            let on_the_left = (turn > 0.0) == (edge[1] > 0.0);
            let sides = if on_the_left {
                &mut outline.left
            } else {
                &mut outline.right
            };
            if let Some(place) = sides.get_mut(slot) {
                *place = side;
            }
        }
        Some(outline)
    }

    /// What `footprint`, which this is the outline of as seen from any tile, covers of row `row` of the tile.
    #[inline]
    pub fn row(&self, footprint: &Parallelogram, row: i64) -> CoveredRow {
        let top = row as f64 - footprint.cell[1];
        let bottom = top + 1.0;
        CoveredRow {
            left: self.left.map(|side| side.cut(top, bottom)),
            right: self.right.map(|side| side.cut(top, bottom)),
            origin: footprint.cell[0],
            texel_weight: self.texel_weight,
        }
    }
}

impl Outline {
    /// The least and greatest column, not rounded, that `footprint`, which this is the outline of as seen from any tile,
    /// has between rows `top` and `bottom` of the tile; the least is the greater one if it has none.
    #[inline]
    pub fn columns(&self, footprint: &Parallelogram, top: f64, bottom: f64) -> [f64; 2] {
        let (top, bottom) = (top - footprint.cell[1], bottom - footprint.cell[1]);
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        for side in &self.left {
            let cut = side.cut(top, bottom);
            if cut.height > 0.0 {
                low = low.min(cut.low);
            }
        }
        for side in &self.right {
            let cut = side.cut(top, bottom);
            if cut.height > 0.0 {
                high = high.max(cut.high);
            }
        }
        [footprint.cell[0] + low, footprint.cell[0] + high]
    }
}

/// What a footprint covers of one row of texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoveredRow {
    left: [Cut; 2],
    right: [Cut; 2],
    /// Column of the centre's texel.
    origin: f64,
    texel_weight: f64,
}

impl CoveredRow {
    /// The weight of the texel in column `column`.
    #[inline]
    pub fn weight(&self, column: i64) -> f64 {
        let border = (column as f64 - self.origin) + 1.0;
        let [first, second] = &self.left;
        let [third, fourth] = &self.right;
        let area = (first.right_of(border) + second.right_of(border))
            - (third.right_of(border) + fourth.right_of(border));
        area.clamp(0.0, 1.0) * self.texel_weight
    }

    /// The columns that may hold weight, those of them that all hold the same, and that weight.
    pub fn columns(&self) -> (Range<i64>, Range<i64>, f64) {
        let cuts = |cuts: &[Cut; 2]| {
            let mut low = f64::INFINITY;
            let mut high = f64::NEG_INFINITY;
            let mut height = 0.0;
            for cut in cuts {
                if cut.height > 0.0 {
                    low = low.min(cut.low);
                    high = high.max(cut.high);
                    height += cut.height;
                }
            }
            (low, high, height)
        };
        let (low, first, height) = cuts(&self.left);
        let (last, high, _) = cuts(&self.right);
        if low > high {
            return (0..0, 0..0, 0.0);
        }
        let origin = self.origin as i64;
        let start = origin + floor(low);
        let end = origin + floor(high) + 1;
        let even_start = (origin - floor(-first)).clamp(start, end);
        let even_end = (origin + floor(last)).clamp(even_start, end);
        (
            start..end,
            even_start..even_end,
            height.min(1.0) * self.texel_weight,
        )
    }
}
