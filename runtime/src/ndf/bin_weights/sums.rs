//! Weights by place, in integers: they do not depend on the order in which texels are found.

use super::window::WINDOW;

/// Places that a texel can be counted under: those of [`KeyRuns`](super::window::KeyRuns) and, last, elsewhere.
const PLACES: usize = 64;
const _: () = assert!(WINDOW * WINDOW < PLACES);
/// Tables of counts: neighbouring texels often share a bin, and a count must be stored before it can rise again.
const TABLES: usize = 4;
/// 2⁶²: the weights of all texels add up to at most 1 and rounding.
const UNITS: f64 = (1_u64 << 62) as f64;

/// What was found of each place's texels under a footprint.
///
/// Which of a window's places is looked at first depends on the window, so sums of floats would too, in their last
/// digits; integers give a bin one weight in whichever window it is found.
pub(super) struct Sums {
    /// Texels that lie inside.
    inside: [u64; PLACES],
    /// Weight of the other texels in [`UNITS`].
    parts: [u64; PLACES],
    /// Texels that lie inside, counted many at a time, not yet in `inside`.
    tables: [[u32; PLACES]; TABLES],
    /// Texels counted since the tables were empty.
    counted: u32,
}

impl Sums {
    pub fn new() -> Self {
        Self {
            inside: [0; PLACES],
            parts: [0; PLACES],
            tables: [[0; PLACES]; TABLES],
            counted: 0,
        }
    }

    /// Counts `texels` texels of `place` that lie inside.
    #[inline]
    pub fn add_inside(&mut self, place: u32, texels: u64) {
        if let Some(sum) = self.inside.get_mut(place as usize) {
            *sum = sum.saturating_add(texels);
        }
    }

    /// Adds the weight of a texel of `place`.
    #[inline]
    pub fn add(&mut self, place: u32, weight: f64) {
        if let Some(sum) = self.parts.get_mut(place as usize) {
            *sum = sum.saturating_add((weight * UNITS) as u64);
        }
    }

    /// Counts a texel inside for each of `places`, those that are elsewhere included.
    #[inline(always)]
    pub fn count<const N: usize>(&mut self, places: &[u16; N]) {
        if self.counted > u32::MAX - N as u32 {
            self.pour();
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

    /// Counts what the tables hold as inside.
    fn pour(&mut self) {
        for table in &mut self.tables {
            for (sum, count) in self.inside.iter_mut().zip(table.iter()) {
                *sum = sum.saturating_add(u64::from(*count));
            }
            *table = [0; PLACES];
        }
        self.counted = 0;
    }

    /// The weights by place, if a texel inside has the weight `texel_weight`.
    pub fn weights(&mut self, texel_weight: f64) -> [f64; WINDOW * WINDOW] {
        if self.counted > 0 {
            self.pour();
        }
        let mut weights = [0.0; WINDOW * WINDOW];
        let found = self.inside.iter().zip(&self.parts);
        for (weight, (&inside, &parts)) in weights.iter_mut().zip(found) {
            *weight = parts as f64 / UNITS;
            // The weight of a whole texel is infinite where there can be none.
            if inside > 0 {
                *weight += inside as f64 * texel_weight;
            }
        }
        weights
    }
}
