//! Queries that light meets, for benchmarks.

use core::f64::consts::TAU;
use glintbake_bake::normals::NormalMap;
use glintbake_cli::measure::plan::Shape;
use glintbake_cli::measure::stream::Stream;
use glintbake_format::model::{Footprint, HalfVector};

/// A footprint and a half vector.
pub type Query = (Footprint, HalfVector);

/// A footprint of `shape`, and the normal of a texel under it, moved by a kernel of deviation `roughness`.
pub fn lit_query(map: &NormalMap, shape: Shape, roughness: f64, stream: &mut Stream) -> Query {
    let footprint = shape.footprint(map, stream);
    loop {
        let [x, y] = gaussians(stream).map(|x| 0.5 * x);
        let index = |axis: usize, size: u32| {
            let place =
                footprint.centre[axis] + x * footprint.edge_1[axis] + y * footprint.edge_2[axis];
            ((place - place.floor()) * f64::from(size)) as usize % size as usize
        };
        let texel = index(1, map.height()) * map.width() as usize + index(0, map.width());
        let [s, t] = map.texels()[texel].map(f64::from);
        let [x, y] = gaussians(stream).map(|x| roughness * x);
        let h = HalfVector { s: s + x, t: t + y };
        if h.is_on_disk() {
            return (footprint, h);
        }
    }
}

fn gaussians(stream: &mut Stream) -> [f64; 2] {
    let [u, v]: [f64; 2] = stream.uniforms();
    let (radius, angle) = ((-2.0 * (1.0 - u).ln()).sqrt(), TAU * v);
    [radius * angle.cos(), radius * angle.sin()]
}
