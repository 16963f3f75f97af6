//! Numbers in sixteen lanes: what loops over them are made of. Such loops, over arrays of sixteen, are for compilers to turn
//! into vector instructions.
#![expect(
    clippy::indexing_slicing,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

/// Children of a node, texels of a leaf, or lobes of a block.
pub(crate) const LANES: usize = 16;

/// One number of each.
pub(crate) type Lanes = [f32; LANES];

/// Below it `e^x` is taken as that: 5.5e-36.
const LEAST_EXPONENT: f32 = -81.0;

/// The greater one; the second if one is not a number.
#[inline(always)]
pub(crate) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `e^x` for x up to 0, within 3e-7 of it.
#[inline(always)]
pub(crate) fn exponential(x: f32) -> f32 {
    /// 1.5 · 2²³: adding it rounds to a whole number, which is then in the low bits.
    const WHOLE: f32 = 12_582_912.0;
    let y = max(x, LEAST_EXPONENT) * core::f32::consts::LOG2_E;
    let shifted = y + WHOLE;
    let rest = (y - (shifted - WHOLE)) * core::f32::consts::LN_2;
    let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    // Taylor's series, as |rest| is at most 0.35, in an order that leaves the processor something to do at once.
    let square = rest * rest;
    let low = 0.5 + rest * (1.0 / 6.0);
    let high = 1.0 / 24.0 + rest * (1.0 / 120.0) + square * (1.0 / 720.0);
    let series = 1.0 + rest + square * (low + square * high);
    series * power
}

/// `1 / √x` for x above 0, within 2e-7 of it.
#[inline(always)]
pub(crate) fn inverse_root(x: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_59df_u32.wrapping_sub(x.to_bits() >> 1));
    let half = 0.5 * x;
    y *= 1.5 - half * y * y;
    y *= 1.5 - half * y * y;
    y *= 1.5 - half * y * y;
    y
}

/// The lesser one; the second if one is not a number.
#[inline(always)]
pub(crate) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// `x` moved into 0 to 1.
#[inline(always)]
pub(crate) fn unit(x: f32) -> f32 {
    min(max(x, 0.0), 1.0)
}

/// Bit `1 << lane` of each lane.
pub(crate) const BITS: [u32; LANES] = {
    let mut bits = [0; LANES];
    let mut lane = 0;
    while lane < LANES {
        bits[lane] = 1 << lane;
        lane += 1;
    }
    bits
};

/// The lowest `count` bits, of up to 16.
#[inline(always)]
pub(crate) const fn first_bits(count: u32) -> u32 {
    (1 << (count & 31)) - 1
}

/// The least of all lanes.
#[inline(always)]
pub(crate) fn least(lanes: &Lanes) -> f32 {
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

/// The sum of all lanes, in pairs.
#[inline(always)]
pub(crate) fn sum(lanes: &Lanes) -> f32 {
    let mut eighths = [0.0; 8];
    for lane in 0..8 {
        eighths[lane] = lanes[lane] + lanes[lane + 8];
    }
    let mut quarters = [0.0; 4];
    for lane in 0..4 {
        quarters[lane] = eighths[lane] + eighths[lane + 4];
    }
    let [a, b, c, d] = quarters;
    (a + c) + (b + d)
}
