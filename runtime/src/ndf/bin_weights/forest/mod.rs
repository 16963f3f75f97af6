//! Weights from the inverse bin map and its forest, \[AWKK21\] §5.4.

mod walk;

use super::map_shape;
use super::sums::Sums;
use super::window::{KeyRuns, WINDOW};
use crate::error::QueryError;
use crate::overlap::{Outline, Parallelogram, Probe};
use core::hint::black_box;
use core::ops::Range;
use glintbake_format::model::{ForestShape, Wrap};
use glintbake_format::records::TexelPosition;
use glintbake_format::view::{BinTables, InverseBinMap};
use walk::Walk;

/// Lists of a window.
const LISTS: usize = WINDOW * WINDOW;

/// A list of the window and its tree.
#[derive(Clone, Copy)]
struct List {
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
pub(in crate::ndf::bin_weights) struct Lists {
    lists: [List; LISTS],
    count: usize,
}

impl Lists {
    /// The lists of `runs`.
    pub fn new(
        tables: &BinTables<'_>,
        inverse: &InverseBinMap<'_>,
        runs: &KeyRuns,
    ) -> Result<Self, QueryError> {
        // Fetches the runs' offsets all at once.
        for (start, _, _) in runs.iter() {
            black_box(inverse.list(start).is_ok());
        }
        let mut lists = Self {
            lists: [List::NONE; LISTS],
            count: 0,
        };
        for (start, count, place) in runs.iter() {
            for (place, key) in (place..place + count).zip(start..) {
                let Range { start, end } = inverse.list(key)?;
                if start < end
                    && let Some(slot) = lists.lists.get_mut(lists.count)
                {
                    *slot = List {
                        place,
                        start,
                        end,
                        shape: ForestShape::new(start, end - start, tables.bins.leaf_size),
                    };
                    lists.count += 1;
                }
            }
        }
        Ok(lists)
    }

    /// The numbers of texels of the lists.
    pub fn lengths(&self) -> impl Iterator<Item = u32> {
        self.as_slice().iter().map(|list| list.end - list.start)
    }

    fn as_slice(&self) -> &[List] {
        self.lists.get(..self.count).unwrap_or_default()
    }

    /// Adds the weights of the lists' texels under the part of a footprint in one tile.
    pub fn traverse(
        &self,
        sums: &mut Sums,
        tables: &BinTables<'_>,
        inverse: &InverseBinMap<'_>,
        tile: &Parallelogram,
        outline: Option<&Outline>,
    ) -> Result<(), QueryError> {
        let shape = map_shape(tables);
        let unbounded = shape.wrap == Wrap::Clamp && !shape.holds(tile);
        let probe = Probe::new(tile, outline);
        Walk::new(tables, inverse, tile, probe, unbounded, sums).lists(self.as_slice())
    }

    /// The place and the texels of each list.
    pub fn positions<'p>(
        &self,
        inverse: &InverseBinMap<'p>,
    ) -> impl Iterator<Item = (u32, &'p [TexelPosition])> {
        self.as_slice().iter().map(|list| {
            let texels = list.start as usize..list.end as usize;
            (
                list.place,
                inverse.positions.get(texels).unwrap_or_default(),
            )
        })
    }

    /// Counts every texel of the lists `times` times.
    pub fn count(&self, sums: &mut Sums, times: u64) {
        for list in self.as_slice() {
            sums.add_inside(list.place, u64::from(list.end - list.start) * times);
        }
    }
}
