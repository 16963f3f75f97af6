//! Quick tests of many squares of one size against a footprint.

use super::Parallelogram;
use super::probe::Relation;

/// A footprint as seen from one tile, ready to be tested against squares of texels of one size.
///
/// In f32, which vector instructions hold twice as many of: whatever f32 cannot tell is called crossing, and crossing
/// squares are looked at texel by texel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SquareProbe {
    /// From a square's corner to the footprint's centre, negated: add the corner's column and row.
    offset: [f32; 2],
    edges: [[f32; 2]; 2],
    /// Distances from each centre line, times its edge's length, beyond which a square's centre is outside.
    outside: [f32; 2],
    /// The same below which the square lies between the two sides.
    inside: [f32; 2],
    /// Distances along the axes beyond which it is outside.
    extent: [f32; 2],
}

/// Bound on the relative error of the few f32 operations behind a distance, with room to spare.
const SLACK: f64 = 1e-6;

impl SquareProbe {
    /// Tests of squares of `side` texels against `footprint`; their corners have coordinates of at most `reach`.
    pub fn new(footprint: &Parallelogram, side: f64, reach: f64) -> Self {
        let half = 0.5 * side;
        let [x, y] = footprint.extent;
        // A square that is not beyond the bounding box has a centre this near the footprint's, and both are known to
        // f32's precision of this and of `reach`.
        let error = [x, y].map(|extent| SLACK * (extent + side + reach));
        let mut probe = Self {
            offset: [0, 1].map(|axis| {
                let at = |pair: [f64; 2]| if axis == 0 { pair[0] } else { pair[1] };
                (half - at(footprint.cell) - at(footprint.centre)) as f32
            }),
            edges: [footprint.edge_1, footprint.edge_2].map(|edge| edge.map(|x| x as f32)),
            outside: [0.0; 2],
            inside: [0.0; 2],
            extent: [(x + half + error[0]) as f32, (y + half + error[1]) as f32],
        };
        let edges = [footprint.edge_1, footprint.edge_2];
        for ((outside, inside), edge) in probe.outside.iter_mut().zip(&mut probe.inside).zip(edges)
        {
            let [across, down] = edge.map(f64::abs);
            let square = half * (across + down);
            // The distance itself is rounded relative to its two products.
            let slack = 4.0 * (error[0] * down + error[1] * across);
            *outside = (0.5 * footprint.area + square + slack) as f32;
            *inside = (0.5 * footprint.area - square - slack) as f32;
        }
        probe
    }

    /// How the square with its upper left corner at texel (`column`, `row`) lies to the footprint; crossing in doubt.
    #[inline(always)]
    pub fn relation(&self, column: f32, row: f32) -> Relation {
        let x = column + self.offset[0];
        let y = row + self.offset[1];
        let [first, second] = self.edges;
        let distance_1 = (x * first[1] - y * first[0]).abs();
        let distance_2 = (x * second[1] - y * second[0]).abs();
        let outside = (x.abs() > self.extent[0])
            | (y.abs() > self.extent[1])
            | (distance_1 > self.outside[0])
            | (distance_2 > self.outside[1]);
        let inside = (distance_1 < self.inside[0]) & (distance_2 < self.inside[1]);
        Relation {
            inside,
            crossing: !(inside | outside),
        }
    }

    /// How eight squares in a row lie to the footprint, the first with its upper left corner at texel (`column`, `row`)
    /// and each `side` texels right of the one before: a bit each for those inside and those crossing, the first lowest.
    #[inline(always)]
    pub fn row_of_eight(&self, column: f32, row: f32, side: f32) -> [u8; 2] {
        let mut inside = [0; 8];
        let mut crossing = [0; 8];
        for (number, (inside, crossing)) in (0_u8..).zip(inside.iter_mut().zip(&mut crossing)) {
            let relation = self.relation(column + f32::from(number) * side, row);
            *inside = u8::from(relation.inside);
            *crossing = u8::from(relation.crossing);
        }
        [inside, crossing].map(pack)
    }
}

/// The lowest bits of eight bytes, the first byte's lowest.
#[inline(always)]
fn pack(bytes: [u8; 8]) -> u8 {
    // Each byte is multiplied to its own bit of the highest byte, and no two products meet in a bit.
    (u64::from_le_bytes(bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::overlap::{Probe, TexelBox};
    use glintbake_format::model::{Footprint, Wrap};

    #[test]
    fn packing_keeps_the_order() {
        for bits in 0..=255_u8 {
            let bytes = core::array::from_fn(|place| bits >> place & 1);
            assert_eq!(pack(bytes), bits);
        }
    }

    #[test]
    fn nothing_is_called_inside_or_outside_that_the_slow_test_calls_crossing() {
        let mut decided = [0; 2];
        for number in 0..400_u32 {
            let turn = f64::from(number) * 2.399_963;
            let length = libm::exp(f64::from(number % 40) * 0.2 - 2.0);
            let thin = libm::exp(-f64::from(number % 7));
            let footprint = Footprint {
                centre: [
                    f64::from(number) * 0.618_034 % 1.0,
                    f64::from(number) * 0.414 % 1.0,
                ],
                edge_1: [
                    length * libm::cos(turn) / 2048.0,
                    length * libm::sin(turn) / 2048.0,
                ],
                edge_2: [
                    -length * thin * libm::sin(turn) / 2048.0,
                    length * thin * libm::cos(turn) / 2048.0,
                ],
            };
            let footprint = Parallelogram::new(&footprint, 2048, 2048, Wrap::Repeat).unwrap();
            let slow = Probe::new(&footprint, None);
            for side in [8.0, 64.0] {
                let fast = SquareProbe::new(&footprint, side, 2048.0);
                let centre = footprint.bounds();
                let spread = centre.high[0] - centre.low[0] + side;
                for step in 0..200_u32 {
                    let place = |axis: usize, factor: f64| {
                        let middle = (centre.low[axis] + centre.high[axis]) * 0.5;
                        let wide = f64::from(step) * factor % 1.0 - 0.5;
                        libm::floor(middle + wide * spread).max(0.0)
                    };
                    let low = [place(0, 0.618_034), place(1, 0.324_718)];
                    let truth = slow.relation(&TexelBox {
                        low,
                        high: [low[0] + side, low[1] + side],
                    });
                    let quick = fast.relation(low[0] as f32, low[1] as f32);
                    assert!(!quick.inside || truth.inside, "{footprint:?} {low:?}");
                    if !quick.inside && !quick.crossing {
                        assert!(!truth.inside && !truth.crossing, "{footprint:?} {low:?}");
                    }
                    decided[0] += u32::from(quick.inside);
                    decided[1] += u32::from(!quick.crossing && !quick.inside);
                }
            }
        }
        assert!(decided[0] > 1000 && decided[1] > 1000, "{decided:?}");
    }
}
