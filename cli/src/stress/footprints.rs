//! Footprints from a ten-thousandth of a texel to 64 tiles, thin, flat, gone, and far away.

use super::numbers::Numbers;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::Footprint;
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

/// The names of the footprints that are also asked in f32.
pub const IN_SINGLE_PRECISION: [&str; 5] = [
    "0.1 texel",
    COUNTED,
    "1 tile",
    "anisotropy 1e3",
    "1e6 tiles away",
];

/// Sizes of the footprint that grows, the texels under the largest, and the least side of a map on which it does.
const SIZES: u32 = 48;
const LARGEST: f64 = 40_000.0;
const LEAST_SIDE: u32 = 64;

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

/// A square footprint that grows from 2 texels to more than the map; none on small maps, on which no look-up and no level
/// changes.
pub fn growing(map: &NormalMap, numbers: &mut Numbers) -> Vec<NamedFootprint> {
    if map.width().min(map.height()) < LEAST_SIDE {
        return Vec::new();
    }
    let centre = [numbers.uniform(), numbers.uniform()];
    let growth = libm::pow(0.5 * LARGEST.sqrt(), 1.0 / f64::from(SIZES));
    (0..SIZES)
        .map(|size| NamedFootprint {
            name: "growing",
            footprint: Footprint::square(
                centre,
                2.0 * libm::pow(growth, f64::from(size)),
                map.width(),
                map.height(),
            ),
        })
        .collect()
}

/// `named` with every coordinate rounded to f32.
pub fn rounded(named: &NamedFootprint) -> NamedFootprint {
    let round = |pair: [f64; 2]| pair.map(|x| f64::from(x as f32));
    let footprint = &named.footprint;
    NamedFootprint {
        name: named.name,
        footprint: Footprint {
            centre: round(footprint.centre),
            edge_1: round(footprint.edge_1),
            edge_2: round(footprint.edge_2),
        },
    }
}
