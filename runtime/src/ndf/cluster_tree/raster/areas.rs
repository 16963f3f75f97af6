//! The areas that a parallelogram shares with sixteen texels, in closed form.
#![expect(
    clippy::indexing_slicing,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use super::super::lanes::{LANES, Lanes, max};
use crate::overlap::Parallelogram;

/// Texels a side of a block.
const SIDE: usize = 4;

/// Columns of the lanes, which are the four sides of the parallelogram in each of four columns.
const COLUMNS: Lanes = [
    0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0,
];

/// Sides this narrow, in texels, are straight up: no area is behind them.
const UPRIGHT: f64 = 1e-9;

/// The least rise of a side in a column: a level one rises by this, which moves no area by more than half of it.
const LEAST_RISE: f32 = 1e-5;

#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Whether a block of texels is met, and by what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Outside,
    Inside,
    Cut,
}

/// A parallelogram about the origin, in texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Areas {
    /// The left end of each side, where it ends on the right, and its slope; each four times.
    x: Lanes,
    y: Lanes,
    right: Lanes,
    slope: Lanes,
    /// 1/2 of sides that the parallelogram is above, in the sense of rows, and -1/2 of those it is below.
    half: Lanes,
    /// Unit vectors across each pair of sides, half their distance, and half a block's reach along them.
    across: [[f32; 2]; 2],
    distance: [f32; 2],
    reach: [f32; 2],
    /// Half the sides of the bounding box.
    extent: [f32; 2],
}

impl Areas {
    /// Those of `footprint`, or `None` if it is too narrow for single precision: by less than an eighth of a texel.
    #[inline(always)]
    pub fn new(footprint: &Parallelogram) -> Option<Self> {
        /// Least distance of either pair of sides.
        const LEAST: f64 = 0.125;
        let [first, second] = footprint.edges();
        let area = footprint.area();
        let (mut across, mut distance, mut reach) = ([[0.0; 2]; 2], [0.0; 2], [0.0; 2]);
        for (pair, [x, y]) in [first, second].into_iter().enumerate() {
            let length = libm::sqrt(x * x + y * y);
            // A point, of 0 in all, is too.
            if area <= LEAST * length {
                return None;
            }
            let inverse = 1.0 / length;
            let [a, b] = [-y * inverse, x * inverse];
            across[pair] = [a as f32, b as f32];
            distance[pair] = (0.5 * area * inverse) as f32;
            reach[pair] = (0.5 * SIDE as f64 * (a.abs() + b.abs())) as f32;
        }
        let mut areas = Self {
            x: [0.0; LANES],
            y: [0.0; LANES],
            right: [0.0; LANES],
            slope: [0.0; LANES],
            half: [0.0; LANES],
            across,
            distance,
            reach,
            extent: [
                (0.5 * (first[0].abs() + second[0].abs())) as f32,
                (0.5 * (first[1].abs() + second[1].abs())) as f32,
            ],
        };
        // Each side is one edge moved by half the other, to either side.
        for (pair, (edge, other)) in [(first, second), (second, first)].into_iter().enumerate() {
            let edge = if edge[0] < 0.0 {
                edge.map(|x| -x)
            } else {
                edge
            };
            let slope = if edge[0] > UPRIGHT {
                edge[1] / edge[0]
            } else {
                0.0
            };
            // Below `edge`, going right, is where the cross product with it is positive.
            let is_below = edge[0] * other[1] - edge[1] * other[0] > 0.0;
            for (which, sign) in [0.5, -0.5].into_iter().enumerate() {
                let x = sign * other[0] - 0.5 * edge[0];
                let y = sign * other[1] - 0.5 * edge[1];
                let half = if is_below == (sign > 0.0) { 0.5 } else { -0.5 };
                let side = SIDE * (2 * pair + which);
                for lane in side..side + SIDE {
                    areas.x[lane] = x as f32;
                    areas.y[lane] = y as f32;
                    areas.right[lane] = (x + edge[0]) as f32;
                    areas.slope[lane] = slope as f32;
                    areas.half[lane] = half;
                }
            }
        }
        Some(areas)
    }

    /// How the block whose first corner is at (`x`, `y`) lies.
    #[inline(always)]
    pub fn place(&self, x: f32, y: f32) -> Place {
        /// Rounding of coordinates, which makes blocks cut that are in doubt.
        const SLACK: f32 = 1e-4;
        let half = 0.5 * SIDE as f32;
        let (x, y) = (x + half, y + half);
        let [[a_x, a_y], [b_x, b_y]] = self.across;
        let a = (x * a_x + y * a_y).abs() - self.distance[0];
        let b = (x * b_x + y * b_y).abs() - self.distance[1];
        let outside = max(
            max(a - self.reach[0], b - self.reach[1]),
            max(
                x.abs() - half - self.extent[0],
                y.abs() - half - self.extent[1],
            ),
        );
        if outside > SLACK {
            Place::Outside
        } else if max(a + self.reach[0], b + self.reach[1]) < -SLACK {
            Place::Inside
        } else {
            Place::Cut
        }
    }

    /// The area shared with each texel of the block whose first corner is at (`x`, `y`), of which texels end `room` columns
    /// and rows from there. In texels, within 2e-6 and a few units of the last place of the coordinates.
    ///
    /// Green's theorem: between rows r and r + 1 and within a column, the area above a side that runs from y₁ to y₂ over a width w
    /// is `w (M(r) - M(r + 1))`, where M(r) is the mean of max(y - r, 0), `(b² - a²) / (2 (y₂ - y₁))` with a and b the
    /// ends so cut; and the parallelogram is what lies above its far sides less what lies above the near ones.
    #[inline(always)]
    pub fn shares(&self, x: f32, y: f32, room: [f32; 2]) -> Lanes {
        let (mut low, mut high, mut scale) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let from = x + COLUMNS[lane];
            let to = min(from + 1.0, x + room[0]);
            let left = max(min(self.x[lane], to), from);
            let right = max(min(self.right[lane], to), from);
            let at_left = self.y[lane] - y + self.slope[lane] * (left - self.x[lane]);
            let at_right = self.y[lane] - y + self.slope[lane] * (right - self.x[lane]);
            // What is beyond the last row is behind all of them wherever it lies.
            let least = min(min(at_left, at_right), SIDE as f32);
            let most = max(max(at_left, at_right), least + LEAST_RISE);
            let most = if least >= SIDE as f32 {
                least + LEAST_RISE
            } else {
                most
            };
            let rise = max(most - least, 0.5 * LEAST_RISE);
            low[lane] = least;
            high[lane] = most;
            scale[lane] = self.half[lane] * (right - left) / rise;
        }
        let mut shares = [0.0; LANES];
        let levels = [
            behind(&low, &high, &scale, 0.0),
            behind(&low, &high, &scale, min(1.0, room[1])),
            behind(&low, &high, &scale, min(2.0, room[1])),
            behind(&low, &high, &scale, min(3.0, room[1])),
            behind(&low, &high, &scale, min(4.0, room[1])),
        ];
        for row in 0..SIDE {
            for column in 0..SIDE {
                let share = levels[row][column] - levels[row + 1][column];
                shares[SIDE * row + column] = min(max(share, 0.0), 1.0);
            }
        }
        shares
    }
}

/// `Σ w M(row)` over the sides, in each column.
#[inline(always)]
fn behind(low: &Lanes, high: &Lanes, scale: &Lanes, row: f32) -> [f32; SIDE] {
    let mut parts = [0.0; LANES];
    for lane in 0..LANES {
        let a = max(low[lane] - row, 0.0);
        let b = max(high[lane] - row, 0.0);
        parts[lane] = scale[lane] * ((b - a) * (b + a));
    }
    let mut sums = [0.0; SIDE];
    for column in 0..SIDE {
        sums[column] = (parts[column] + parts[SIDE + column])
            + (parts[2 * SIDE + column] + parts[3 * SIDE + column]);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::overlap::TexelBox;
    use glintbake_format::model::{Footprint, Wrap};

    #[test]
    fn shares_are_the_exact_areas_of_any_shape_and_place() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / (1_u64 << 24) as f64
        };
        let (mut inside, mut outside, mut cut) = (0, 0, 0);
        for number in 0..4000 {
            let size = [0.4, 1.5, 6.0, 40.0][number % 4];
            let mut edge = || [0, 1].map(|_| (random() - 0.5) * size / 32.0);
            let (mut edge_1, mut edge_2) = (edge(), edge());
            match number % 5 {
                0 => edge_1[0] = 0.0,
                1 => (edge_1[1], edge_2[0]) = (0.0, 0.0),
                2 => edge_2[0] = 1e-12,
                _ => {}
            }
            let footprint = Footprint {
                centre: [0.5 + 0.3 * random(), 0.4 + 0.3 * random()],
                edge_1,
                edge_2,
            };
            let placed = Parallelogram::new(&footprint, 32, 32, Wrap::Repeat).unwrap();
            let Some(areas) = Areas::new(&placed) else {
                continue;
            };
            for block in 0..64 {
                let first = [4 * (block % 8), 4 * (block / 8)].map(f64::from);
                let [x, y] = placed.centred(first[0], first[1]).map(|x| x as f32);
                let room = [[4.0, 4.0], [3.0, 1.0]][block as usize % 2];
                let shares = areas.shares(x, y, room);
                let place = areas.place(x, y);
                for (lane, &share) in shares.iter().enumerate() {
                    let [column, row] = [lane % 4, lane / 4].map(|x| x as f64);
                    let low = [first[0] + column, first[1] + row];
                    let exact = if column < f64::from(room[0]) && row < f64::from(room[1]) {
                        let high = [low[0] + 1.0, low[1] + 1.0];
                        placed.weight(&TexelBox { low, high }) * placed.area()
                    } else {
                        0.0
                    };
                    let off = (f64::from(share) - exact).abs();
                    assert!(off < 1e-5, "{footprint:?} {low:?}: {} {exact}", share);
                    if place == Place::Inside && room == [4.0, 4.0] {
                        assert!(exact > 1.0 - 1e-9);
                    }
                    assert!(place != Place::Outside || exact == 0.0);
                }
                match place {
                    Place::Inside => inside += 1,
                    Place::Outside => outside += 1,
                    Place::Cut => cut += 1,
                }
            }
        }
        assert!(inside > 1000 && outside > 1000 && cut > 1000);
    }
}
