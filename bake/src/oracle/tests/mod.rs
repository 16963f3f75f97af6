//! Checks of the oracle against hand-made cases, quadrature, brute force and identities.

mod analytic;
mod bells;
mod binning;
mod disk;
mod double_double;
mod draws;
mod flake_bins;
mod gaussian;
mod kernel;
mod lean;
mod limits;
mod lobes;
mod ndf_maps;
mod one_lobe;
mod specular_bins;
mod sweep;
mod weights;
mod wrap;

use super::{TexelWeight, box_weights};
use crate::normals::NormalMap;
use glintbake_format::model::{Footprint, Wrap};
use std::collections::BTreeMap;

/// Uniform numbers for tests: `SplitMix64` (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [from, to).
    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// A vector of `length` in a uniform direction.
    fn vector(&mut self, length: f64) -> [f64; 2] {
        let angle = self.between(0.0, core::f64::consts::TAU);
        [length * libm::cos(angle), length * libm::sin(angle)]
    }
}

/// A map whose normals do not matter.
fn flat_map(width: u32, height: u32, wrap: Wrap) -> NormalMap {
    let count = width as usize * height as usize;
    NormalMap::new(width, height, wrap, vec![[0.0, 0.0]; count])
}

/// A map with a different normal in every texel.
fn varied_map(width: u32, height: u32, wrap: Wrap) -> NormalMap {
    let mut random = Random(u64::from(width) << 32 | u64::from(height));
    let texels = (0..width * height)
        .map(|_| {
            let length = 0.6 * libm::sqrt(random.unit());
            random.vector(length).map(|x| x as f32)
        })
        .collect();
    NormalMap::new(width, height, wrap, texels)
}

/// A footprint given in texels of `map`.
fn in_texels(map: &NormalMap, centre: [f64; 2], edge_1: [f64; 2], edge_2: [f64; 2]) -> Footprint {
    let tiles = |[u, v]: [f64; 2]| [u / f64::from(map.width()), v / f64::from(map.height())];
    Footprint {
        centre: tiles(centre),
        edge_1: tiles(edge_1),
        edge_2: tiles(edge_2),
    }
}

/// Weights by (column, row).
fn by_texel(weights: &[TexelWeight]) -> BTreeMap<(u32, u32), f64> {
    weights
        .iter()
        .map(|texel| ((texel.column, texel.row), texel.weight))
        .collect()
}

/// The weights of a box footprint, after checking what every answer must satisfy.
fn checked_weights(map: &NormalMap, footprint: &Footprint) -> BTreeMap<(u32, u32), f64> {
    check_weights(map, footprint, &box_weights(map, footprint))
}

/// `weights` of `footprint` by texel, after checking what every answer must satisfy.
fn check_weights(
    map: &NormalMap,
    footprint: &Footprint,
    weights: &[TexelWeight],
) -> BTreeMap<(u32, u32), f64> {
    let sum: f64 = weights.iter().map(|texel| texel.weight).sum();
    assert!(
        (sum - 1.0).abs() < 1e-13 * (1.0 + libm::sqrt(weights.len() as f64)),
        "weights of {footprint:?} sum to {sum}"
    );
    for texel in weights {
        assert!(
            texel.weight > 0.0 && texel.weight <= 1.0 + 1e-15,
            "{texel:?} of {footprint:?}"
        );
        assert!(
            texel.column < map.width() && texel.row < map.height(),
            "{texel:?} is off the map"
        );
    }
    assert!(
        weights.is_sorted_by(|a, b| (a.row, a.column) < (b.row, b.column)),
        "texels must be row-major, each once"
    );
    by_texel(weights)
}

/// The largest difference of two sets of weights.
fn difference(a: &BTreeMap<(u32, u32), f64>, b: &BTreeMap<(u32, u32), f64>) -> f64 {
    let weight = |set: &BTreeMap<(u32, u32), f64>, texel| set.get(texel).copied().unwrap_or(0.0);
    a.keys()
        .chain(b.keys())
        .map(|texel| (weight(a, texel) - weight(b, texel)).abs())
        .fold(0.0, f64::max)
}
