//! Surfaces: normals in rows, under boxes of what they are interpolated to.

use super::box_pyramid::{self, Bounds};
use crate::normals::NormalMap;
use glintbake_format::model::{
    BoxPyramidLayout, CATMULL_ROM, CATMULL_ROM_PARTS, Interpolation, PYRAMID_SIDE, Wrap,
};
use glintbake_format::records::{BoxNode, SurfaceNormal, TileRoot};
use rayon::prelude::*;

/// Cells along a side of a block.
const SIDE: usize = PYRAMID_SIDE as usize;
/// Texels along a side that the cells of a block are interpolated from.
const TEXELS: usize = SIDE + 3;
/// Vertices along a side of a block of 4 × 4 parts a cell.
const VERTICES: usize = SIDE * CATMULL_ROM_PARTS + 1;

/// The surface of a map.
pub struct Surface {
    /// Normals at the middles of texels, row by row.
    pub normals: Vec<SurfaceNormal>,
    /// The box of all normals.
    pub root: Vec<TileRoot>,
    /// Nodes of the box pyramid over the cells.
    pub nodes: Vec<BoxNode>,
}

/// The normals of `map`, and the box pyramid over its cells: texels where nothing is interpolated, else the squares of which
/// cell (i, j) begins at the middle of texel (i, j). Boxes hold every vertex of the cell's triangles. 8.3 bytes a texel;
/// O(texels).
///
/// # Panics
/// If the map is empty or a side above 65535.
pub fn build(map: &NormalMap, interpolation: Interpolation) -> Surface {
    let layout = BoxPyramidLayout::new(map.width(), map.height()).expect("maps have texels");
    let [columns, rows] = layout.size(0);
    let blocks: Vec<Bounds> = (0..columns * rows)
        .into_par_iter()
        .map(|place| bounds(map, interpolation, place % columns, place / columns))
        .collect();
    let pyramid = box_pyramid::build(layout, &blocks);
    let normals = map
        .texels()
        .par_iter()
        .map(|&texel| SurfaceNormal::new(texel));
    Surface {
        normals: normals.collect(),
        root: pyramid.root,
        nodes: pyramid.nodes,
    }
}

/// The normal of texel (`x`, `y`) of `map`, wherever it lies.
pub(super) fn texel(map: &NormalMap, x: i64, y: i64) -> [f64; 2] {
    let fold = |place: i64, side: u32| match map.wrap() {
        Wrap::Repeat => place.rem_euclid(i64::from(side)),
        Wrap::Clamp => place.clamp(0, i64::from(side) - 1),
    };
    let (x, y) = (fold(x, map.width()), fold(y, map.height()));
    map.texels()[y as usize * map.width() as usize + x as usize].map(f64::from)
}

/// The box of all vertices of the cells of a block.
fn bounds(map: &NormalMap, interpolation: Interpolation, column: u32, row: u32) -> Bounds {
    let (first, top) = (i64::from(column) * 4, i64::from(row) * 4);
    let cells = |first: i64, side: u32| (i64::from(side) - first).min(4);
    let (across, down) = (cells(first, map.width()), cells(top, map.height()));
    let of_texels = |beyond: i64| {
        let texels = (0..down + beyond).flat_map(|y| (0..across + beyond).map(move |x| (x, y)));
        texels.fold(Bounds::NONE, |bounds, (x, y)| {
            bounds.with(texel(map, first + x, top + y), [0.0; 2])
        })
    };
    match interpolation {
        Interpolation::None => of_texels(0),
        Interpolation::Linear => of_texels(1),
        Interpolation::CatmullRom => {
            let vertices = vertices(map, first, top);
            let parts = CATMULL_ROM_PARTS;
            let (across, down) = (across as usize * parts + 1, down as usize * parts + 1);
            let rows = vertices.iter().take(down);
            rows.flat_map(|row| row.iter().take(across))
                .fold(Bounds::NONE, |bounds, &vertex| {
                    bounds.with(vertex, [0.0; 2])
                })
        }
    }
}

/// The vertices of the 4 × 4 cells that begin at the middle of texel (`first`, `top`): bicubic, rows first.
fn vertices(map: &NormalMap, first: i64, top: i64) -> [[[f64; 2]; VERTICES]; VERTICES] {
    let mut rows = [[[0.0; 2]; VERTICES]; TEXELS];
    for (y, row) in rows.iter_mut().enumerate() {
        let texels: [[f64; 2]; TEXELS] =
            core::array::from_fn(|x| texel(map, first + x as i64 - 1, top + y as i64 - 1));
        for (vertex, value) in row.iter_mut().enumerate() {
            *value = between(vertex, |near| texels[near]);
        }
    }
    let mut vertices = [[[0.0; 2]; VERTICES]; VERTICES];
    for (y, row) in vertices.iter_mut().enumerate() {
        for (x, value) in row.iter_mut().enumerate() {
            *value = between(y, |near| rows[near][x]);
        }
    }
    vertices
}

/// The value at `vertex` of a row of those at texels, which begins one texel before the first vertex.
fn between(vertex: usize, value: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
    let last = vertex == VERTICES - 1;
    let cell = vertex / CATMULL_ROM_PARTS - usize::from(last);
    let weights = CATMULL_ROM[vertex - cell * CATMULL_ROM_PARTS];
    let mut sum = [0.0; 2];
    for (near, weight) in weights.iter().enumerate() {
        let [s, t] = value(cell + near);
        sum = [sum[0] + weight * s, sum[1] + weight * t];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_pass_through_texels_and_overshoot_steps() {
        let texels: Vec<[f32; 2]> = (0..64)
            .map(|i| {
                [
                    if i % 8 < 4 { -0.5 } else { 0.5 },
                    f32::from(i as u8) * 0.01,
                ]
            })
            .collect();
        let map = NormalMap::new(8, 8, Wrap::Clamp, texels);
        let found = vertices(&map, 2, 1);
        for (j, i) in (0..=SIDE).flat_map(|j| (0..=SIDE).map(move |i| (j, i))) {
            let exact = texel(&map, 2 + i as i64, 1 + j as i64);
            let got = found[j * CATMULL_ROM_PARTS][i * CATMULL_ROM_PARTS];
            assert!((0..2).all(|axis| (got[axis] - exact[axis]).abs() < 1e-15));
        }
        // Linear where texels are, and beyond a step by its sixteenth.
        assert!((found[6][9][1] - (0.01 * (8.0 * 2.5 + 4.25))).abs() < 1e-7);
        let box_of = bounds(&map, Interpolation::CatmullRom, 0, 0);
        assert!(box_of.high[0] >= 0.5 && box_of.low[0] < -0.55, "{box_of:?}");
        assert_eq!(bounds(&map, Interpolation::None, 0, 0).high[0], -0.5);
        assert_eq!(bounds(&map, Interpolation::Linear, 0, 0).high[0], 0.5);
    }
}
