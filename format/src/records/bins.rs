//! Records of the inverse bin map and what accompanies it, \[AWKK21\] §5.4.

use zerocopy::little_endian::U16;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Column and row of a texel. 4 bytes: one u32, column in the low half.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct TexelPosition {
    /// Column.
    pub column: U16,
    /// Row.
    pub row: U16,
}

/// The bounding box of some texels, borders included. 8 bytes.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Default,
    FromBytes,
    IntoBytes,
    Immutable,
    KnownLayout,
    Unaligned,
)]
#[repr(C)]
pub struct BoxRecord {
    /// Leftmost column.
    pub first_column: U16,
    /// Topmost row.
    pub first_row: U16,
    /// Rightmost column.
    pub last_column: U16,
    /// Bottommost row.
    pub last_row: U16,
}

/// An inner node of a forest tree: the boxes of its two children. 16 bytes.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Default,
    FromBytes,
    IntoBytes,
    Immutable,
    KnownLayout,
    Unaligned,
)]
#[repr(C)]
pub struct ForestNode {
    /// Boxes of the first and the second half of the node's texels.
    pub children: [BoxRecord; 2],
}

/// Where in its bin a texel's normal lies: fraction `(x + 1/2) / 65536` of the bin's width from its lower border
/// in s, the same in t. 4 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct ExactNormal {
    /// In the grid's column direction.
    pub x: U16,
    /// In the grid's row direction.
    pub y: U16,
}

impl ExactNormal {
    /// The nearest record to the fractions `x`, `y` in [0, 1] of the bin.
    pub fn from_fractions(x: f64, y: f64) -> Self {
        // A cast from float saturates: fraction 1, left over by rounding, lands in the last step.
        let step = |fraction: f64| U16::new((fraction * 65536.0) as u16);
        Self {
            x: step(x),
            y: step(y),
        }
    }

    /// The fractions of the bin this record stands for.
    pub fn fractions(self) -> [f64; 2] {
        [self.x, self.y].map(|step| (f64::from(step.get()) + 0.5) / 65536.0)
    }
}
