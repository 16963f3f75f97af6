//! The bin map: one key per texel.

use super::bin_tables::expect_count;
use crate::container::Container;
use crate::finding::Finding;
use crate::model::{BLOCK_SIDE, BLOCK_TEXELS, BlockLayout};
use crate::records::{BIN_MAP, BLOCKED_BIN_MAP, Instance};
use crate::section::SectionId;
use zerocopy::little_endian::{U16, U32};

/// Keys of either width, in the order of the bin map's layout.
#[derive(Clone, Copy, Debug)]
pub enum Keys<'a> {
    /// Keys of 2 bytes, for up to 65 536 of them.
    Narrow(&'a [U16]),
    /// Keys of 4 bytes.
    Wide(&'a [U32]),
}

/// Where the key of a texel lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyLayout {
    /// Row by row.
    Rows {
        /// Texels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Block by block.
    Blocks(BlockLayout),
}

/// A bin map.
#[derive(Clone, Copy, Debug)]
pub struct BinMap<'a> {
    /// The section it lies in.
    pub id: SectionId,
    /// One key a texel, and in blocks that reach beyond the map zeros.
    pub keys: Keys<'a>,
    /// Where a texel's key is among them.
    pub layout: KeyLayout,
}

impl<'a> BinMap<'a> {
    /// The bin map of `instance`: in blocks if it has one of these, else in rows.
    ///
    /// # Errors
    /// If neither section is there or the one that is has not as many elements as its layout needs.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let blocked = instance.section(BLOCKED_BIN_MAP);
        let (id, layout, count) = if container.find(blocked).is_some() {
            let layout = BlockLayout::new(instance.width, instance.height);
            (blocked, KeyLayout::Blocks(layout), layout.key_count())
        } else {
            let layout = KeyLayout::Rows {
                width: instance.width,
                height: instance.height,
            };
            let id = instance.section(BIN_MAP);
            (id, layout, u64::from(instance.texel_count()))
        };
        let wide = container
            .find(id)
            .is_some_and(|entry| entry.element_size.get() == 4);
        let keys = if wide {
            Keys::Wide(container.elements(id)?)
        } else {
            Keys::Narrow(container.elements(id)?)
        };
        let map = Self { id, keys, layout };
        expect_count(id, count as usize, map.len())?;
        Ok(map)
    }

    /// Number of keys, those beyond the map included.
    pub const fn len(&self) -> usize {
        match self.keys {
            Keys::Narrow(keys) => keys.len(),
            Keys::Wide(keys) => keys.len(),
        }
    }

    /// Whether there are no keys.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The key at place `place` of the layout.
    #[inline]
    pub fn key_at(&self, place: usize) -> Option<u32> {
        match self.keys {
            Keys::Narrow(keys) => keys.get(place).map(|key| u32::from(key.get())),
            Keys::Wide(keys) => keys.get(place).map(|key| key.get()),
        }
    }

    /// The key of texel (`column`, `row`).
    #[inline]
    pub fn key(&self, column: u32, row: u32) -> Option<u32> {
        self.key_at(match self.layout {
            KeyLayout::Rows { width, .. } => (row as usize)
                .wrapping_mul(width as usize)
                .wrapping_add(column as usize),
            KeyLayout::Blocks(layout) => layout.texel(column, row),
        })
    }
}

impl KeyLayout {
    /// The 64 keys of block (`column`, `row`) of `keys`, which is in this layout; put together in `space` where they do
    /// not lie together, with zeros beyond the map. `None` if there is no such block.
    #[inline(always)]
    pub fn block<'k, K: Copy + Default>(
        self,
        keys: &'k [K],
        column: u32,
        row: u32,
        space: &'k mut [K; BLOCK_TEXELS],
    ) -> Option<&'k [K; BLOCK_TEXELS]> {
        match self {
            Self::Blocks(layout) => keys.get(layout.block(column, row)..)?.first_chunk(),
            Self::Rows { width, height } => {
                put_together(keys, [width, height], [column, row], space)?;
                Some(space)
            }
        }
    }
}

/// Puts the keys of block (`column`, `row`) of a map in rows together.
fn put_together<K: Copy + Default>(
    keys: &[K],
    [width, height]: [u32; 2],
    [column, row]: [u32; 2],
    space: &mut [K; BLOCK_TEXELS],
) -> Option<()> {
    let left = column.checked_mul(BLOCK_SIDE)?;
    let top = row.checked_mul(BLOCK_SIDE)?;
    let length = BLOCK_SIDE.min(width.checked_sub(left)?) as usize;
    let rows = BLOCK_SIDE.min(height.checked_sub(top)?) as usize;
    *space = [K::default(); BLOCK_TEXELS];
    let (lines, _) = space.as_chunks_mut::<{ BLOCK_SIDE as usize }>();
    for (line, row) in lines.iter_mut().take(rows).zip(top..) {
        let start = row as usize * width as usize + left as usize;
        let stored = keys.get(start..start.checked_add(length)?)?;
        for (slot, key) in line.iter_mut().zip(stored) {
            *slot = *key;
        }
    }
    Some(())
}
