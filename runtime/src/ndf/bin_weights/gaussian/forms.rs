//! The Gaussian over blocks and tiles: its average over a square, and which squares may stand for their texels.

use crate::overlap::{GaussianFootprint, LOST, RADIUS};
use core::f64::consts::{LOG2_E, PI, SQRT_2};
use glintbake_format::model::{BLOCK_SIDE, TILE_SIDE};

/// Squares larger than this against the Gaussian, half diagonal over least deviation, never stand for their texels: the
/// average at their centre would no longer say what they hold.
const LARGEST: f64 = 1.0;
/// Radius, in standard deviations, of what is weighed where every block stands for its texels, and the share of the
/// Gaussian beyond it, `exp(-3.7² / 2)`: as little as the tolerance already costs, for three fifths of the area.
const NEAR_RADIUS: f64 = 3.7;
const NEAR_LOST: f64 = 1.066_149e-3;
/// How much more than over a block the Gaussian may range over tiles if all of them stand for their texels: then the
/// slope over a tile is taken into account as well. At the default tolerance, from a least deviation of two tiles on.
const SLOPING: f64 = 3.5;
/// Halvings that find where squares may stand for their texels: to a thousandth of a deviation.
const HALVINGS: usize = 13;
/// Slack of every comparison in single precision, in standard deviations.
const SLACK: f64 = 2e-3;
/// Rounding of a square's distance in single precision, relative to its coordinates.
const ROUNDING: f64 = 3e-7;

/// The Gaussian averaged over squares of one size: that of covariance `Σ + side²/12 I`, but for fourth derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form {
    inverse_11: f32,
    lean: f32,
    inverse_22: f32,
    /// Average weight of a texel of the square at the centre.
    pub peak: f64,
}

impl Form {
    fn new(footprint: &GaussianFootprint, side: f64, lost: f64) -> Self {
        let [xx, yy, xy] = footprint.covariance();
        let root = footprint.determinant_root();
        let added = side * side / 12.0;
        // A sum of what is not negative: nothing cancels, however thin the Gaussian is.
        let determinant = root * root + added * (xx + yy) + added * added;
        let (root, yy) = (libm::sqrt(determinant), yy + added);
        let root_yy = libm::sqrt(yy);
        Self {
            inverse_11: (1.0 / root_yy) as f32,
            lean: (xy / yy) as f32,
            inverse_22: (root_yy / root) as f32,
            peak: 1.0 / (2.0 * PI * root * (1.0 - lost)),
        }
    }

    /// Square of the distance of (`x`, `y`) from the centre, in standard deviations.
    #[inline(always)]
    pub fn distance_squared(&self, x: f32, y: f32) -> f32 {
        let first = y * self.inverse_11;
        let second = (x - self.lean * y) * self.inverse_22;
        first * first + second * second
    }
}

impl Form {
    /// Half the slope of [`distance_squared`](Self::distance_squared) at (`x`, `y`), along x and y.
    #[inline(always)]
    pub fn slope(&self, x: f32, y: f32) -> [f32; 2] {
        let first = y * self.inverse_11 * self.inverse_11;
        let second = (x - self.lean * y) * self.inverse_22 * self.inverse_22;
        [second, first - self.lean * second]
    }
}

/// `e^(-q/2)` within 1e-5 of its value for q in [0, 170], and as at 170 beyond, where it would leave the normal numbers.
#[inline(always)]
pub(super) fn exp_half(q: f32) -> f32 {
    /// 1.5 · 2²³: adding it rounds to a whole number, which is then in the low bits.
    const WHOLE: f32 = 12_582_912.0;
    let y = q.min(170.0) * (-0.5 * LOG2_E) as f32;
    let shifted = y + WHOLE;
    let rest = y - (shifted - WHOLE);
    let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    // The series of 2^rest, in [-1/2, 1/2].
    let square = rest * rest;
    let low = (1.0 + core::f32::consts::LN_2 * rest) + square * (0.240_226_5 + 0.055_504_11 * rest);
    let high = 0.009_618_13 + 0.001_333_36 * rest;
    (low + (square * square) * high) * power
}

/// Which squares of one size may stand for their texels, by their centre's squared distance in the form of blocks, and
/// which meet the ellipse at all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    /// Up to this, and from `far` on, the square stands for its texels.
    pub near: f32,
    pub far: f32,
    /// Beyond this the square does not meet the ellipse.
    pub end: f32,
}

impl Rule {
    /// Whether all squares may.
    pub fn accepts_all(&self) -> bool {
        self.near == f32::INFINITY
    }

    /// Whether a square at squared distance `q` may stand for its texels.
    #[inline(always)]
    pub fn accepts(&self, q: f32) -> bool {
        (q <= self.near) | (q >= self.far)
    }
}

/// Forms and rules of blocks and tiles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forms {
    pub block: Form,
    pub tile: Form,
    pub block_rule: Rule,
    pub tile_rule: Rule,
    /// Radius of what is weighed, over that of the ellipse.
    pub share_of_radius: f64,
}

impl Forms {
    /// Those of `footprint` under `tolerance`, for squares up to `reach` texels from the centre on either axis.
    ///
    /// A square may stand for its texels if the Gaussian, in units of its peak, ranges over it by at most the tolerance;
    /// less if the square has more texels than the Gaussian's own area `2π √det Σ`, in proportion. Blocks of an accepted
    /// tile are always accepted, so that whoever opens a block knows that no list has counted it within a tile.
    pub fn new(footprint: &GaussianFootprint, tolerance: f64, reach: f64) -> Self {
        let least = footprint.least_deviation();
        let block_side = f64::from(BLOCK_SIDE);
        let deviation = libm::sqrt(least * least + block_side * block_side / 12.0);
        let half_diagonal = |side: u32| f64::from(side) / SQRT_2 / deviation;
        let (of_block, of_tile) = (half_diagonal(BLOCK_SIDE), half_diagonal(TILE_SIDE));
        let tolerance_of = |side: u32| {
            let share = f64::from(side * side) / (2.0 * PI * footprint.determinant_root());
            if footprint.is_smooth() {
                tolerance / share.max(1.0)
            } else {
                0.0
            }
        };
        let accepted = accepted(of_block, tolerance_of(BLOCK_SIDE));
        let (radius, lost) = match accepted {
            Accepted::All => (NEAR_RADIUS, NEAR_LOST),
            Accepted::Beyond { .. } | Accepted::None => (RADIUS, LOST),
        };
        let block = Form::new(footprint, f64::from(BLOCK_SIDE), lost);
        let tile = Form::new(footprint, f64::from(TILE_SIDE), lost);
        let spread = f64::from(block.inverse_22) * (1.0 + f64::from(block.lean).abs());
        let slack = SLACK + ROUNDING * reach * (spread + f64::from(block.inverse_11));
        let [near, far] = match accepted {
            Accepted::All => [f64::INFINITY, f64::INFINITY],
            Accepted::Beyond { near, far } => [near + slack, far - slack],
            Accepted::None => [-1.0, f64::INFINITY],
        };
        let of_all_tiles = self::accepted(of_tile, SLOPING * tolerance_of(TILE_SIDE));
        let apart = of_tile - of_block;
        let [tile_near, tile_far] =
            match (accepted, self::accepted(of_tile, tolerance_of(TILE_SIDE))) {
                (Accepted::All, _) if matches!(of_all_tiles, Accepted::All) => {
                    [f64::INFINITY, f64::INFINITY]
                }
                (Accepted::None, _) | (_, Accepted::None) => [-1.0, f64::INFINITY],
                (Accepted::All, Accepted::All) => [f64::INFINITY, f64::INFINITY],
                (Accepted::All, Accepted::Beyond { near, far }) => [near, far],
                (
                    Accepted::Beyond { near, far },
                    Accepted::Beyond {
                        near: inner,
                        far: outer,
                    },
                ) => [inner.min(near - apart), outer.max(far + apart)],
                // Cannot be: a block ranges over less than its tile.
                (Accepted::Beyond { far, .. }, Accepted::All) => [-1.0, far + apart],
            };
        let square = |distance: f64| {
            if distance < 0.0 {
                -1.0
            } else {
                (distance * distance) as f32
            }
        };
        let end = |half: f64| square((radius + half) * (1.0 + 1e-6) + slack);
        Self {
            share_of_radius: radius / RADIUS,
            block,
            tile,
            block_rule: Rule {
                near: square(near),
                far: square(far),
                end: end(of_block),
            },
            tile_rule: Rule {
                near: square(tile_near),
                far: square(tile_far),
                end: end(of_tile),
            },
        }
    }
}

/// Distances, in standard deviations, of the squares that may stand for their texels.
#[derive(Clone, Copy, Debug)]
enum Accepted {
    All,
    /// Up to `near`, if that is not negative, and from `far` on.
    Beyond {
        near: f64,
        far: f64,
    },
    None,
}

/// Where squares of the half diagonal `half`, in standard deviations, range over at most `tolerance`.
fn accepted(half: f64, tolerance: f64) -> Accepted {
    if tolerance <= 0.0 || half > LARGEST {
        return Accepted::None;
    }
    let gaussian = |distance: f64| libm::exp(-0.5 * distance * distance);
    // The Gaussian is nowhere steeper than e^(-1/2).
    if 2.0 * half * gaussian(1.0) <= tolerance {
        return Accepted::All;
    }
    let fits = |distance: f64| {
        gaussian((distance - half).max(0.0)) - gaussian(distance + half) <= tolerance
    };
    // The range rises up to a distance of 1 at least, and falls from 1 + half on.
    let (mut near, mut not_near) = (0.0, 1.0);
    let (mut not_far, mut far) = (1.0 + half, RADIUS + 4.0 * LARGEST);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (near + not_near);
        if fits(middle) {
            near = middle;
        } else {
            not_near = middle;
        }
        let middle = 0.5 * (not_far + far);
        if fits(middle) {
            far = middle;
        } else {
            not_far = middle;
        }
    }
    Accepted::Beyond {
        near: if fits(near) { near } else { -1.0 },
        far: if fits(far) { far } else { f64::INFINITY },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::model::{Footprint, Wrap};

    /// The Gaussian of deviations `long` and `short` texels, turned by `angle`, on a large map.
    fn gaussian(long: f64, short: f64, angle: f64) -> GaussianFootprint {
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let edge = |length: f64, x: f64, y: f64| [x, y].map(|part| 2.0 * length * part / 4096.0);
        let footprint = Footprint {
            centre: [0.5, 0.5],
            edge_1: edge(long, cosine, sine),
            edge_2: edge(short, -sine, cosine),
        };
        GaussianFootprint::new(&footprint, 4096, 4096, Wrap::Repeat).expect("in range")
    }

    /// The range, in units of the peak, of the Gaussian averaged over blocks over the square of `side` texels around
    /// (`x`, `y`), by points.
    fn range(gaussian: &GaussianFootprint, x: f64, y: f64, side: f64) -> f64 {
        let added = f64::from(BLOCK_SIDE * BLOCK_SIDE) / 12.0;
        let [xx, yy, xy] = gaussian.covariance();
        let (xx, yy) = (xx + added, yy + added);
        let determinant = xx * yy - xy * xy;
        let (mut least, mut greatest) = (f64::INFINITY, 0.0_f64);
        for point in 0..33 * 33 {
            let [dx, dy] =
                [point % 33, point / 33].map(|step| (f64::from(step) / 32.0 - 0.5) * side);
            let (x, y) = (x + dx, y + dy);
            let square = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant;
            let value = libm::exp(-0.5 * square);
            (least, greatest) = (least.min(value), greatest.max(value));
        }
        greatest - least
    }

    #[test]
    fn what_is_accepted_ranges_by_the_tolerance_at_most() {
        let (mut accepted, mut refused, mut close) = (0, 0, 0);
        for case in 0..3000_u32 {
            let turn = f64::from(case) * 0.618_034;
            let short = 4.0 * libm::exp(4.0 * (turn * 7.3 % 1.0));
            let long = short * libm::exp(1.5 * (turn * 3.1 % 1.0));
            let tolerance = 0.02 * libm::exp(3.0 * (turn * 5.7 % 1.0));
            let gaussian = gaussian(long, short, turn);
            let forms = Forms::new(&gaussian, tolerance, 4096.0);
            let (distance, around) = (4.0 * (turn * 11.9 % 1.0) * long, turn * 2.7);
            let (x, y) = (distance * libm::cos(around), distance * libm::sin(around));
            let q = forms.block.distance_squared(x as f32, y as f32);
            let all_tiles = forms.tile_rule.accepts_all();
            for (rule, side) in [(forms.block_rule, BLOCK_SIDE), (forms.tile_rule, TILE_SIDE)] {
                let sloping = if side == TILE_SIDE && all_tiles {
                    SLOPING
                } else {
                    1.0
                };
                let share = f64::from(side * side) / (2.0 * PI * gaussian.determinant_root());
                let allowed = sloping * tolerance / share.max(1.0);
                let range = range(&gaussian, x, y, f64::from(side));
                if rule.accepts(q) {
                    accepted += 1;
                    close += u32::from(range > 0.5 * allowed);
                    assert!(
                        range <= allowed * 1.001,
                        "{range} of {allowed}, case {case}"
                    );
                } else {
                    refused += 1;
                }
            }
        }
        // Neither side of the rule is empty, nor is it far too strict.
        assert!(
            accepted > 1000 && refused > 1000 && close > 100,
            "{accepted} {refused} {close}"
        );
    }

    #[test]
    fn the_fast_exponential_and_the_slope_are_right() {
        for step in 0..=1700_u16 {
            let q = f32::from(step) * 0.1;
            let exact = libm::exp(-0.5 * f64::from(q));
            assert!((f64::from(exp_half(q)) / exact - 1.0).abs() < 1e-5, "{q}");
        }
        assert_eq!(exp_half(1e9), exp_half(170.0));
        let form = Forms::new(&gaussian(90.0, 40.0, 0.7), 0.1, 4096.0).tile;
        for (x, y) in [(0.0, 0.0), (30.0, -70.0), (-120.0, 15.0)] {
            let [along_x, along_y] = form.slope(x, y);
            let q = |x, y| f64::from(form.distance_squared(x, y));
            let numeric = [
                (q(x + 1.0, y) - q(x - 1.0, y)) / 4.0,
                (q(x, y + 1.0) - q(x, y - 1.0)) / 4.0,
            ];
            for (slope, numeric) in [along_x, along_y].into_iter().zip(numeric) {
                assert!(
                    (f64::from(slope) - numeric).abs() < 1e-5,
                    "{slope} {numeric}"
                );
            }
        }
    }
}
