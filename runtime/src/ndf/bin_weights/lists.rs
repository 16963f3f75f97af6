//! Weights from the inverse bin map and its forest.

use super::window::KeyRuns;
use super::{Sums, map_shape};
use crate::error::QueryError;
use crate::overlap::{Parallelogram, Relation, TexelBox};
use core::ops::Range;
use glintbake_format::model::{ForestShape, Wrap};
use glintbake_format::records::{BoxRecord, FOREST};
use glintbake_format::view::BinTables;
use glintbake_format::{Fault, Finding};

impl Sums {
    /// Adds the weights of all texels under `footprint` whose keys are in `runs`.
    pub(super) fn traverse(
        &mut self,
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
        runs: &KeyRuns,
    ) -> Result<(), QueryError> {
        let shape = map_shape(tables);
        if shape.wrap == Wrap::Clamp {
            return self.traverse_tile(tables, footprint, runs);
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
                    self.traverse_tile(tables, &tile, runs)?;
                }
            }
        }
        if whole_tiles > 0 {
            let weight = whole_tiles as f64 * footprint.texel_weight();
            self.for_each_list(tables, runs, &mut |list| {
                Ok(f64::from(list.end - list.start) * weight)
            })?;
        }
        Ok(())
    }

    fn traverse_tile(
        &mut self,
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
        runs: &KeyRuns,
    ) -> Result<(), QueryError> {
        self.for_each_list(tables, runs, &mut |list| {
            list_weight(tables, footprint, list)
        })
    }

    /// Adds what `weigh` says of each list of the window.
    fn for_each_list(
        &mut self,
        tables: &BinTables<'_>,
        runs: &KeyRuns,
        weigh: &mut impl FnMut(Range<u32>) -> Result<f64, QueryError>,
    ) -> Result<(), QueryError> {
        for (start, count, place) in runs.iter() {
            for (place, key) in (place..place + count).zip(start..) {
                let list = tables.index.list(key)?;
                if !list.is_empty() {
                    self.add(place as usize, weigh(list)?);
                }
            }
        }
        Ok(())
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
