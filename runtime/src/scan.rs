//! Visiting every texel under a footprint with its weight.

use crate::error::QueryError;
use crate::overlap::{Parallelogram, TexelBox};
use glintbake_format::model::Wrap;

/// Texels a scan may visit, as a multiple of the map's: enough for footprints of a few tiles, and a bound in time.
const BUDGET_MAPS: u64 = 16;
/// What a scan may visit on any map, however small.
const BUDGET_LEAST: u64 = 1 << 16;

/// The size and wrap of a map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MapShape {
    pub width: u32,
    pub height: u32,
    pub wrap: Wrap,
}

impl MapShape {
    /// Calls `visit(column, row, weight)` for every texel under `footprint`; the weights add up to 1.
    ///
    /// A texel is visited as often as the footprint meets it in different tiles. Tiles wholly inside are visited
    /// once, with their number in the weight.
    ///
    /// # Errors
    /// [`QueryError::TooManyTexels`] beyond 16 times the map, or what `visit` returns.
    pub fn scan(
        self,
        footprint: &Parallelogram,
        visit: &mut impl FnMut(u32, u32, f64) -> Result<(), QueryError>,
    ) -> Result<(), QueryError> {
        let map_texels = u64::from(self.width) * u64::from(self.height);
        let limit = (BUDGET_MAPS * map_texels).max(BUDGET_LEAST);
        let mut budget = Budget { left: limit, limit };
        if self.wrap == Wrap::Clamp {
            return self.scan_rows(footprint, footprint.rows(1.0), None, &mut budget, visit);
        }
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let mut whole_tiles = 0_u64;
        for tile_row in footprint.rows(height) {
            let span = footprint.row_span(tile_row as f64, width, height);
            whole_tiles += span.inside.end.abs_diff(span.inside.start);
            for tile_column in span.touched.clone() {
                if span.inside.contains(&tile_column) {
                    continue;
                }
                let tile =
                    footprint.relative_to(tile_column as f64 * width, tile_row as f64 * height);
                let rows = tile.rows(1.0);
                let rows = rows.start.max(0)..rows.end.min(i64::from(self.height));
                let columns = 0..i64::from(self.width);
                self.scan_rows(&tile, rows, Some(columns), &mut budget, visit)?;
            }
        }
        if whole_tiles > 0 {
            let weight = whole_tiles as f64 * footprint.texel_weight();
            for row in 0..self.height {
                for column in 0..self.width {
                    visit(column, row, weight)?;
                }
            }
        }
        Ok(())
    }

    fn scan_rows(
        self,
        footprint: &Parallelogram,
        rows: core::ops::Range<i64>,
        columns: Option<core::ops::Range<i64>>,
        budget: &mut Budget,
        visit: &mut impl FnMut(u32, u32, f64) -> Result<(), QueryError>,
    ) -> Result<(), QueryError> {
        let whole = footprint.texel_weight();
        for row in rows {
            let mut span = footprint.row_span(row as f64, 1.0, 1.0);
            if let Some(columns) = &columns {
                span.touched =
                    span.touched.start.max(columns.start)..span.touched.end.min(columns.end);
            }
            let touched = span.touched.end.saturating_sub(span.touched.start).max(0) as u64;
            budget.spend(touched)?;
            let map_row = into_map(row, self.height);
            for column in span.touched {
                let weight = if span.inside.contains(&column) {
                    whole
                } else {
                    let low = [column as f64, row as f64];
                    footprint.weight(&TexelBox {
                        low,
                        high: [low[0] + 1.0, low[1] + 1.0],
                    })
                };
                if weight > 0.0 {
                    visit(into_map(column, self.width), map_row, weight)?;
                }
            }
        }
        Ok(())
    }

    /// Column and row, on the map, of the texel under the point of `footprint` at parameters (`a`, `b`).
    pub fn texel_at(self, footprint: &Parallelogram, a: f64, b: f64) -> (u32, u32) {
        let fold = |cell: i64, size: u32| match self.wrap {
            Wrap::Repeat => cell.rem_euclid(i64::from(size)) as u32,
            Wrap::Clamp => into_map(cell, size),
        };
        let [column, row] = footprint.texel(a, b);
        (fold(column, self.width), fold(row, self.height))
    }
}

/// Texels a scan may still visit.
struct Budget {
    left: u64,
    limit: u64,
}

impl Budget {
    fn spend(&mut self, texels: u64) -> Result<(), QueryError> {
        let limit = self.limit;
        self.left = self
            .left
            .checked_sub(texels)
            .ok_or(QueryError::TooManyTexels { limit })?;
        Ok(())
    }
}

/// `cell` clamped to the map of `size` cells; the identity where a scan is restricted to the map already.
fn into_map(cell: i64, size: u32) -> u32 {
    cell.clamp(0, i64::from(size) - 1) as u32
}
