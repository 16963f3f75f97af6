//! Weights from block lists: blocks inside count by their numbers, those on the outline are scanned.

use super::frame::Frame;
use super::keys::StoredKey;
use super::scan::missing;
use super::sums::Sums;
use super::window::{KeyRuns, RUNS, WINDOW};
use crate::error::QueryError;
use crate::fetch::fetch;
use crate::overlap::TexelBox;
use core::ops::Range;
use glintbake_format::model::{
    BLOCK_SIDE, BLOCK_TEXELS, PAGE_SIDE, TILE_SIDE, block_name, block_place,
};
use glintbake_format::view::{BlockList, BlockLists, KeyLayout, Keys};

/// Tiles of a list that are looked at together.
const TOGETHER: usize = 32;
/// Up to this length a list is cut down to some rows of tiles by counting, which vector instructions do, and beyond it by
/// searching.
const COUNTED: usize = 256;
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

impl Traversal<'_> {
    /// Adds them.
    pub fn run(self) -> Result<(), QueryError> {
        let Self {
            sums,
            frame,
            lists,
            runs,
        } = self;
        let TexelBox { low, high } = frame.footprint.bounds();
        let unbounded = frame.unbounded;
        let page_columns = page_range(low[0], high[0], lists.layout.columns, unbounded);
        for page_row in page_range(low[1], high[1], lists.layout.rows, unbounded) {
            for page_column in page_columns.clone() {
                // Written out here: whatever returned so large a value would copy it.
                let bounds = frame.block_bounds();
                let mut page = Page {
                    frame,
                    corner: [page_column * PAGE_BLOCKS, page_row * PAGE_BLOCKS],
                    rows: TileRows::new(&bounds[1], page_row, frame.blocks.rows),
                    inside: [0; PAGE_WORDS],
                    crossing: [0; PAGE_WORDS],
                    wanted: [0; PAGE_WORDS],
                };
                page.test_blocks(tiles_of_page(&bounds[0], page_column));
                let number = page_row * lists.layout.columns + page_column;
                let mut window = WindowLists::NONE;
                window.find(lists, number, runs)?;
                for (_, list) in window.as_slice() {
                    page.rows.fetch(list);
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
        let mut window = WindowLists::NONE;
        window.find(lists, page, runs)?;
        for (place, list) in window.as_slice() {
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
pub(super) struct WindowLists<'w> {
    lists: [(u32, BlockList<'w>); WINDOW * WINDOW],
    count: usize,
}

impl<'w> WindowLists<'w> {
    pub(super) const NONE: Self = Self {
        lists: [(0, BlockList::EMPTY); WINDOW * WINDOW],
        count: 0,
    };

    /// Adds the lists of `runs` in page number `page`.
    #[inline(always)]
    pub(super) fn find(
        &mut self,
        lists: &BlockLists<'w>,
        page: u32,
        runs: &KeyRuns,
    ) -> Result<(), QueryError> {
        let of_page = lists.lists(page)?;
        let mut numbers = [const { 0..0 }; RUNS];
        for ((start, count, _), numbers) in runs.iter().zip(&mut numbers) {
            if count > 0 {
                *numbers = lists.lists_of_keys(of_page.clone(), start..start.saturating_add(count));
                fetch(lists.starts(), numbers.start as usize);
                fetch(lists.starts(), numbers.end as usize);
            }
        }
        for ((start, count, first_place), numbers) in runs.iter().zip(numbers) {
            for number in numbers {
                let list = lists.list(number)?;
                let key = lists.key(number, number - of_page.start);
                if let Some(slot) = self.lists.get_mut(self.count) {
                    *slot = (first_place + key.saturating_sub(start).min(count - 1), list);
                    self.count += usize::from(!list.blocks.is_empty());
                }
            }
        }
        Ok(())
    }

    pub(super) fn as_slice(&self) -> &[(u32, BlockList<'w>)] {
        self.lists.get(..self.count).unwrap_or_default()
    }
}

/// The rows of tiles of a page that a footprint meets, which a list is cut down to first.
#[derive(Clone, Debug)]
pub(super) struct TileRows {
    pub meets: Range<u16>,
    /// All of the page's rows of tiles, at least 1.
    pub count: u16,
}

impl TileRows {
    /// Those of a page in row `page_row` of pages, of a map of `block_rows` rows of blocks, that meet the rows `meets` of
    /// blocks.
    pub fn new(meets: &Range<u32>, page_row: u32, block_rows: u32) -> Self {
        Self {
            meets: tiles_of_page(meets, page_row),
            count: tiles_of_page(&(0..block_rows), page_row).end.max(1),
        }
    }

    /// Asks for the part of `list` that will be looked at first.
    #[inline(always)]
    pub fn fetch(&self, list: &BlockList<'_>) {
        let Range { start, end } = self.meets;
        if list.tiles.is_empty() {
            let guess = self.guess(list.blocks.len(), start);
            fetch(list.blocks, guess);
            fetch(list.blocks, self.guess(list.blocks.len(), end));
            fetch(list.counts, guess);
        } else {
            fetch(list.tiles, self.guess(list.tiles.len(), start));
        }
    }

    /// Where among `count` records those in row `row` of tiles begin, if a list's texels lie evenly.
    #[inline(always)]
    fn guess(&self, count: usize, row: u16) -> usize {
        count * usize::from(row) / usize::from(self.count)
    }

    /// The part of `records`, in rising order of their tiles, in these rows.
    #[inline(always)]
    pub fn within<T>(&self, records: &[T], tile: impl Fn(&T) -> u16) -> Range<usize> {
        let Range { start, end } = self.meets;
        let before = |record: &T, row: u16| tile(record) < row * PAGE_TILES;
        if records.len() <= COUNTED {
            let (mut first, mut last) = (0, 0);
            for record in records {
                first += u16::from(before(record, start));
                last += u16::from(before(record, end));
            }
            return usize::from(first)..usize::from(last);
        }
        let first = search(records, self.guess(records.len(), start), |record| {
            before(record, start)
        });
        let rest = records.get(first..).unwrap_or_default();
        let guess = self.guess(records.len(), end).saturating_sub(first);
        first..first + search(rest, guess, |record| before(record, end))
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
pub(super) fn page_range(low: f64, high: f64, count: u32, unbounded: bool) -> Range<u32> {
    let page = |texel: f64| libm::floor(texel / f64::from(PAGE_SIDE));
    let last = f64::from(count) - 1.0;
    if !unbounded && (high < 0.0 || page(low) > last) {
        return 0..0;
    }
    page(low).clamp(0.0, last) as u32..page(high).clamp(0.0, last) as u32 + 1
}

/// The tiles of page number `page` in its row or column of pages that `blocks` meet.
fn tiles_of_page(blocks: &Range<u32>, page: u32) -> Range<u16> {
    let first = page * PAGE_BLOCKS;
    let tiles = TILE_SIDE / BLOCK_SIDE;
    let place = |block: u32| block.saturating_sub(first).min(PAGE_BLOCKS);
    (place(blocks.start) / tiles) as u16..place(blocks.end).div_ceil(tiles) as u16
}

/// A page of the map under the part of a footprint in one tile: how each of its blocks lies to the footprint.
struct Page<'a> {
    frame: &'a Frame<'a>,
    /// Its first block.
    corner: [u32; 2],
    /// The rows of tiles that may hold weight.
    rows: TileRows,
    /// The blocks that lie inside, a word for each tile: a block's name is 64 times its tile's number and its bit.
    inside: [u64; PAGE_WORDS],
    /// The blocks that cross the outline.
    crossing: [u64; PAGE_WORDS],
    /// Those of them that hold a wanted key.
    wanted: [u64; PAGE_WORDS],
}

/// Tiles of a page.
const PAGE_WORDS: usize = 1 << 10;
const _: () = assert!(block_name(PAGE_BLOCKS - 1, PAGE_BLOCKS - 1) as usize == PAGE_WORDS * 64 - 1);

impl Page<'_> {
    /// Tests the blocks of the columns `tile_columns` of tiles: each block once, and each tile that lies inside or outside
    /// at once, whatever the number of lists they are in.
    #[inline(always)]
    fn test_blocks(&mut self, tile_columns: Range<u16>) {
        let frame = self.frame;
        let tiles = frame.squares(f64::from(TILE_SIDE));
        let side = TILE_SIDE / BLOCK_SIDE;
        for row in self.rows.meets.clone() {
            for column in tile_columns.clone() {
                let first = [
                    self.corner[0] + u32::from(column) * side,
                    self.corner[1] + u32::from(row) * side,
                ];
                let (mut inside, mut crossing) = (0, 0);
                let tile = tiles.relation(
                    (first[0] * BLOCK_SIDE) as f32,
                    (first[1] * BLOCK_SIDE) as f32,
                );
                if tile.crossing | frame.unbounded {
                    for (line, row) in (0..side).zip(first[1]..) {
                        let [more_inside, more_crossing] = frame.eight_blocks(first[0], row);
                        inside |= u64::from(more_inside) << (8 * line);
                        crossing |= u64::from(more_crossing) << (8 * line);
                    }
                } else if tile.inside {
                    inside = u64::MAX;
                }
                let tile = usize::from(row * PAGE_TILES + column);
                if let (Some(slot), Some(other)) =
                    (self.inside.get_mut(tile), self.crossing.get_mut(tile))
                {
                    (*slot, *other) = (inside, crossing);
                }
            }
        }
    }

    #[inline(always)]
    fn add_list(&mut self, sums: &mut Sums, place: u32, list: &BlockList<'_>) {
        let inside = if list.tiles.is_empty() {
            self.blocks(
                list,
                self.rows
                    .within(list.blocks, |name| name.get() / BLOCK_TEXELS as u16),
            )
        } else {
            self.tiles(list)
        };
        sums.add_inside(place, inside);
    }

    /// The texels of the tiles of `list` that lie inside, and of the blocks inside of those that do not.
    #[inline(always)]
    fn tiles(&mut self, list: &BlockList<'_>) -> u64 {
        let range = self.rows.within(list.tiles, |tile| tile.tile.get());
        let records = list.tiles.get(range.clone()).unwrap_or_default();
        let mut texels = 0;
        let mut waiting = [0; TOGETHER];
        for (chunk, first) in records.chunks(TOGETHER).zip(range.step_by(TOGETHER)) {
            let mut count = 0;
            for (record, number) in chunk.iter().zip(first..) {
                let tile = usize::from(record.tile.get());
                let (Some(&inside), Some(&crossing)) =
                    (self.inside.get(tile), self.crossing.get(tile))
                else {
                    continue;
                };
                let is_whole = inside == u64::MAX;
                texels += u64::from(record.texels.get()) * u64::from(is_whole);
                if let Some(slot) = waiting.get_mut(count) {
                    *slot = number;
                    count += usize::from((inside | crossing != 0) & !is_whole);
                }
            }
            // Each tile's blocks are in cache lines of their own: asks for all of them first.
            let waiting = waiting.get(..count).unwrap_or_default();
            for &number in waiting {
                let start = list.tile(number).start;
                fetch(list.blocks, start);
                fetch(list.counts, start);
            }
            for &number in waiting {
                texels += self.blocks_of_tile(list, number);
            }
        }
        texels
    }

    /// The texels of those blocks of tile record number `number` of `list` that lie inside; marks those that cross the
    /// outline.
    #[inline(always)]
    fn blocks_of_tile(&mut self, list: &BlockList<'_>, number: usize) -> u64 {
        let range = list.tile(number);
        let (Some(names), Some(counts)) = (list.blocks.get(range.clone()), list.counts.get(range))
        else {
            return 0;
        };
        let tile = list
            .tiles
            .get(number)
            .map_or(0, |record| usize::from(record.tile.get()));
        let (Some(&inside), Some(&crossing), Some(wanted)) = (
            self.inside.get(tile),
            self.crossing.get(tile),
            self.wanted.get_mut(tile),
        ) else {
            return 0;
        };
        let mut texels = 0;
        let mut present = 0;
        for (name, &count) in names.iter().zip(counts) {
            let block = name.get() % BLOCK_TEXELS as u16;
            texels += u32::from(count) * (inside >> block & 1) as u32;
            present |= 1 << block;
        }
        *wanted |= present & crossing;
        u64::from(texels)
    }

    /// The texels of those blocks in `range` of `list` that lie inside; marks those that cross the outline.
    #[inline(always)]
    fn blocks(&mut self, list: &BlockList<'_>, range: Range<usize>) -> u64 {
        let (Some(names), Some(counts)) = (list.blocks.get(range.clone()), list.counts.get(range))
        else {
            return 0;
        };
        let mut texels = 0;
        for (name, &count) in names.iter().zip(counts) {
            let (tile, block) = (usize::from(name.get() >> 6), name.get() & 63);
            if let (Some(inside), Some(crossing)) = (self.inside.get(tile), self.crossing.get(tile))
            {
                texels += u64::from(count) * (inside >> block & 1);
                if crossing >> block & 1 != 0
                    && let Some(wanted) = self.wanted.get_mut(tile)
                {
                    *wanted |= 1 << block;
                }
            }
        }
        texels
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
        let mut marked = self.wanted();
        loop {
            let mut waiting = [(0, 0); FETCHED];
            let mut count = 0;
            for (slot, name) in waiting.iter_mut().zip(&mut marked) {
                let (column, row) = block_place(name);
                *slot = (column + self.corner[0], row + self.corner[1]);
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

    /// The wanted blocks, in rising order of their names.
    #[inline(always)]
    fn wanted(&self) -> impl Iterator<Item = u16> {
        let first = self.rows.meets.start * PAGE_TILES;
        let words = usize::from(first)..usize::from(self.rows.meets.end * PAGE_TILES);
        let words = self.wanted.get(words).unwrap_or_default();
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
