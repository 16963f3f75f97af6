//! Structural checks of block lists.

use super::Limited;
use crate::finding::{Fault, Finding};
use crate::model::{BLOCK_SIDE, BLOCK_TEXELS, BlockLayout, PAGE_SIDE, block_place};
use crate::records::{LIST_BLOCKS, LIST_COUNTS, LIST_KEYS, LIST_TILES, LISTS, PAGES, TileRecord};
use crate::view::{BinTables, BlockList, BlockLists};
use zerocopy::little_endian::U16;

/// Blocks in a row of a page.
const PAGE_BLOCKS: u32 = PAGE_SIDE / BLOCK_SIDE;

/// Each count is the bin map's, and together they are as many as there are texels: every texel is counted once, as each
/// block comes once in a list and each key once in a page.
///
/// Reports what it can; an error is a fault that makes the rest meaningless.
pub(super) fn check(
    tables: &BinTables<'_>,
    lists: &BlockLists<'_>,
    report: &mut dyn FnMut(Finding),
) -> Result<(), Finding> {
    check_ends(tables, lists)?;
    let mut faults = Faults {
        tables,
        keys: Limited::new(report),
    };
    let mut texels = 0_u64;
    let mut next_list = 0;
    for page in 0..lists.layout.count() {
        let range = lists.lists(page)?;
        if range.start != next_list {
            return Err(Finding::new(Fault::ListOrder)
                .within(tables.instance.section(PAGES))
                .at(u64::from(page))
                .values(u64::from(next_list), u64::from(range.start)));
        }
        next_list = range.end;
        let mut least = 0;
        for (place, number) in (0..).zip(range) {
            let key = lists.key(number, place);
            if key < least || key >= tables.bins.key_count {
                faults.report(Fault::ListKey, LIST_KEYS, number);
            }
            least = key.saturating_add(1);
            let list = lists.list(number)?;
            texels = texels.saturating_add(faults.check_list(lists, page, number, key, &list));
        }
    }
    if next_list as usize != lists.list_count() {
        return Err(Finding::new(Fault::ListOrder)
            .within(tables.instance.section(PAGES))
            .values(lists.list_count() as u64, u64::from(next_list)));
    }
    let expected = u64::from(tables.instance.texel_count());
    if texels != expected {
        return Err(Finding::new(Fault::ListTotal)
            .within(tables.instance.section(LIST_COUNTS))
            .values(expected, texels));
    }
    Ok(())
}

/// The first list begins at zero, and the last ends with its sections.
fn check_ends(tables: &BinTables<'_>, lists: &BlockLists<'_>) -> Result<(), Finding> {
    let finding = Finding::new(Fault::ListOrder).within(tables.instance.section(LISTS));
    for (start, blocks, tiles) in lists.ends() {
        let start = start.ok_or(finding)?;
        for (expected, got) in [(blocks, start.block.get()), (tiles, start.tile.get())] {
            if expected as u64 != u64::from(got) {
                return Err(finding.values(expected as u64, u64::from(got)));
            }
        }
    }
    Ok(())
}

struct Faults<'f> {
    tables: &'f BinTables<'f>,
    keys: Limited<'f>,
}

impl Faults<'_> {
    fn report(&mut self, fault: Fault, section: crate::FourCc, list: u32) {
        self.keys.report(
            Finding::new(fault)
                .within(self.tables.instance.section(section))
                .at(u64::from(list)),
        );
    }

    /// The texels `list` counts.
    fn check_list(
        &mut self,
        lists: &BlockLists<'_>,
        page: u32,
        number: u32,
        key: u32,
        list: &BlockList<'_>,
    ) -> u64 {
        let first_column = page % lists.layout.columns * PAGE_BLOCKS;
        let first_row = page / lists.layout.columns * PAGE_BLOCKS;
        let instance = &self.tables.instance;
        let map = BlockLayout::new(instance.width, instance.height);
        let mut texels = 0_u64;
        let mut least = 0;
        for (name, &count) in list.blocks.iter().zip(list.counts) {
            let (column, row) = block_place(name.get());
            let (column, row) = (
                first_column.saturating_add(column),
                first_row.saturating_add(row),
            );
            let order = u32::from(name.get()).saturating_add(1);
            if order <= least || column >= map.columns || row >= map.rows {
                self.report(Fault::ListBlock, LIST_BLOCKS, number);
            }
            least = order;
            if count == 0 || u32::from(count) != self.count(column, row, key) {
                self.report(Fault::ListCount, LIST_COUNTS, number);
            }
            texels = texels.saturating_add(u64::from(count));
        }
        if !list.tiles.is_empty() && !tiles_agree(list) {
            self.report(Fault::ListTile, LIST_TILES, number);
        }
        texels
    }

    /// The texels of block (`column`, `row`) of the map whose key is `key`.
    fn count(&self, column: u32, row: u32, key: u32) -> u32 {
        let instance = &self.tables.instance;
        let (left, top) = (
            column.saturating_mul(BLOCK_SIDE),
            row.saturating_mul(BLOCK_SIDE),
        );
        let right = left.saturating_add(BLOCK_SIDE).min(instance.width);
        let bottom = top.saturating_add(BLOCK_SIDE).min(instance.height);
        let mut count = 0_u32;
        for row in top..bottom {
            for column in left..right {
                let same = self.tables.bin_map.key(column, row) == Some(key);
                count = count.saturating_add(u32::from(same));
            }
        }
        count
    }
}

/// Whether the tiles of `list` are exactly those its blocks lie in.
fn tiles_agree(list: &BlockList<'_>) -> bool {
    let mut number = 0;
    let mut expected: Option<TileRecord> = None;
    for (place, (name, &count)) in (0_u32..).zip(list.blocks.iter().zip(list.counts)) {
        let tile = name.get() / BLOCK_TEXELS as u16;
        match &mut expected {
            Some(record) if record.tile.get() == tile => {
                record.texels = U16::new(record.texels.get().saturating_add(u16::from(count)));
            }
            _ => {
                if expected.is_some() {
                    if list.tiles.get(number) != expected.as_ref() {
                        return false;
                    }
                    number = number.saturating_add(1);
                }
                expected = Some(TileRecord {
                    tile: U16::new(tile),
                    first: U16::new(place as u16),
                    texels: U16::new(u16::from(count)),
                });
            }
        }
    }
    list.tiles.get(number) == expected.as_ref() && list.tiles.len() == number.saturating_add(1)
}
