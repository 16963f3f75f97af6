//! A plain vectorised scan: every texel under the footprint, its key compared with the window's.
//!
//! What `flake-bins` is measured against (`benches/contest.rs`), and nothing else. It stores the bin map, 2 bytes a
//! texel on grids of up to 65 536 bins, and nothing besides. The keys of each row under the footprint are compared, a
//! register at a time, with the runs of keys that the window's rows are. Of the texels whose key is wanted those that
//! lie wholly inside are counted, and the few at the row's ends clipped.

use super::paper_forest::bins;
use super::parallelogram::{Parallelogram, Relation};
use super::window::{self, MOST_BINS, MOST_ROWS};
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{BinGrid, Footprint, HalfVector, Neighbourhood, Wrap};
use std::array;
use std::ops::Range;

/// A bin map to be scanned.
#[derive(Clone, Debug)]
pub struct PlainScan {
    width: u32,
    height: u32,
    grid: BinGrid,
    keys: Keys,
}

#[derive(Clone, Debug)]
enum Keys {
    Narrow(Vec<u16>),
    Wide(Vec<u32>),
}

impl PlainScan {
    /// The bin map of `map` on `grid`; a key is the bin's number.
    ///
    /// # Panics
    /// If `map` does not repeat, or has a side above 65 535.
    pub fn new(map: &NormalMap, grid: BinGrid) -> Self {
        assert_eq!(
            map.wrap(),
            Wrap::Repeat,
            "the baselines are for maps that repeat"
        );
        assert!(
            map.width().max(map.height()) <= 65_535,
            "positions are of 16 bits"
        );
        let bins = bins(map, grid);
        Self {
            width: map.width(),
            height: map.height(),
            grid,
            keys: if grid.count() <= 1 << 16 {
                Keys::Narrow(bins.map(|bin| bin as u16).collect())
            } else {
                Keys::Wide(bins.collect())
            },
        }
    }

    /// Bytes a texel.
    pub fn bytes_per_texel(&self) -> f64 {
        match self.keys {
            Keys::Narrow(_) => 2.0,
            Keys::Wide(_) => 4.0,
        }
    }

    /// Calls `visit(column, row, weight)` for the bins of the neighbourhood around `half_vector`'s bin that have weight
    /// over `footprint`.
    ///
    /// # Panics
    /// If the footprint has no area.
    pub fn bin_weights(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        neighbourhood: Neighbourhood,
        visit: &mut dyn FnMut(u32, u32, f64),
    ) {
        let mut window = [(0, 0); MOST_ROWS];
        let rows = window::rows(self.grid, half_vector, neighbourhood);
        for (run, (row, columns)) in window.iter_mut().zip(rows) {
            *run = (
                self.grid.number(columns.start, row),
                columns.end - columns.start,
            );
        }
        let footprint = Parallelogram::new(footprint, self.width, self.height);
        let areas = match &self.keys {
            Keys::Narrow(keys) => self.areas(keys, &Runs::new(&window), &footprint),
            Keys::Wide(keys) => self.areas(keys, &Runs::new(&window), &footprint),
        };
        for (run, (start, count)) in window.into_iter().enumerate() {
            for offset in 0..count {
                let area = areas[run * MOST_ROWS + offset as usize];
                if area > 0.0 {
                    let (column, row) = self.grid.column_row(start + offset);
                    visit(column, row, area / footprint.area());
                }
            }
        }
    }

    /// The area of each of the window's bins: 7 × run + place in the run.
    fn areas<K: Key>(
        &self,
        keys: &[K],
        runs: &Runs<K>,
        footprint: &Parallelogram,
    ) -> [f64; MOST_BINS] {
        let mut found = Found {
            counts: [[0; COUNTERS]; MOST_BINS + 1],
            areas: [0.0; MOST_BINS + 1],
        };
        for copy in footprint.copies(self.width, self.height) {
            for row in copy.rows(self.height) {
                let (touched, inside) = copy.columns(row, self.width);
                let start = row as usize * self.width as usize;
                let keys = &keys[start + touched.start as usize..start + touched.end as usize];
                let inside =
                    (inside.start - touched.start) as usize..(inside.end - touched.start) as usize;
                found.add_row(keys, &inside, runs, |offset| {
                    let texel = [touched.start as u16 + offset as u16, row as u16];
                    match copy.texel_relation(texel) {
                        Relation::Outside => 0.0,
                        Relation::Inside => 1.0,
                        Relation::Crossing => copy.clipped_area(texel),
                    }
                });
            }
        }
        array::from_fn(|place| {
            let whole: u32 = found.counts[place + 1].iter().sum();
            f64::from(whole) + found.areas[place + 1]
        })
    }
}

/// Keys compared at once: two registers without any target features, one with AVX2.
const CHUNK: usize = 16;

/// Counters of each place: texels next to each other are often of one bin, and an increment waits for the last one.
const COUNTERS: usize = 4;

/// What a scan has seen of each place; places from 1, 0 is elsewhere.
struct Found {
    /// Texels that lie wholly inside.
    counts: [[u32; COUNTERS]; MOST_BINS + 1],
    /// Areas of the others.
    areas: [f64; MOST_BINS + 1],
}

impl Found {
    /// Adds the texels of a row, `keys`: those in `inside` whole, of the others what `area` says of their place in
    /// `keys`.
    // Kept apart, so that the compiler has all registers for the loop.
    #[inline(never)]
    fn add_row<K: Key>(
        &mut self,
        keys: &[K],
        inside: &Range<usize>,
        runs: &Runs<K>,
        area: impl Fn(usize) -> f64,
    ) {
        let (chunks, rest) = keys.as_chunks::<CHUNK>();
        for (offset, chunk) in (0..).step_by(CHUNK).zip(chunks) {
            // Most chunks hold none of the window's keys, which takes less work to see.
            if runs.hold_any(chunk) {
                self.add_chunk(chunk, offset, inside, runs, &area);
            }
        }
        if !rest.is_empty() {
            let mut chunk = [runs.elsewhere; CHUNK];
            chunk[..rest.len()].copy_from_slice(rest);
            if runs.hold_any(&chunk) {
                self.add_chunk(&chunk, keys.len() - rest.len(), inside, runs, &area);
            }
        }
    }

    #[inline(always)]
    fn add_chunk<K: Key>(
        &mut self,
        chunk: &[K; CHUNK],
        offset: usize,
        inside: &Range<usize>,
        runs: &Runs<K>,
        area: &impl Fn(usize) -> f64,
    ) {
        let places = runs.places(chunk);
        if inside.start <= offset && offset + CHUNK <= inside.end {
            for (lane, place) in places.into_iter().enumerate() {
                self.counts[place.to_usize()][lane % COUNTERS] += 1;
            }
        } else {
            for (offset, place) in (offset..).zip(places) {
                if inside.contains(&offset) {
                    self.counts[place.to_usize()][0] += 1;
                } else if place != K::ZERO {
                    self.areas[place.to_usize()] += area(offset);
                }
            }
        }
    }
}

/// A key as it is stored; numbers of its width.
trait Key: Copy + PartialEq {
    const ZERO: Self;

    fn from_u32(number: u32) -> Self;

    fn to_usize(self) -> usize;

    fn or(self, other: Self) -> Self;

    /// Whether `self` is less than `count` beyond `start`.
    fn is_within(self, start: Self, count: Self) -> bool;

    /// `first` + how far `self` is beyond `start` if that is less than `count`, else 0.
    fn place(self, start: Self, count: Self, first: Self) -> Self;
}

macro_rules! key {
    ($type:ty) => {
        impl Key for $type {
            const ZERO: Self = 0;

            #[inline(always)]
            fn from_u32(number: u32) -> Self {
                number as Self
            }

            #[inline(always)]
            fn to_usize(self) -> usize {
                self as usize
            }

            #[inline(always)]
            fn or(self, other: Self) -> Self {
                self | other
            }

            #[inline(always)]
            fn is_within(self, start: Self, count: Self) -> bool {
                self.wrapping_sub(start) < count
            }

            #[inline(always)]
            fn place(self, start: Self, count: Self, first: Self) -> Self {
                let offset = self.wrapping_sub(start);
                if offset < count { first + offset } else { 0 }
            }
        }
    };
}

key!(u16);
key!(u32);

/// The keys of a window: a run of at most seven consecutive keys for each of its rows.
struct Runs<K> {
    starts: [K; MOST_ROWS],
    /// 0 for rows there are not.
    counts: [K; MOST_ROWS],
    /// The place of each run's first key.
    firsts: [K; MOST_ROWS],
    /// A key of no bin of the window.
    elsewhere: K,
}

impl<K: Key> Runs<K> {
    fn new(window: &[(u32, u32); MOST_ROWS]) -> Self {
        Self {
            starts: window.map(|(start, _)| K::from_u32(start)),
            counts: window.map(|(_, count)| K::from_u32(count)),
            firsts: array::from_fn(|run| K::from_u32((run * MOST_ROWS) as u32 + 1)),
            // The number before the window's first, or the highest there is: only a grid of at most seven bins a side
            // has its first bin and its last in one window.
            elsewhere: K::from_u32(window[0].0.wrapping_sub(1)),
        }
    }

    /// Whether any of `keys` is of one of the window's bins. No branches, so that LLVM does a register of keys at once.
    #[inline(always)]
    fn hold_any(&self, keys: &[K; CHUNK]) -> bool {
        keys.iter().fold(false, |any, key| {
            (0..MOST_ROWS).fold(any, |any, run| {
                any | key.is_within(self.starts[run], self.counts[run])
            })
        })
    }

    /// The place of each key; likewise.
    #[inline(always)]
    fn places(&self, keys: &[K; CHUNK]) -> [K; CHUNK] {
        let mut places = [K::ZERO; CHUNK];
        for run in 0..MOST_ROWS {
            let (start, count, first) = (self.starts[run], self.counts[run], self.firsts[run]);
            for (place, key) in places.iter_mut().zip(keys) {
                *place = place.or(key.place(start, count, first));
            }
        }
        places
    }
}
