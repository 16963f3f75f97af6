//! Records of block lists: for each key the blocks of texels that hold it.

use zerocopy::little_endian::{U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Which block lists are a page's. 8 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct PageRecord {
    /// Number of the page's first list.
    pub first_list: U32,
    /// Number of its lists.
    pub list_count: U32,
}

/// Where a block list begins; it ends where the next one does. 8 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct ListStart {
    /// Its first block among those of all lists.
    pub block: U32,
    /// Its first tile among those of all lists; a list without tiles ends where it begins.
    pub tile: U32,
}

/// The blocks of a block list that lie in one tile. 6 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct TileRecord {
    /// Number of the tile in its page, row by row: a block's name over 64.
    pub tile: U16,
    /// Its first block within the list; its last comes before the next tile's first.
    pub first: U16,
    /// Texels of the list's key in the tile, 1 to 4096.
    pub texels: U16,
}
