//! Gaussian weights against integrals by other means, and what bins will be built on: rows, bounds, samples.

extern crate std;

mod limits;
mod reference;
mod shape;
mod weights;

use super::GaussianFootprint;
use glintbake_format::model::{Footprint, Wrap};

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

    /// A whole number in [from, to).
    fn whole(&mut self, from: i64, to: i64) -> i64 {
        from + (self.unit() * (to - from) as f64) as i64
    }
}

/// Side of the map that the footprints of these tests lie on.
const SIDE: f64 = 1024.0;

/// The Gaussian at `centre` with the standard deviations `long` and `short`, `long` at `angle` to the columns; all in
/// texels.
fn gaussian(centre: [f64; 2], long: f64, short: f64, angle: f64) -> GaussianFootprint {
    let (sine, cosine) = libm::sincos(angle);
    from_edges(
        centre,
        [2.0 * long * cosine, 2.0 * long * sine],
        [-2.0 * short * sine, 2.0 * short * cosine],
    )
}

/// The Gaussian of these edges, in texels.
fn from_edges(centre: [f64; 2], edge_1: [f64; 2], edge_2: [f64; 2]) -> GaussianFootprint {
    let tiles = |texels: [f64; 2]| texels.map(|texel| texel / SIDE);
    let footprint = Footprint {
        centre: tiles(centre),
        edge_1: tiles(edge_1),
        edge_2: tiles(edge_2),
    };
    GaussianFootprint::new(&footprint, SIDE as u32, SIDE as u32, Wrap::Repeat)
        .expect("finite and not too large")
}
