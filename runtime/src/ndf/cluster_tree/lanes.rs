//! Sixteen children of a node, or texels of a leaf, at once: loops over arrays of sixteen that a compiler turns into vector
//! instructions.
#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

pub(super) use crate::lanes::{
    BITS, LANES, Lanes, exponential, first_bits, inverse_root, least, max, min, unit,
};

use super::lobe::Lobe;
use super::walk::Limits;
use glintbake_format::records::{ClusterLeaf, ClusterNode, FineBits, LeafBits};

/// Texels of leaves that are opened anyway count down to e^-this.
pub(super) const LEAST_TERM: f32 = 40.0;

/// A box of normals, in a frame whose origin is the half vector: where it begins, and a 255th of its sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct NormalBox {
    pub low: [f32; 2],
    pub step: [f32; 2],
}

impl NormalBox {
    pub const NONE: Self = Self {
        low: [0.0; 2],
        step: [0.0; 2],
    };

    /// The box of child `lane` of `node`, whose own is this.
    #[inline(always)]
    pub fn child(&self, node: &ClusterNode, lane: usize) -> Self {
        const SHARE: f32 = 1.0 / 255.0;
        let lane = lane % LANES;
        let of = |bytes: &[u8; LANES]| f32::from(bytes[lane]);
        let (from_s, from_t) = (of(&node.low_s), of(&node.low_t));
        Self {
            low: [
                self.low[0] + from_s * self.step[0],
                self.low[1] + from_t * self.step[1],
            ],
            step: [
                (of(&node.high_s) - from_s) * self.step[0] * SHARE,
                (of(&node.high_t) - from_t) * self.step[1] * SHARE,
            ],
        }
    }

    /// Its sides.
    #[inline(always)]
    pub fn extent(&self) -> [f32; 2] {
        self.step.map(|step| 255.0 * step)
    }
}

/// What the normals of a node's children say.
#[derive(Clone, Copy, Debug)]
pub(super) struct Normals {
    /// Half the squared distance of each child's box of normals from the origin.
    pub distances: Lanes,
    /// Those near enough for the limits.
    pub alive: u32,
    /// Those that may be taken as a Gaussian, as far as their normals go.
    pub narrow: u32,
}

/// How the normals of `node`'s children lie, whose own box is `own`.
#[inline(always)]
pub(super) fn normals<L: Lobe>(
    node: &ClusterNode,
    own: NormalBox,
    lobe: L,
    limits: Limits,
) -> Normals {
    const HALF: f32 = 0.5 / 255.0;
    let mut distances = [0.0; LANES];
    let (mut alive, mut narrow) = (0, 0);
    let [[low_s, low_t], [step_s, step_t]] = [own.low, own.step];
    for lane in 0..LANES {
        let from_s = low_s + f32::from(node.low_s[lane]) * step_s;
        let to_s = low_s + f32::from(node.high_s[lane]) * step_s;
        let from_t = low_t + f32::from(node.low_t[lane]) * step_t;
        let to_t = low_t + f32::from(node.high_t[lane]) * step_t;
        let s = max(max(from_s, -to_s), 0.0);
        let t = max(max(from_t, -to_t), 0.0);
        let distance = 0.5 * (s * s + t * t);
        distances[lane] = distance;
        alive |= if distance <= limits.exponent {
            BITS[lane]
        } else {
            0
        };
        let (side_s, side_t) = (to_s - from_s, to_t - from_t);
        let deviation_s = f32::from(node.deviation_s[lane]) * HALF * side_s;
        let deviation_t = f32::from(node.deviation_t[lane]) * HALF * side_t;
        let most = max(deviation_s * deviation_s, deviation_t * deviation_t);
        let side = 0.5 * max(side_s, side_t);
        let limit = lobe.most_variance(limits.variance, [from_s, from_t], [to_s, to_t]);
        let excess = max(most - limit, most * side * side - limits.tail);
        narrow |= if excess <= 0.0 { BITS[lane] } else { 0 };
    }
    Normals {
        distances,
        alive,
        narrow,
    }
}

/// What a node says of one child's normals as a whole, in the node's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    pub mean: [f32; 2],
    /// Variance of s, covariance, variance of t.
    pub covariance: [f32; 3],
}

impl Moments {
    /// Of child `lane` of `node`, whose box is `own`.
    #[inline(always)]
    pub fn of(node: &ClusterNode, lane: usize, own: NormalBox) -> Self {
        const SHARE: f32 = 1.0 / 255.0;
        let lane = lane % LANES;
        let [[low_s, low_t], [step_s, step_t]] = [own.low, own.step];
        let (from_s, from_t) = (f32::from(node.low_s[lane]), f32::from(node.low_t[lane]));
        let side_s = (f32::from(node.high_s[lane]) - from_s) * step_s;
        let side_t = (f32::from(node.high_t[lane]) - from_t) * step_t;
        let deviation_s = f32::from(node.deviation_s[lane]) * (0.5 * SHARE) * side_s;
        let deviation_t = f32::from(node.deviation_t[lane]) * (0.5 * SHARE) * side_t;
        let correlation = (f32::from(node.correlation[lane]) - 127.0) * (1.0 / 127.0);
        Self {
            mean: [
                low_s + from_s * step_s + f32::from(node.mean_s[lane]) * SHARE * side_s,
                low_t + from_t * step_t + f32::from(node.mean_t[lane]) * SHARE * side_t,
            ],
            covariance: [
                deviation_s * deviation_s,
                correlation * deviation_s * deviation_t,
                deviation_t * deviation_t,
            ],
        }
    }
}

/// Where a tile lies: the offset of its first texel from wherever places are counted, and texels to a stored unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub offset: [f32; 2],
    pub unit: f32,
}

/// Middle and half sides of a box of texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub x: f32,
    pub y: f32,
    pub half_x: f32,
    pub half_y: f32,
}

impl Place {
    /// The box of positions of child `lane` of `node`, in a tile that lies at `frame`.
    #[inline(always)]
    pub fn of(node: &ClusterNode, lane: usize, frame: Frame) -> Self {
        let lane = lane % LANES;
        let half = 0.5 * frame.unit;
        let (from_x, to_x) = (f32::from(node.low_x[lane]), f32::from(node.high_x[lane]));
        let (from_y, to_y) = (f32::from(node.low_y[lane]), f32::from(node.high_y[lane]));
        Self {
            x: frame.offset[0] + half * (from_x + to_x + 1.0),
            half_x: half * (to_x - from_x + 1.0),
            y: frame.offset[1] + half * (from_y + to_y + 1.0),
            half_y: half * (to_y - from_y + 1.0),
        }
    }
}

/// How the texels of a cluster lie in its box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    /// Mean place from the middle of the box, in texels.
    pub mean: [f32; 2],
    /// Mean of the variances of column and row, as a share of the squares of the box's sides added up.
    pub variance: f32,
}

impl Spread {
    /// That of child `lane` of `node`, whose box is `place`.
    #[inline(always)]
    pub fn of(node: &ClusterNode, lane: usize, place: Place) -> Self {
        const SHARE: f32 = 2.0 / 255.0;
        let lane = lane % LANES;
        let deviation = f32::from(node.deviation_xy[lane] & 63) * (1.0 / 63.0);
        Self {
            mean: [
                (f32::from(node.mean_x[lane]) * SHARE - 1.0) * place.half_x,
                (f32::from(node.mean_y[lane]) * SHARE - 1.0) * place.half_y,
            ],
            variance: deviation * deviation * 0.125,
        }
    }
}

/// The texels of a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texels {
    /// Column and row from the leaf's first.
    pub x: Lanes,
    pub y: Lanes,
    /// Normals, in the frame of the leaf's box.
    pub s: Lanes,
    pub t: Lanes,
    /// Half the squared distance of each from the origin; endless for those that are not there.
    pub distances: Lanes,
}

impl Texels {
    pub const NONE: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        s: [0.0; LANES],
        t: [0.0; LANES],
        distances: [0.0; LANES],
    };

    /// Keeps the normal of texel `lane`, if its bit is set in `there`; returns its bit if it is at most `limit` away.
    #[inline(always)]
    fn keep(&mut self, lane: usize, [s, t]: [f32; 2], there: u32, limit: f32) -> u32 {
        self.s[lane] = s;
        self.t[lane] = t;
        let distance = if BITS[lane] & there != 0 {
            0.5 * (s * s + t * t)
        } else {
            f32::INFINITY
        };
        self.distances[lane] = distance;
        if distance <= limit { BITS[lane] } else { 0 }
    }

    /// Reads the first `count` texels of a narrow leaf in the box `own`; returns those at most `limit` away.
    #[inline(always)]
    pub fn read_narrow(
        &mut self,
        leaf: &ClusterLeaf,
        bits: LeafBits,
        own: NormalBox,
        count: u32,
        limit: f32,
    ) -> u32 {
        let share = 255.0 / bits.most() as f32;
        let (step_s, step_t) = (own.step[0] * share, own.step[1] * share);
        let [low_s, low_t] = own.low;
        let (to_y, to_s) = (bits.x & 7, (bits.x + bits.y) & 15);
        let to_t = (to_s + bits.normal) & 31;
        let (mask_x, mask_y) = ((1_u32 << to_y) - 1, (1_u32 << (bits.y & 7)) - 1);
        let mask = bits.most();
        let (mut near, there) = (0, first_bits(count));
        for lane in 0..LANES {
            let word = leaf.0[lane].get();
            self.x[lane] = (word & mask_x) as i32 as f32;
            self.y[lane] = ((word >> to_y) & mask_y) as i32 as f32;
            let s = low_s + ((word >> to_s) & mask) as i32 as f32 * step_s;
            let t = low_t + ((word >> to_t) & mask) as i32 as f32 * step_t;
            near |= self.keep(lane, [s, t], there, limit);
        }
        near
    }

    /// Likewise of a wide leaf, of which `fine` has the lower bits.
    #[inline(always)]
    pub fn read_wide(
        &mut self,
        leaf: &ClusterLeaf,
        fine: &FineBits,
        bits: LeafBits,
        own: NormalBox,
        count: u32,
        limit: f32,
    ) -> u32 {
        let share = 255.0 / (bits.most() as f32 * 16.0 + 15.0);
        let (step_s, step_t) = (own.step[0] * share, own.step[1] * share);
        let [low_s, low_t] = own.low;
        let (to_y, to_s) = (bits.x & 7, (bits.x + bits.y) & 15);
        let to_t = (to_s + bits.normal) & 31;
        let (mask_x, mask_y) = ((1_u32 << to_y) - 1, (1_u32 << (bits.y & 7)) - 1);
        let mask = bits.most();
        let (mut near, there) = (0, first_bits(count));
        for lane in 0..LANES {
            let word = leaf.0[lane].get();
            let finer = u32::from(fine.0[lane]);
            self.x[lane] = (word & mask_x) as i32 as f32;
            self.y[lane] = ((word >> to_y) & mask_y) as i32 as f32;
            let whole_s = ((word >> to_s) & mask) << 4 | finer & 15;
            let whole_t = ((word >> to_t) & mask) << 4 | finer >> 4;
            let s = low_s + whole_s as i32 as f32 * step_s;
            let t = low_t + whole_t as i32 as f32 * step_t;
            near |= self.keep(lane, [s, t], there, limit);
        }
        near
    }

    /// Likewise of a leaf with a palette, in a frame of which `origin` is the origin and `scale` the unit; columns and rows are
    /// those of the tile.
    #[inline(always)]
    pub fn read_palette(
        &mut self,
        leaf: &ClusterLeaf,
        origin: [f64; 2],
        scale: f64,
        count: u32,
        limit: f32,
    ) -> u32 {
        const UNIT: f64 = glintbake_format::records::PALETTE_UNIT;
        let mut colours = [0.0_f32; 8];
        for at in 0..8 {
            let component = f64::from(leaf.0[at].get() as i32) * UNIT;
            colours[at] = ((component - origin[at % 2]) * scale) as f32;
        }
        let mut entries = [0_u32; LANES];
        for pair in 0..8 {
            let word = leaf.0[8 + pair].get();
            entries[2 * pair] = word & 0xFFFF;
            entries[2 * pair + 1] = word >> 16;
        }
        let [s0, t0, s1, t1, s2, t2, s3, t3] = colours;
        let (mut near, there) = (0, first_bits(count));
        for lane in 0..LANES {
            let entry = entries[lane];
            let (is_odd, is_upper) = (entry & 1 != 0, entry & 2 != 0);
            let (low_s, high_s) = (if is_odd { s1 } else { s0 }, if is_odd { s3 } else { s2 });
            let (low_t, high_t) = (if is_odd { t1 } else { t0 }, if is_odd { t3 } else { t2 });
            let s = if is_upper { high_s } else { low_s };
            let t = if is_upper { high_t } else { low_t };
            self.x[lane] = ((entry >> 2) & 63) as i32 as f32;
            self.y[lane] = ((entry >> 8) & 63) as i32 as f32;
            near |= self.keep(lane, [s, t], there, limit);
        }
        near
    }
}

/// Lane `lane` of `lanes`.
#[inline(always)]
pub(super) fn get(lanes: &Lanes, lane: usize) -> f32 {
    lanes[lane % LANES]
}

/// Sets lane `lane` of `lanes`.
#[inline(always)]
pub(super) fn set(lanes: &mut Lanes, lane: usize, value: f32) {
    lanes[lane % LANES] = value;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_and_roots_are_within_what_they_say() {
        for step in 0..8000 {
            let x = -0.01 * step as f32;
            let exact = libm::exp(f64::from(x));
            let error = (f64::from(exponential(x)) - exact).abs() / exact;
            assert!(error < 3e-7 + 1.2e-7 * f64::from(-x), "{x}: {error}");
        }
        for step in -60..60 {
            let x = libm::exp(f64::from(step)) as f32;
            let exact = 1.0 / libm::sqrt(f64::from(x));
            assert!(
                (f64::from(inverse_root(x)) / exact - 1.0).abs() < 3e-7,
                "{x}"
            );
        }
        assert!(exponential(f32::NEG_INFINITY) < 1e-34);
    }
}
