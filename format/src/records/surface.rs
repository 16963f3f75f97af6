//! Records of surfaces: normals in rows, and what bounces after the first see of them.

use zerocopy::little_endian::F32;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The normal at a texel's middle, as a point of the projected disk. 8 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct SurfaceNormal {
    /// 0: s, to the right.
    pub s: F32,
    /// 4: t, up.
    pub t: F32,
}

impl SurfaceNormal {
    /// The record of a point of the disk.
    pub fn new([s, t]: [f32; 2]) -> Self {
        Self {
            s: F32::new(s),
            t: F32::new(t),
        }
    }

    /// The point of the disk.
    #[inline(always)]
    pub fn point(self) -> [f64; 2] {
        [f64::from(self.s.get()), f64::from(self.t.get())]
    }
}

const _: () = assert!(
    size_of::<SurfaceNormal>() == 8,
    "records are as FORMAT.md says"
);
