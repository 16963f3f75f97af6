//! Records of cluster trees: roots of tiles, nodes, and leaves of texels.

use zerocopy::little_endian::{F32, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The box of normals that a tile's tree begins with. 16 bytes.
///
/// It runs from `low` to `low + 255 step` in s and t.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct TileRoot {
    /// 0: least s and t of the tile's normals.
    pub low: [F32; 2],
    /// 8: a 255th of the box's sides, rounded up; 0 where all normals have the same.
    pub step: [F32; 2],
}

/// Sixteen children: each field holds one byte of each. 256 bytes.
///
/// Normals are relative to the node's own box, positions to the tile, in units of 1 texel (4 in tiles of 1024). A child
/// that is not there has zeros. Where a child's box is `[low, high]`, a byte `b` of its moments means `low + b/255 (high - low)`.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct ClusterNode {
    /// 0: least s, rounded down.
    pub low_s: [u8; 16],
    /// 16: greatest s, rounded up.
    pub high_s: [u8; 16],
    /// 32: least t, rounded down.
    pub low_t: [u8; 16],
    /// 48: greatest t, rounded up.
    pub high_t: [u8; 16],
    /// 64: mean s in the child's box.
    pub mean_s: [u8; 16],
    /// 80: mean t in the child's box.
    pub mean_t: [u8; 16],
    /// 96: standard deviation of s, 255 for half the child's box.
    pub deviation_s: [u8; 16],
    /// 112: standard deviation of t, 255 for half the child's box.
    pub deviation_t: [u8; 16],
    /// 128: correlation of s and t: `(byte - 127) / 127`.
    pub correlation: [u8; 16],
    /// 144: first column.
    pub low_x: [u8; 16],
    /// 160: last column, inclusive.
    pub high_x: [u8; 16],
    /// 176: first row.
    pub low_y: [u8; 16],
    /// 192: last row, inclusive.
    pub high_y: [u8; 16],
    /// 208: mean column in the child's box, whose sides run to the far border of its last texel.
    pub mean_x: [u8; 16],
    /// 224: mean row, likewise.
    pub mean_y: [u8; 16],
    /// 240: bits 0-5: root mean square of the standard deviations of column and row, 63 for `√((w² + h²) / 8)` of the box's
    /// sides w and h; bits 6-7: what a leaf looks like, see [`LeafKind`].
    pub deviation_xy: [u8; 16],
}

/// Sixteen texels of one leaf. 64 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct ClusterLeaf(pub [U32; 16]);

/// The finer bits of the normals of a wide leaf: of each texel four of s, and above them four of t. 16 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct FineBits(pub [u8; 16]);

const _: () = assert!(
    size_of::<TileRoot>() == 16
        && size_of::<ClusterNode>() == 256
        && size_of::<ClusterLeaf>() == 64,
    "records are as FORMAT.md says"
);

/// How the words of a leaf are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum LeafKind {
    /// Column, row, s and t of each texel within the leaf's boxes.
    Narrow = 0,
    /// Up to four normals, and which of them each texel has.
    Palette = 1,
    /// As [`Self::Narrow`], with four more bits of s and t each in a record of its own.
    Wide = 2,
}

impl LeafKind {
    /// The kind in bits 6-7 of `deviation_xy`, if there is one.
    #[inline]
    pub const fn of(deviation_xy: u8) -> Option<Self> {
        match deviation_xy >> 6 {
            0 => Some(Self::Narrow),
            1 => Some(Self::Palette),
            2 => Some(Self::Wide),
            _ => None,
        }
    }
}

/// How the 32 bits of a texel of a leaf are shared out: column, row, s and t from the lowest bit up. Columns and rows
/// take as many as the leaf's box needs, s and t half each of what is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafBits {
    /// Bits of the column.
    pub x: u32,
    /// Bits of the row.
    pub y: u32,
    /// Bits of s, and of t: 10 to 16.
    pub normal: u32,
}

impl LeafBits {
    /// For a leaf that is `width + 1` columns and `height + 1` rows of a tile of 64 wide and high; wider is taken as 64.
    #[inline]
    pub const fn new(width: u8, height: u8) -> Self {
        let x = 8 - (width & 63).leading_zeros();
        let y = 8 - (height & 63).leading_zeros();
        Self {
            x,
            y,
            normal: (32 - x - y) / 2,
        }
    }

    /// The greatest number that s and t can hold.
    #[inline]
    pub const fn most(self) -> u32 {
        (1_u32 << self.normal) - 1
    }

    /// The word of a texel.
    pub const fn pack(self, x: u32, y: u32, s: u32, t: u32) -> u32 {
        x | (y << self.x) | (s << (self.x + self.y)) | (t << (self.x + self.y + self.normal))
    }

    /// Column, row, s and t of `word`.
    #[inline]
    pub const fn unpack(self, word: u32) -> [u32; 4] {
        let rest = word >> (self.x + self.y);
        [
            word & ((1 << self.x) - 1),
            (word >> self.x) & ((1 << self.y) - 1),
            rest & self.most(),
            (rest >> self.normal) & self.most(),
        ]
    }
}

/// A component of a normal in a palette: `number / (2³¹ - 1)`.
pub const PALETTE_UNIT: f64 = 1.0 / i32::MAX as f64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_of_leaves_unpack_to_what_was_packed() {
        for (width, height) in [(0, 0), (1, 0), (7, 3), (8, 63), (63, 63)] {
            let bits = LeafBits::new(width, height);
            assert!((10..=16).contains(&bits.normal), "{bits:?}");
            let fields = [u32::from(width), u32::from(height), bits.most(), 5];
            let word = bits.pack(fields[0], fields[1], fields[2], fields[3]);
            assert_eq!(bits.unpack(word), fields);
        }
        assert_eq!(
            LeafBits::new(63, 63),
            LeafBits {
                x: 6,
                y: 6,
                normal: 10
            }
        );
        assert_eq!(
            LeafBits::new(3, 4),
            LeafBits {
                x: 2,
                y: 3,
                normal: 13
            }
        );
    }
}
