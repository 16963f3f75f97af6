//! Block lists: for each key the blocks of texels that hold it.

use super::bin_tables::{bins, elements, expect_count};
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::PageLayout;
use crate::records::{
    Instance, LIST_BLOCKS, LIST_COUNTS, LIST_KEYS, LIST_TILES, LISTS, ListStart, PAGES, PageRecord,
    TileRecord,
};
use crate::section::SectionId;
use core::ops::Range;
use zerocopy::little_endian::{U16, U32};

/// The block lists of one instance.
#[derive(Clone, Copy, Debug)]
pub struct BlockLists<'a> {
    id: SectionId,
    /// How the map is cut into pages.
    pub layout: PageLayout,
    pages: &'a [PageRecord],
    keys: Option<&'a [U32]>,
    starts: &'a [ListStart],
    blocks: &'a [U16],
    counts: &'a [u8],
    tiles: &'a [TileRecord],
}

/// The blocks of a page that hold one key.
#[derive(Clone, Copy, Debug)]
pub struct BlockList<'a> {
    /// Names of the blocks, rising.
    pub blocks: &'a [U16],
    /// Texels of the key in each.
    pub counts: &'a [u8],
    /// The tiles the blocks lie in; empty for a short list.
    pub tiles: &'a [TileRecord],
}

impl<'a> BlockLists<'a> {
    /// The block lists of `instance`. O(1).
    ///
    /// # Errors
    /// If a section is missing or its count does not fit the map or another section.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let layout = PageLayout::new(instance.width, instance.height);
        let starts: &[ListStart] = container.elements(instance.section(LISTS))?;
        let blocks: &[U16] = container.elements(instance.section(LIST_BLOCKS))?;
        let list_count = starts.len().saturating_sub(1);
        let tiles = instance.section(LIST_TILES);
        let keys = instance.section(LIST_KEYS);
        // Also refuses a section without even the record that ends the last list.
        expect_count(
            instance.section(LISTS),
            list_count.saturating_add(1),
            starts.len(),
        )?;
        Ok(Self {
            id: instance.section(LISTS),
            layout,
            pages: elements(container, instance, PAGES, layout.count() as usize)?,
            keys: match container.find(keys) {
                Some(_) => Some(elements(container, instance, LIST_KEYS, list_count)?),
                None => {
                    let expected = (bins(instance)?.key_count as usize)
                        .saturating_mul(layout.count() as usize);
                    expect_count(
                        instance.section(LISTS),
                        expected.saturating_add(1),
                        starts.len(),
                    )?;
                    None
                }
            },
            starts,
            blocks,
            counts: elements(container, instance, LIST_COUNTS, blocks.len())?,
            tiles: match container.find(tiles) {
                Some(_) => container.elements(tiles)?,
                None => &[],
            },
        })
    }

    /// The numbers of the lists of page number `page`.
    ///
    /// # Errors
    /// [`Fault::ListOrder`] if there is no such page, or it names lists that do not exist.
    pub fn lists(&self, page: u32) -> Result<Range<u32>, Finding> {
        let range = self.pages.get(page as usize).and_then(|record| {
            let first = record.first_list.get();
            let end = first.checked_add(record.list_count.get())?;
            ((end as usize) < self.starts.len()).then_some(first..end)
        });
        range.ok_or(
            Finding::new(Fault::ListOrder)
                .within(SectionId {
                    kind: PAGES,
                    ..self.id
                })
                .at(u64::from(page)),
        )
    }

    /// The key of list number `list`, which is the `place`-th of its page.
    #[inline]
    pub fn key(&self, list: u32, place: u32) -> u32 {
        self.keys
            .and_then(|keys| keys.get(list as usize))
            .map_or(place, |key| key.get())
    }

    /// The lists among `lists`, one page's, of the keys `keys`. O(1) if each page has a list for every key, else a
    /// binary search.
    #[inline]
    pub fn lists_of_keys(&self, lists: Range<u32>, keys: Range<u32>) -> Range<u32> {
        let Some(stored) = self.keys else {
            let place = |key: u32| lists.start.saturating_add(key).min(lists.end);
            return place(keys.start)..place(keys.end);
        };
        let stored = stored
            .get(lists.start as usize..lists.end as usize)
            .unwrap_or_default();
        let first = stored.partition_point(|key| key.get() < keys.start);
        // A run is a few keys: walk instead of searching again.
        let length = stored
            .get(first..)
            .unwrap_or_default()
            .iter()
            .take(keys.len())
            .take_while(|key| key.get() < keys.end)
            .count();
        let first = lists.start.saturating_add(first as u32);
        first..first.saturating_add(length as u32)
    }

    /// Where each list begins, and the last one's end; what [`list`](Self::list) reads.
    pub fn starts(&self) -> &'a [ListStart] {
        self.starts
    }

    /// How many blocks and tiles the lists `lists` have together, as far as their starts can be believed.
    #[inline]
    pub fn sizes(&self, lists: Range<u32>) -> (u32, u32) {
        match (
            self.starts.get(lists.start as usize),
            self.starts.get(lists.end as usize),
        ) {
            (Some(first), Some(end)) => (
                end.block.get().saturating_sub(first.block.get()),
                end.tile.get().saturating_sub(first.tile.get()),
            ),
            _ => (0, 0),
        }
    }

    /// List number `list`.
    ///
    /// # Errors
    /// [`Fault::ListOrder`] if there is no such list, or its starts contradict each other or the sections.
    #[inline]
    pub fn list(&self, list: u32) -> Result<BlockList<'a>, Finding> {
        let place = list as usize;
        let found = match self.starts.get(place..place.saturating_add(2)) {
            Some([start, end]) => {
                let blocks = start.block.get() as usize..end.block.get() as usize;
                let tiles = start.tile.get() as usize..end.tile.get() as usize;
                match (
                    self.blocks.get(blocks.clone()),
                    self.counts.get(blocks),
                    self.tiles.get(tiles),
                ) {
                    (Some(blocks), Some(counts), Some(tiles)) => Some(BlockList {
                        blocks,
                        counts,
                        tiles,
                    }),
                    _ => None,
                }
            }
            _ => None,
        };
        found.ok_or(
            Finding::new(Fault::ListOrder)
                .within(self.id)
                .at(u64::from(list)),
        )
    }

    /// Number of lists.
    pub(crate) const fn list_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Where the first list begins and the last one ends: at zero, and as many blocks and tiles as the sections hold, if
    /// all is well.
    pub(crate) fn ends(&self) -> [(Option<ListStart>, usize, usize); 2] {
        let (first, last) = (self.starts.first(), self.starts.last());
        [
            (first.copied(), 0, 0),
            (last.copied(), self.blocks.len(), self.tiles.len()),
        ]
    }
}

impl BlockList<'_> {
    /// The list of no blocks.
    pub const EMPTY: Self = Self {
        blocks: &[],
        counts: &[],
        tiles: &[],
    };

    /// The places of the blocks that lie in the tile of record number `number`; empty or beyond the list if the record
    /// lies.
    #[inline]
    pub fn tile(&self, number: usize) -> Range<usize> {
        let start = self.tiles.get(number).map(|tile| tile.first.get() as usize);
        let end = self
            .tiles
            .get(number.saturating_add(1))
            .map_or(self.blocks.len(), |tile| tile.first.get() as usize);
        start.unwrap_or(end)..end
    }
}
