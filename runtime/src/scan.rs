//! Visiting every texel under a footprint with its weight, a few rows of the map at a time.

use crate::error::QueryError;
use crate::overlap::{CoveredRow, Outline, Parallelogram, TexelBox};
use core::ops::Range;
use glintbake_format::model::Wrap;

/// Texels a scan may visit, as a multiple of the map's: enough for footprints of a few tiles, and a bound in time.
const BUDGET_MAPS: u64 = 16;
/// What a scan may visit on any map, however small.
const BUDGET_LEAST: u64 = 1 << 16;
/// How many times as many under a Gaussian, whose ellipse has 18 times the area of the box of the same edges.
const GAUSSIAN_BUDGET: u64 = 8;
/// Rows handed out together. Rows of a map are pages apart in memory, and whoever waits for the first texel of one
/// may as well wait for several.
const ROWS: usize = 8;

/// The size and wrap of a map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MapShape {
    pub width: u32,
    pub height: u32,
    pub wrap: Wrap,
}

/// Neighbouring texels of one row of the map, and what a footprint weighs them.
///
/// Most rows of a large footprint are of one weight but for their ends: whoever wants only some of the texels reads
/// the map first and asks for the weights of those few.
#[derive(Clone, Debug)]
pub(crate) struct TexelRow<'a> {
    /// Row of the map.
    pub row: u32,
    /// The columns that may hold weight.
    pub columns: Range<u32>,
    /// Those of them, possibly none, that all weigh [`even_weight`](Self::even_weight).
    pub even: Range<u32>,
    pub even_weight: f64,
    ends: Ends<'a>,
}

/// Where the weights of texels come from that are not even.
#[derive(Clone, Debug)]
enum Ends<'a> {
    /// There are none.
    None,
    Covered(CoveredRow),
    /// Of a footprint too thin for coverage, in this row of its tile.
    Clipped(&'a Parallelogram, f64),
}

impl TexelRow<'_> {
    const EMPTY: Self = Self {
        row: 0,
        columns: 0..0,
        even: 0..0,
        even_weight: 0.0,
        ends: Ends::None,
    };

    /// Texels in columns `columns` that weigh `weight` each.
    fn even(row: u32, columns: Range<u32>, weight: f64) -> Self {
        Self {
            row,
            columns: columns.clone(),
            even: columns,
            even_weight: weight,
            ends: Ends::None,
        }
    }

    /// The weight of the texel in column `column`, one of [`columns`](Self::columns).
    #[inline]
    pub fn weight(&self, column: u32) -> f64 {
        if self.even.contains(&column) {
            self.even_weight
        } else {
            self.ends.weight(i64::from(column))
        }
    }
}

impl Ends<'_> {
    fn weight(&self, column: i64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Covered(row) => row.weight(column),
            Self::Clipped(footprint, row) => {
                let low = [column as f64, *row];
                footprint.weight(&TexelBox {
                    low,
                    high: [low[0] + 1.0, low[1] + 1.0],
                })
            }
        }
    }
}

impl MapShape {
    /// Calls `visit` for the texels under `footprint`, a few rows at a time; the weights add up to 1.
    ///
    /// A texel is visited as often as the footprint meets it in different tiles, and the border's texels of a
    /// clamped map once more for what lies beyond. Tiles wholly inside are visited once, with their number in the
    /// weight.
    ///
    /// # Errors
    /// [`QueryError::TooManyTexels`] beyond 16 times the map, or what `visit` returns.
    pub fn scan(
        self,
        footprint: &Parallelogram,
        visit: &mut impl FnMut(&[TexelRow<'_>]) -> Result<(), QueryError>,
    ) -> Result<(), QueryError> {
        let mut budget = Budget::new(self);
        let outline = Outline::new(footprint);
        let outline = outline.as_ref();
        let whole_tiles = self.for_each_copy(footprint, &mut |tile| {
            self.scan_tile(tile, outline, &mut budget, visit)
        })?;
        if whole_tiles > 0 {
            let weight = whole_tiles as f64 * footprint.texel_weight();
            let mut rows = Rows::new(visit);
            for row in 0..self.height {
                rows.push(TexelRow::even(row, 0..self.width, weight))?;
            }
            rows.hand_out()?;
        }
        Ok(())
    }

    /// Calls `visit` with `footprint` as seen from each tile that it covers in part, and returns the number of those that
    /// lie wholly inside. On a clamped map there is but one tile.
    #[inline(always)]
    pub fn for_each_copy(
        self,
        footprint: &Parallelogram,
        visit: &mut impl FnMut(&Parallelogram) -> Result<(), QueryError>,
    ) -> Result<u64, QueryError> {
        if self.wrap == Wrap::Clamp || self.holds(footprint) {
            visit(footprint)?;
            return Ok(0);
        }
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let mut whole_tiles = 0_u64;
        for tile_row in footprint.rows(height) {
            let span = footprint.row_span(tile_row as f64, width, height);
            whole_tiles += span.inside.end.abs_diff(span.inside.start);
            for tile_column in span.touched.clone() {
                if !span.inside.contains(&tile_column) {
                    visit(
                        &footprint
                            .relative_to(tile_column as f64 * width, tile_row as f64 * height),
                    )?;
                }
            }
        }
        Ok(whole_tiles)
    }

    /// Whether `footprint` lies within the first tile.
    pub fn holds(self, footprint: &Parallelogram) -> bool {
        let TexelBox { low, high } = footprint.bounds();
        low[0] >= 0.0
            && low[1] >= 0.0
            && high[0] <= f64::from(self.width)
            && high[1] <= f64::from(self.height)
    }

    /// Visits the part of `footprint` in the first tile, or all of it if the map is clamped.
    fn scan_tile(
        self,
        footprint: &Parallelogram,
        outline: Option<&Outline>,
        budget: &mut Budget,
        visit: &mut impl FnMut(&[TexelRow<'_>]) -> Result<(), QueryError>,
    ) -> Result<(), QueryError> {
        let clamped = self.wrap == Wrap::Clamp;
        let size = i64::from(self.height);
        let mut rows = footprint.rows(1.0);
        if !clamped {
            rows = within(&rows, size);
        }
        let tile = 0..i64::from(self.width);
        let mut handed = Rows::new(visit);
        for row in rows {
            let (touched, even, even_weight, ends) = match outline {
                Some(outline) => {
                    let covered = outline.row(footprint, row);
                    let (touched, even, even_weight) = covered.columns();
                    (touched, even, even_weight, Ends::Covered(covered))
                }
                None => {
                    let span = footprint.row_span(row as f64, 1.0, 1.0);
                    let ends = Ends::Clipped(footprint, row as f64);
                    (span.touched, span.inside, footprint.texel_weight(), ends)
                }
            };
            let columns = within(&touched, tile.end);
            let spent = if clamped { &touched } else { &columns };
            budget.spend(spent.end.abs_diff(spent.start))?;
            let row = row.clamp(0, size - 1) as u32;
            if clamped {
                for (beyond, border) in [
                    (touched.start..touched.end.min(0), 0),
                    (touched.start.max(tile.end)..touched.end, self.width - 1),
                ] {
                    let weight = total(&beyond, &even, even_weight, &ends);
                    if weight > 0.0 {
                        let columns = border..border.saturating_add(1);
                        handed.push(TexelRow::even(row, columns, weight))?;
                    }
                }
            }
            if !columns.is_empty() {
                let even_start = even.start.clamp(columns.start, columns.end);
                let even_end = even.end.clamp(even_start, columns.end);
                handed.push(TexelRow {
                    row,
                    columns: columns.start as u32..columns.end as u32,
                    even: even_start as u32..even_end as u32,
                    even_weight,
                    ends,
                })?;
            }
        }
        handed.hand_out()
    }

    /// Column and row, on the map, of the texel under the point of `footprint` at parameters (`a`, `b`).
    pub fn texel_at(self, footprint: &Parallelogram, a: f64, b: f64) -> (u32, u32) {
        self.fold(footprint.texel(a, b))
    }

    /// Column and row, on the map, of the texel in column and row `texel` of endless texture.
    pub fn fold(self, [column, row]: [i64; 2]) -> (u32, u32) {
        let fold = |cell: i64, size: u32| match self.wrap {
            Wrap::Repeat => cell.rem_euclid(i64::from(size)) as u32,
            Wrap::Clamp => cell.clamp(0, i64::from(size) - 1) as u32,
        };
        (fold(column, self.width), fold(row, self.height))
    }
}

/// Rows that wait to be handed to a visitor together.
struct Rows<'a, 'v, V> {
    rows: [TexelRow<'a>; ROWS],
    count: usize,
    visit: &'v mut V,
}

impl<'a, 'v, V> Rows<'a, 'v, V>
where
    V: FnMut(&[TexelRow<'_>]) -> Result<(), QueryError>,
{
    fn new(visit: &'v mut V) -> Self {
        Self {
            rows: [const { TexelRow::EMPTY }; ROWS],
            count: 0,
            visit,
        }
    }

    #[inline]
    fn push(&mut self, row: TexelRow<'a>) -> Result<(), QueryError> {
        if self.count == ROWS {
            self.hand_out()?;
        }
        if let Some(slot) = self.rows.get_mut(self.count) {
            *slot = row;
            self.count += 1;
        }
        Ok(())
    }

    fn hand_out(&mut self) -> Result<(), QueryError> {
        let rows = self.rows.get(..self.count).unwrap_or_default();
        self.count = 0;
        (self.visit)(rows)
    }
}

/// The weight of all texels in columns `columns`, of which those in `even` weigh `even_weight`.
fn total(columns: &Range<i64>, even: &Range<i64>, even_weight: f64, ends: &Ends<'_>) -> f64 {
    let start = even
        .start
        .clamp(columns.start, columns.end.max(columns.start));
    let end = even.end.clamp(start, columns.end.max(start));
    let mut sum: f64 = (columns.start..start)
        .chain(end..columns.end)
        .map(|column| ends.weight(column))
        .sum();
    // A footprint without area has an infinite weight for the even texels it lacks.
    if start < end {
        sum += (end - start) as f64 * even_weight;
    }
    sum
}

/// The part of `cells` on a map of `size` cells; empty ranges stay in bounds.
fn within(cells: &Range<i64>, size: i64) -> Range<i64> {
    let start = cells.start.clamp(0, size);
    start..cells.end.clamp(start, size)
}

/// Texels a scan may still visit.
pub(crate) struct Budget {
    left: u64,
    limit: u64,
}

impl Budget {
    /// What a scan of a map of `shape` may visit.
    pub fn new(shape: MapShape) -> Self {
        let map_texels = u64::from(shape.width) * u64::from(shape.height);
        let limit = (BUDGET_MAPS * map_texels).max(BUDGET_LEAST);
        Self { left: limit, limit }
    }

    /// What a scan may visit of a map of `shape` under a Gaussian, which reaches further than a box of its edges.
    pub fn for_gaussian(shape: MapShape) -> Self {
        let limit = GAUSSIAN_BUDGET * Self::new(shape).limit;
        Self { left: limit, limit }
    }

    pub fn spend(&mut self, texels: u64) -> Result<(), QueryError> {
        let limit = self.limit;
        self.left = self
            .left
            .checked_sub(texels)
            .ok_or(QueryError::TooManyTexels { limit })?;
        Ok(())
    }
}
