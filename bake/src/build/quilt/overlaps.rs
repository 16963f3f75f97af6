//! How much any two blocks differ where they would meet.

use super::texels::{FEATURES, Texels};
use glintbake_format::model::QuiltLayout;
use rayon::prelude::*;

/// Numbers summed side by side, in an order of their own that no compiler or processor changes.
const LANES: usize = 16;

/// Mean differences over shared texels, of all pairs of origins.
pub(super) struct Overlaps {
    count: usize,
    beside: Vec<f32>,
    below: Vec<f32>,
}

impl Overlaps {
    pub fn new(texels: &Texels, layout: &QuiltLayout, origins: &[[u32; 2]]) -> Self {
        let (patch, overlap) = (layout.patch(), u32::from(layout.overlap));
        let block = patch + overlap;
        let strips = |first: [u32; 2], size: [u32; 2]| -> Vec<Vec<f32>> {
            origins
                .par_iter()
                .map(|&origin| strip(texels, origin, first, size))
                .collect()
        };
        let (upright, lying) = ([overlap, block], [block, overlap]);
        let table = |size: [u32; 2], end: [u32; 2]| {
            let ends = strips(end, size);
            let starts = strips([0, 0], size);
            let shared = f64::from((size[0] * size[1]).max(1));
            ends.par_iter()
                .flat_map_iter(|end| {
                    starts
                        .iter()
                        .map(move |start| (squared(end, start) / shared) as f32)
                })
                .collect()
        };
        Self {
            count: origins.len(),
            beside: table(upright, [patch, 0]),
            below: table(lying, [0, patch]),
        }
    }

    /// Mean difference of texels that the block at origin `right` shares with the one at `left`, to its left.
    pub fn beside(&self, left: usize, right: usize) -> f32 {
        self.beside[left * self.count + right]
    }

    /// The same of a block below another.
    pub fn below(&self, above: usize, below: usize) -> f32 {
        self.below[above * self.count + below]
    }
}

/// The features of `size` texels from `first` in the block at `origin`, filled up to whole vectors.
fn strip(texels: &Texels, origin: [u32; 2], first: [u32; 2], size: [u32; 2]) -> Vec<f32> {
    let mut strip = Vec::with_capacity((size[0] * size[1]) as usize * FEATURES + LANES);
    for y in 0..size[1] {
        for x in 0..size[0] {
            strip.extend(texels.at(origin, [first[0] + x, first[1] + y]));
        }
    }
    strip.resize(strip.len().next_multiple_of(LANES), 0.0);
    strip
}

/// The sum of squared differences.
fn squared(a: &[f32], b: &[f32]) -> f64 {
    let mut sums = [0.0_f32; LANES];
    let (a, b) = (a.as_chunks::<LANES>().0, b.as_chunks::<LANES>().0);
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            let d = a[lane] - b[lane];
            sums[lane] += d * d;
        }
    }
    sums.iter().map(|&sum| f64::from(sum)).sum()
}
