//! Weights from block lists: blocks inside count by their numbers, those on the outline are scanned.

use super::frame::Frame;
use super::keys::StoredKey;
use super::scan::missing;
use super::sums::Sums;
use super::window::{KeyRuns, RUNS, WINDOW};
use crate::error::QueryError;
use crate::overlap::{SquareProbe, TexelBox};
use crate::simd::{Work, fetch};
use core::ops::Range;
use glintbake_format::model::{
    BLOCK_SIDE, BLOCK_TEXELS, PAGE_SIDE, TILE_SIDE, block_name, block_place,
};
use glintbake_format::view::{BlockList, BlockLists, KeyLayout, Keys};
use zerocopy::little_endian::U16;

/// Blocks tested together. Where each of them lies is anyone's guess, so nothing branches on it.
const TOGETHER: usize = 16;
/// Lists longer than this are first cut down to the rows of tiles that the footprint meets.
const SEARCHED: usize = 32;
/// Blocks on the outline that are fetched at once.
const FETCHED: usize = 16;
/// Blocks in a row of a page.
const PAGE_BLOCKS: u32 = PAGE_SIDE / BLOCK_SIDE;
/// Tiles in a row of a page.
const PAGE_TILES: u16 = (PAGE_SIDE / TILE_SIDE) as u16;

/// Adds the weights of all texels under the footprint of `frame` whose keys are in `runs` to `sums`.
pub(super) struct Traversal<'t> {
    pub sums: &'t mut Sums,
    pub frame: &'t Frame<'t>,
    pub lists: &'t BlockLists<'t>,
    pub runs: &'t KeyRuns,
}

impl Work for Traversal<'_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            sums,
            frame,
            lists,
            runs,
        } = self;
        let rows = frame.block_rows();
        let TexelBox { low, high } = frame.footprint.bounds();
        let unbounded = frame.unbounded;
        let page_columns = page_range(low[0], high[0], lists.layout.columns, unbounded);
        for page_row in page_range(low[1], high[1], lists.layout.rows, unbounded) {
            for page_column in page_columns.clone() {
                let mut page = Page {
                    frame,
                    corner: [page_column * PAGE_SIDE, page_row * PAGE_SIDE],
                    blocks: frame.squares(f64::from(BLOCK_SIDE)),
                    tiles: frame.squares(f64::from(TILE_SIDE)),
                    tile_rows: tile_rows(&rows, page_row),
                    rows_of_tiles: tile_rows(&(0..frame.blocks.rows), page_row).end.max(1),
                    outline: Marks::new(),
                };
                let number = page_row * lists.layout.columns + page_column;
                let window = WindowLists::new(lists, number, runs)?;
                for (_, list) in window.as_slice() {
                    page.fetch(list);
                }
                for (place, list) in window.as_slice() {
                    page.add_list(sums, *place, list);
                }
                page.scan_outline(sums, runs)?;
            }
        }
        Ok(())
    }
}

/// Adds the texels of every list of `runs` `times` times.
pub(super) fn count_map(
    sums: &mut Sums,
    lists: &BlockLists<'_>,
    runs: &KeyRuns,
    times: u64,
) -> Result<(), QueryError> {
    for page in 0..lists.layout.count() {
        for (place, list) in WindowLists::new(lists, page, runs)?.as_slice() {
            let texels: u64 = if list.tiles.is_empty() {
                list.counts.iter().map(|&count| u64::from(count)).sum()
            } else {
                list.tiles
                    .iter()
                    .map(|tile| u64::from(tile.texels.get()))
                    .sum()
            };
            sums.add_inside(*place, texels.saturating_mul(times));
        }
    }
    Ok(())
}

/// The lists of a window in one page that are not empty, with the places of their keys.
struct WindowLists<'w> {
    lists: [(u32, BlockList<'w>); WINDOW * WINDOW],
    count: usize,
}

impl<'w> WindowLists<'w> {
    #[inline(always)]
    fn new(lists: &BlockLists<'w>, page: u32, runs: &KeyRuns) -> Result<Self, QueryError> {
        let of_page = lists.lists(page)?;
        let mut numbers = [const { 0..0 }; RUNS];
        for ((start, count, _), numbers) in runs.iter().zip(&mut numbers) {
            if count > 0 {
                *numbers = lists.lists_of_keys(of_page.clone(), start..start.saturating_add(count));
                fetch(lists.starts(), numbers.start as usize);
                fetch(lists.starts(), numbers.end as usize);
            }
        }
        let mut found = Self {
            lists: [(0, BlockList::default()); WINDOW * WINDOW],
            count: 0,
        };
        for ((start, count, first_place), numbers) in runs.iter().zip(numbers) {
            for number in numbers {
                let list = lists.list(number)?;
                let key = lists.key(number, number - of_page.start);
                if let Some(slot) = found.lists.get_mut(found.count) {
                    *slot = (first_place + key.saturating_sub(start).min(count - 1), list);
                    found.count += usize::from(!list.blocks.is_empty());
                }
            }
        }
        Ok(found)
    }

    fn as_slice(&self) -> &[(u32, BlockList<'w>)] {
        self.lists.get(..self.count).unwrap_or_default()
    }
}

/// The number of `records` that are `before`, which come first: as `partition_point`, but looking near `guess` first,
/// where the cache lines have been asked for.
#[inline(always)]
fn search<T>(records: &[T], guess: usize, before: impl Fn(&T) -> bool) -> usize {
    let (mut low, mut high) = (0, records.len());
    let mut step = 4;
    let mut at = guess.min(records.len().saturating_sub(1));
    while low < high {
        match records.get(at) {
            Some(record) if before(record) => {
                low = at + 1;
                at = if high - low > step {
                    low + step
                } else {
                    low + (high - low) / 2
                };
            }
            _ => {
                high = at;
                at = if high - low > step {
                    high - step
                } else {
                    low + (high - low) / 2
                };
            }
        }
        step *= 2;
    }
    low
}

/// The pages, of `count` in a row, that a footprint from `low` to `high` meets.
fn page_range(low: f64, high: f64, count: u32, unbounded: bool) -> Range<u32> {
    let page = |texel: f64| libm::floor(texel / f64::from(PAGE_SIDE));
    let last = f64::from(count) - 1.0;
    if !unbounded && (high < 0.0 || page(low) > last) {
        return 0..0;
    }
    page(low).clamp(0.0, last) as u32..page(high).clamp(0.0, last) as u32 + 1
}

/// The rows of tiles of the page in row `page_row` of pages that the rows `rows` of blocks meet.
fn tile_rows(rows: &Range<u32>, page_row: u32) -> Range<u16> {
    let first = page_row * PAGE_BLOCKS;
    let tiles = TILE_SIDE / BLOCK_SIDE;
    let place = |row: u32| row.saturating_sub(first).min(PAGE_BLOCKS);
    (place(rows.start) / tiles) as u16..place(rows.end).div_ceil(tiles) as u16
}

/// A page of the map under the part of a footprint in one tile.
struct Page<'a> {
    frame: &'a Frame<'a>,
    /// Its first texel.
    corner: [u32; 2],
    blocks: SquareProbe,
    tiles: SquareProbe,
    /// The rows of tiles that may hold weight.
    tile_rows: Range<u16>,
    /// All of the page's rows of tiles.
    rows_of_tiles: u16,
    /// Blocks on the outline that hold a wanted key.
    outline: Marks,
}

impl Page<'_> {
    #[inline(always)]
    fn add_list(&mut self, sums: &mut Sums, place: u32, list: &BlockList<'_>) {
        let inside = if self.frame.unbounded {
            self.unbounded_blocks(list)
        } else if list.tiles.is_empty() {
            self.blocks(
                list,
                self.rows_of(list.blocks, |name| name.get() / BLOCK_TEXELS as u16),
            )
        } else {
            self.tiles(list)
        };
        sums.add_inside(place, inside);
    }

    /// Asks for the part of `list` that [`add_list`](Self::add_list) will look at first.
    #[inline(always)]
    fn fetch(&self, list: &BlockList<'_>) {
        if list.tiles.is_empty() {
            let guess = self.guess(list.blocks.len(), self.tile_rows.start);
            let middle = self.guess(list.blocks.len(), self.tile_rows.end);
            fetch(list.blocks, guess);
            fetch(list.blocks, middle);
            fetch(list.counts, guess);
        } else {
            fetch(
                list.tiles,
                self.guess(list.tiles.len(), self.tile_rows.start),
            );
        }
    }

    /// Where among `count` records those in row `row` of tiles begin, if a list's texels lie evenly.
    #[inline(always)]
    fn guess(&self, count: usize, row: u16) -> usize {
        count * usize::from(row) / usize::from(self.rows_of_tiles)
    }

    /// The part of `records`, in rising order of their tiles, in the rows of tiles that may hold weight.
    #[inline(always)]
    fn rows_of<T>(&self, records: &[T], tile: impl Fn(&T) -> u16) -> Range<usize> {
        if records.len() <= SEARCHED {
            return 0..records.len();
        }
        let before = |record: &T, row: u16| tile(record) / PAGE_TILES < row;
        let Range { start, end } = self.tile_rows;
        let first = search(records, self.guess(records.len(), start), |record| {
            before(record, start)
        });
        let rest = records.get(first..).unwrap_or_default();
        let guess = self.guess(records.len(), end).saturating_sub(first);
        first..first + search(rest, guess, |record| before(record, end))
    }

    /// The texels of the tiles of `list` that lie inside, and of the blocks inside of those that do not.
    #[inline(always)]
    fn tiles(&mut self, list: &BlockList<'_>) -> u64 {
        let range = self.rows_of(list.tiles, |tile| tile.tile.get());
        let records = list.tiles.get(range.clone()).unwrap_or_default();
        let mut inside = 0;
        for (chunk, first) in records.chunks(TOGETHER).zip(range.step_by(TOGETHER)) {
            let mut crossing = [false; TOGETHER];
            let mut any = false;
            for (record, crossing) in chunk.iter().zip(&mut crossing) {
                let tile = record.tile.get();
                let relation = self.tiles.relation(
                    (u32::from(tile % PAGE_TILES) * TILE_SIDE + self.corner[0]) as f32,
                    (u32::from(tile / PAGE_TILES) * TILE_SIDE + self.corner[1]) as f32,
                );
                inside += if relation.inside {
                    u64::from(record.texels.get())
                } else {
                    0
                };
                *crossing = relation.crossing;
                any |= relation.crossing;
            }
            if any {
                // Each tile's blocks are in cache lines of their own: asks for all of them first.
                for (number, crossing) in (first..).zip(crossing) {
                    if crossing {
                        let start = list.tile(number).start;
                        fetch(list.blocks, start);
                        fetch(list.counts, start);
                    }
                }
                for (number, crossing) in (first..).zip(crossing) {
                    if crossing {
                        inside += self.blocks(list, list.tile(number));
                    }
                }
            }
        }
        inside
    }

    /// The texels of those blocks in `range` of `list` that lie inside; marks those that cross the outline.
    #[inline(always)]
    fn blocks(&mut self, list: &BlockList<'_>, range: Range<usize>) -> u64 {
        let mut inside = 0;
        let mut at = range.start;
        while at < range.end {
            let wanted = (range.end - at).min(TOGETHER);
            let (Some(names), Some(counts)) = (list.blocks.get(at..), list.counts.get(at..)) else {
                break;
            };
            // What follows within the list may be read along, it is not counted.
            inside += u64::from(match (names.first_chunk(), counts.first_chunk()) {
                (Some(names), Some(counts)) => self.few_blocks(names, counts, wanted),
                _ => {
                    let mut last_names = [U16::ZERO; TOGETHER];
                    let mut last_counts = [0; TOGETHER];
                    for (slot, name) in last_names.iter_mut().zip(names) {
                        *slot = *name;
                    }
                    for (slot, count) in last_counts.iter_mut().zip(counts) {
                        *slot = *count;
                    }
                    self.few_blocks(&last_names, &last_counts, wanted)
                }
            });
            at += TOGETHER;
        }
        inside
    }

    /// [`blocks`](Self::blocks) for the first `wanted` of a few.
    #[inline(always)]
    fn few_blocks(
        &mut self,
        names: &[U16; TOGETHER],
        counts: &[u8; TOGETHER],
        wanted: usize,
    ) -> u32 {
        let mut inside = 0;
        let mut crossing = [false; TOGETHER];
        let mut any = false;
        let corner = self.corner.map(|corner| corner as f32);
        for (place, ((name, &count), crossing)) in
            (0_u8..).zip(names.iter().zip(counts).zip(&mut crossing))
        {
            let (column, row) = block_place(name.get());
            let relation = self.blocks.relation(
                (column * BLOCK_SIDE) as f32 + corner[0],
                (row * BLOCK_SIDE) as f32 + corner[1],
            );
            let is_wanted = place < wanted as u8;
            inside += if relation.inside & is_wanted {
                u32::from(count)
            } else {
                0
            };
            *crossing = relation.crossing & is_wanted;
            any |= *crossing;
        }
        if any {
            for (name, crossing) in names.iter().zip(crossing) {
                if crossing {
                    self.outline.add(name.get());
                }
            }
        }
        inside
    }

    /// As [`blocks`](Self::blocks), for a frame whose border has no end.
    fn unbounded_blocks(&mut self, list: &BlockList<'_>) -> u64 {
        let mut inside = 0;
        for (name, &count) in list.blocks.iter().zip(list.counts) {
            let (column, row) = block_place(name.get());
            let relation = self.frame.block(
                column + self.corner[0] / BLOCK_SIDE,
                row + self.corner[1] / BLOCK_SIDE,
            );
            if relation.inside {
                inside += u64::from(count);
            } else if relation.crossing {
                self.outline.add(name.get());
            }
        }
        inside
    }

    /// Adds the texels of the marked blocks.
    #[inline(always)]
    fn scan_outline(&self, sums: &mut Sums, runs: &KeyRuns) -> Result<(), QueryError> {
        match self.frame.tables.bin_map.keys {
            Keys::Narrow(keys) => self.scan_marked(keys, sums, runs),
            Keys::Wide(keys) => self.scan_marked(keys, sums, runs),
        }
    }

    #[inline(always)]
    fn scan_marked<K: StoredKey>(
        &self,
        keys: &[K],
        sums: &mut Sums,
        runs: &KeyRuns,
    ) -> Result<(), QueryError> {
        let layout = self.frame.tables.bin_map.layout;
        let mut space = [K::default(); BLOCK_TEXELS];
        let mut marked = self.outline.iter(self.tile_rows.clone());
        loop {
            let mut waiting = [(0, 0); FETCHED];
            let mut count = 0;
            for (slot, name) in waiting.iter_mut().zip(&mut marked) {
                let (column, row) = block_place(name);
                *slot = (
                    column + self.corner[0] / BLOCK_SIDE,
                    row + self.corner[1] / BLOCK_SIDE,
                );
                count += 1;
            }
            let waiting = waiting.get(..count).unwrap_or_default();
            if waiting.is_empty() {
                return Ok(());
            }
            if let KeyLayout::Blocks(layout) = layout {
                for &(column, row) in waiting {
                    let block = layout.block(column, row);
                    fetch(keys, block);
                    fetch(keys, block + BLOCK_TEXELS / 2);
                }
            }
            for &(column, row) in waiting {
                let block = layout
                    .block(keys, column, row, &mut space)
                    .ok_or(missing(self.frame.tables))?;
                self.frame
                    .add_crossing_block(sums, runs, block, column, row);
            }
        }
    }
}

/// A set of blocks of a page.
struct Marks([u64; MARK_WORDS]);

/// One word a tile: a block's name over 64 is its tile's number.
const MARK_WORDS: usize = 1 << 10;
const _: () = assert!(block_name(PAGE_BLOCKS - 1, PAGE_BLOCKS - 1) as usize == MARK_WORDS * 64 - 1);

impl Marks {
    const fn new() -> Self {
        Self([0; MARK_WORDS])
    }

    #[inline]
    fn add(&mut self, name: u16) {
        if let Some(word) = self.0.get_mut(usize::from(name >> 6)) {
            *word |= 1 << (name & 63);
        }
    }

    /// The marked blocks in `rows` of tiles, in rising order.
    fn iter(&self, rows: Range<u16>) -> impl Iterator<Item = u16> {
        let first = rows.start * PAGE_TILES;
        let words = usize::from(first)..usize::from(rows.end * PAGE_TILES);
        let words = self.0.get(words).unwrap_or_default();
        words.iter().zip(first..).flat_map(|(&word, tile)| {
            let mut left = word;
            core::iter::from_fn(move || {
                let bit = (left != 0).then(|| left.trailing_zeros() as u16)?;
                left &= left - 1;
                Some(tile << 6 | bit)
            })
        })
    }
}
