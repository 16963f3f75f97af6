//! Records of NDF maps: where images lie, and how copies of the example do.

use zerocopy::little_endian::{F64, I16, I32, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// What all images and copies have in common. 64 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct NdfMapRoot {
    /// 0: distance of two pixels on the disk.
    pub pitch: F64,
    /// 8: normal of the ground that no copy covers, a point of the disk.
    pub ground: [F64; 2],
    /// 24: standard deviation of the ground's normals, as the roughness of its kernel.
    pub ground_deviation: F64,
    /// 32: share of the surface that copies cover, 0 to 1.
    pub covered: F64,
    /// 40: unit of the transformations of copies, a power of two.
    pub unit: F64,
    /// 48: the farthest a copy reaches from its centre, in texels.
    pub reach: F64,
    /// 56: cells along a side of the grid of centres; 0 if copies are not scattered.
    pub cells: U32,
    /// 60: zero.
    pub reserved: [u8; 4],
}

impl NdfMapRoot {
    /// Whether every number is one and in range, copies reaching `farthest` texels at most.
    pub fn is_sound(&self, farthest: f64) -> bool {
        let [s, t] = self.ground.map(|x| x.get());
        let unit = self.unit.get();
        (1e-7..=1.0).contains(&self.pitch.get())
            && s * s + t * t <= 1.0
            && (1e-7..=10.0).contains(&self.ground_deviation.get())
            && (0.0..=1.0).contains(&self.covered.get())
            && (1e-12..=1e6).contains(&unit)
            // A power of two has no fraction.
            && unit.to_bits().trailing_zeros() >= 52
            && (0.0..=farthest).contains(&self.reach.get())
            && self.reserved == [0; 4]
    }
}

/// Where an NDF image lies. 16 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct NdfImage {
    /// 0: place of the first pixel on the disk, along s and t, in pitches.
    pub place: [I32; 2],
    /// 8: columns, along s, and rows, along t.
    pub size: [U16; 2],
    /// 12: its first pixel, row by row.
    pub first: U32,
}

/// A copy of the example. 24 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct NdfCopy {
    /// 0: its centre, in 2⁻³² of a tile of texture space.
    pub centre: [U32; 2],
    /// 8: how texels of the example lie on the surface, from the centre: xx, xy, yx, yy, in the root's unit.
    pub matrix: [I16; 4],
    /// 16: its first neighbour among those of all copies; its last comes before the first of the next copy.
    pub neighbours: U32,
    /// 20: the share of it that neighbours leave visible, in 65535.
    pub visible: U16,
    /// 22: zero.
    pub reserved: [u8; 2],
}

const _: () = assert!(
    size_of::<NdfMapRoot>() == 64 && size_of::<NdfImage>() == 16 && size_of::<NdfCopy>() == 24,
    "records are as FORMAT.md says"
);

/// Bits of a pixel's fraction.
const FRACTION: u32 = 11;

/// What turns the bits of a pixel, moved to where an f32 has its own, into its value: 31, the greatest exponent, is 4 to 8.
const PIXEL_SCALE: f32 = f32::from_bits((127 + 127 - 31 + 2) << 23);

/// The value of a pixel, in peaks of the kernel: 5 bits of exponent, 11 of fraction; 0, or 2⁻²⁸ to 8.
#[inline(always)]
pub const fn unpack_ndf(pixel: u16) -> f32 {
    // Below one step of the exponent there is zero alone, so that no subnormal number comes of it.
    f32::from_bits((pixel as u32) << (23 - FRACTION)) * PIXEL_SCALE
}

/// The pixel nearest to `value`, in peaks of the kernel; 0 below 2⁻²⁸, the greatest beyond 8.
pub fn pack_ndf(value: f64) -> u16 {
    const LEAST: f64 = 1.0 / (1_u64 << 28) as f64;
    // So that NaN is 0.
    let is_seen = value >= LEAST;
    if !is_seen {
        return 0;
    }
    let scaled = (value as f32).min(7.99) / PIXEL_SCALE;
    let rounded = scaled.to_bits().wrapping_add(1 << (22 - FRACTION)) >> (23 - FRACTION);
    rounded.min(0xFFFF) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_keep_values_to_a_4096th() {
        let mut value = 1.0 / (1_u64 << 28) as f64;
        while value < 7.9 {
            let read = f64::from(unpack_ndf(pack_ndf(value)));
            assert!((read - value).abs() <= value / 4095.0, "{value} {read}");
            value *= 1.0137;
        }
        assert_eq!(unpack_ndf(pack_ndf(1.0)), 1.0);
        assert_eq!(unpack_ndf(pack_ndf(4.0)), 4.0);
        assert_eq!(pack_ndf(1e-12), 0);
        assert_eq!(pack_ndf(f64::NAN), 0);
        assert_eq!(unpack_ndf(0), 0.0);
        assert!(unpack_ndf(pack_ndf(1e9)) > 7.9);
    }

    #[test]
    fn every_pixel_but_the_subnormal_ones_is_that_of_its_value() {
        for pixel in (1_u16 << FRACTION)..=0xFFFE {
            let value = f64::from(unpack_ndf(pixel));
            let again = pack_ndf(value);
            assert!(again == pixel || value > 7.98, "{pixel} {value} {again}");
        }
    }
}
