//! Weights from block lists: blocks and tiles that may stand for their texels by their numbers, the others opened.

use super::Target;
use super::forms::{Forms, exp_half};
use super::tables::{BlockWeights, OPENED, Opened, Tiles};
use super::texels::{add_block, rows};
use crate::error::QueryError;
use crate::fetch::fetch;
use crate::ndf::bin_weights::block_lists::{TileRows, WindowLists, page_range};
use crate::ndf::bin_weights::keys::StoredKey;
use crate::ndf::bin_weights::scan::missing;
use crate::overlap::{GaussianFootprint, TexelBox};
use crate::scan::MapShape;
use crate::simd::Work;
use core::ops::Range;
use glintbake_format::model::{BLOCK_SIDE, BLOCK_TEXELS, PAGE_SIDE, TILE_SIDE, Wrap, block_place};
use glintbake_format::view::{BinTables, BlockList, BlockLists, Keys};
use zerocopy::little_endian::U16;

/// Blocks or tiles weighed together, without a branch on where they lie.
pub(super) const TOGETHER: usize = 16;
/// Tiles in a row of a page, and in a column.
pub(super) const PAGE_TILES: u16 = (PAGE_SIDE / TILE_SIDE) as u16;
/// The same, as a length.
pub(super) const ROW: usize = PAGE_TILES as usize;
const HALF_BLOCK: f64 = 0.5 * BLOCK_SIDE as f64;
pub(super) const HALF_TILE: f32 = (TILE_SIDE / 2 - BLOCK_SIDE / 2) as f32;

/// Whether, on a map of `shape`, no tile meets `footprint` both from the left and from the right: then every block has
/// but one copy in its row that counts.
pub(super) fn folds(shape: MapShape, footprint: &GaussianFootprint) -> bool {
    let TexelBox { low, high } = footprint.bounds();
    let width = f64::from(shape.width) - 2.0 * f64::from(TILE_SIDE);
    shape.wrap == Wrap::Repeat && high[0] - low[0] <= width
}

/// Adds the weights of all wanted texels of one tile of the map under `footprint` to the sums; with `fold`, of its
/// whole row of tiles.
pub(super) struct Traversal<'s, 't> {
    pub target: &'s mut Target<'t>,
    pub footprint: &'s GaussianFootprint,
    pub forms: &'s Forms,
    pub lists: &'s BlockLists<'s>,
    pub fold: bool,
}

impl Work for Traversal<'_, '_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            target,
            footprint,
            forms,
            lists,
            fold,
        } = self;
        let bounds = footprint.bounds();
        let columns = if fold {
            0..lists.layout.columns
        } else {
            page_range(bounds.low[0], bounds.high[0], lists.layout.columns, false)
        };
        for page_row in page_range(bounds.low[1], bounds.high[1], lists.layout.rows, false) {
            for page_column in columns.clone() {
                let corner = [page_column, page_row].map(|place| place * PAGE_SIDE);
                let mut page = Page::new(target.tables, forms, footprint, corner, fold);
                page.weigh_tiles();
                let number = page_row * lists.layout.columns + page_column;
                let mut window = WindowLists::NONE;
                window.find(lists, number, target.runs)?;
                let lists = window.as_slice();
                for (_, list) in lists {
                    page.rows.fetch(list);
                }
                if lists.iter().all(|(_, list)| list.tiles.is_empty()) {
                    for (place, list) in lists {
                        target.sums.add(*place, page.weigh_blocks(list));
                    }
                } else {
                    let mut table = BlockTable::new();
                    for (place, list) in lists {
                        let weight = if list.tiles.is_empty() {
                            page.weigh_blocks(list)
                        } else {
                            page.weigh_tiles_of(list, &mut table)
                        };
                        target.sums.add(*place, weight);
                    }
                }
                page.add_opened(target, fold)?;
            }
        }
        Ok(())
    }
}

/// The rows of blocks that are weighed.
fn rows_within(footprint: &GaussianFootprint, forms: &Forms) -> Range<u32> {
    let rows = footprint.rows();
    let half = 0.5 * (rows.end - rows.start) as f64;
    // A tile whose centre is weighed may begin this much further out.
    let spared = (half * (1.0 - forms.share_of_radius)) as i64 - i64::from(TILE_SIDE);
    let spared = spared.max(0);
    // A cast saturates, and what is above the map is not weighed here.
    let block = |row: i64| u32::try_from(row.max(0)).unwrap_or(u32::MAX);
    block(rows.start + spared) / BLOCK_SIDE..block(rows.end - spared).div_ceil(BLOCK_SIDE)
}

/// A page of the map under a Gaussian.
pub(super) struct Page<'a> {
    pub(super) forms: &'a Forms,
    footprint: &'a GaussianFootprint,
    /// Its first texel.
    corner: [u32; 2],
    /// The centre of its first block, relative to the Gaussian's.
    pub(super) origin: [f32; 2],
    /// The map's width if columns repeat, and its inverse; else zeros.
    period: f32,
    frequency: f32,
    /// The rows of tiles that may hold weight.
    pub(super) rows: TileRows,
    tiles: Tiles,
    opened: Opened,
}

impl<'a> Page<'a> {
    /// The page of a map that begins at texel `corner`; with `fold`, columns repeat.
    #[inline(always)]
    pub(super) fn new(
        tables: &BinTables<'_>,
        forms: &'a Forms,
        footprint: &'a GaussianFootprint,
        corner: [u32; 2],
        fold: bool,
    ) -> Self {
        let width = f64::from(tables.instance.width);
        let [left, top] = corner.map(f64::from);
        let origin = footprint.centred(left + HALF_BLOCK, top + HALF_BLOCK);
        let (period, frequency) = if fold {
            (width, 1.0 / width)
        } else {
            (0.0, 0.0)
        };
        Self {
            forms,
            footprint,
            corner,
            origin: origin.map(|coordinate| coordinate as f32),
            period: period as f32,
            frequency: frequency as f32,
            rows: TileRows::new(
                &rows_within(footprint, forms),
                corner[1] / PAGE_SIDE,
                tables.instance.height.div_ceil(BLOCK_SIDE),
            ),
            tiles: Tiles::new(),
            opened: Opened::new(),
        }
    }
}

impl Page<'_> {
    /// The weight of a list without tiles: of those blocks that stand for their texels, or whose tiles do; opens the others.
    ///
    /// A block costs a look at its tile; only those of tiles that are to be opened, few, are weighed by themselves.
    #[inline(always)]
    fn weigh_blocks(&mut self, list: &BlockList<'_>) -> f64 {
        let range = self
            .rows
            .within(list.blocks, |name| name.get() / BLOCK_TEXELS as u16);
        let (Some(names), Some(counts)) = (list.blocks.get(range.clone()), list.counts.get(range))
        else {
            return 0.0;
        };
        let mut tiles = [0.0_f32; 4];
        let mut blocks = [0.0; TOGETHER];
        let mut waiting = ([U16::ZERO; TOGETHER], [0; TOGETHER]);
        let mut count = 0;
        for (names, counts) in names.chunks(tiles.len()).zip(counts.chunks(tiles.len())) {
            for ((name, &texels), tiles) in names.iter().zip(counts).zip(&mut tiles) {
                let weight = self.tiles.get(name.get() / BLOCK_TEXELS as u16);
                *tiles += f32::from(texels) * weight.max(0.0);
                // Written in any case, kept only if opened: that costs less than a wrong guess.
                if let (Some(name_slot), Some(texels_slot)) =
                    (waiting.0.get_mut(count), waiting.1.get_mut(count))
                {
                    (*name_slot, *texels_slot) = (*name, texels);
                }
                count += usize::from(weight < 0.0);
                if count == TOGETHER {
                    self.few_blocks(&waiting.0, &waiting.1, TOGETHER, &mut blocks);
                    count = 0;
                }
            }
        }
        if count > 0 {
            self.few_blocks(&waiting.0, &waiting.1, count, &mut blocks);
        }
        let sum = |sums: &[f32]| sums.iter().map(|&sum| f64::from(sum)).sum::<f64>();
        self.forms.block.peak * sum(&blocks) + self.forms.tile.peak * sum(&tiles)
    }

    /// The weight of a list with tiles: of those tiles and blocks that stand for their texels; opens the others.
    #[inline(always)]
    fn weigh_tiles_of(&mut self, list: &BlockList<'_>, table: &mut BlockTable) -> f64 {
        let mut blocks = [0.0; TOGETHER];
        let (tiles, of_table) = self.tiles(list, &mut blocks, table);
        let blocks: f64 = blocks.into_iter().map(f64::from).sum();
        self.forms.block.peak * (blocks + of_table) + self.forms.tile.peak * tiles
    }

    /// `x`, less as many periods as bring it next to zero.
    #[inline(always)]
    pub(super) fn fold(&self, x: f32) -> f32 {
        /// 1.5 · 2²³: adding it rounds to a whole number.
        const WHOLE: f32 = 12_582_912.0;
        let periods = (x * self.frequency + WHOLE) - WHOLE;
        x - periods * self.period
    }

    /// The tiles of `list` that stand for their texels, in units of the peak, and the blocks of the others that `table`
    /// has room for, in units of theirs; adds the rest to `blocks`.
    #[inline(always)]
    fn tiles(
        &mut self,
        list: &BlockList<'_>,
        blocks: &mut [f32; TOGETHER],
        table: &mut BlockTable,
    ) -> (f64, f64) {
        let mut of_table = 0.0;
        let range = self.rows.within(list.tiles, |tile| tile.tile.get());
        let records = list.tiles.get(range.clone()).unwrap_or_default();
        let mut sum = 0.0;
        for (chunk, first) in records.chunks(TOGETHER).zip(range.step_by(TOGETHER)) {
            let mut opened = [false; TOGETHER];
            let mut any = false;
            for (record, opened) in chunk.iter().zip(&mut opened) {
                let weight = self.tiles.get(record.tile.get());
                sum += f64::from(record.texels.get()) * f64::from(weight.max(0.0));
                *opened = weight < 0.0;
                any |= *opened;
            }
            if !any {
                continue;
            }
            // Each tile's blocks are in cache lines of their own: asks for all of them first.
            for (number, opened) in (first..).zip(opened) {
                if opened {
                    let start = list.tile(number).start;
                    fetch(list.blocks, start);
                    fetch(list.counts, start);
                }
            }
            for ((number, opened), record) in (first..).zip(opened).zip(chunk) {
                if opened {
                    match table.slot(self, record.tile.get()) {
                        Some(slot) => {
                            of_table += self.blocks_by_table(list, number, record.tile.get(), slot);
                        }
                        None => self.blocks(list, list.tile(number), blocks),
                    }
                }
            }
        }
        (sum, of_table)
    }

    /// The blocks of tile record number `number` of `list`, whose tile is `tile`, by the weights in `slot`.
    #[inline(always)]
    fn blocks_by_table(
        &mut self,
        list: &BlockList<'_>,
        number: usize,
        tile: u16,
        slot: &BlockWeights,
    ) -> f64 {
        let range = list.tile(number);
        let (Some(names), Some(counts)) = (list.blocks.get(range.clone()), list.counts.get(range))
        else {
            return 0.0;
        };
        let mut sum = 0.0_f32;
        let mut present = 0_u64;
        for (name, &count) in names.iter().zip(counts) {
            let block = name.get() % BLOCK_TEXELS as u16;
            if let Some(weight) = slot.weights.get(usize::from(block)) {
                sum += f32::from(count) * weight;
            }
            present |= 1 << block;
        }
        self.opened.add_all(tile, present & slot.opened);
        f64::from(sum)
    }

    /// Weighs the tiles in the rows that may hold weight: those that stand for their texels, and which are to be opened.
    #[inline(always)]
    fn weigh_tiles(&mut self) {
        let rule = self.forms.tile_rule;
        for row in self.rows.meets.clone() {
            let y = f32::from(row) * TILE_SIDE as f32 + HALF_TILE + self.origin[1];
            let mut weights = [0.0; ROW];
            for (weight, column) in weights.iter_mut().zip(0_u16..) {
                let x = f32::from(column) * TILE_SIDE as f32 + HALF_TILE + self.origin[0];
                let x = self.fold(x);
                let distance = self.forms.block.distance_squared(x, y);
                let meets = distance <= rule.end;
                let accepted = rule.accepts(distance);
                let average = exp_half(self.forms.tile.distance_squared(x, y));
                let inside = if accepted { average } else { OPENED };
                *weight = if meets { inside } else { 0.0 };
            }
            self.tiles.add_row(row, &weights);
        }
    }

    /// Adds those blocks in `range` of `list` that stand for their texels to `sums`; opens the others.
    #[inline(always)]
    fn blocks(&mut self, list: &BlockList<'_>, range: Range<usize>, sums: &mut [f32; TOGETHER]) {
        let mut at = range.start;
        while at < range.end {
            let wanted = (range.end - at).min(TOGETHER);
            let (Some(names), Some(counts)) = (list.blocks.get(at..), list.counts.get(at..)) else {
                break;
            };
            // What follows within the list may be read along, it is not counted.
            match (names.first_chunk(), counts.first_chunk()) {
                (Some(names), Some(counts)) => self.few_blocks(names, counts, wanted, sums),
                _ => {
                    let mut last_names = [U16::ZERO; TOGETHER];
                    let mut last_counts = [0; TOGETHER];
                    for (slot, name) in last_names.iter_mut().zip(names) {
                        *slot = *name;
                    }
                    for (slot, count) in last_counts.iter_mut().zip(counts) {
                        *slot = *count;
                    }
                    self.few_blocks(&last_names, &last_counts, wanted, sums);
                }
            }
            at += TOGETHER;
        }
    }

    /// [`blocks`](Self::blocks) for the first `wanted` of a few.
    #[inline(always)]
    fn few_blocks(
        &mut self,
        names: &[U16; TOGETHER],
        counts: &[u8; TOGETHER],
        wanted: usize,
        sums: &mut [f32; TOGETHER],
    ) {
        let rule = self.forms.block_rule;
        let mut opened = [false; TOGETHER];
        let mut any = false;
        for (place, (((name, &count), sum), opened)) in
            (0_u8..).zip(names.iter().zip(counts).zip(sums).zip(&mut opened))
        {
            let (column, row) = block_place(name.get());
            let x = self.fold((column * BLOCK_SIDE) as f32 + self.origin[0]);
            let y = (row * BLOCK_SIDE) as f32 + self.origin[1];
            let distance = self.forms.block.distance_squared(x, y);
            let meets = (distance <= rule.end) & (place < wanted as u8);
            let accepted = rule.accepts(distance);
            *sum += if meets & accepted {
                f32::from(count) * exp_half(distance)
            } else {
                0.0
            };
            *opened = meets & !accepted;
            any |= *opened;
        }
        if any {
            for (name, opened) in names.iter().zip(opened) {
                if opened {
                    self.opened.add(name.get());
                }
            }
        }
    }

    /// The weights of the blocks of tile number `tile`, and which of them are to be opened.
    #[inline(always)]
    fn weights_of_tile(&self, tile: u16) -> BlockWeights {
        let rule = self.forms.block_rule;
        let mut slot = BlockWeights::NONE;
        let mut opened = [false; BLOCK_TEXELS];
        for (((weight, opened), name), _) in slot
            .weights
            .iter_mut()
            .zip(&mut opened)
            .zip(tile * BLOCK_TEXELS as u16..=u16::MAX)
            .zip(0..BLOCK_TEXELS)
        {
            let (column, row) = block_place(name);
            let x = self.fold((column * BLOCK_SIDE) as f32 + self.origin[0]);
            let y = (row * BLOCK_SIDE) as f32 + self.origin[1];
            let distance = self.forms.block.distance_squared(x, y);
            let meets = distance <= rule.end;
            let accepted = rule.accepts(distance);
            *weight = if meets & accepted {
                exp_half(distance)
            } else {
                0.0
            };
            *opened = meets & !accepted;
        }
        for (block, opened) in opened.into_iter().enumerate() {
            slot.opened |= u64::from(opened) << block;
        }
        slot
    }

    /// Adds the texels of the opened blocks.
    #[inline(always)]
    fn add_opened(&self, target: &mut Target<'_>, fold: bool) -> Result<(), QueryError> {
        match target.tables.bin_map.keys {
            Keys::Narrow(keys) => self.add_opened_of(keys, target, fold),
            Keys::Wide(keys) => self.add_opened_of(keys, target, fold),
        }
    }

    #[inline(always)]
    fn add_opened_of<K: StoredKey>(
        &self,
        keys: &[K],
        target: &mut Target<'_>,
        fold: bool,
    ) -> Result<(), QueryError> {
        let layout = target.tables.bin_map.layout;
        let width = f64::from(target.tables.instance.width);
        let evenly = self.footprint.is_smooth();
        let mut space = [K::default(); BLOCK_TEXELS];
        for tile_row in self.rows.meets.clone() {
            let tiles = self.opened.row(tile_row);
            let all = tiles.iter().fold(0, |all, tile| all | tile);
            for within in (0..8).filter(|within| (all >> (8 * within)) & 0xFF != 0) {
                let row = u32::from(tile_row) * 8 + within + self.corner[1] / BLOCK_SIDE;
                let rows = rows(self.footprint, i64::from(row * BLOCK_SIDE));
                for (tile, first) in tiles.iter().zip((0_u32..).step_by(8)) {
                    let mut left = (tile >> (8 * within)) & 0xFF;
                    while left != 0 {
                        let column = first + left.trailing_zeros() + self.corner[0] / BLOCK_SIDE;
                        left &= left - 1;
                        let block = layout
                            .block(keys, column, row, &mut space)
                            .ok_or(missing(target.tables))?;
                        let mut texel = i64::from(column * BLOCK_SIDE);
                        if fold {
                            let [x, _] = self.footprint.centred(texel as f64 + HALF_BLOCK, 0.0);
                            texel -= (libm::rint(x / width) * width) as i64;
                        }
                        add_block(target, &rows, block, [column, row], texel, evenly);
                    }
                }
            }
        }
        Ok(())
    }
}

/// Tiles whose blocks have been weighed: for windows with dense lists, many of which open the same tiles.
struct BlockTable {
    /// Place among `slots` of each tile of the page.
    places: [u8; ROW * ROW],
    slots: [BlockWeights; SLOTS],
    count: usize,
}

/// Tiles whose blocks are kept.
const SLOTS: usize = 128;
const UNKNOWN: u8 = u8::MAX;

impl BlockTable {
    const fn new() -> Self {
        Self {
            places: [UNKNOWN; ROW * ROW],
            slots: [BlockWeights::NONE; SLOTS],
            count: 0,
        }
    }

    /// The weights of tile number `tile` of `page`, if there is room.
    #[inline(always)]
    fn slot(&mut self, page: &Page<'_>, tile: u16) -> Option<&BlockWeights> {
        let place = self.places.get_mut(usize::from(tile))?;
        if *place == UNKNOWN {
            *self.slots.get_mut(self.count)? = page.weights_of_tile(tile);
            *place = self.count as u8;
            self.count += 1;
        }
        self.slots.get(usize::from(*place))
    }
}
