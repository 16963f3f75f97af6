//! Blocks of texels: how a blocked bin map is laid out, and what block lists call a block.

/// Texels a side of a block.
pub const BLOCK_SIDE: u32 = 8;
/// Texels of a block.
pub const BLOCK_TEXELS: usize = 64;
/// Texels a side of a tile, 8 × 8 blocks.
pub const TILE_SIDE: u32 = 64;
/// Texels a side of a page, 32 × 32 tiles: as many blocks as 16 bits can name.
pub const PAGE_SIDE: u32 = 2048;

const BLOCKS_PER_TILE_SIDE: u32 = TILE_SIDE / BLOCK_SIDE;
const TILES_PER_PAGE_SIDE: u32 = PAGE_SIDE / TILE_SIDE;

/// The blocks of a map: rows of blocks from the top, left to right, each block row by row.
///
/// The last block of a row and the last row of blocks may reach beyond the map; keys there are zero and mean nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockLayout {
    /// Blocks in a row.
    pub columns: u32,
    /// Rows of blocks.
    pub rows: u32,
}

impl BlockLayout {
    /// The blocks of a map of `width` × `height` texels.
    pub const fn new(width: u32, height: u32) -> Self {
        Self {
            columns: width.div_ceil(BLOCK_SIDE),
            rows: height.div_ceil(BLOCK_SIDE),
        }
    }

    /// Keys that a blocked bin map holds: 64 a block.
    pub const fn key_count(self) -> u64 {
        self.columns as u64 * self.rows as u64 * BLOCK_TEXELS as u64
    }

    /// The place of the first key of block (`column`, `row`).
    pub const fn block(self, column: u32, row: u32) -> usize {
        (row as usize)
            .wrapping_mul(self.columns as usize)
            .wrapping_add(column as usize)
            .wrapping_mul(BLOCK_TEXELS)
    }

    /// The place of the key of texel (`column`, `row`).
    pub const fn texel(self, column: u32, row: u32) -> usize {
        self.block(column / BLOCK_SIDE, row / BLOCK_SIDE)
            .wrapping_add((row % BLOCK_SIDE * BLOCK_SIDE + column % BLOCK_SIDE) as usize)
    }

    /// Whether blocks waste less than half as many keys as the map has texels; a thin map is kept in rows.
    pub const fn pays(width: u32, height: u32) -> bool {
        let texels = width as u64 * height as u64;
        Self::new(width, height).key_count() * 2 <= texels * 3
    }
}

/// The name of block (`column`, `row`) within its page, both below 256.
///
/// Bits 0-2 column and 3-5 row of the block within its tile, 6-10 column and 11-15 row of the tile within its page: the
/// blocks of a tile are together, and the tiles of a row of tiles.
pub const fn block_name(column: u32, row: u32) -> u16 {
    let tile = row / BLOCKS_PER_TILE_SIDE * TILES_PER_PAGE_SIDE + column / BLOCKS_PER_TILE_SIDE;
    let block = row % BLOCKS_PER_TILE_SIDE * BLOCKS_PER_TILE_SIDE + column % BLOCKS_PER_TILE_SIDE;
    (tile << 6 | block) as u16
}

/// Column and row, within the page, of the block called `name`: the inverse of [`block_name`].
pub const fn block_place(name: u16) -> (u32, u32) {
    let name = name as u32;
    (
        (name >> 3 & 0xF8) | (name & 7),
        (name >> 8 & 0xF8) | (name >> 3 & 7),
    )
}

/// The pages of a map: rows of pages from the top, left to right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageLayout {
    /// Pages in a row.
    pub columns: u32,
    /// Rows of pages.
    pub rows: u32,
}

impl PageLayout {
    /// The pages of a map of `width` × `height` texels.
    pub const fn new(width: u32, height: u32) -> Self {
        Self {
            columns: width.div_ceil(PAGE_SIDE),
            rows: height.div_ceil(PAGE_SIDE),
        }
    }

    /// Number of pages; at most 32 × 32, as a side is at most 65 535 texels.
    pub const fn count(self) -> u32 {
        self.columns * self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_places_are_inverse_and_keep_tiles_together() {
        for row in 0..256 {
            for column in 0..256 {
                let name = block_name(column, row);
                assert_eq!(block_place(name), (column, row));
                assert_eq!(u32::from(name >> 6), row / 8 * 32 + column / 8);
            }
        }
    }

    #[test]
    fn every_texel_has_a_place_of_its_own() {
        let (width, height) = (19, 11);
        let layout = BlockLayout::new(width, height);
        let mut seen = [false; 6 * 64];
        assert_eq!(layout.key_count(), 6 * 64);
        for row in 0..height {
            for column in 0..width {
                let place = layout.texel(column, row);
                assert!(!core::mem::replace(&mut seen[place], true));
            }
        }
    }
}
