//! What is compared where blocks meet: normals and slopes of the sample's texels.

use crate::build::numbers::Numbers;
use crate::build::surface::texel;
use crate::normals::NormalMap;

/// Numbers of a texel: the unit normal, and the change of (s, t) per texel along both axes; one more, 0, fills vectors.
pub(super) const FEATURES: usize = 8;

/// Pairs of texels that the mean difference is taken over.
const PAIRS: usize = 4096;

/// The texels of a sample, such that the difference of two, `α |Δn|² + (1 - α) |ΔJ|²` (\[TZX22\] eq. 7), is a sum of squares.
pub(super) struct Texels {
    pub size: [u32; 2],
    features: Vec<[f32; FEATURES]>,
}

impl Texels {
    pub fn new(sample: &NormalMap, alpha: f64) -> Self {
        let (of_normal, of_slope) = (alpha.sqrt(), (1.0 - alpha).sqrt());
        let (width, height) = (sample.width(), sample.height());
        let places =
            (0..height).flat_map(|y| (0..width).map(move |x| [i64::from(x), i64::from(y)]));
        let features = places
            .map(|[x, y]| {
                let [s, t] = texel(sample, x, y);
                let z = (1.0 - s * s - t * t).max(0.0).sqrt();
                let half = |after: [f64; 2], before: [f64; 2]| {
                    [0.5 * (after[0] - before[0]), 0.5 * (after[1] - before[1])]
                };
                let along = half(texel(sample, x + 1, y), texel(sample, x - 1, y));
                let down = half(texel(sample, x, y + 1), texel(sample, x, y - 1));
                let [n, j] = [of_normal, of_slope];
                [
                    n * s,
                    n * t,
                    n * z,
                    j * along[0],
                    j * along[1],
                    j * down[0],
                    j * down[1],
                    0.0,
                ]
                .map(|x| x as f32)
            })
            .collect();
        Self {
            size: [width, height],
            features,
        }
    }

    /// The texel `at` off `origin`, across the border.
    pub fn at(&self, origin: [u32; 2], at: [u32; 2]) -> &[f32; FEATURES] {
        let [x, y] = [0, 1].map(|axis: usize| (origin[axis] + at[axis]) % self.size[axis]);
        &self.features[y as usize * self.size[0] as usize + x as usize]
    }

    /// The mean difference of two texels anywhere, over seeded pairs.
    pub fn mean_difference(&self, seed: u64) -> f64 {
        let mut numbers = Numbers::new(!seed);
        let mut draw = || &self.features[numbers.below(self.features.len())];
        let sum: f64 = (0..PAIRS).map(|_| difference(draw(), draw())).sum();
        sum / PAIRS as f64
    }
}

/// The difference of two texels.
pub(super) fn difference(a: &[f32; FEATURES], b: &[f32; FEATURES]) -> f64 {
    let squares = a
        .iter()
        .zip(b)
        .map(|(a, b)| f64::from(a - b) * f64::from(a - b));
    squares.sum()
}
