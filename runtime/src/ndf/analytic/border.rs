//! Beyond the border of a map that does not repeat: strips and corners whose normals are those of the border, without end.

use super::gather::{Found, Sink};
use super::surface::{VERTICES, along};
use crate::error::QueryError;
use core::ops::Range;
use glintbake_format::model::{CATMULL_ROM_PARTS, Interpolation};

/// Deviations by which strips are longer than the reach, so that what is cut off is none of it.
const SLACK: f64 = 1.0;

/// One axis of a map and of a footprint on it, in cells from the first one's beginning.
#[derive(Clone, Copy)]
struct Axis {
    /// From where on the surface changes, and up to where.
    low: i64,
    high: i64,
    /// What the footprint reaches.
    from: f64,
    to: f64,
    /// Ends of strips.
    ends: [f64; 2],
}

impl Axis {
    /// Cells between the borders that the footprint reaches.
    fn inner(&self) -> Range<i64> {
        let first = (libm::floor(self.from) as i64).max(self.low);
        let last = (libm::ceil(self.to) as i64).min(self.high);
        first..last
    }

    /// What lies beyond either border within reach: begin and end, and the place of a texel there.
    fn outer(&self) -> [Option<(f64, f64, i64)>; 2] {
        let (low, high) = (self.low as f64, self.high as f64);
        [
            (self.from < low).then_some((self.ends[0], low, self.low.saturating_sub(1))),
            (self.to > high).then_some((high, self.ends[1], self.high)),
        ]
    }
}

impl<S: Sink> Found<'_, S> {
    /// Adds all that lies beyond the border. O(texels of the border within reach).
    ///
    /// # Errors
    /// [`QueryError::Damaged`].
    pub(super) fn border(&mut self) -> Result<(), QueryError> {
        let query = self.query;
        let placed = &query.placed;
        let reach = libm::sqrt(query.reach_squared);
        // Cubics reach one texel further: a cell before the first texel is not flat yet. After the last, cell (W - 1) is the
        // one that is not.
        let low = match self.surface.interpolation {
            Interpolation::CatmullRom => -1,
            Interpolation::None | Interpolation::Linear => 0,
        };
        let [across, down] = placed.spread;
        let wide = libm::sqrt(across * across + placed.lean * placed.lean * down * down);
        let shift = self.surface.shift();
        let [width, height] = self.surface.normals.size;
        let [x, y] = placed.middle();
        let axis = |middle: f64, deviation: f64, side: u32| {
            let (half, end) = (reach * deviation, (reach + SLACK) * deviation);
            let middle = middle - shift;
            let (low, high) = (low, i64::from(side));
            Axis {
                low,
                high,
                from: middle - half,
                to: middle + half,
                ends: [
                    (middle - end).min(low as f64),
                    (middle + end).max(high as f64),
                ],
            }
        };
        let (columns, rows) = (axis(x, wide, width), axis(y, down, height));
        if low < 0 {
            // The cells before the first ones.
            if columns.inner().contains(&low) {
                for row in rows.inner() {
                    self.one([low, row])?;
                }
            }
            if rows.inner().contains(&low) {
                for column in columns.inner().filter(|column| *column >= 0) {
                    self.one([column, low])?;
                }
            }
        }
        for (from, to, texel) in columns.outer().into_iter().flatten() {
            for row in rows.inner() {
                self.strip(
                    row,
                    [from, to],
                    |place| [texel, place],
                    |[along, across]| [along, across],
                )?;
            }
            for (top, bottom, corner) in rows.outer().into_iter().flatten() {
                let normal = query.whiten(self.surface.texel(texel, corner)?);
                self.rectangle([from, top], [to - from, bottom - top], false, [normal; 2]);
            }
        }
        for (from, to, texel) in rows.outer().into_iter().flatten() {
            for column in columns.inner() {
                self.strip(
                    column,
                    [from, to],
                    |place| [place, texel],
                    |[along, across]| [across, along],
                )?;
            }
        }
        Ok(())
    }

    /// Adds the strip beside the border's cell `cell`, `from` one place `to` another along it. `texel` says which texel stands at a
    /// place of the border, `turn` makes a point of a place along the strip and one across.
    fn strip(
        &mut self,
        cell: i64,
        [from, to]: [f64; 2],
        texel: impl Fn(i64) -> [i64; 2],
        turn: impl Fn([f64; 2]) -> [f64; 2],
    ) -> Result<(), QueryError> {
        let query = self.query;
        let normal = |off: i64| {
            let [x, y] = texel(cell.wrapping_add(off));
            self.surface.texel(x, y).map(|normal| query.whiten(normal))
        };
        let is_turned = turn([1.0, 0.0]) != [1.0, 0.0];
        let place = cell as f64;
        match self.surface.interpolation {
            Interpolation::None => {
                let normals = [normal(0)?; 2];
                self.rectangle(
                    turn([from, place]),
                    turn([to - from, 1.0]),
                    is_turned,
                    normals,
                );
            }
            Interpolation::Linear => {
                let normals = [normal(0)?, normal(1)?];
                self.rectangle(
                    turn([from, place]),
                    turn([to - from, 1.0]),
                    is_turned,
                    normals,
                );
            }
            Interpolation::CatmullRom => {
                const SIDE: f64 = 1.0 / CATMULL_ROM_PARTS as f64;
                let normals: [[f64; 2]; VERTICES] =
                    along(&[normal(-1)?, normal(0)?, normal(1)?, normal(2)?]);
                for (part, pair) in (0_u32..).zip(normals.windows(2)) {
                    let [near, other] = pair else { continue };
                    let across = place + SIDE * f64::from(part);
                    let size = turn([to - from, SIDE]);
                    self.rectangle(turn([from, across]), size, is_turned, [*near, *other]);
                }
            }
        }
        Ok(())
    }

    /// Adds a rectangle, in cells, whose normals go from one to another along y, or along x if it `is_turned`.
    fn rectangle(
        &mut self,
        start: [f64; 2],
        [width, height]: [f64; 2],
        is_turned: bool,
        normals: [[f64; 2]; 2],
    ) {
        let has_area = width > 0.0 && height > 0.0;
        if !has_area {
            return;
        }
        let query = self.query;
        let shift = self.surface.shift();
        let corner = query.frame.corner(&query.placed, start.map(|x| x + shift));
        let [across, down] = query.frame.edges;
        let (across, down) = (across.map(|x| width * x), down.map(|x| height * x));
        let edges = if is_turned {
            [down, across]
        } else {
            [across, down]
        };
        let amount = query.strip(corner, edges, width * height, normals);
        if S::EACH {
            if amount > 0.0 {
                let share = query.share(corner, edges, width * height);
                let [[a, b], [c, d]] = normals;
                self.sink
                    .cell(amount, [0.5 * (a + c), 0.5 * (b + d)], share);
            }
        } else {
            self.sink.add(amount);
        }
    }
}
