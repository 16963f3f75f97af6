//! The integral over all of the surface that a footprint and a half vector reach.

use super::cells::Query;
use super::surface::{Surface, VERTICES, vertices};
use crate::error::QueryError;
use crate::ndf::box_pyramid::{self, Cell, Visitor};
use crate::simd::Work;
use glintbake_format::model::{CATMULL_ROM_PARTS, Interpolation, PYRAMID_SIDE, Wrap};
use glintbake_format::view::BoxPyramid;

/// Who adds up.
pub(super) trait Sink {
    /// Whether each cell is wanted by itself, with its share of the footprint and its normal.
    const EACH: bool;

    /// So much of the density, in units of the kernel's peak.
    fn add(&mut self, amount: f64);

    /// So much of the density, of a cell of a mean normal and a share of the footprint.
    fn cell(&mut self, amount: f64, normal: [f64; 2], share: f64);
}

/// The sum of a query.
pub(super) struct Total(pub f64);

impl Sink for Total {
    const EACH: bool = false;

    #[inline(always)]
    fn add(&mut self, amount: f64) {
        self.0 += amount;
    }

    #[inline(always)]
    fn cell(&mut self, _: f64, _: [f64; 2], _: f64) {}
}

/// A query of a surface, and what it has found so far.
pub(super) struct Gather<'q, S> {
    pub surface: &'q Surface<'q>,
    pub pyramid: &'q BoxPyramid<'q>,
    pub query: &'q Query,
    pub sink: S,
}

impl<S: Sink> Work for Gather<'_, S> {
    type Output = Result<S, QueryError>;

    /// Visits every copy of the map that the footprint reaches.
    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            surface,
            pyramid,
            query,
            sink,
        } = self;
        let placed = &query.placed;
        let shift = surface.shift();
        let mut found = Found {
            surface,
            query,
            copy: [0, 0],
            sink,
        };
        let reach = libm::sqrt(query.reach_squared);
        let (rows, is_one) = if placed.is_even || placed.wrap == Wrap::Clamp {
            (0..1, true)
        } else {
            (placed.copy_rows(shift, reach), false)
        };
        for row in rows {
            let columns = if is_one {
                0..1
            } else {
                placed.copy_columns(row, shift, reach)
            };
            for column in columns {
                found.copy = [column, row];
                let [width, height] = placed.size;
                let [x, y] = placed.middle();
                let asked = box_pyramid::Query {
                    centre: [
                        x - shift - column as f64 * width,
                        y - shift - row as f64 * height,
                    ],
                    whiten: if placed.is_even {
                        [0.0; 3]
                    } else {
                        placed.whiten
                    },
                    normal: query.normal,
                    scale: query.scale,
                    reach_squared: query.reach_squared,
                    drift: 0.0,
                    blur: 0.0,
                };
                box_pyramid::walk(pyramid, &asked, &mut found)?;
            }
        }
        if placed.wrap == Wrap::Clamp {
            found.border()?;
        }
        Ok(found.sink)
    }
}

/// The copy of the map that is being visited, and what has been found so far.
pub(super) struct Found<'q, S> {
    pub surface: &'q Surface<'q>,
    pub query: &'q Query,
    /// Column and row of the copy.
    copy: [i64; 2],
    pub sink: S,
}

impl<S: Sink> Visitor for Found<'_, S> {
    #[inline(always)]
    fn cell(&mut self, cell: &Cell) -> Result<bool, QueryError> {
        if cell.level > 0 {
            return Ok(false);
        }
        let [width, height] = self.surface.normals.size;
        let (left, top) = (cell.column.wrapping_mul(4), cell.row.wrapping_mul(4));
        let right = left.saturating_add(PYRAMID_SIDE).min(width);
        let bottom = top.saturating_add(PYRAMID_SIDE).min(height);
        match self.surface.interpolation {
            Interpolation::Linear => self.linear([left, top], [right, bottom])?,
            Interpolation::CatmullRom => self.cubic([left, top], [right, bottom])?,
            Interpolation::None => {
                for row in top..bottom {
                    for column in left..right {
                        self.one([i64::from(column), i64::from(row)])?;
                    }
                }
            }
        }
        Ok(true)
    }
}

impl<S: Sink> Found<'_, S> {
    /// Where cell (`column`, `row`) of this copy begins, in deviations.
    #[inline(always)]
    fn corner(&self, [column, row]: [i64; 2]) -> [f64; 2] {
        let placed = &self.query.placed;
        let shift = self.surface.shift();
        let [width, height] = placed.size;
        let [x, y] = self.copy.map(|copy| copy as f64);
        let place = [
            column as f64 + shift + x * width,
            row as f64 + shift + y * height,
        ];
        self.query.frame.corner(placed, place)
    }

    /// Tells the sink of `amount` of a cell.
    #[inline(always)]
    fn tell(&mut self, amount: f64, corner: [f64; 2], normals: [[f64; 2]; 4]) {
        if S::EACH {
            if amount > 0.0 && amount < f64::INFINITY {
                let edges = self.query.frame.edges;
                let share = self.query.share(corner, edges, 1.0);
                self.sink.cell(amount, mean_of(normals), share);
            }
        } else {
            self.sink.add(amount);
        }
    }

    /// The cells of a block, on two triangles each: every vertex is read once.
    #[inline(always)]
    fn linear(
        &mut self,
        [left, top]: [u32; 2],
        [right, bottom]: [u32; 2],
    ) -> Result<(), QueryError> {
        const ROW: usize = PYRAMID_SIDE as usize + 1;
        let query = self.query;
        let edges = query.frame.edges;
        let mut above = [[0.0; 2]; ROW];
        for row in top..=bottom {
            let normals = self.row_of::<ROW>(i64::from(left), i64::from(row))?;
            let below = normals.map(|normal| query.whiten(normal));
            if row > top {
                let line = i64::from(row).wrapping_sub(1);
                let start = self.corner([i64::from(left), line]);
                let pairs = above.windows(2).zip(below.windows(2));
                for (column, pair) in (0..right.saturating_sub(left)).zip(pairs) {
                    let ([a, b], [c, d]) = pair else {
                        continue;
                    };
                    // Exact where all places weigh alike: there corners are the origin.
                    let corner = if query.placed.is_even {
                        start
                    } else {
                        let [x, y] = edges[0];
                        [
                            start[0] + f64::from(column) * x,
                            start[1] + f64::from(column) * y,
                        ]
                    };
                    let amount = query.square(corner, edges, 1.0, [*a, *b, *c, *d]);
                    if amount > 0.0 && amount < f64::INFINITY {
                        self.tell(amount, corner, [*a, *b, *c, *d]);
                    }
                }
            }
            above = below;
        }
        Ok(())
    }

    /// `N` normals from texel `left` on in `row`, which may lie beyond the border.
    #[inline(always)]
    fn row_of<const N: usize>(&self, left: i64, row: i64) -> Result<[[f64; 2]; N], QueryError> {
        let [_, height] = self.surface.normals.size;
        if let (Ok(left), Ok(row)) = (u32::try_from(left), u32::try_from(row))
            && row < height
            && let Some(run) = self.surface.normals.run::<N>(left, row)
        {
            return Ok(run.map(|normal| normal.point()));
        }
        let mut normals = [[0.0; 2]; N];
        for (column, normal) in (0_i64..).zip(&mut normals) {
            *normal = self.surface.texel(left.wrapping_add(column), row)?;
        }
        Ok(normals)
    }

    /// Cell (`column`, `row`), wherever it lies.
    #[inline(always)]
    pub fn one(&mut self, [column, row]: [i64; 2]) -> Result<(), QueryError> {
        let query = self.query;
        let edges = query.frame.edges;
        let corner = self.corner([column, row]);
        if query.is_beyond(corner) {
            return Ok(());
        }
        match self.surface.interpolation {
            Interpolation::None => {
                let normal = query.whiten(self.surface.texel(column, row)?);
                let amount = query.strip(corner, edges, 1.0, [normal; 2]);
                self.tell(amount, corner, [normal; 4]);
            }
            Interpolation::Linear => {
                let (right, below) = (column.wrapping_add(1), row.wrapping_add(1));
                let corners = [
                    self.surface.texel(column, row)?,
                    self.surface.texel(right, row)?,
                    self.surface.texel(column, below)?,
                    self.surface.texel(right, below)?,
                ];
                let corners = corners.map(|normal| query.whiten(normal));
                let amount = query.square(corner, edges, 1.0, corners);
                self.tell(amount, corner, corners);
            }
            Interpolation::CatmullRom => {
                let texels = self.surface.around(column, row)?;
                let texels = texels.map(|row| row.map(|normal| query.whiten(normal)));
                self.cubic_cell(corner, &texels);
            }
        }
        Ok(())
    }

    /// The cells of a block in 4 × 4 parts each: every texel is read once.
    #[inline(always)]
    fn cubic(
        &mut self,
        [left, top]: [u32; 2],
        [right, bottom]: [u32; 2],
    ) -> Result<(), QueryError> {
        const ROW: usize = PYRAMID_SIDE as usize + 3;
        let query = self.query;
        let mut texels = [[[0.0; 2]; ROW]; ROW];
        let first = i64::from(left).wrapping_sub(1);
        for (row, line) in (i64::from(top).wrapping_sub(1)..).zip(&mut texels) {
            *line = self
                .row_of::<ROW>(first, row)?
                .map(|normal| query.whiten(normal));
        }
        for (row, lines) in (top..bottom).zip(texels.windows(4)) {
            let [a, b, c, d] = lines else { continue };
            for (column, start) in (left..right).zip(0_usize..) {
                let part = |line: &[[f64; 2]; ROW]| line.get(start..)?.first_chunk::<4>().copied();
                let (Some(a), Some(b), Some(c), Some(d)) = (part(a), part(b), part(c), part(d))
                else {
                    continue;
                };
                let corner = self.corner([i64::from(column), i64::from(row)]);
                self.cubic_cell(corner, &[a, b, c, d]);
            }
        }
        Ok(())
    }

    /// The cell at `corner` in the middle of whitened `texels`.
    #[inline(always)]
    fn cubic_cell(&mut self, corner: [f64; 2], texels: &[[[f64; 2]; 4]; 4]) {
        if self.query.is_cubic_beyond(corner, texels) {
            return;
        }
        // Weights add up to 1, so that whitened texels give whitened vertices.
        let normals = vertices(texels);
        let amount = self.parts(corner, &normals);
        let [[a, .., b], .., [c, .., d]] = normals;
        self.tell(amount, corner, [a, b, c, d]);
    }

    /// The 4 × 4 parts of a cell.
    #[inline(always)]
    fn parts(&self, corner: [f64; 2], normals: &[[[f64; 2]; VERTICES]; VERTICES]) -> f64 {
        const SIDE: f64 = 1.0 / CATMULL_ROM_PARTS as f64;
        let query = self.query;
        let [across, down] = query.frame.edges.map(|[x, y]| [SIDE * x, SIDE * y]);
        let mut sum = 0.0;
        for (row, lines) in (0_u32..).zip(normals.windows(2)) {
            let [above, below] = lines else { continue };
            let pairs = above.windows(2).zip(below.windows(2));
            for (column, pair) in (0_u32..).zip(pairs) {
                let ([a, b], [c, d]) = pair else { continue };
                let (i, j) = (f64::from(column), f64::from(row));
                let place = [
                    corner[0] + i * across[0] + j * down[0],
                    corner[1] + i * across[1] + j * down[1],
                ];
                sum += query.square(place, [across, down], SIDE * SIDE, [*a, *b, *c, *d]);
            }
        }
        sum
    }
}

fn mean_of(normals: [[f64; 2]; 4]) -> [f64; 2] {
    let [[a, e], [b, f], [c, g], [d, h]] = normals;
    [0.25 * (a + b + c + d), 0.25 * (e + f + g + h)]
}
