//! Weights from the bin map under the footprint.

use super::window::{KeyRuns, WINDOW};
use super::{Sums, map_shape};
use crate::error::QueryError;
use crate::overlap::Parallelogram;
use crate::scan::TexelRow;
use glintbake_format::view::{BinMap, BinTables};
use glintbake_format::{Fault, Finding};
use zerocopy::little_endian::{U16, U32};

/// Keys looked at together. Everything that is done to a chunk has no branches and a fixed length, which a compiler
/// turns into vector instructions.
const CHUNK: usize = 32;
/// Places that a texel can be counted under: those of [`KeyRuns`] and [`ELSEWHERE`].
const PLACES: usize = 64;
/// The place of keys that no run holds. All ones: a place less one, where there is none, lands here.
const ELSEWHERE: u16 = u16::MAX;
const _: () = assert!(WINDOW * WINDOW < PLACES);
/// Tables of counts: neighbouring texels often share a bin, and a count must be stored before it can rise again.
const TABLES: usize = 4;

/// A key as the bin map stores it.
trait StoredKey: Copy {
    fn number(self) -> u32;

    /// Whether any of `keys` may be one of `runs`.
    fn any_wanted(keys: &[Self; CHUNK], runs: &KeyRuns) -> bool;

    /// The place of each key, or [`ELSEWHERE`].
    fn places(keys: &[Self; CHUNK], runs: &KeyRuns) -> [u16; CHUNK];
}

impl StoredKey for U16 {
    fn number(self) -> u32 {
        u32::from(self.get())
    }

    #[inline(always)]
    fn any_wanted(keys: &[Self; CHUNK], runs: &KeyRuns) -> bool {
        if let Some(lattice) = runs.lattice {
            return any(keys, |key| lattice.holds(key.get()));
        }
        let Ok(least) = u16::try_from(runs.least) else {
            return false;
        };
        let spread = u16::try_from(runs.spread).unwrap_or(u16::MAX);
        any(keys, |key| key.get().wrapping_sub(least) <= spread)
    }

    #[inline(always)]
    fn places(keys: &[Self; CHUNK], runs: &KeyRuns) -> [u16; CHUNK] {
        if let Some(lattice) = runs.lattice {
            return keys.map(|key| lattice.place(key.get(), ELSEWHERE));
        }
        // At most one run holds a key, so what they say can be put together bit by bit.
        let mut places = [0; CHUNK];
        for ((&start, &count), &first) in runs.starts.iter().zip(&runs.counts).zip(&runs.places) {
            let Ok(start) = u16::try_from(start) else {
                continue;
            };
            for (place, key) in places.iter_mut().zip(keys) {
                let offset = key.get().wrapping_sub(start);
                *place |= if offset < count as u16 {
                    first as u16 + offset + 1
                } else {
                    0
                };
            }
        }
        places.map(|place: u16| place.wrapping_sub(1))
    }
}

impl StoredKey for U32 {
    fn number(self) -> u32 {
        self.get()
    }

    #[inline(always)]
    fn any_wanted(keys: &[Self; CHUNK], runs: &KeyRuns) -> bool {
        any(keys, |key| {
            key.get().wrapping_sub(runs.least) <= runs.spread
        })
    }

    #[inline(always)]
    fn places(keys: &[Self; CHUNK], runs: &KeyRuns) -> [u16; CHUNK] {
        let mut places = [0; CHUNK];
        for ((&start, &count), &first) in runs.starts.iter().zip(&runs.counts).zip(&runs.places) {
            for (place, key) in places.iter_mut().zip(keys) {
                let offset = key.get().wrapping_sub(start);
                *place |= if offset < count {
                    first + offset + 1
                } else {
                    0
                };
            }
        }
        places.map(|place: u32| place.wrapping_sub(1) as u16)
    }
}

#[inline(always)]
fn any<K: Copy>(keys: &[K; CHUNK], wanted: impl Fn(K) -> bool) -> bool {
    keys.iter().fold(false, |any, &key| any | wanted(key))
}

/// Numbers of texels of one weight, by place.
struct Counts {
    tables: [[u32; PLACES]; TABLES],
    weight: f64,
    /// Texels counted since the tables were empty.
    counted: u32,
}

impl Counts {
    /// Counts a chunk of texels that weigh `weight` each.
    #[inline]
    fn add(&mut self, places: &[u16; CHUNK], sums: &mut Sums) {
        if self.counted > u32::MAX - CHUNK as u32 {
            self.pour(sums);
        }
        self.counted += CHUNK as u32;
        for places in places.as_chunks::<TABLES>().0 {
            for (table, place) in self.tables.iter_mut().zip(places) {
                if let Some(count) = table.get_mut(usize::from(*place) % PLACES) {
                    *count += 1;
                }
            }
        }
    }

    /// Counts texels of `weight` from now on.
    #[inline]
    fn weigh(&mut self, weight: f64, sums: &mut Sums) {
        if self.weight != weight {
            self.pour(sums);
            self.weight = weight;
        }
    }

    /// Adds what was counted to `sums` and counts from zero.
    fn pour(&mut self, sums: &mut Sums) {
        if self.counted > 0 {
            for table in &mut self.tables {
                for (sum, count) in sums.0.iter_mut().zip(table.iter()) {
                    *sum += f64::from(*count) * self.weight;
                }
                *table = [0; PLACES];
            }
            self.counted = 0;
        }
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
        match tables.bin_map {
            BinMap::Narrow(keys) => self.scan_keys(keys, tables, footprint, runs),
            BinMap::Wide(keys) => self.scan_keys(keys, tables, footprint, runs),
        }
    }

    fn scan_keys<K: StoredKey>(
        &mut self,
        keys: &[K],
        tables: &BinTables<'_>,
        footprint: &Parallelogram,
        runs: &KeyRuns,
    ) -> Result<(), QueryError> {
        let mut counts = Counts {
            tables: [[0; PLACES]; TABLES],
            weight: 0.0,
            counted: 0,
        };
        map_shape(tables).scan(footprint, &mut |row| {
            self.add_row(runs, keys_under(keys, tables, row)?, row, &mut counts);
            Ok(())
        })?;
        counts.pour(self);
        Ok(())
    }

    #[inline]
    fn add_row<K: StoredKey>(
        &mut self,
        runs: &KeyRuns,
        keys: &[K],
        row: &TexelRow<'_>,
        counts: &mut Counts,
    ) {
        let start = row.columns.start;
        let even = (row.even.start - start) as usize..(row.even.end - start) as usize;
        if even.len() < CHUNK {
            return self.add_texels(runs, keys, start, row);
        }
        let (Some(before), Some(within), Some(after)) = (
            keys.get(..even.start),
            keys.get(even.clone()),
            keys.get(even.end..),
        ) else {
            return;
        };
        self.add_texels(runs, before, start, row);
        let (chunks, rest) = within.as_chunks::<CHUNK>();
        counts.weigh(row.even_weight, self);
        for chunk in chunks {
            if K::any_wanted(chunk, runs) {
                counts.add(&K::places(chunk, runs), self);
            }
        }
        self.add_texels(runs, rest, row.even.end - rest.len() as u32, row);
        self.add_texels(runs, after, row.even.end, row);
    }

    /// Adds the weights of the texels from column `first` of `row` one by one.
    #[inline]
    fn add_texels<K: StoredKey>(
        &mut self,
        runs: &KeyRuns,
        keys: &[K],
        first: u32,
        row: &TexelRow<'_>,
    ) {
        for (first, chunk) in (first..).step_by(CHUNK).zip(keys.chunks(CHUNK)) {
            if let Ok(whole) = chunk.try_into()
                && !K::any_wanted(whole, runs)
            {
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
