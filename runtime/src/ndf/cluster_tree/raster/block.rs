//! The normals of a block of a raster about a half vector.
#![expect(
    clippy::indexing_slicing,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use super::super::lanes::{LANES, Lanes, exponential};
use super::super::lobe::Lobe;
use super::super::walk::Centre;
use glintbake_format::records::{RasterBlock, RasterLattice};

/// Where the half vector lies among a raster's numbers.
///
/// Numbers are subtracted from its whole part before anything is rounded: what is left is as fine in single precision as the
/// distance is short, however narrow the lobe.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    whole: [i32; 2],
    rest: [f32; 2],
    /// A step in units of σr.
    pub step: f32,
}

impl Frame {
    pub fn new(lattice: RasterLattice, centre: Centre) -> Self {
        let [offset, step] = lattice.offset_and_step();
        let place = centre.point.map(|x| x / step - offset);
        // Half vectors are on the disk, so that this fits; casts saturate.
        let whole = place.map(|x| x as i32);
        Self {
            whole,
            rest: [
                (place[0] - f64::from(whole[0])) as f32,
                (place[1] - f64::from(whole[1])) as f32,
            ],
            step: (step * centre.scale) as f32,
        }
    }

    /// The normals of `block`, by their offset from the half vector in units of σr.
    #[inline(always)]
    pub fn normals(&self, block: &RasterBlock) -> [Lanes; 2] {
        let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let word = block.0[lane].get() as i32;
            let (low, high) = ((word << 16) >> 16, word >> 16);
            s[lane] = ((low - self.whole[0]) as f32 - self.rest[0]) * self.step;
            t[lane] = ((high - self.whole[1]) as f32 - self.rest[1]) * self.step;
        }
        [s, t]
    }
}

/// Half the squared distance of each normal.
#[inline(always)]
pub(super) fn distances([s, t]: &[Lanes; 2]) -> Lanes {
    let mut distances = [0.0; LANES];
    for lane in 0..LANES {
        distances[lane] = 0.5 * (s[lane] * s[lane] + t[lane] * t[lane]);
    }
    distances
}

/// What each texel adds: the kernel's term for its normal times its weight.
#[inline(always)]
pub(super) fn terms<L: Lobe>(lobe: &L, [s, t]: &[Lanes; 2], weights: &Lanes) -> Lanes {
    let mut terms = [0.0; LANES];
    for lane in 0..LANES {
        let [exponent, factor] = lobe.exponent(s[lane], t[lane]);
        terms[lane] = factor * weights[lane] * exponential(-exponent);
    }
    terms
}
