//! Weights from the bin map under the footprint.

use super::window::KeyRuns;
use super::{Sums, map_shape};
use crate::error::QueryError;
use crate::overlap::Parallelogram;
use crate::scan::TexelRow;
use glintbake_format::view::{BinMap, BinTables};
use glintbake_format::{Fault, Finding};
use zerocopy::little_endian::{U16, U32};

/// Keys looked at together: most chunks hold none that is wanted, and to see that takes a few wide instructions.
const CHUNK: usize = 32;

/// A key as the bin map stores it.
trait StoredKey: Copy {
    fn number(self) -> u32;
    /// Whether any of `keys` is among the `spread` + 1 keys from `least`.
    fn any_within(keys: &[Self], least: u32, spread: u32) -> bool;
}

impl StoredKey for U16 {
    fn number(self) -> u32 {
        u32::from(self.get())
    }

    #[inline]
    fn any_within(keys: &[Self], least: u32, spread: u32) -> bool {
        let Ok(least) = u16::try_from(least) else {
            return false;
        };
        let spread = u16::try_from(spread).unwrap_or(u16::MAX);
        keys.iter().fold(false, |any, key| {
            any | (key.get().wrapping_sub(least) <= spread)
        })
    }
}

impl StoredKey for U32 {
    fn number(self) -> u32 {
        self.get()
    }

    #[inline]
    fn any_within(keys: &[Self], least: u32, spread: u32) -> bool {
        keys.iter().fold(false, |any, key| {
            any | (key.get().wrapping_sub(least) <= spread)
        })
    }
}

impl Sums {
    /// Adds the weights of all texels under `footprint` whose keys are in `runs`.
    pub(super) fn scan(
        &mut self,
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
        runs: &KeyRuns,
    ) -> Result<(), QueryError> {
        let shape = map_shape(tables);
        match tables.bin_map {
            BinMap::Narrow(keys) => shape.scan(footprint, &mut |row| {
                self.add_row(runs, keys_under(keys, tables, row)?, row);
                Ok(())
            }),
            BinMap::Wide(keys) => shape.scan(footprint, &mut |row| {
                self.add_row(runs, keys_under(keys, tables, row)?, row);
                Ok(())
            }),
        }
    }

    fn add_row<K: StoredKey>(&mut self, runs: &KeyRuns, keys: &[K], row: &TexelRow<'_>) {
        for (first, chunk) in (row.columns.start..).step_by(CHUNK).zip(keys.chunks(CHUNK)) {
            if !K::any_within(chunk, runs.least, runs.spread) {
                continue;
            }
            for (column, key) in (first..).zip(chunk) {
                if let Some(place) = runs.place(key.number()) {
                    self.add(place, row.weight(column));
                }
            }
        }
    }
}

/// The keys of the texels of `row`.
fn keys_under<'a, K>(
    keys: &'a [K],
    tables: &BinTables<'_>,
    row: &TexelRow<'_>,
) -> Result<&'a [K], Finding> {
    let start = tables.texel(row.columns.start, row.row);
    let end = tables.texel(row.columns.end, row.row);
    keys.get(start..end)
        .ok_or(Finding::new(Fault::PositionRange).at(start as u64))
}
