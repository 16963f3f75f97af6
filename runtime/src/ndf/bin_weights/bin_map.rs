//! Weights from the bin map under the footprint.

use super::window::{KeyRuns, WINDOW};
use super::{Sums, map_shape};
use crate::error::QueryError;
use crate::overlap::Parallelogram;
use crate::scan::TexelRow;
use core::hint::black_box;
use glintbake_format::view::{BinMap, BinTables};
use glintbake_format::{Fault, Finding};
use zerocopy::little_endian::{U16, U32};

/// Keys looked at together, in the middle of a row and elsewhere. Everything that is done to them has no branches and
/// a fixed length, which a compiler turns into vector instructions.
const LONG: usize = 32;
const SHORT: usize = 8;
/// Texels of one weight in a row from which on they are counted rather than summed.
const COUNTED: usize = 16;
/// Places that a texel can be counted under: those of [`KeyRuns`] and [`ELSEWHERE`].
const PLACES: usize = 64;
/// The place of keys that no run holds. All ones: a place less one, where there is none, lands here.
const ELSEWHERE: u16 = u16::MAX;
const _: () = assert!(WINDOW * WINDOW < PLACES);
/// Tables of counts: neighbouring texels often share a bin, and a count must be stored before it can rise again.
const TABLES: usize = 4;

/// A key as the bin map stores it.
trait StoredKey: Copy + Default {
    /// Whether any of `keys` may be one of `runs`.
    fn any_wanted<const N: usize>(keys: &[Self; N], runs: &KeyRuns) -> bool;

    /// The place of each key, or [`ELSEWHERE`].
    fn places<const N: usize>(keys: &[Self; N], runs: &KeyRuns) -> [u16; N];
}

impl StoredKey for U16 {
    #[inline(always)]
    fn any_wanted<const N: usize>(keys: &[Self; N], runs: &KeyRuns) -> bool {
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
    fn places<const N: usize>(keys: &[Self; N], runs: &KeyRuns) -> [u16; N] {
        if let Some(lattice) = runs.lattice {
            return keys.map(|key| lattice.place(key.get(), ELSEWHERE));
        }
        // At most one run holds a key, so what they say can be put together bit by bit.
        let mut places = [0; N];
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
    #[inline(always)]
    fn any_wanted<const N: usize>(keys: &[Self; N], runs: &KeyRuns) -> bool {
        any(keys, |key| {
            key.get().wrapping_sub(runs.least) <= runs.spread
        })
    }

    #[inline(always)]
    fn places<const N: usize>(keys: &[Self; N], runs: &KeyRuns) -> [u16; N] {
        let mut places = [0; N];
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
fn any<K: Copy, const N: usize>(keys: &[K; N], wanted: impl Fn(K) -> bool) -> bool {
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
    fn add<const N: usize>(&mut self, places: &[u16; N], sums: &mut Sums) {
        if self.counted > u32::MAX - N as u32 {
            self.pour(sums);
        }
        self.counted += N as u32;
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
        map_shape(tables).scan(footprint, &mut |rows| {
            // Fetches the rows' first and last keys all at once: what is loaded here is not waited for, while the
            // branches on each row's keys are.
            for row in rows {
                let keys = keys_under(keys, tables, row)?;
                black_box((keys.first().copied(), keys.last().copied()));
            }
            for row in rows {
                self.add_row(runs, keys_under(keys, tables, row)?, row, &mut counts);
            }
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
        if even.len() < COUNTED {
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
        counts.weigh(row.even_weight, self);
        let (chunks, rest) = within.as_chunks::<LONG>();
        for chunk in chunks {
            if K::any_wanted(chunk, runs) {
                counts.add(&K::places(chunk, runs), self);
            }
        }
        for_each_chunk(rest, runs, &mut |places, _| counts.add(places, self));
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
        for_each_chunk(keys, runs, &mut |places, offset| {
            for (column, &place) in (first + offset..).zip(places) {
                if place != ELSEWHERE {
                    self.add(u32::from(place), row.weight(column));
                }
            }
        });
    }
}

/// Calls `visit` with the places of a few keys, and their offset in `keys`, wherever `keys` holds a wanted one.
#[inline(always)]
fn for_each_chunk<K: StoredKey>(
    keys: &[K],
    runs: &KeyRuns,
    visit: &mut impl FnMut(&[u16; SHORT], u32),
) {
    let (chunks, rest) = keys.as_chunks::<SHORT>();
    let mut offset = 0;
    for chunk in chunks {
        if K::any_wanted(chunk, runs) {
            visit(&K::places(chunk, runs), offset);
        }
        offset += SHORT as u32;
    }
    if !rest.is_empty() {
        let mut chunk = [K::default(); SHORT];
        for (slot, key) in chunk.iter_mut().zip(rest) {
            *slot = *key;
        }
        if K::any_wanted(&chunk, runs) {
            let mut places = K::places(&chunk, runs);
            for place in places.iter_mut().skip(rest.len()) {
                *place = ELSEWHERE;
            }
            visit(&places, offset);
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
