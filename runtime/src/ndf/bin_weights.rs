//! Weights `W_j` of a few neighbouring bins over a footprint, \[AWKK21\] §5.4.
//!
//! Two ways to the same numbers: scan the bin map under the footprint, or look the bins' texels up in the inverse
//! bin map and its forest. The first is cheaper for few texels, the second does not grow with their number.

use crate::error::QueryError;
use crate::overlap::{Parallelogram, Relation, TexelBox};
use crate::scan::MapShape;
use core::ops::Range;
use glintbake_format::model::{ForestShape, Neighbourhood, Wrap};
use glintbake_format::records::{BoxRecord, FOREST};
use glintbake_format::view::BinTables;
use glintbake_format::{Fault, Finding};

/// Bins per side of the largest window.
const WINDOW: usize = 7;

/// Footprint area, in texels, below which scanning the bin map is the cheaper way.
///
/// Measured with `cargo bench -p glintbake-tests --bench weights`: on flakes, brushed and noise maps at α = 0.01 the
/// two ways break even between 1 000 and 6 000 texels.
const SCAN_BELOW_TEXELS: f64 = 2000.0;

/// Which way to the weights a query takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Lookup {
    /// The cheaper way by the footprint's area.
    #[default]
    Auto,
    /// Scan the bin map.
    Scan,
    /// Traverse the inverse bin map.
    Lists,
}

/// The bins around one bin of which weights are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BinWindow {
    pub column: u32,
    pub row: u32,
    /// `None` for the one bin alone.
    pub neighbourhood: Option<Neighbourhood>,
}

impl BinWindow {
    fn reach(self) -> i32 {
        self.neighbourhood.map_or(0, Neighbourhood::reach)
    }

    /// The place of the bin (`column`, `row`) in [`BinWeights`], if it belongs to the window.
    fn place(self, column: u32, row: u32) -> Option<usize> {
        let dx = i64::from(column) - i64::from(self.column);
        let dy = i64::from(row) - i64::from(self.row);
        let reach = i64::from(self.reach());
        if dx.abs() > reach || dy.abs() > reach {
            return None;
        }
        let holds = self
            .neighbourhood
            .is_none_or(|neighbourhood| neighbourhood.holds(dx as i32, dy as i32));
        holds.then_some((dy + reach) as usize * WINDOW + (dx + reach) as usize)
    }

    /// Row and columns of the window's bins on a grid of `resolution` bins a side, row by row; x and y are clipped
    /// apart, so that no neighbour leaks into the next row.
    fn runs(self, resolution: u32) -> impl Iterator<Item = (u32, Range<u32>)> {
        let reach = self.reach();
        (-reach..=reach).filter_map(move |dy| {
            let row = self.row.checked_add_signed(dy)?;
            // The outermost rows lack their corners.
            let wide = self
                .neighbourhood
                .is_none_or(|neighbourhood| neighbourhood.holds(reach, dy));
            let side = reach.unsigned_abs() - u32::from(!wide);
            let columns = self.column.saturating_sub(side)
                ..self.column.saturating_add(side + 1).min(resolution);
            (row < resolution).then_some((row, columns))
        })
    }
}

/// Weights of a window's bins; those outside the window or the grid are zero.
#[derive(Clone, Debug)]
pub(crate) struct BinWeights {
    window: BinWindow,
    weights: [f64; WINDOW * WINDOW],
}

impl BinWeights {
    /// The weights of the bins of `window` over `footprint`.
    ///
    /// # Errors
    /// [`QueryError::TooManyTexels`] from a forced scan, [`QueryError::Damaged`].
    pub fn new(
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
        window: BinWindow,
        lookup: Lookup,
    ) -> Result<Self, QueryError> {
        let mut weights = Self {
            window,
            weights: [0.0; WINDOW * WINDOW],
        };
        let bounds = footprint.bounds();
        let reach = (bounds.high[0] - bounds.low[0]).max(bounds.high[1] - bounds.low[1]);
        let scan = match lookup {
            Lookup::Auto => footprint.area() + 2.0 * reach < SCAN_BELOW_TEXELS,
            Lookup::Scan => true,
            Lookup::Lists => false,
        };
        if scan {
            weights.scan(tables, footprint)?;
        } else {
            weights.traverse(tables, footprint)?;
        }
        Ok(weights)
    }

    /// Column, row and weight of every bin that has weight.
    pub fn nonzero(&self) -> impl Iterator<Item = (u32, u32, f64)> {
        let reach = self.window.reach();
        (-reach..=reach)
            .zip(self.weights.chunks_exact(WINDOW))
            .flat_map(move |(dy, row)| {
                (-reach..=reach)
                    .zip(row)
                    .filter(|(_, weight)| **weight > 0.0)
                    .map(move |(dx, &weight)| {
                        (
                            self.window.column.wrapping_add_signed(dx),
                            self.window.row.wrapping_add_signed(dy),
                            weight,
                        )
                    })
            })
    }

    fn add(&mut self, column: u32, row: u32, weight: f64) {
        if let Some(place) = self.window.place(column, row)
            && let Some(sum) = self.weights.get_mut(place)
        {
            *sum += weight;
        }
    }

    fn scan(
        &mut self,
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
    ) -> Result<(), QueryError> {
        let grid = tables.instance.grid;
        // Keys rise with bin numbers, so that two comparisons turn most texels away.
        let (mut least, mut end) = (u32::MAX, 0);
        for (row, columns) in self.window.runs(grid.resolution()) {
            let run = tables
                .index
                .keys(grid.number(columns.start, row)..grid.number(columns.end, row));
            least = least.min(run.start);
            end = end.max(run.end);
        }
        let keys = least..end;
        map_shape(tables).scan(footprint, &mut |column, row, weight| {
            let texel = tables.texel(column, row);
            let key = tables.bin_map.key(texel).unwrap_or(u32::MAX);
            if keys.contains(&key) {
                let (column, row) = grid.column_row(tables.index.bin_of_key(key)?);
                self.add(column, row, weight);
            }
            Ok(())
        })
    }

    fn traverse(
        &mut self,
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
    ) -> Result<(), QueryError> {
        let shape = map_shape(tables);
        if shape.wrap == Wrap::Clamp {
            return self.traverse_tile(tables, footprint);
        }
        let (width, height) = (f64::from(shape.width), f64::from(shape.height));
        let mut whole_tiles = 0_u64;
        for tile_row in footprint.rows(height) {
            let span = footprint.row_span(tile_row as f64, width, height);
            whole_tiles += span.inside.end.abs_diff(span.inside.start);
            for tile_column in span.touched.clone() {
                if !span.inside.contains(&tile_column) {
                    let tile =
                        footprint.relative_to(tile_column as f64 * width, tile_row as f64 * height);
                    self.traverse_tile(tables, &tile)?;
                }
            }
        }
        if whole_tiles > 0 {
            let weight = whole_tiles as f64 * footprint.texel_weight();
            self.for_each_list(tables, &mut |list| {
                Ok(f64::from(list.end - list.start) * weight)
            })?;
        }
        Ok(())
    }

    fn traverse_tile(
        &mut self,
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
    ) -> Result<(), QueryError> {
        self.for_each_list(tables, &mut |list| list_weight(tables, footprint, list))
    }

    /// Adds what `weigh` says of each list of the window.
    fn for_each_list(
        &mut self,
        tables: &BinTables<'_>,
        weigh: &mut impl FnMut(Range<u32>) -> Result<f64, QueryError>,
    ) -> Result<(), QueryError> {
        let grid = tables.instance.grid;
        for (row, columns) in self.window.runs(grid.resolution()) {
            let bins = grid.number(columns.start, row)..grid.number(columns.end, row);
            for key in tables.index.keys(bins) {
                let list = tables.index.list(key)?;
                if !list.is_empty() {
                    let (column, row) = grid.column_row(tables.index.bin_of_key(key)?);
                    self.add(column, row, weigh(list)?);
                }
            }
        }
        Ok(())
    }
}

pub(crate) fn map_shape(tables: &BinTables<'_>) -> MapShape {
    MapShape {
        width: tables.instance.width,
        height: tables.instance.height,
        wrap: tables.instance.wrap,
    }
}

/// The weight of the texels at `list` of the inverse bin map over the part of `footprint` in the first tile.
///
/// Depth first over the list's tree: a box outside is skipped, one inside counts by its number of texels, and the
/// texels of a crossing leaf are clipped one by one. Each node is visited at most once and covers texels no other
/// node of its level covers, so the work is bounded by the list's length whatever the bytes say.
fn list_weight(
    tables: &BinTables<'_>,
    footprint: &Parallelogram,
    list: Range<u32>,
) -> Result<f64, QueryError> {
    let shape = ForestShape::new(
        list.start,
        list.end.saturating_sub(list.start),
        tables.instance.leaf_size,
    );
    if shape.depth() == 0 {
        return leaf_weight(tables, footprint, list);
    }
    let forest_missing = || {
        QueryError::Damaged(
            Finding::new(Fault::SectionMissing).within(tables.instance.section(FOREST)),
        )
    };
    let nodes = tables.forest.ok_or_else(forest_missing)?;
    let mut weight = 0.0;
    let mut whole_texels = 0_u64;
    // Level and number of inner nodes to open; one sibling a level waits at most.
    let mut waiting = [(0_u32, 0_u32); ForestShape::MAX_DEPTH as usize + 1];
    let mut count = 1_usize;
    while count > 0 {
        count -= 1;
        let (level, node) = waiting.get(count).copied().unwrap_or_default();
        let record = nodes
            .get(shape.slot(level, node) as usize)
            .ok_or_else(forest_missing)?;
        let below = level + 1;
        for (child, bounds) in (node.wrapping_mul(2)..).zip(record.children) {
            let first = list.start + shape.first_texel(below, child);
            let last = list.start + shape.first_texel(below, child.wrapping_add(1));
            match footprint.relation(&box_in_texels(tables, &bounds)) {
                Relation::Outside => {}
                Relation::Inside => whole_texels += u64::from(last.saturating_sub(first)),
                Relation::Crossing if below == shape.depth() => {
                    weight += leaf_weight(tables, footprint, first..last)?;
                }
                Relation::Crossing => {
                    if let Some(slot) = waiting.get_mut(count) {
                        *slot = (below, child);
                        count += 1;
                    }
                }
            }
        }
    }
    if whole_texels > 0 {
        weight += whole_texels as f64 * footprint.texel_weight();
    }
    Ok(weight)
}

fn leaf_weight(
    tables: &BinTables<'_>,
    footprint: &Parallelogram,
    list: Range<u32>,
) -> Result<f64, QueryError> {
    let positions = tables
        .positions
        .get(list.start as usize..list.end as usize)
        .ok_or(Finding::new(Fault::IndexOrder))?;
    let mut weight = 0.0;
    let mut whole_texels = 0_u32;
    for position in positions {
        let texel = box_in_texels(
            tables,
            &BoxRecord {
                first_column: position.column,
                first_row: position.row,
                last_column: position.column,
                last_row: position.row,
            },
        );
        match footprint.relation(&texel) {
            Relation::Outside => {}
            Relation::Inside => whole_texels += 1,
            Relation::Crossing => weight += footprint.weight(&texel),
        }
    }
    if whole_texels > 0 {
        weight += f64::from(whole_texels) * footprint.texel_weight();
    }
    Ok(weight)
}

/// The area of texture the texels from one corner of `bounds` to the other cover; without end beyond the border of
/// a clamped map.
#[inline]
fn box_in_texels(tables: &BinTables<'_>, bounds: &BoxRecord) -> TexelBox {
    let mut texels = TexelBox {
        low: [
            f64::from(bounds.first_column.get()),
            f64::from(bounds.first_row.get()),
        ],
        high: [
            f64::from(bounds.last_column.get()) + 1.0,
            f64::from(bounds.last_row.get()) + 1.0,
        ],
    };
    let instance = &tables.instance;
    if instance.wrap == Wrap::Clamp {
        let size = [f64::from(instance.width), f64::from(instance.height)];
        texels.low = texels
            .low
            .map(|low| if low <= 0.0 { f64::NEG_INFINITY } else { low });
        for (high, size) in texels.high.iter_mut().zip(size) {
            if *high >= size {
                *high = f64::INFINITY;
            }
        }
    }
    texels
}
