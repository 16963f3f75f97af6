//! Lobes of texels, made as they are asked for, sixteen at a time.
#![expect(
    clippy::indexing_slicing,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use super::sixteen::{Asked, Normals, Positions};
use super::walk::Visitor;
use crate::error::QueryError;
use crate::lanes::{LANES, Lanes};
use core::ops::Range;
use glintbake_format::model::LobeLattice;
use glintbake_format::view::MipLobes;
use glintbake_format::{Fault, Finding};

/// The half vector less a normal, in deviations of the kernel.
type Apart = [f32; 2];

/// Lobes of texels, until there are sixteen.
pub(super) struct Batch<'w, 'q> {
    lobes: &'w MipLobes<'q>,
    asked: &'w Asked,
    positions: Positions,
    /// For each lobe the middles about it: of four lobes a texel the four that its normal is interpolated between, row by row; of one
    /// those before and after it along x, then along y.
    around: [[Lanes; 2]; 4],
    /// Its own, of one lobe a texel.
    own: [Lanes; 2],
    count: usize,
}

/// Shares of the second column, and of the second row, of the four lobes of a texel.
const SHARES: [[f32; 2]; 4] = [[0.75, 0.75], [0.25, 0.75], [0.75, 0.25], [0.25, 0.25]];

/// Where they lie off the texel's middle.
const PLACES: [[f32; 2]; 4] = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];

impl<'w, 'q> Batch<'w, 'q> {
    pub fn new(lobes: &'w MipLobes<'q>, asked: &'w Asked) -> Self {
        let per_side = f32::from(lobes.layout.per_side.max(1));
        let deviation = LobeLattice::DEVIATION as f32 / per_side;
        Self {
            lobes,
            asked,
            positions: Positions {
                l_11: [deviation; LANES],
                l_22: [deviation; LANES],
                ..Positions::NONE
            },
            around: [[[0.0; LANES]; 2]; 4],
            own: [[0.0; LANES]; 2],
            count: 0,
        }
    }

    #[inline(always)]
    fn apart(&self, column: u32, row: u32) -> Result<Apart, QueryError> {
        let normal = self.lobes.normal(column, row);
        let [s, t] = normal.ok_or(Finding::new(Fault::MipIndex))?;
        let [h_s, h_t] = self.asked.normal;
        let scale = self.asked.scale;
        Ok([((h_s - s) * scale) as f32, ((h_t - t) * scale) as f32])
    }

    /// Adds the lobes of the texels in `columns` of `row`, over which the footprint is at `centre`.
    #[inline(always)]
    pub fn row<V: Visitor>(
        &mut self,
        centre: [f64; 2],
        row: u32,
        columns: Range<u32>,
        visitor: &mut V,
    ) -> Result<(), QueryError> {
        let [width, height] = self.lobes.layout.size;
        let before = |place: u32, side: u32| place.checked_sub(1).unwrap_or(side.wrapping_sub(1));
        let after = |place: u32, side: u32| {
            let next = place.wrapping_add(1);
            if next >= side { 0 } else { next }
        };
        let (above, below) = (before(row, height), after(row, height));
        let column_of = |batch: &Self, column: u32| -> Result<[Apart; 3], QueryError> {
            Ok([
                batch.apart(column, above)?,
                batch.apart(column, row)?,
                batch.apart(column, below)?,
            ])
        };
        if columns.is_empty() {
            return Ok(());
        }
        let mut left = column_of(self, before(columns.start, width))?;
        let mut middle = column_of(self, columns.start)?;
        let y = (centre[1] - f64::from(row) - 0.5) as f32;
        for column in columns {
            let right = column_of(self, after(column, width))?;
            let x = (centre[0] - f64::from(column) - 0.5) as f32;
            self.texel(&[left, middle, right], [x, y], visitor);
            (left, middle) = (middle, right);
        }
        Ok(())
    }

    /// Adds the lobes of a texel whose middle lies `offset` before the footprint's centre; `columns` has the normals of it and its
    /// neighbours.
    #[inline(always)]
    fn texel<V: Visitor>(&mut self, columns: &[[Apart; 3]; 3], [x, y]: [f32; 2], visitor: &mut V) {
        let [left, middle, right] = columns;
        if self.lobes.layout.per_side == 1 {
            let lane = self.count & (LANES - 1);
            let around = [left[1], right[1], middle[0], middle[2]];
            for axis in 0..2 {
                self.own[axis][lane] = middle[1][axis];
                for (lanes, one) in self.around.iter_mut().zip(around) {
                    lanes[axis][lane] = one[axis];
                }
            }
            self.positions.weight[lane] = 1.0;
            self.positions.x[lane] = x;
            self.positions.y[lane] = y;
            self.added(visitor);
            return;
        }
        for (number, place) in PLACES.iter().enumerate() {
            let lane = self.count & (LANES - 1);
            let (one, other) = if number & 1 == 0 {
                (left, middle)
            } else {
                (middle, right)
            };
            let row = number >> 1;
            let around = [one[row], other[row], one[row + 1], other[row + 1]];
            for axis in 0..2 {
                for (lanes, one) in self.around.iter_mut().zip(around) {
                    lanes[axis][lane] = one[axis];
                }
            }
            self.positions.weight[lane] = 0.25;
            self.positions.x[lane] = x - place[0];
            self.positions.y[lane] = y - place[1];
            self.added(visitor);
        }
    }

    #[inline(always)]
    fn added<V: Visitor>(&mut self, visitor: &mut V) {
        self.count = self.count.wrapping_add(1);
        if self.count >= LANES {
            visitor.sixteen(&self.positions, &self.normals());
            self.count = 0;
        }
    }

    /// Normals and slopes of the lobes; what is interpolated is the half vector less normals, so slopes change their sign.
    #[inline(always)]
    fn normals(&self) -> Normals {
        let mut normals = Normals::NONE;
        let [a, b, c, d] = &self.around;
        for axis in 0..2 {
            let (mut value, mut along, mut down) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            let (a, b, c, d) = (&a[axis], &b[axis], &c[axis], &d[axis]);
            if self.lobes.layout.per_side == 1 {
                value = self.own[axis];
                for lane in 0..LANES {
                    along[lane] = 0.5 * (a[lane] - b[lane]);
                    down[lane] = 0.5 * (c[lane] - d[lane]);
                }
            } else {
                for lane in 0..LANES {
                    let [p, q] = SHARES[lane & 3];
                    let (upper, lower) = (b[lane] - a[lane], d[lane] - c[lane]);
                    let (first, second) = (a[lane] + p * upper, c[lane] + p * lower);
                    value[lane] = first + q * (second - first);
                    along[lane] = -(upper + q * (lower - upper));
                    down[lane] = first - second;
                }
            }
            if axis == 0 {
                (normals.s, normals.s_x, normals.s_y) = (value, along, down);
            } else {
                (normals.t, normals.t_x, normals.t_y) = (value, along, down);
            }
        }
        normals
    }

    /// Shows what is left.
    #[inline(always)]
    pub fn finish<V: Visitor>(mut self, visitor: &mut V) {
        if self.count == 0 {
            return;
        }
        for weight in self.positions.weight.iter_mut().skip(self.count) {
            *weight = 0.0;
        }
        visitor.sixteen(&self.positions, &self.normals());
    }
}
