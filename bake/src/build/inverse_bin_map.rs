//! The inverse bin map: the texels of every key, \[AWKK21\] eq. 19.

use super::bin_map::BinMap;
use super::morton;
use glintbake_format::records::TexelPosition;
use zerocopy::little_endian::{U16, U32};

/// All texels sorted by key, and where each key's list begins.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseBinMap {
    /// Start of each key's list, and the number of texels at the end.
    pub offsets: Vec<U32>,
    /// Positions of all texels, list after list, each list in Morton order.
    pub positions: Vec<TexelPosition>,
}

impl InverseBinMap {
    /// The places of `key`'s texels in [`positions`](Self::positions).
    pub fn list(&self, key: usize) -> core::ops::Range<usize> {
        self.offsets[key].get() as usize..self.offsets[key + 1].get() as usize
    }
}

/// The inverse of `bin_map`, a map of `width` × `height` texels, both at most 65 535.
///
/// A counting sort that reads the texels in Morton order, so that each list comes out in Morton order without being
/// sorted again, and any stretch of a list is compact in the map. O(texels + keys), 4 bytes a texel.
pub fn build(bin_map: &BinMap, width: u32, height: u32) -> InverseBinMap {
    let texels = width as usize * height as usize;
    let mut next = vec![0_u32; bin_map.key_count as usize + 1];
    for row in 0..height {
        for column in 0..width {
            next[bin_map.key(column, row) as usize] += 1;
        }
    }
    let mut total = 0;
    for count in &mut next {
        let start = total;
        total += *count;
        *count = start;
    }
    let offsets = next.iter().map(|&start| U32::new(start)).collect();
    let nowhere = TexelPosition {
        column: U16::ZERO,
        row: U16::ZERO,
    };
    let mut positions = vec![nowhere; texels];
    morton::for_each_texel(width, height, |column, row| {
        let key = bin_map.key(column, row);
        let place = &mut next[key as usize];
        positions[*place as usize] = TexelPosition {
            column: U16::new(column as u16),
            row: U16::new(row as u16),
        };
        *place += 1;
    });
    InverseBinMap { offsets, positions }
}
