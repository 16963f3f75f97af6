//! Block lists: for each key the blocks of 8 × 8 texels that hold it, and how many texels each.
//!
//! Neighbouring texels of real maps share bins, so that a list of blocks is several times shorter than a list of texels;
//! and where they do not (white noise), a block's name and count still take 3 bytes where a position takes 4 and its
//! share of a forest 1. Which texels of a block they are is in the bin map, two cache lines a block.

use super::bin_map::BinMap;
use glintbake_format::model::{
    BLOCK_SIDE, BLOCK_TEXELS, PAGE_SIDE, PageLayout, block_name, block_place,
};
use glintbake_format::records::{ListStart, PageRecord, TileRecord};
use rayon::prelude::*;
use zerocopy::little_endian::{U16, U32};

/// Blocks in a row of a page.
const PAGE_BLOCKS: u32 = PAGE_SIDE / BLOCK_SIDE;
/// The shortest list that has tiles.
const TILED: usize = 128;
/// Blocks a tile must hold on average for tiles to be worth their bytes.
const BLOCKS_A_TILE: usize = 4;

/// The block lists of a map, as they are stored.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockLists {
    /// Which lists are a page's.
    pub pages: Vec<PageRecord>,
    /// The key of each list; empty if each page has a list for every key.
    pub keys: Vec<U32>,
    /// Where each list begins, and the ends of the last.
    pub starts: Vec<ListStart>,
    /// Names of blocks, list after list.
    pub blocks: Vec<U16>,
    /// Texels of the list's key in each block.
    pub counts: Vec<u8>,
    /// Tiles of the long lists.
    pub tiles: Vec<TileRecord>,
}

/// The block lists of `bin_map`, a map of `width` × `height` texels.
///
/// Two passes over the keys and no sort: blocks are visited in the order of their names. O(texels + keys × pages);
/// 3 bytes a block that holds a key, 6 a tile of a long list, 8 a list; beside that 8 bytes a key for each thread.
pub fn build(bin_map: &BinMap, width: u32, height: u32) -> BlockLists {
    let layout = PageLayout::new(width, height);
    let pages: Vec<Page> = (0..layout.count())
        .into_par_iter()
        .map(|page| {
            let (column, row) = (page % layout.columns, page / layout.columns);
            let left = column * PAGE_SIDE;
            let top = row * PAGE_SIDE;
            Page::new(
                bin_map,
                [left, top],
                [PAGE_SIDE.min(width - left), PAGE_SIDE.min(height - top)],
            )
        })
        .collect();
    let occupied: usize = pages.iter().map(|page| page.keys.len()).sum();
    // A start for every key of every page, or a key and a start for every list. The first is read directly, the other
    // searched by every query: that must save more than about 1 % of the package.
    let all = bin_map.key_count as usize * pages.len();
    let texels = width as usize * height as usize;
    let dense = 8 * all <= 12 * occupied + texels / 32;
    let mut lists = BlockLists::default();
    for page in pages {
        page.append_to(&mut lists, dense.then_some(bin_map.key_count));
    }
    lists.starts.push(lists.end());
    lists
}

impl BlockLists {
    /// Where the next list would begin.
    fn end(&self) -> ListStart {
        ListStart {
            block: U32::new(self.blocks.len() as u32),
            tile: U32::new(self.tiles.len() as u32),
        }
    }

    /// Bytes of all sections together.
    pub fn bytes(&self) -> u64 {
        (size_of_val(self.pages.as_slice())
            + size_of_val(self.keys.as_slice())
            + size_of_val(self.starts.as_slice())
            + size_of_val(self.blocks.as_slice())
            + size_of_val(self.counts.as_slice())
            + size_of_val(self.tiles.as_slice())) as u64
    }
}

/// The lists of one page: those of its keys only.
struct Page {
    /// Rising.
    keys: Vec<u32>,
    /// Where each key's list begins, and the end of the last.
    starts: Vec<u32>,
    blocks: Vec<U16>,
    counts: Vec<u8>,
}

impl Page {
    /// The lists of the page of `size` texels that begins at texel `corner`.
    fn new(bin_map: &BinMap, corner: [u32; 2], size: [u32; 2]) -> Self {
        let key_count = bin_map.key_count as usize;
        // The block, by its number from 1, that each key was last seen in, and how many it was seen in.
        let mut last = vec![0_u32; key_count];
        let mut next = vec![0_u32; key_count];
        let mut keys = Vec::new();
        for_each_key(bin_map, corner, size, |number, _, key| {
            let key = key as usize;
            if last[key] != number {
                if last[key] == 0 {
                    keys.push(key as u32);
                }
                last[key] = number;
                next[key] += 1;
            }
        });
        keys.par_sort_unstable();
        let mut starts = Vec::with_capacity(keys.len() + 1);
        let mut total = 0;
        for &key in &keys {
            starts.push(total);
            let count = std::mem::replace(&mut next[key as usize], total);
            total += count;
            last[key as usize] = 0;
        }
        starts.push(total);
        let mut blocks = vec![U16::ZERO; total as usize];
        let mut counts = vec![0_u8; total as usize];
        for_each_key(bin_map, corner, size, |number, name, key| {
            let key = key as usize;
            if last[key] != number {
                last[key] = number;
                blocks[next[key] as usize] = U16::new(name);
                next[key] += 1;
            }
            counts[next[key] as usize - 1] += 1;
        });
        Self {
            keys,
            starts,
            blocks,
            counts,
        }
    }

    /// Appends this page to `lists`, with a list for each of `key_count` keys if given, else for its own keys.
    fn append_to(self, lists: &mut BlockLists, key_count: Option<u32>) {
        let first_list = lists.starts.len() as u32;
        let mut next_key = 0;
        for (&key, range) in self.keys.iter().zip(self.starts.windows(2)) {
            if key_count.is_some() {
                let end = lists.end();
                lists.starts.extend((next_key..key).map(|_| end));
                next_key = key + 1;
            } else {
                lists.keys.push(U32::new(key));
            }
            lists.starts.push(lists.end());
            let range = range[0] as usize..range[1] as usize;
            let (blocks, counts) = (&self.blocks[range.clone()], &self.counts[range]);
            if blocks.len() >= TILED {
                let tiles = tiles(blocks, counts);
                if tiles.len() * BLOCKS_A_TILE <= blocks.len() {
                    lists.tiles.extend(tiles);
                }
            }
            lists.blocks.extend_from_slice(blocks);
            lists.counts.extend_from_slice(counts);
        }
        if let Some(key_count) = key_count {
            let end = lists.end();
            lists.starts.extend((next_key..key_count).map(|_| end));
        }
        lists.pages.push(PageRecord {
            first_list: U32::new(first_list),
            list_count: U32::new(lists.starts.len() as u32 - first_list),
        });
    }
}

/// The tiles that `blocks` lie in.
fn tiles(blocks: &[U16], counts: &[u8]) -> Vec<TileRecord> {
    let mut tiles: Vec<TileRecord> = Vec::new();
    for (place, (name, &count)) in blocks.iter().zip(counts).enumerate() {
        let tile = name.get() / BLOCK_TEXELS as u16;
        match tiles.last_mut() {
            Some(record) if record.tile.get() == tile => {
                record.texels = U16::new(record.texels.get() + u16::from(count));
            }
            _ => tiles.push(TileRecord {
                tile: U16::new(tile),
                first: U16::new(place as u16),
                texels: U16::new(u16::from(count)),
            }),
        }
    }
    tiles
}

/// Calls `visit(number, name, key)` for every texel of a page, block by block in the order of their names; blocks are
/// numbered from 1.
fn for_each_key(
    bin_map: &BinMap,
    corner: [u32; 2],
    size: [u32; 2],
    mut visit: impl FnMut(u32, u16, u32),
) {
    let columns = size[0].div_ceil(BLOCK_SIDE);
    let rows = size[1].div_ceil(BLOCK_SIDE);
    let names = u32::from(block_name(PAGE_BLOCKS - 1, rows - 1));
    let mut number = 0;
    for name in 0..=names {
        let name = name as u16;
        let (column, row) = block_place(name);
        if column >= columns || row >= rows {
            continue;
        }
        number += 1;
        let (left, top) = (column * BLOCK_SIDE, row * BLOCK_SIDE);
        for y in top..(top + BLOCK_SIDE).min(size[1]) {
            for x in left..(left + BLOCK_SIDE).min(size[0]) {
                visit(number, name, bin_map.key(corner[0] + x, corner[1] + y));
            }
        }
    }
}
