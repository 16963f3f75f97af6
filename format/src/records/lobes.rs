//! Records of lobes: blocks of 4 × 4 of them, where the blocks of a node lie, and moments of cells.

use zerocopy::little_endian::{F32, I16, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The normals of 4 × 4 lobes, row by row. 100 bytes.
///
/// Lobe k, x columns and y rows from the middle of the block, has the normal `low + plane (x, y) + step (s[k], t[k])`: as smooth
/// normals are nearly on a plane, 16 bits are ten times as fine as without it. Lobes beyond the lattice have zeros.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct LobeBlock {
    /// 0: least s and t beside the plane.
    pub low: [F32; 2],
    /// 8: a 65535th of how far they range beside the plane.
    pub step: [F32; 2],
    /// 16: unit of the block's [`LobeSlopes`]; 0 without them.
    pub slope_step: F32,
    /// 20: ∂s/∂x, ∂s/∂y, ∂t/∂x and ∂t/∂y of the plane.
    pub plane: [F32; 4],
    /// 36: s beside the plane.
    pub s: [U16; 16],
    /// 68: t beside the plane.
    pub t: [U16; 16],
}

/// The slopes J of the lobes of a [`LobeBlock`], in its `slope_step`, per spacing of the lattice. 128 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct LobeSlopes {
    /// 0: ∂s/∂x.
    pub s_x: [I16; 16],
    /// 32: ∂s/∂y.
    pub s_y: [I16; 16],
    /// 64: ∂t/∂x.
    pub t_x: [I16; 16],
    /// 96: ∂t/∂y.
    pub t_y: [I16; 16],
}

/// A block of curved lobes: normals and slopes side by side, as every query that reads one reads both. 228 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct CurvedLobeBlock {
    /// 0: normals.
    pub normals: LobeBlock,
    /// 100: slopes.
    pub slopes: LobeSlopes,
}

/// A block whose normals or slopes 16 bits would round by too much. 128 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct WideLobeBlock {
    /// 0: s.
    pub s: [F32; 16],
    /// 64: t.
    pub t: [F32; 16],
}

/// The slopes of a [`WideLobeBlock`], per spacing of the lattice. 256 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct WideLobeSlopes {
    /// 0: ∂s/∂x.
    pub s_x: [F32; 16],
    /// 64: ∂s/∂y.
    pub s_y: [F32; 16],
    /// 128: ∂t/∂x.
    pub t_x: [F32; 16],
    /// 192: ∂t/∂y.
    pub t_y: [F32; 16],
}

/// A wide block of curved lobes. 384 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct CurvedWideLobeBlock {
    /// 0: normals.
    pub normals: WideLobeBlock,
    /// 128: slopes.
    pub slopes: WideLobeSlopes,
}

/// Where the blocks of a node of level 1 lie. 12 bytes.
///
/// Blocks with a bit in neither mask are merged: their lobes follow from the cell's moments.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct LobeIndex {
    /// 0: place of the node's first [`LobeBlock`].
    pub first: U32,
    /// 4: place of the node's first [`WideLobeBlock`].
    pub first_wide: U32,
    /// 8: which children are stored as [`LobeBlock`], in order of their bits.
    pub narrow: U16,
    /// 10: which children are stored as [`WideLobeBlock`].
    pub wide: U16,
}

/// How far lobes spread in each of sixteen children of a node. 20 bytes.
///
/// A lobe spreads by σh |J|, |J| the root of the sum of J's squares: so far normals range over one deviation of its position.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct LobeSpreads {
    /// 0: unit of `greatest`.
    pub step: F32,
    /// 4: the most that a lobe of the child spreads, rounded up.
    pub greatest: [u8; 16],
}

/// The moments of the lobes in each of sixteen children of a node: each child as one lobe. 244 bytes.
///
/// A lobe at the middle of its cell, of the cell's mean normal, with a slope by regression of normals on positions, and what
/// is left of the covariance of normals. A child that is not there has zeros.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct LobeMoments {
    /// 0: unit of `slope`.
    pub slope_step: F32,
    /// 4: mean s, in 65535ths of the child's box.
    pub mean_s: [U16; 16],
    /// 36: mean t, in 65535ths of the child's box.
    pub mean_t: [U16; 16],
    /// 68: ∂s/∂x, ∂s/∂y, ∂t/∂x and ∂t/∂y per spacing of the lattice, in `slope_step`.
    pub slope: [[I16; 16]; 4],
    /// 196: residual standard deviation of s, in 255ths of the child's box.
    pub deviation_s: [u8; 16],
    /// 212: residual standard deviation of t, likewise.
    pub deviation_t: [u8; 16],
    /// 228: residual correlation of s and t, `(byte - 127) / 127`.
    pub correlation: [u8; 16],
}

const _: () = assert!(
    size_of::<LobeBlock>() == 100
        && size_of::<CurvedLobeBlock>() == 228
        && size_of::<CurvedWideLobeBlock>() == 384
        && size_of::<LobeSlopes>() == 128
        && size_of::<WideLobeBlock>() == 128
        && size_of::<WideLobeSlopes>() == 256
        && size_of::<LobeIndex>() == 12
        && size_of::<LobeSpreads>() == 20
        && size_of::<LobeMoments>() == 244,
    "records are as FORMAT.md says"
);
