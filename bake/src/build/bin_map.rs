//! The bin map: normals to bins to keys, \[AWKK21\] eq. 17, with the index kind chosen by size.

use crate::normals::NormalMap;
use glintbake_format::model::{BinGrid, HalfVector};
use glintbake_format::records::IndexKind;
use rayon::prelude::*;
use zerocopy::little_endian::{U16, U32};

/// Texels a unit of parallel work covers; fixed, so that the split never depends on the machine.
const CHUNK: usize = 1 << 16;

/// Keys of all texels, in the width the package stores.
#[derive(Clone, Debug, PartialEq)]
pub enum Keys {
    /// 2 bytes each, for at most 65 536 different keys.
    Narrow(Vec<U16>),
    /// 4 bytes each.
    Wide(Vec<U32>),
}

impl Keys {
    /// The key of texel number `texel`, row-major.
    #[inline]
    pub fn get(&self, texel: usize) -> u32 {
        match self {
            Self::Narrow(keys) => u32::from(keys[texel].get()),
            Self::Wide(keys) => keys[texel].get(),
        }
    }

    fn from_bins(bins: Vec<u32>, key_count: u32, key_of_bin: impl Fn(u32) -> u32 + Sync) -> Self {
        if key_count <= 1 << 16 {
            let narrow = |&bin: &u32| U16::new(key_of_bin(bin) as u16);
            Self::Narrow(bins.par_iter().with_min_len(CHUNK).map(narrow).collect())
        } else {
            let wide = |&bin: &u32| U32::new(key_of_bin(bin));
            Self::Wide(bins.par_iter().with_min_len(CHUNK).map(wide).collect())
        }
    }
}

/// A bin map with what its keys mean.
#[derive(Clone, Debug, PartialEq)]
pub struct BinMap {
    /// How keys find their bin.
    pub index: IndexKind,
    /// Number of keys: bins of the grid, or occupied bins.
    pub key_count: u32,
    /// The bin of each key of a sparse index, rising; empty for a dense one.
    pub occupied: Vec<U32>,
    /// One key per texel, row-major.
    pub keys: Keys,
}

/// The bin map of `map` under `grid`, with a sparse index where that makes the package smaller by more than 1 %.
///
/// A dense index costs 4 bytes a bin of the grid; a sparse one 8 bytes an occupied bin, and a binary search for each
/// row of bins a query looks at. Either needs 2 bytes a texel up to 65 536 keys, else 4. Peak memory 14 bytes a texel with the map itself; O(texels), with a sort where the
/// grid has more bins than the map has texels twice over.
pub fn build(map: &NormalMap, grid: BinGrid) -> BinMap {
    let bins: Vec<u32> = map
        .texels()
        .par_iter()
        .with_min_len(CHUNK)
        .map(|&[s, t]| {
            let (column, row) = grid.bin_of(HalfVector {
                s: f64::from(s),
                t: f64::from(t),
            });
            grid.number(column, row)
        })
        .collect();
    let texels = bins.len() as u64;
    let occupied = if u64::from(grid.count()) <= 2 * texels + (1 << 16) {
        occupied_by_flags(&bins, grid)
    } else {
        occupied_by_sorting(&bins)
    };
    let key_bytes = |count: u64| if count <= 1 << 16 { 2 } else { 4 };
    let dense_bins = u64::from(grid.count());
    let dense_cost = 4 * dense_bins + key_bytes(dense_bins) * texels;
    let sparse_bins = occupied.len() as u64;
    let sparse_cost = 8 * sparse_bins + key_bytes(sparse_bins) * texels;
    // What the inverse bin map adds to either.
    let positions = 4 * texels;
    if (dense_cost + positions) * 99 <= (sparse_cost + positions) * 100 {
        BinMap {
            index: IndexKind::Dense,
            key_count: grid.count(),
            occupied: Vec::new(),
            keys: Keys::from_bins(bins, grid.count(), |bin| bin),
        }
    } else {
        let key_count = occupied.len() as u32;
        let keys = Keys::from_bins(bins, key_count, |bin| {
            occupied.partition_point(|&other| other < bin) as u32
        });
        BinMap {
            index: IndexKind::Sparse,
            key_count,
            occupied: occupied.into_iter().map(U32::new).collect(),
            keys,
        }
    }
}

fn occupied_by_flags(bins: &[u32], grid: BinGrid) -> Vec<u32> {
    let mut flags = vec![false; grid.count() as usize];
    for &bin in bins {
        flags[bin as usize] = true;
    }
    (0..grid.count())
        .filter(|&bin| flags[bin as usize])
        .collect()
}

fn occupied_by_sorting(bins: &[u32]) -> Vec<u32> {
    let mut sorted = bins.to_vec();
    sorted.par_sort_unstable();
    sorted.dedup();
    sorted
}
