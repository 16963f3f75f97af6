//! Records of MIP lobes: blocks of clustered lobes.

use zerocopy::little_endian::{F32, I16, U16};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Sixteen clustered lobes of a cell. 512 bytes.
///
/// A lobe has the weight `weight / 65535` of its cell, the middle `side (x, y) / 65535` from the cell's first corner, `side` being that
/// of the cell in texels, and the position factor L, lower triangular, with A = L Lᵀ: `side / 2 · (l_11 / 65535, l_21 / 32767,
/// l_22 / 65535)`. There its normal is `low + step (s, t)`, and its slope J `slope_step` times `s_x` … `t_y` a texel. Beside the kernel's,
/// normals have the residual covariance M Mᵀ, M lower triangular, `residual_step` times `m_11`, `m_21`, `m_22`.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct MipBlock {
    /// 0: least s and t of the block.
    pub low: [F32; 2],
    /// 8: a 65535th of how far they range.
    pub step: [F32; 2],
    /// 16: unit of slopes, per texel.
    pub slope_step: F32,
    /// 20: unit of residuals.
    pub residual_step: F32,
    /// 24: greatest standard deviation of normals of a lobe in any direction, its position unknown, without the kernel.
    pub spread: F32,
    /// 28: zero.
    pub reserved: [u8; 4],
    /// 32: shares of the cell; of all lobes of a cell, 65535 together.
    pub weight: [U16; 16],
    /// 64: middles, to the right.
    pub x: [U16; 16],
    /// 96: middles, down.
    pub y: [U16; 16],
    /// 128: first column of L.
    pub l_11: [U16; 16],
    /// 160: below it.
    pub l_21: [I16; 16],
    /// 192: second column of L.
    pub l_22: [U16; 16],
    /// 224: s beyond the least.
    pub s: [U16; 16],
    /// 256: t beyond the least.
    pub t: [U16; 16],
    /// 288: ∂s/∂x.
    pub s_x: [I16; 16],
    /// 320: ∂s/∂y.
    pub s_y: [I16; 16],
    /// 352: ∂t/∂x.
    pub t_x: [I16; 16],
    /// 384: ∂t/∂y.
    pub t_y: [I16; 16],
    /// 416: first column of M.
    pub m_11: [I16; 16],
    /// 448: below it.
    pub m_21: [I16; 16],
    /// 480: second column of M.
    pub m_22: [I16; 16],
}

const _: () = assert!(
    size_of::<MipBlock>() == 512,
    "records are as FORMAT.md says"
);
