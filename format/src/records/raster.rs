//! Rasters of normals: every texel's own, in blocks of one cache line.

use zerocopy::little_endian::U32;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Texels a side of a block of a raster.
pub const RASTER_SIDE: u32 = 4;

/// The normals of 4 × 4 texels, row by row, s in the low half of each word and t in the high one. 64 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct RasterBlock(pub [U32; 16]);

const _: () = assert!(
    size_of::<RasterBlock>() == 64,
    "records are as FORMAT.md says"
);

/// Which components the 65 536 numbers of a raster stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RasterLattice {
    /// `n / 32767`: zero is one of them; -32768 is not used.
    Whole,
    /// `(2 n + 1) / 65535`: zero lies halfway between two of them, as 16-bit images are decoded unless told otherwise.
    Half,
}

impl RasterLattice {
    /// What is added to a number, and what the sum is multiplied by.
    pub const fn offset_and_step(self) -> [f64; 2] {
        match self {
            Self::Whole => [0.0, 1.0 / 32767.0],
            Self::Half => [0.5, 2.0 / 65535.0],
        }
    }

    /// The component that the number `n` stands for, within an f64's last place.
    pub fn component(self, n: i16) -> f64 {
        match self {
            Self::Whole => f64::from(n) / 32767.0,
            Self::Half => (2.0 * f64::from(n) + 1.0) / 65535.0,
        }
    }

    /// The number whose component is nearest to `component`, at most half a step off for components in [-1, 1].
    pub fn nearest(self, component: f64) -> i16 {
        match self {
            Self::Whole => libm::rint(component * 32767.0).clamp(-32767.0, 32767.0) as i16,
            Self::Half => libm::rint(component * 32767.5 - 0.5).clamp(-32768.0, 32767.0) as i16,
        }
    }

    /// Whether `n` may be stored.
    pub const fn has(self, n: i16) -> bool {
        matches!(self, Self::Half) || n != i16::MIN
    }
}

/// The word of a texel of the numbers `s` and `t`.
pub const fn pack_raster(s: i16, t: i16) -> u32 {
    (s as u16 as u32) | ((t as u16 as u32) << 16)
}

/// The numbers of `word`.
#[inline(always)]
pub const fn unpack_raster(word: u32) -> [i16; 2] {
    [word as u16 as i16, (word >> 16) as u16 as i16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_nearest_to_its_own_component() {
        for lattice in [RasterLattice::Whole, RasterLattice::Half] {
            let [offset, step] = lattice.offset_and_step();
            for n in i16::MIN..=i16::MAX {
                if !lattice.has(n) {
                    continue;
                }
                let component = lattice.component(n);
                assert_eq!(lattice.nearest(component), n);
                assert!(component.abs() <= 1.0);
                assert!((component - (f64::from(n) + offset) * step).abs() < 1e-15);
                assert_eq!(unpack_raster(pack_raster(n, !n)), [n, !n]);
            }
            for place in 0..10_000 {
                let component = f64::from(place) / 5000.0 - 1.0;
                let off = lattice.component(lattice.nearest(component)) - component;
                assert!(off.abs() <= 0.5 * step + 1e-12, "{component}: {off}");
            }
        }
        assert_eq!(RasterLattice::Whole.component(0), 0.0);
    }

    #[test]
    fn components_of_images_of_16_and_8_bits_are_kept() {
        for sample in 0..=u16::MAX {
            let half = (2.0 * f64::from(sample) - 65535.0) / 65535.0;
            let kept = RasterLattice::Half.component(RasterLattice::Half.nearest(half));
            assert_eq!(kept as f32, half as f32);
            let whole = ((f64::from(sample) - 32768.0) / 32767.0).max(-1.0);
            let kept = RasterLattice::Whole.component(RasterLattice::Whole.nearest(whole));
            assert_eq!(kept as f32, whole as f32);
        }
        for sample in 0..=u8::MAX {
            let half = (2.0 * f64::from(sample) - 255.0) / 255.0;
            let kept = RasterLattice::Half.component(RasterLattice::Half.nearest(half));
            assert_eq!(kept as f32, half as f32);
        }
    }
}
