//! Layered materials: against the oracle, and everything a renderer relies on.

mod energy;
mod formulas;
mod golden;
mod opacity;
mod sampling;

use crate::masking::direction;
use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_format::Container;
use glintbake_format::model::{Method, Wrap};
use glintbake_runtime::Material;
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, sample_map};
use glintbake_tests::materials::Layer;

/// The material in `bytes`.
fn open(bytes: &[u8]) -> Material<'_> {
    Material::open(&Container::open(bytes).unwrap()).unwrap()
}

/// Flakes of `map` with a roughness, with exact normals beside the bins.
fn exact_flakes(alpha: f64, masking: bool) -> MethodRecipe {
    MethodRecipe {
        exact_normals: true,
        masking,
        ..MethodRecipe::new(Method::FlakeBins, &[alpha])
    }
}

/// A pair of directions above the horizon.
fn directions(stream: &mut Stream, least: f64) -> [[f64; 3]; 2] {
    [0, 1].map(|_| direction(stream.between(least, 1.0), stream.uniform()))
}

fn flakes() -> NormalMap {
    sample_map(Kind::Flakes, 32, 24, 5, Wrap::Repeat)
}

/// Opaque and clear texels of a 16 × 8 map, in patches.
fn patches() -> Vec<u8> {
    (0..16 * 8)
        .map(|texel| {
            let (x, y) = (texel % 16, texel / 16);
            if (x / 3 + y / 2) % 2 == 0 { 255 } else { 40 }
        })
        .collect()
}

/// Car paint: coat, flakes with gaps, paint.
fn car_paint(alpha: f64, coat: f64) -> Vec<Layer> {
    let glints = Layer::glints(&flakes(), exact_flakes(alpha, true), [0.91, 0.92, 0.93]);
    vec![
        Layer::coat(1.5, coat),
        glints.covering(16, 8, patches(), Wrap::Repeat),
        Layer::base([0.04; 3], [0.02, 0.1, 0.6], 0.3),
    ]
}
