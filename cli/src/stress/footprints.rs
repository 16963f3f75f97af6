//! Footprints from a ten-thousandth of a texel to 64 tiles, thin, flat, gone, and far away.

use super::numbers::Numbers;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, Wrap};
use std::f64::consts::PI;

/// A footprint with a name.
#[derive(Clone, Debug)]
pub struct NamedFootprint {
    /// What the results call it.
    pub name: &'static str,
    /// The footprint.
    pub footprint: Footprint,
}

/// The name of the footprint that lies within one texel.
pub const POINT: &str = "1e-4 texel";
/// The name of the footprint that draws are counted under.
pub const COUNTED: &str = "3 texels";

/// Every extreme footprint on `map`.
pub fn extreme(map: &NormalMap, numbers: &mut Numbers) -> Vec<NamedFootprint> {
    let mut footprints = Vec::new();
    for (name, texels) in [
        (POINT, 1e-4),
        ("0.1 texel", 0.1),
        ("1 texel", 1.0),
        (COUNTED, 3.0),
    ] {
        footprints.push(NamedFootprint {
            name,
            footprint: turned(map, numbers, [texels, 0.8 * texels]),
        });
    }
    for (name, tiles) in [("1 tile", 1.0), ("7.3 tiles", 7.3), ("64 tiles", 64.0)] {
        let (sine, cosine) = libm::sincos(numbers.between(0.0, PI));
        footprints.push(NamedFootprint {
            name,
            footprint: Footprint {
                centre: [numbers.uniform(), numbers.uniform()],
                edge_1: [tiles * cosine, tiles * sine],
                edge_2: [-0.8 * tiles * sine, 0.8 * tiles * cosine],
            },
        });
    }
    for (name, anisotropy) in [
        ("anisotropy 8", 8.0),
        ("anisotropy 1e3", 1e3),
        ("anisotropy 1e6", 1e6),
    ] {
        footprints.push(NamedFootprint {
            name,
            footprint: turned(map, numbers, [20.0, 20.0 / anisotropy]),
        });
    }
    let plain = |name, centre, edge_1, edge_2| NamedFootprint {
        name,
        footprint: Footprint {
            centre,
            edge_1,
            edge_2,
        },
    };
    footprints.extend([
        plain("no area", [0.37, 0.61], [0.0; 2], [0.0; 2]),
        plain("no second edge", [0.9, 0.2], [0.4, -0.3], [0.0; 2]),
        plain("parallel edges", [0.123, 0.456], [0.3, 0.2], [0.15, 0.1]),
    ]);
    let mut far = turned(map, numbers, [5.0, 4.0]);
    far.centre = far.centre.map(|x| x + 1e6);
    footprints.push(NamedFootprint {
        name: "1e6 tiles away",
        footprint: far,
    });
    footprints
}

/// A footprint of `edges` texels at a random place and angle.
fn turned(map: &NormalMap, numbers: &mut Numbers, edges: [f64; 2]) -> Footprint {
    let size = [f64::from(map.width()), f64::from(map.height())];
    let (sine, cosine) = libm::sincos(numbers.between(0.0, PI));
    Footprint {
        centre: [numbers.between(-2.0, 3.0), numbers.between(-2.0, 3.0)],
        edge_1: [edges[0] * cosine / size[0], edges[0] * sine / size[1]],
        edge_2: [-edges[1] * sine / size[0], edges[1] * cosine / size[1]],
    }
}

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
        Wrap::Repeat => visited,
        // Beyond its border, a clamped map is visited a row or a column at a time.
        Wrap::Clamp => visited.min(4.0 * (size[0] + 2.0) * (size[1] + 2.0) + 18.0 * outline),
    }
}
