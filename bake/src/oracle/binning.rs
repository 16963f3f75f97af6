//! The picture of a normal distribution function by counting samples: the reference of \[YHJ*14\] Fig. 9.
//!
//! A sample is a place drawn from the Gaussian footprint, the normal of the piecewise-linear surface there, and a
//! Gaussian of σr = α / √2 about it; beyond the rim it is no vector, and not counted. It shares with
//! [`analytic`](super::analytic) the vertices of the surface and the axes of the footprint, and nothing of the
//! integral.

use super::analytic::{FLOOR, footprint_axes};
use super::double_double::DoubleDouble;
use super::surface::Surface;
use super::texel_axis::TexelAxis;
use crate::normals::NormalMap;
use core::f64::consts::PI;
use core::sync::atomic::{AtomicU64, Ordering};
use glintbake_format::model::{Footprint, Interpolation};
use rayon::prelude::*;

/// Samples that are drawn one after another.
const CHUNK: u64 = 1 << 14;

/// A square picture of a part of the disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The point (s, t) at the middle.
    pub centre: [f64; 2],
    /// Half of the side, as a length on the disk.
    pub extent: f64,
    /// Columns and rows of pixels: s grows with columns, t falls with rows.
    pub side: usize,
}

impl Window {
    /// The window of `side` × `side` pixels over the whole disk.
    pub const fn disk(side: usize) -> Self {
        Self {
            centre: [0.0; 2],
            extent: 1.0,
            side,
        }
    }

    /// Side of a pixel, as a length on the disk.
    pub fn pitch(&self) -> f64 {
        2.0 * self.extent / self.side as f64
    }

    /// The point (s, t) at the middle of a pixel.
    pub fn middle(&self, column: usize, row: usize) -> [f64; 2] {
        let half = self.pitch() * 0.5;
        [
            self.centre[0] + half * (2.0 * column as f64 + 1.0 - self.side as f64),
            self.centre[1] - half * (2.0 * row as f64 + 1.0 - self.side as f64),
        ]
    }

    /// The pixel, row-major from the top, that (s, t) lies in.
    fn pixel(&self, [s, t]: [f64; 2]) -> Option<usize> {
        let side = self.side as f64;
        let scale = side / (2.0 * self.extent);
        let column = libm::floor((s - self.centre[0] + self.extent) * scale);
        let row = libm::floor((self.centre[1] + self.extent - t) * scale);
        let inside = |place: f64| (0.0..side).contains(&place);
        (inside(column) && inside(row)).then(|| row as usize * self.side + column as usize)
    }
}

/// What came of the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Binned {
    /// Where on the disk the pixels are.
    pub window: Window,
    /// Samples in each pixel, row-major from the top.
    pub counts: Vec<u64>,
    /// Samples drawn, those outside the window and beyond the rim included.
    pub samples: u64,
}

impl Binned {
    /// `samples` samples of the surface of `map` under the Gaussian `footprint`, for Beckmann roughness `alpha`.
    ///
    /// The same `seed` gives the same counts on any machine with any number of threads: each sample has its own
    /// numbers.
    ///
    /// # Cost
    /// About 0.2 µs a sample on one thread.
    ///
    /// # Panics
    /// If the window has no pixel, or as [`analytic::Prepared::new`](super::analytic::Prepared::new).
    pub fn new(
        map: &NormalMap,
        footprint: &Footprint,
        interpolation: Interpolation,
        alpha: f64,
        window: Window,
        samples: u64,
        seed: u64,
    ) -> Self {
        assert!(
            window.side > 0 && window.extent > 0.0,
            "a window must have pixels"
        );
        let axes = footprint_axes(map, footprint);
        let surface = Surface::new(map, interpolation);
        let deviation = libm::sqrt(0.5) * alpha;
        let counts: Vec<AtomicU64> = (0..window.side * window.side)
            .map(|_| AtomicU64::new(0))
            .collect();
        (0..samples.div_ceil(CHUNK))
            .into_par_iter()
            .for_each(|chunk| {
                for index in chunk * CHUNK..((chunk + 1) * CHUNK).min(samples) {
                    let mut numbers = Numbers::new(seed, index);
                    let place = place(&axes, [numbers.normal_pair(), numbers.normal_pair()]);
                    let [s, t] = surface.normal(place[0], place[1]);
                    let [by_s, by_t] = numbers.normal_pair();
                    let drawn = [s + deviation * by_s, t + deviation * by_t];
                    if drawn[0] * drawn[0] + drawn[1] * drawn[1] <= 1.0
                        && let Some(pixel) = window.pixel(drawn)
                    {
                        counts[pixel].fetch_add(1, Ordering::Relaxed);
                    }
                }
            });
        Self {
            window,
            counts: counts.into_iter().map(AtomicU64::into_inner).collect(),
            samples,
        }
    }

    /// Density of each pixel per area of the disk, row-major from the top: the average of D over it, but for the
    /// samples' noise.
    pub fn densities(&self) -> Vec<f64> {
        let pitch = self.window.pitch();
        let unit = 1.0 / (self.samples as f64 * pitch * pitch);
        self.counts
            .iter()
            .map(|&count| count as f64 * unit)
            .collect()
    }
}

/// A place under the footprint, in texels from the upper left corner of the map or of a copy of it, by numbers of mean 0 and
/// deviation 1: two for the footprint, two for its floor.
pub(super) fn place(axes: &[TexelAxis; 2], [along, floor]: [[f64; 2]; 2]) -> [f64; 2] {
    let [first, second] = along;
    [0, 1].map(|i: usize| {
        let axis = &axes[i];
        let [edge_1, edge_2] = axis.edges().map(DoubleDouble::value);
        let offset = 0.5 * (edge_1 * first + edge_2 * second) + libm::sqrt(FLOOR) * floor[i];
        // The map begins where its border 0 is.
        let from_start = DoubleDouble::from(offset) - axis.border(0);
        from_start.value()
    })
}

/// Random numbers of one sample: `SplitMix64` (Steele, Lea and Flood 2014) from a state that is itself a hash.
struct Numbers(u64);

impl Numbers {
    fn new(seed: u64, index: u64) -> Self {
        Self(mix(mix(seed ^ 0x6a09_e667_f3bc_c909).wrapping_add(index)))
    }

    /// Uniform in (0, 1].
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        ((mix(self.0) >> 11) + 1) as f64 / (1u64 << 53) as f64
    }

    /// Two independent numbers of mean 0 and deviation 1, by Box and Muller.
    fn normal_pair(&mut self) -> [f64; 2] {
        let radius = libm::sqrt(-2.0 * libm::log(self.unit()));
        let (sin, cos) = libm::sincos(2.0 * PI * self.unit());
        [radius * cos, radius * sin]
    }
}

/// The finaliser of `SplitMix64`.
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
