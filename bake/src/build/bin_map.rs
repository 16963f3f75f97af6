//! The bin map: normals to bins to keys, \[AWKK21\] eq. 17, with the index kind chosen by size.

use crate::normals::NormalMap;
use glintbake_format::model::{BLOCK_SIDE, BLOCK_TEXELS, BinGrid, BlockLayout, HalfVector};
use glintbake_format::records::IndexKind;
use glintbake_format::view::KeyLayout;
use rayon::prelude::*;
use zerocopy::little_endian::{U16, U32};

/// Texels a unit of parallel work covers; fixed, so that the split never depends on the machine.
const CHUNK: usize = 1 << 16;

/// Keys of all texels, in the width the package stores and the order of the bin map's layout.
#[derive(Clone, Debug, PartialEq)]
pub enum Keys {
    /// 2 bytes each, for at most 65 536 different keys.
    Narrow(Vec<U16>),
    /// 4 bytes each.
    Wide(Vec<U32>),
}

impl Keys {
    fn new(
        bins: &[u32],
        layout: KeyLayout,
        width: usize,
        key_count: u32,
        key_of_bin: impl Fn(u32) -> u32 + Sync,
    ) -> Self {
        if key_count <= 1 << 16 {
            let narrow = |bin| U16::new(key_of_bin(bin) as u16);
            Self::Narrow(lay_out(bins, layout, width, narrow))
        } else {
            let wide = |bin| U32::new(key_of_bin(bin));
            Self::Wide(lay_out(bins, layout, width, wide))
        }
    }
}

/// `key_of_bin` of each of `bins`, which come row by row, in the order of `layout`.
fn lay_out<K: Copy + Default + Send>(
    bins: &[u32],
    layout: KeyLayout,
    width: usize,
    key_of_bin: impl Fn(u32) -> K + Sync,
) -> Vec<K> {
    let KeyLayout::Blocks(layout) = layout else {
        let keys = bins.par_iter().with_min_len(CHUNK);
        return keys.map(|&bin| key_of_bin(bin)).collect();
    };
    let side = BLOCK_SIDE as usize;
    let mut keys = vec![K::default(); layout.key_count() as usize];
    keys.par_chunks_mut(layout.columns as usize * BLOCK_TEXELS)
        .zip(bins.par_chunks(width * side))
        .for_each(|(blocks, rows)| {
            for (row, bins) in rows.chunks(width).enumerate() {
                let lines = blocks[row * side..].chunks_mut(BLOCK_TEXELS);
                for (line, bins) in lines.zip(bins.chunks(side)) {
                    for (key, &bin) in line.iter_mut().zip(bins) {
                        *key = key_of_bin(bin);
                    }
                }
            }
        });
    keys
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
    /// One key per texel, and zeros where blocks reach beyond the map.
    pub keys: Keys,
    /// Where a texel's key is among them: in blocks, but for thin maps.
    pub layout: KeyLayout,
}

impl BinMap {
    /// The key of texel (`column`, `row`).
    #[inline]
    pub fn key(&self, column: u32, row: u32) -> u32 {
        let place = match self.layout {
            KeyLayout::Rows { width, .. } => row as usize * width as usize + column as usize,
            KeyLayout::Blocks(layout) => layout.texel(column, row),
        };
        match &self.keys {
            Keys::Narrow(keys) => u32::from(keys[place].get()),
            Keys::Wide(keys) => keys[place].get(),
        }
    }
}

/// The bin map of `map` under `grid`, with a sparse index where that makes it smaller by more than 5 %.
///
/// Looking a window up is quicker with a dense index, whose keys are told apart by arithmetic. It costs 8 bytes a bin of the grid (with its block list's start); a sparse one 12 bytes an occupied bin,
/// and a binary search for each row of bins a query looks at. Either needs 2 bytes a texel up to 65 536 keys, else 4.
/// Peak memory 14 bytes a texel with the map itself; O(texels), with a sort where the grid has more bins than the map
/// has texels twice over.
pub fn build(map: &NormalMap, grid: BinGrid) -> BinMap {
    let (width, height) = (map.width(), map.height());
    let layout = if BlockLayout::pays(width, height) {
        KeyLayout::Blocks(BlockLayout::new(width, height))
    } else {
        KeyLayout::Rows { width, height }
    };
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
    let dense_cost = 8 * dense_bins + key_bytes(dense_bins) * texels;
    let sparse_bins = occupied.len() as u64;
    let sparse_cost = 12 * sparse_bins + key_bytes(sparse_bins) * texels;
    let (index, key_count) = if dense_cost * 95 <= sparse_cost * 100 {
        (IndexKind::Dense, grid.count())
    } else {
        (IndexKind::Sparse, occupied.len() as u32)
    };
    let width = width as usize;
    let (keys, occupied) = match index {
        IndexKind::Dense => {
            let keys = Keys::new(&bins, layout, width, key_count, |bin| bin);
            (keys, Vec::new())
        }
        IndexKind::Sparse => {
            let key_of_bin = |bin: u32| occupied.partition_point(|&other| other < bin) as u32;
            let keys = Keys::new(&bins, layout, width, key_count, key_of_bin);
            (keys, occupied)
        }
    };
    BinMap {
        index,
        key_count,
        occupied: occupied.into_iter().map(U32::new).collect(),
        keys,
        layout,
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
