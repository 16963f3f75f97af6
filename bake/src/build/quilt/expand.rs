//! The surface a quilt stands for.

use crate::normals::NormalMap;
use glintbake_format::model::{QuiltLayout, Wrap};
use rayon::prelude::*;

/// The normals of every texel of the surface, which repeats. Takes 8 bytes a texel.
///
/// # Panics
/// If the numbers are not those of a quilt of `sample`.
pub(super) fn expand(
    sample: &NormalMap,
    layout: &QuiltLayout,
    origins: &[[u16; 2]],
    cuts: &[u8],
) -> NormalMap {
    let [width, height] = layout.patches.map(|count| count * layout.patch());
    let row_of = |y: u32| {
        (0..width).map(move |x| {
            let (patch, within) = layout.place(x, y);
            let first = layout.number(patch) * layout.cuts();
            let left = cuts[first + within[1] as usize];
            let above = cuts[first + (layout.patch() + within[0]) as usize];
            let (patch, within) = layout.supplier(patch, within, [left, above]);
            let [x, y] = layout.texel(origins[layout.number(patch)], within);
            sample.texels()[y as usize * layout.sample[0] as usize + x as usize]
        })
    };
    let texels = (0..height).into_par_iter().flat_map_iter(row_of).collect();
    NormalMap::new(width, height, Wrap::Repeat, texels)
}
