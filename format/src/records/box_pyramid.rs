//! Records of box pyramids: boxes of normals, nested.

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The boxes of normals of sixteen children, row by row of four. 64 bytes: one cache line.
///
/// Each is within the node's own box: from `low` to `high` 255ths of it. A child that is not there has a `low_s` above its
/// `high_s`.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct BoxNode {
    /// 0: least s, rounded down.
    pub low_s: [u8; 16],
    /// 16: greatest s, rounded up.
    pub high_s: [u8; 16],
    /// 32: least t, rounded down.
    pub low_t: [u8; 16],
    /// 48: greatest t, rounded up.
    pub high_t: [u8; 16],
}

impl BoxNode {
    /// A node without children.
    pub const EMPTY: Self = Self {
        low_s: [255; 16],
        high_s: [0; 16],
        low_t: [255; 16],
        high_t: [0; 16],
    };
}

const _: () = assert!(size_of::<BoxNode>() == 64, "records are as FORMAT.md says");
