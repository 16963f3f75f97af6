//! The piecewise-linear surface of normals between the middles of texels \[YHJ*14\] §4, written out from its
//! definition.

use super::double_double::DoubleDouble;
use super::texel_axis::TexelAxis;
use crate::normals::NormalMap;
use core::ops::RangeInclusive;
use glintbake_format::model::{Interpolation, Wrap};

/// Normals at the vertices of a grid, or, without interpolation, of whole texels.
///
/// Vertex k of an axis stands at `offset + k / per_side` texels. A clamped map has the vertices `first..first + count`
/// of an axis, and stays what it is beyond them; one that repeats has `count` vertices a tile.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    interpolation: Interpolation,
    wrap: Wrap,
    per_side: i64,
    first: [i64; 2],
    count: [i64; 2],
    values: Vec<[f64; 2]>,
}

/// Where a cell ends towards one side; `None` if it extends without end.
pub(super) type Border = Option<DoubleDouble>;

impl Surface {
    /// The surface of `map`.
    ///
    /// # Panics
    /// If the map is empty.
    pub(super) fn new(map: &NormalMap, interpolation: Interpolation) -> Self {
        let size = [map.width(), map.height()].map(i64::from);
        assert!(size[0] > 0 && size[1] > 0, "an empty map has no surface");
        let per_side = match interpolation {
            Interpolation::None | Interpolation::Linear => 1,
            Interpolation::CatmullRom => 4,
        };
        let (first, count) = match (interpolation, map.wrap()) {
            // The bicubic pieces about the border still look at texels within.
            (Interpolation::CatmullRom, Wrap::Clamp) => {
                (-per_side, size.map(|n| (n + 1) * per_side + 1))
            }
            _ => (0, size.map(|n| n * per_side)),
        };
        let mut surface = Self {
            interpolation,
            wrap: map.wrap(),
            per_side,
            first: [first; 2],
            count,
            values: Vec::new(),
        };
        let texel = |i: i64, j: i64| {
            let [i, j] = [(i, size[0]), (j, size[1])].map(|(index, n)| match map.wrap() {
                Wrap::Repeat => index.rem_euclid(n),
                Wrap::Clamp => index.clamp(0, n - 1),
            });
            map.texels()[(j * size[0] + i) as usize].map(f64::from)
        };
        for j in first..first + count[1] {
            for i in first..first + count[0] {
                surface.values.push(match interpolation {
                    Interpolation::None | Interpolation::Linear => texel(i, j),
                    Interpolation::CatmullRom => bicubic(&texel, i, j),
                });
            }
        }
        surface
    }

    /// How many vertices there are along a texel.
    pub(super) fn per_side(&self) -> i64 {
        self.per_side
    }

    /// Whether texels are flat.
    pub(super) fn is_flat(&self) -> bool {
        self.interpolation == Interpolation::None
    }

    /// The normal at a vertex of the endless grid, or of a texel.
    pub(super) fn value(&self, column: i64, row: i64) -> [f64; 2] {
        let [i, j] = [(column, 0), (row, 1)].map(|(index, axis): (i64, usize)| {
            let index = index - self.first[axis];
            match self.wrap {
                Wrap::Repeat => index.rem_euclid(self.count[axis]),
                Wrap::Clamp => index.clamp(0, self.count[axis] - 1),
            }
        });
        self.values[(j * self.count[0] + i) as usize]
    }

    /// Texels from the border of a texel to its first vertex.
    pub(super) fn offset(&self) -> f64 {
        if self.is_flat() { 0.0 } else { 0.5 }
    }

    /// Where vertex `index` is, from the centre of the footprint of `axis`.
    fn place(&self, axis: &TexelAxis, index: i64) -> DoubleDouble {
        let part = index.rem_euclid(self.per_side) as f64 / self.per_side as f64;
        axis.border(index.div_euclid(self.per_side)) + DoubleDouble::from(part + self.offset())
    }

    /// The first and last cell of an axis that differs from those beyond; `None` if cells repeat.
    fn ends(&self, axis: usize) -> Option<(i64, i64)> {
        let last = self.first[axis] + self.count[axis] - 1;
        // Between vertices there is one cell more than on a grid of texels: that before the first.
        let before = i64::from(!self.is_flat());
        (self.wrap == Wrap::Clamp).then_some((self.first[axis] - before, last))
    }

    /// Where cell `index` begins and ends along axis number `axis`.
    pub(super) fn borders(&self, along: &TexelAxis, axis: usize, index: i64) -> [Border; 2] {
        let ends = self.ends(axis);
        let open = |end: Option<i64>| end == Some(index);
        [
            (!open(ends.map(|ends| ends.0))).then(|| self.place(along, index)),
            (!open(ends.map(|ends| ends.1))).then(|| self.place(along, index + 1)),
        ]
    }

    /// The cells that hold the places between `from` and `to`, from the footprint's centre, and a few more.
    pub(super) fn cells_between(
        &self,
        along: &TexelAxis,
        axis: usize,
        from: f64,
        to: f64,
    ) -> RangeInclusive<i64> {
        let first = (along.texel_at(from) - 2) * self.per_side;
        let last = (along.texel_at(to) + 2) * self.per_side;
        match self.ends(axis) {
            None => first..=last,
            Some((low, high)) => first.clamp(low, high)..=last.clamp(low, high),
        }
    }

    /// The normal at (x, y) texels from the upper left corner of the map.
    pub(super) fn normal(&self, x: f64, y: f64) -> [f64; 2] {
        let per_side = self.per_side as f64;
        let [x, y] = [x, y].map(|place| (place - self.offset()) * per_side);
        let [column, row] = [x, y].map(libm::floor);
        let (right, down) = (x - column, y - row);
        let (column, row) = (column as i64, row as i64);
        if self.is_flat() {
            return self.value(column, row);
        }
        // The diagonal runs from the upper right corner to the lower left one.
        let corner = i64::from(right + down > 1.0);
        let (across, along) = if corner == 0 {
            (right, down)
        } else {
            (1.0 - right, 1.0 - down)
        };
        let other = 1 - corner;
        let at = self.value(column + corner, row + corner);
        let beside = self.value(column + other, row + corner);
        let below = self.value(column + corner, row + other);
        [0, 1].map(|axis: usize| {
            at[axis] + across * (beside[axis] - at[axis]) + along * (below[axis] - at[axis])
        })
    }
}

/// The bicubic of Catmull and Rom, tension 1/2, at vertex (`column`, `row`), quarters of a texel from the first middle.
fn bicubic(texel: &impl Fn(i64, i64) -> [f64; 2], column: i64, row: i64) -> [f64; 2] {
    let ([i, j], [x, y]) = (
        [column, row].map(|index| index.div_euclid(4)),
        [column, row].map(|index| index.rem_euclid(4) as f64 / 4.0),
    );
    let lines = [-1, 0, 1, 2].map(|down| {
        let line = [-1, 0, 1, 2].map(|across| texel(i + across, j + down));
        [0, 1].map(|axis: usize| cubic(line.map(|value| value[axis]), x))
    });
    [0, 1].map(|axis: usize| cubic(lines.map(|value| value[axis]), y))
}

/// The cubic from `b` to `c` with the slopes `(c - a) / 2` and `(d - b) / 2` at its ends, by Hermite's polynomials.
fn cubic([a, b, c, d]: [f64; 4], x: f64) -> f64 {
    let rise = x * x * (3.0 - 2.0 * x);
    let slopes = [0.5 * (c - a), 0.5 * (d - b)];
    b + rise * (c - b) + x * (1.0 - x) * ((1.0 - x) * slopes[0] - x * slopes[1])
}
