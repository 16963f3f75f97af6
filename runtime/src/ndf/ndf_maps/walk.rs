//! From the whole example down to its tiles, as far as it matters.
//!
//! A tile that the footprint covers in part, or that a neighbour hides in part, is taken for its share of its NDF if that hardly
//! matters, else it is divided in four, and the finest into its lobes. Of a tile of the value v and the share A of the footprint, of
//! which the share a is seen, the answer lies between 0 and v A; were what adds to v spread over the tile by chance, v a would err
//! by `v √(a (A - a))`, and this is what is held against the threshold.

use super::frame::{Local, Region};
use super::hidden::{Hidden, Shadows};
use super::image::Probe;
use super::lobes::Lobes;
use glintbake_format::view::NdfMaps;

/// The most that chance may err by, in units of `v a`: what is seen of a tile of a needle is little of it, but all lies in a line.
const MOST_CHANCE: f64 = 8.0;

/// One copy of the example under a footprint, at one normal.
pub(super) struct Walk<'q> {
    pub maps: &'q NdfMaps<'q>,
    pub local: Local,
    pub probe: Probe,
    pub lobes: Lobes<'q>,
    pub hidden: &'q Hidden,
    /// Values of tiles that are known, NaN where one is not, or none at all if they are not kept.
    pub known: &'q mut [f32],
    /// Errors of this much do not matter, in shares of the footprint times the unit of values.
    pub threshold: f64,
    /// What turns densities into the unit of values.
    pub unit: f64,
}

impl Walk<'_> {
    /// The value of the tile in `column` and `row` of `level`.
    pub fn value(&mut self, level: u8, column: u32, row: u32) -> f64 {
        let side = self.maps.layout.tiles(level) as usize;
        let place = self
            .maps
            .layout
            .tiles_before(level)
            .wrapping_add((row as usize).wrapping_mul(side))
            .wrapping_add(column as usize);
        if let Some(&known) = self.known.get(place)
            && !known.is_nan()
        {
            return f64::from(known);
        }
        let value = self
            .maps
            .images
            .get(place)
            .map_or(0.0, |image| self.probe.value(image, self.maps.pixels));
        if let Some(slot) = self.known.get_mut(place) {
            *slot = value;
        }
        f64::from(value)
    }

    /// What chance may err by if the share `seen` of a tile of `value`, itself the share `whole`, is taken for its share.
    pub fn chance(value: f64, seen: f64, whole: f64) -> f64 {
        if seen <= 0.0 {
            return 0.0;
        }
        let others = libm::sqrt(((whole - seen) / seen).max(0.0));
        // Of no number there is none: a footprint without an area.
        value * seen * others.min(MOST_CHANCE)
    }

    /// The share of the footprint that a tile of `level` is, were all of it there.
    pub fn share_of(&self, level: u8) -> f64 {
        let side = f64::from(1_u32 << (level & 31));
        side * side * self.local.texel()
    }

    /// What the part `region` of the footprint shows of the tile in `column` and `row` of `level`, whose value is `value`;
    /// `shadows` may hide some of it.
    pub fn tile(
        &mut self,
        level: u8,
        [column, row]: [u32; 2],
        value: f64,
        region: &Region,
        shadows: Shadows,
    ) -> f64 {
        let (shadows, seen) = self.hidden.left(region, shadows);
        if seen <= 0.0 {
            return 0.0;
        }
        let whole = self.share_of(level);
        let rough = value * seen;
        if seen >= whole * (1.0 - 1e-9) || Self::chance(value, seen, whole) <= self.threshold {
            return rough;
        }
        if level == 0 {
            let pieces = self.hidden.pieces(region, shadows);
            return self.lobes.over(&self.local, pieces.regions()) * self.unit;
        }
        let below = level - 1;
        let half = f64::from(1_u32 << (below & 31));
        let [x, y] = self.local.axes;
        let middle = |place: u32| (2.0 * f64::from(place) + 1.0) * half;
        let mut sum = 0.0;
        for is_right in [false, true] {
            let mut side = *region;
            if is_right {
                x.above(middle(column), &mut side);
            } else {
                x.below(middle(column), &mut side);
            }
            if side.is_empty() {
                continue;
            }
            for is_below in [false, true] {
                let child = [
                    2 * column + u32::from(is_right),
                    2 * row + u32::from(is_below),
                ];
                let value = self.value(below, child[0], child[1]);
                if value <= 0.0 {
                    continue;
                }
                let mut quarter = side;
                if is_below {
                    y.above(middle(row), &mut quarter);
                } else {
                    y.below(middle(row), &mut quarter);
                }
                if !quarter.is_empty() {
                    sum += self.tile(below, child, value, &quarter, shadows);
                }
            }
        }
        sum
    }
}
