//! Weights from the bin map under the footprint.

use super::frame::Frame;
use super::keys::StoredKey;
use super::sums::Sums;
use super::window::KeyRuns;
use crate::error::QueryError;
use crate::fetch::fetch;
use crate::scan::Budget;
use core::ops::Range;
use glintbake_format::model::BLOCK_TEXELS;
use glintbake_format::view::{BinTables, KeyLayout, Keys};
use glintbake_format::{Fault, Finding};

/// Keys looked at together. Many, since most blocks hold none that is wanted.
const TOGETHER: usize = 32;
/// Blocks of the next row that are asked for in advance; the processor foresees the rest of a long row by itself.
const FETCHED: usize = 16;

/// Adds the weights of all texels under the footprint of `frame` whose keys are in `runs` to `sums`.
pub(super) struct Scan<'s> {
    pub sums: &'s mut Sums,
    pub frame: &'s Frame<'s>,
    pub runs: &'s KeyRuns,
    pub budget: &'s mut Budget,
}

impl Scan<'_> {
    /// Adds them.
    pub fn run(self) -> Result<(), QueryError> {
        match self.frame.tables.bin_map.keys {
            Keys::Narrow(keys) => scan_keys(keys, self.sums, self.frame, self.runs, self.budget),
            Keys::Wide(keys) => scan_keys(keys, self.sums, self.frame, self.runs, self.budget),
        }
    }
}

#[inline(always)]
fn scan_keys<K: StoredKey>(
    keys: &[K],
    sums: &mut Sums,
    frame: &Frame<'_>,
    runs: &KeyRuns,
    budget: &mut Budget,
) -> Result<(), QueryError> {
    let layout = frame.tables.bin_map.layout;
    let mut space = [K::default(); BLOCK_TEXELS];
    let rows = frame.block_rows();
    let mut next = frame.block_columns(rows.start);
    fetch_blocks(layout, keys, next.clone(), rows.start);
    for row in rows.clone() {
        let columns = next;
        next = if row + 1 < rows.end {
            frame.block_columns(row + 1)
        } else {
            0..0
        };
        // Blocks of the next row, pages away, come while those of this one are looked at.
        fetch_blocks(layout, keys, next.clone(), row + 1);
        budget.spend(columns.len() as u64 * BLOCK_TEXELS as u64)?;
        for column in columns {
            let relation = frame.block(column, row);
            if !(relation.inside | relation.crossing) {
                continue;
            }
            let block = layout
                .block(keys, column, row, &mut space)
                .ok_or(missing(frame.tables))?;
            if relation.inside & frame.is_whole(column, row) {
                count_block(sums, runs, block);
            } else {
                frame.add_crossing_block(sums, runs, block, column, row);
            }
        }
    }
    Ok(())
}

/// Asks for the blocks in `columns` of row `row`, as far as a cache can hold them until they are looked at.
#[inline(always)]
fn fetch_blocks<K: StoredKey>(layout: KeyLayout, keys: &[K], columns: Range<u32>, row: u32) {
    if let KeyLayout::Blocks(layout) = layout {
        for column in columns.take(FETCHED) {
            let block = layout.block(column, row);
            fetch(keys, block);
            fetch(keys, block + BLOCK_TEXELS / 2);
        }
    }
}

/// Counts the texels of a block that lies inside.
#[inline(always)]
pub(super) fn count_block<K: StoredKey>(
    sums: &mut Sums,
    runs: &KeyRuns,
    block: &[K; BLOCK_TEXELS],
) {
    for keys in block.as_chunks::<TOGETHER>().0 {
        if K::any_wanted(keys, runs) {
            sums.count(&K::places(keys, runs));
        }
    }
}

/// Counts every texel of the map `times` times.
pub(super) fn count_map(
    sums: &mut Sums,
    tables: &BinTables<'_>,
    runs: &KeyRuns,
    times: u64,
) -> Result<(), QueryError> {
    let shape = super::map_shape(tables);
    for row in 0..shape.height {
        for column in 0..shape.width {
            let key = tables.bin_map.key(column, row).ok_or(missing(tables))?;
            if let Some(place) = runs.place(key) {
                sums.add_inside(place, times);
            }
        }
    }
    Ok(())
}

pub(super) fn missing(tables: &BinTables<'_>) -> Finding {
    Finding::new(Fault::PositionRange).within(tables.bin_map.id)
}
