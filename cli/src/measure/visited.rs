//! What the oracles have to do under a footprint.

use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, Wrap};
use std::f64::consts::PI;

/// About how many texels the oracle visits under `footprint`, copies counted.
pub fn texels_visited(map: &NormalMap, footprint: &Footprint, filter: Filter) -> f64 {
    let size = [f64::from(map.width()), f64::from(map.height())];
    let edges =
        [footprint.edge_1, footprint.edge_2].map(|edge| [edge[0] * size[0], edge[1] * size[1]]);
    let area = (edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]).abs();
    let outline: f64 = edges.iter().flatten().map(|x| x.abs()).sum();
    let visited = match filter {
        Filter::Box => area + 2.0 * outline,
        // An ellipse of nine standard deviations, which are half an edge.
        Filter::Gaussian => 81.0 * PI * 0.25 * area + 18.0 * outline,
    };
    match map.wrap() {
        // A Gaussian of a few tiles weighs all texels alike.
        Wrap::Repeat if filter == Filter::Gaussian && deviation_in_tiles(footprint) >= 1.5 => {
            size[0] * size[1]
        }
        Wrap::Repeat => visited,
        // Beyond its border, a clamped map is visited a row or a column at a time.
        Wrap::Clamp => visited.min(4.0 * (size[0] + 2.0) * (size[1] + 2.0) + 18.0 * outline),
    }
}

/// The least standard deviation of `footprint` as a Gaussian in tiles, or a little less.
fn deviation_in_tiles(footprint: &Footprint) -> f64 {
    let Footprint { edge_1, edge_2, .. } = footprint;
    let squares: f64 = [edge_1, edge_2].into_iter().flatten().map(|x| x * x).sum();
    if squares == 0.0 {
        return 0.0;
    }
    0.5 * (edge_1[0] * edge_2[1] - edge_1[1] * edge_2[0]).abs() / squares.sqrt()
}
