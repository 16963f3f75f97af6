//! Rasters of normals: every texel's own in 4 bytes, in blocks of 4 × 4.

use crate::normals::NormalMap;
use glintbake_format::records::{RASTER_SIDE, RasterBlock, RasterLattice, pack_raster};
use rayon::prelude::*;
use zerocopy::little_endian::U32;

/// The normals of `map` on the lattice that rounds them by least, and that lattice. 4 bytes a texel; O(texels).
pub fn build(map: &NormalMap) -> (RasterLattice, Vec<RasterBlock>) {
    let lattice = lattice(map);
    let side = RASTER_SIDE as usize;
    let (width, height) = (map.width() as usize, map.height() as usize);
    let columns = width.div_ceil(side);
    let blocks = (0..columns * height.div_ceil(side))
        .into_par_iter()
        .map(|place| {
            let (first, top) = (side * (place % columns), side * (place / columns));
            let mut words = [U32::new(0); 16];
            for (number, word) in words.iter_mut().enumerate() {
                let (x, y) = (first + number % side, top + number / side);
                if x < width && y < height {
                    let [s, t] = map.texels()[y * width + x].map(f64::from);
                    word.set(pack_raster(lattice.nearest(s), lattice.nearest(t)));
                }
            }
            RasterBlock(words)
        })
        .collect();
    (lattice, blocks)
}

/// Texels whose errors are added up as one piece of work.
const CHUNK: usize = 1 << 14;

/// The lattice that rounds the normals of `map` by least: exactly not at all, where two components came from an image of 16
/// bits, whichever number meant zero. Of equals, [`RasterLattice::Whole`].
fn lattice(map: &NormalMap) -> RasterLattice {
    let error = |lattice: RasterLattice| -> f64 {
        let parts: Vec<f64> = map
            .texels()
            .par_chunks(CHUNK)
            .map(|texels| {
                let components = texels.iter().flatten();
                components
                    .map(|&x| {
                        // As f32, so that what the map itself rounds does not count.
                        let off = lattice.component(lattice.nearest(f64::from(x))) as f32 - x;
                        f64::from(off) * f64::from(off)
                    })
                    .sum()
            })
            .collect();
        parts.iter().sum()
    };
    if error(RasterLattice::Half) < error(RasterLattice::Whole) {
        RasterLattice::Half
    } else {
        RasterLattice::Whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::model::Wrap;
    use glintbake_format::records::unpack_raster;

    #[test]
    fn normals_of_16_bits_are_kept_whichever_number_meant_zero() {
        for (lattice, decode) in [
            (
                RasterLattice::Half,
                (|x| (2.0 * x - 65535.0) / 65535.0) as fn(f64) -> f64,
            ),
            (RasterLattice::Whole, |x| (x - 32768.0) / 32767.0),
        ] {
            let texels: Vec<[f32; 2]> = (0..35_u32)
                .map(|texel| {
                    [20_000 + 731 * texel, 47_000 - 613 * texel]
                        .map(|sample| decode(f64::from(sample)) as f32)
                })
                .collect();
            let map = NormalMap::new(7, 5, Wrap::Repeat, texels);
            let (chosen, blocks) = build(&map);
            assert_eq!((chosen, blocks.len()), (lattice, 4));
            for (texel, normal) in map.texels().iter().enumerate() {
                let (x, y) = (texel % 7, texel / 7);
                let word = blocks[2 * (y / 4) + x / 4].0[4 * (y % 4) + x % 4];
                let kept = unpack_raster(word.get()).map(|n| lattice.component(n) as f32);
                assert_eq!(kept, *normal);
            }
            let beyond = blocks[1].0[3].get() | blocks[3].0[15].get() | blocks[2].0[4].get();
            assert_eq!(beyond, 0, "words beyond the map are zero");
        }
    }
}
