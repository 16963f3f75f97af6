//! The bin map: one key per texel.

use crate::container::Container;
use crate::finding::Finding;
use crate::records::{BIN_MAP, Instance};
use zerocopy::little_endian::{U16, U32};

/// A bin map of either key width.
#[derive(Clone, Copy, Debug)]
pub enum BinMap<'a> {
    /// Keys of 2 bytes, for up to 65 536 of them.
    Narrow(&'a [U16]),
    /// Keys of 4 bytes.
    Wide(&'a [U32]),
}

impl<'a> BinMap<'a> {
    /// The bin map of `instance`, one key for each of its texels.
    ///
    /// # Errors
    /// If the section is missing or has not one element a texel.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let id = instance.section(BIN_MAP);
        let wide = container
            .find(id)
            .is_some_and(|entry| entry.element_size.get() == 4);
        let map = if wide {
            Self::Wide(container.elements(id)?)
        } else {
            Self::Narrow(container.elements(id)?)
        };
        let count = match map {
            Self::Narrow(keys) => keys.len(),
            Self::Wide(keys) => keys.len(),
        };
        super::bin_tables::expect_count(id, instance.texel_count() as usize, count)?;
        Ok(map)
    }

    /// The key of texel number `texel`, row-major.
    #[inline]
    pub fn key(&self, texel: usize) -> Option<u32> {
        match self {
            Self::Narrow(keys) => keys.get(texel).map(|key| u32::from(key.get())),
            Self::Wide(keys) => keys.get(texel).map(|key| key.get()),
        }
    }
}
