//! The lists of a window in the inverse bin map.

use super::walk::Walk;
use super::window::{KeyRuns, WINDOW};
use super::{Sums, map_shape};
use crate::error::QueryError;
use crate::overlap::{Outline, Parallelogram, Probe};
use core::hint::black_box;
use core::ops::Range;
use glintbake_format::model::{ForestShape, Wrap};
use glintbake_format::view::BinTables;

/// Lists of a window.
pub(super) const LISTS: usize = WINDOW * WINDOW;

/// A list of the window and its tree.
#[derive(Clone, Copy)]
pub(super) struct List {
    /// The list's place among the sums.
    pub place: u32,
    /// The list's first texel in the inverse bin map.
    pub start: u32,
    pub end: u32,
    pub shape: ForestShape,
}

impl List {
    pub const NONE: Self = Self {
        place: 0,
        start: 0,
        end: 0,
        shape: ForestShape::new(0, 0, 1),
    };
}

/// The lists of a window that are not empty.
pub(super) struct Lists {
    lists: [List; LISTS],
    count: usize,
}

impl Lists {
    /// The lists of `runs`.
    pub fn new(tables: &BinTables<'_>, runs: &KeyRuns) -> Result<Self, QueryError> {
        // Fetches the runs' offsets all at once.
        for (start, _, _) in runs.iter() {
            black_box(tables.index.list(start).is_ok());
        }
        let mut lists = Self {
            lists: [List::NONE; LISTS],
            count: 0,
        };
        for (start, count, place) in runs.iter() {
            for (place, key) in (place..place + count).zip(start..) {
                let Range { start, end } = tables.index.list(key)?;
                if start < end
                    && let Some(slot) = lists.lists.get_mut(lists.count)
                {
                    *slot = List {
                        place,
                        start,
                        end,
                        shape: ForestShape::new(start, end - start, tables.instance.leaf_size),
                    };
                    lists.count += 1;
                }
            }
        }
        Ok(lists)
    }

    /// The number of texels of the longest list.
    pub fn longest(&self) -> u32 {
        let lengths = self.as_slice().iter().map(|list| list.end - list.start);
        lengths.max().unwrap_or(0)
    }

    /// Without the lists of more than `longest` texels.
    pub fn up_to(mut self, longest: u32) -> Self {
        let mut kept = 0;
        for number in 0..self.count {
            let list = self.lists.get(number).copied().unwrap_or(List::NONE);
            if list.end - list.start <= longest
                && let Some(slot) = self.lists.get_mut(kept)
            {
                *slot = list;
                kept += 1;
            }
        }
        self.count = kept;
        self
    }

    fn as_slice(&self) -> &[List] {
        self.lists.get(..self.count).unwrap_or_default()
    }
}

impl Sums {
    /// Replaces the sums of `lists` by the weights of their texels under `footprint`.
    pub(super) fn traverse(
        &mut self,
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
        lists: &Lists,
    ) -> Result<(), QueryError> {
        let lists = lists.as_slice();
        if lists.is_empty() {
            return Ok(());
        }
        for list in lists {
            self.clear(list.place);
        }
        let shape = map_shape(tables);
        let outline = Outline::new(footprint);
        let outline = outline.as_ref();
        if shape.wrap == Wrap::Clamp || shape.holds(footprint) {
            return self.traverse_tile(tables, footprint, outline, lists);
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
                    self.traverse_tile(tables, &tile, outline, lists)?;
                }
            }
        }
        if whole_tiles > 0 {
            let weight = whole_tiles as f64 * footprint.texel_weight();
            for list in lists {
                self.add(list.place, f64::from(list.end - list.start) * weight);
            }
        }
        Ok(())
    }

    /// Adds what the part of `footprint` in the first tile covers; all of it if the map is clamped.
    fn traverse_tile(
        &mut self,
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
        outline: Option<&Outline>,
        lists: &[List],
    ) -> Result<(), QueryError> {
        let shape = map_shape(tables);
        let probe = Probe::new(footprint, outline);
        let unbounded = shape.wrap == Wrap::Clamp && !shape.holds(footprint);
        let mut walk = Walk::new(tables, footprint, probe, unbounded);
        walk.lists(lists)?;
        for (list, weight) in lists.iter().zip(walk.weights()) {
            self.add(list.place, weight);
        }
        Ok(())
    }
}
