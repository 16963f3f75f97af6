//! Sixteen children of a node, or texels of a leaf, at once: loops over arrays of sixteen that a compiler turns into vector
//! instructions.
#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use glintbake_format::records::{ClusterLeaf, ClusterNode, FineBits, LeafBits};

/// Children of a node, and texels of a leaf.
pub(super) const LANES: usize = 16;

/// One number of each child or texel.
pub(super) type Lanes = [f32; LANES];

/// Below it `e^x` is taken as that: 5.5e-36.
const LEAST_EXPONENT: f32 = -81.0;

/// The greater one; the second if one is not a number.
#[inline(always)]
pub(super) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `e^x` for x up to 0, within 3e-7 of it.
#[inline(always)]
pub(super) fn exponential(x: f32) -> f32 {
    /// 1.5 · 2²³: adding it rounds to a whole number, which is then in the low bits.
    const WHOLE: f32 = 12_582_912.0;
    let y = max(x, LEAST_EXPONENT) * core::f32::consts::LOG2_E;
    let shifted = y + WHOLE;
    let rest = (y - (shifted - WHOLE)) * core::f32::consts::LN_2;
    let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    // Taylor's series: |rest| is at most 0.35.
    let series = 1.0
        + rest
            * (1.0
                + rest
                    * (0.5
                        + rest
                            * (1.0 / 6.0
                                + rest
                                    * (1.0 / 24.0 + rest * (1.0 / 120.0 + rest * (1.0 / 720.0))))));
    series * power
}

/// `1 / √x` for x above 0, within 2e-7 of it.
#[inline(always)]
pub(super) fn inverse_root(x: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_59df_u32.wrapping_sub(x.to_bits() >> 1));
    let half = 0.5 * x;
    y *= 1.5 - half * y * y;
    y *= 1.5 - half * y * y;
    y *= 1.5 - half * y * y;
    y
}

/// A bit for each lane that is at most `limit`, the lowest for the first.
#[inline(always)]
pub(super) fn at_most(lanes: &Lanes, limit: f32) -> u32 {
    const BITS: [u32; LANES] = {
        let mut bits = [0; LANES];
        let mut lane = 0;
        while lane < LANES {
            bits[lane] = 1 << lane;
            lane += 1;
        }
        bits
    };
    let mut mask = 0;
    for lane in 0..LANES {
        mask |= if lanes[lane] <= limit { BITS[lane] } else { 0 };
    }
    mask
}

/// The least of all lanes.
#[inline(always)]
pub(super) fn least(lanes: &Lanes) -> f32 {
    let min = |a: f32, b: f32| if a < b { a } else { b };
    let mut halves = [0.0; 8];
    for lane in 0..8 {
        halves[lane] = min(lanes[lane], lanes[lane + 8]);
    }
    let mut quarters = [0.0; 4];
    for lane in 0..4 {
        quarters[lane] = min(halves[lane], halves[lane + 4]);
    }
    let [a, b, c, d] = quarters;
    min(min(a, b), min(c, d))
}

/// Half the squared distance from the origin to each child's box of normals, in a frame in which the node's box begins at `low`
/// and has 255 steps of `step`.
#[inline(always)]
pub(super) fn normal_distances(node: &ClusterNode, low: [f32; 2], step: [f32; 2]) -> Lanes {
    let mut distances = [0.0; LANES];
    for lane in 0..LANES {
        let from_s = low[0] + f32::from(node.low_s[lane]) * step[0];
        let to_s = low[0] + f32::from(node.high_s[lane]) * step[0];
        let from_t = low[1] + f32::from(node.low_t[lane]) * step[1];
        let to_t = low[1] + f32::from(node.high_t[lane]) * step[1];
        let s = max(max(from_s, -to_s), 0.0);
        let t = max(max(from_t, -to_t), 0.0);
        distances[lane] = 0.5 * (s * s + t * t);
    }
    distances
}

/// Middle and half sides of each child's box of positions, in texels from wherever `origin` is counted from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    pub x: Lanes,
    pub y: Lanes,
    pub half_x: Lanes,
    pub half_y: Lanes,
}

/// The boxes of positions of `node`'s children, in a tile that begins at `origin`, stored in units of `unit` texels.
#[inline(always)]
pub(super) fn places(node: &ClusterNode, origin: [f32; 2], unit: f32) -> Places {
    let half = 0.5 * unit;
    let mut places = Places {
        x: [0.0; LANES],
        y: [0.0; LANES],
        half_x: [0.0; LANES],
        half_y: [0.0; LANES],
    };
    for lane in 0..LANES {
        let (from, to) = (f32::from(node.low_x[lane]), f32::from(node.high_x[lane]));
        places.x[lane] = origin[0] + half * (from + to + 1.0);
        places.half_x[lane] = half * (to - from + 1.0);
        let (from, to) = (f32::from(node.low_y[lane]), f32::from(node.high_y[lane]));
        places.y[lane] = origin[1] + half * (from + to + 1.0);
        places.half_y[lane] = half * (to - from + 1.0);
    }
    places
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
}

/// The texels of a narrow leaf whose box begins at `low` and runs over `extent`.
#[inline(always)]
pub(super) fn narrow_texels(
    leaf: &ClusterLeaf,
    bits: LeafBits,
    low: [f32; 2],
    extent: [f32; 2],
) -> Texels {
    let mut texels = Texels {
        x: [0.0; LANES],
        y: [0.0; LANES],
        s: [0.0; LANES],
        t: [0.0; LANES],
    };
    let most = 1.0 / bits.most() as f32;
    let step = [extent[0] * most, extent[1] * most];
    let (to_y, to_s) = (bits.x & 7, (bits.x + bits.y) & 15);
    let to_t = (to_s + bits.normal) & 31;
    let (mask_x, mask_y) = ((1_u32 << to_y) - 1, (1_u32 << (bits.y & 7)) - 1);
    let mask = bits.most();
    for lane in 0..LANES {
        let word = leaf.0[lane].get();
        texels.x[lane] = (word & mask_x) as i32 as f32;
        texels.y[lane] = ((word >> to_y) & mask_y) as i32 as f32;
        texels.s[lane] = low[0] + ((word >> to_s) & mask) as i32 as f32 * step[0];
        texels.t[lane] = low[1] + ((word >> to_t) & mask) as i32 as f32 * step[1];
    }
    texels
}

/// The texels of a wide leaf, of which `fine` has the lower bits.
#[inline(always)]
pub(super) fn wide_texels(
    leaf: &ClusterLeaf,
    fine: &FineBits,
    bits: LeafBits,
    low: [f32; 2],
    extent: [f32; 2],
) -> Texels {
    let whole = bits.most() as f32 * 16.0 + 15.0;
    let unit = [extent[0] / whole, extent[1] / whole];
    // With this extent the narrow part steps by 16 units.
    let coarse = bits.most() as f32 * 16.0;
    let mut texels = narrow_texels(leaf, bits, low, [unit[0] * coarse, unit[1] * coarse]);
    for lane in 0..LANES {
        let byte = fine.0[lane];
        texels.s[lane] += f32::from(byte & 15) * unit[0];
        texels.t[lane] += f32::from(byte >> 4) * unit[1];
    }
    texels
}

/// The texels of a leaf with a palette, in a frame of which `origin` is the origin and `scale` the unit; columns and rows are
/// those of the tile.
pub(super) fn palette_texels(leaf: &ClusterLeaf, origin: [f64; 2], scale: f64) -> Texels {
    const UNIT: f64 = glintbake_format::records::PALETTE_UNIT;
    let mut texels = Texels {
        x: [0.0; LANES],
        y: [0.0; LANES],
        s: [0.0; LANES],
        t: [0.0; LANES],
    };
    let mut colours = [[0.0_f32; 2]; 4];
    for colour in 0..4 {
        for axis in 0..2 {
            let component = f64::from(leaf.0[2 * colour + axis].get() as i32) * UNIT;
            colours[colour][axis] = ((component - origin[axis]) * scale) as f32;
        }
    }
    for lane in 0..LANES {
        let entry = leaf.0[8 + lane / 2].get() >> (16 * (lane % 2));
        let [s, t] = colours[(entry & 3) as usize];
        texels.s[lane] = s;
        texels.t[lane] = t;
        texels.x[lane] = ((entry >> 2) & 63) as i32 as f32;
        texels.y[lane] = ((entry >> 8) & 63) as i32 as f32;
    }
    texels
}

/// What a node says of one child, beyond its box of positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Child {
    /// Where its box of normals begins, and how far it runs, in the frame of the node.
    pub low: [f32; 2],
    pub extent: [f32; 2],
    /// Mean normal.
    pub mean: [f32; 2],
    /// Variance of s, covariance, variance of t.
    pub covariance: [f32; 3],
    /// First column and row, and how many more there are.
    pub first: [u8; 2],
    pub more: [u8; 2],
    /// Mean place as a share of the box.
    pub place: [f32; 2],
    /// Mean of the variances of column and row, as a share of the squares of the box's sides added up.
    pub place_variance: f32,
    /// Kind of leaf in bits 6-7.
    pub kind: u8,
}

/// Child `lane` of `node`, whose box begins at `low` and has 255 steps of `step`.
#[inline(always)]
pub(super) fn child(node: &ClusterNode, lane: usize, low: [f32; 2], step: [f32; 2]) -> Child {
    const SHARE: f32 = 1.0 / 255.0;
    let lane = lane % LANES;
    let of = |bytes: &[u8; LANES]| f32::from(bytes[lane]);
    let (from_s, from_t) = (of(&node.low_s), of(&node.low_t));
    let own = [low[0] + from_s * step[0], low[1] + from_t * step[1]];
    let extent = [
        (of(&node.high_s) - from_s) * step[0],
        (of(&node.high_t) - from_t) * step[1],
    ];
    let deviation = [
        of(&node.deviation_s) * (0.5 * SHARE) * extent[0],
        of(&node.deviation_t) * (0.5 * SHARE) * extent[1],
    ];
    let correlation = (of(&node.correlation) - 127.0) * (1.0 / 127.0);
    let spread = f32::from(node.deviation_xy[lane] & 63) * (1.0 / 63.0);
    Child {
        low: own,
        extent,
        mean: [
            own[0] + of(&node.mean_s) * SHARE * extent[0],
            own[1] + of(&node.mean_t) * SHARE * extent[1],
        ],
        covariance: [
            deviation[0] * deviation[0],
            correlation * deviation[0] * deviation[1],
            deviation[1] * deviation[1],
        ],
        first: [node.low_x[lane], node.low_y[lane]],
        more: [
            node.high_x[lane].wrapping_sub(node.low_x[lane]),
            node.high_y[lane].wrapping_sub(node.low_y[lane]),
        ],
        place: [of(&node.mean_x) * SHARE, of(&node.mean_y) * SHARE],
        place_variance: spread * spread * 0.125,
        kind: node.deviation_xy[lane],
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

/// Sets every lane from number `count` to `value`.
#[inline(always)]
pub(super) fn set_from(lanes: &mut Lanes, count: u32, value: f32) {
    if (count as usize) < LANES {
        for lane in &mut lanes[count as usize..] {
            *lane = value;
        }
    }
}

/// Calls `make` for each lane.
#[inline(always)]
pub(super) fn each(mut make: impl FnMut(usize) -> f32) -> Lanes {
    let mut lanes = [0.0; LANES];
    for lane in 0..LANES {
        lanes[lane] = make(lane);
    }
    lanes
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
