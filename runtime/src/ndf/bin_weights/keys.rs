//! Keys against the window: which of a few keys are wanted, and where their weights are summed.
//!
//! Everything here has no branches and a fixed length, which a compiler turns into vector instructions.

use super::window::KeyRuns;
use zerocopy::little_endian::{U16, U32};

/// The place of keys that no run holds.
pub(super) const ELSEWHERE: u16 = u16::MAX;

/// A key as the bin map stores it.
pub(super) trait StoredKey: Copy + Default {
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
            let mut places = [ELSEWHERE; N];
            for (place, key) in places.iter_mut().zip(keys) {
                *place = lattice.place(key.get(), ELSEWHERE);
            }
            return places;
        }
        // At most one run holds a key, so what they say can be put together bit by bit.
        let mut places = [0_u16; N];
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
        for place in &mut places {
            *place = place.wrapping_sub(1);
        }
        places
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
        let mut places = [0_u16; N];
        for ((&start, &count), &first) in runs.starts.iter().zip(&runs.counts).zip(&runs.places) {
            for (place, key) in places.iter_mut().zip(keys) {
                let offset = key.get().wrapping_sub(start);
                *place |= if offset < count {
                    (first + offset + 1) as u16
                } else {
                    0
                };
            }
        }
        for place in &mut places {
            *place = place.wrapping_sub(1);
        }
        places
    }
}

#[inline(always)]
fn any<K: Copy, const N: usize>(keys: &[K; N], wanted: impl Fn(K) -> bool) -> bool {
    let mut any = false;
    for &key in keys {
        any |= wanted(key);
    }
    any
}
