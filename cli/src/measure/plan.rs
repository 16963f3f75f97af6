//! What a report asks: cells of footprint size, shape and filter, and how much of each.

use super::stream::Stream;
use crate::report::document::HalfVectors;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, Method};
use std::f64::consts::TAU;

/// Long edge over short edge of the footprints.
pub const ANISOTROPIES: [f64; 2] = [1.0, 8.0];
/// Smallest size σ in texels.
const LEAST_SIGMA: f64 = 0.25;
/// Each size is so many times the one before.
const GROWTH: f64 = 4.0;

/// How much is asked, and how long it is timed.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Queries of a cell and kind of half vectors, about.
    pub queries: usize,
    /// Footprints of a cell at most.
    pub footprints: usize,
    /// Texels that the oracles may weigh for a cell, which makes large footprints few; four there are always.
    pub texels: f64,
    /// Texels that an exact sum may visit for the queries of a cell, which makes those of large footprints few; four of
    /// each footprint there are always, if `queries` allows.
    pub visits: f64,
    /// Seconds of a timing.
    pub seconds: f64,
    /// Repetitions of a timing.
    pub repetitions: usize,
    /// Bakes that the fastest is taken of.
    pub bakes: usize,
}

impl Effort {
    /// For a first look.
    pub const QUICK: Self = Self {
        queries: 64,
        footprints: 32,
        texels: 3e5,
        visits: 1.5e7,
        seconds: 0.002,
        repetitions: 5,
        bakes: 1,
    };
    /// For figures that are kept.
    pub const FULL: Self = Self {
        queries: 256,
        footprints: 64,
        texels: 2e6,
        visits: 1e7,
        seconds: 0.008,
        repetitions: 11,
        bakes: 3,
    };

    /// Footprints of a cell, and half vectors of each kind under each, for footprints of `texels` texels.
    pub fn counts(&self, texels: f64) -> (usize, usize) {
        let affordable = (self.texels / texels) as usize;
        let footprints = affordable.clamp(4, self.footprints.max(4));
        let most = self.queries.div_ceil(footprints);
        let visited = (self.visits / (texels * footprints as f64)) as usize;
        (footprints, visited.clamp(most.min(4), most))
    }
}

/// What a report asks of every map.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Methods.
    pub methods: Vec<Method>,
    /// Beckmann roughnesses.
    pub roughness: Vec<f64>,
    /// Filters.
    pub filters: Vec<Filter>,
    /// Sizes σ; those of [`sigmas`] if empty.
    pub sigmas: Vec<f64>,
    /// Seed of footprints and half vectors.
    pub seed: u64,
    /// How much of it.
    pub effort: Effort,
}

/// Sizes σ in texels for `map`: from a quarter, each four times the last, to the whole map, whose edge is 2σ.
pub fn sigmas(map: &NormalMap) -> Vec<f64> {
    let whole = 0.5 * f64::from(map.width().max(map.height()));
    let mut sigmas: Vec<_> = std::iter::successors(Some(LEAST_SIGMA), |sigma| Some(sigma * GROWTH))
        .take_while(|&sigma| sigma < whole)
        .collect();
    sigmas.push(whole);
    sigmas
}

/// Size and shape of footprints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Filter.
    pub filter: Filter,
    /// Size σ in texels.
    pub sigma: f64,
    /// Long edge over short edge.
    pub anisotropy: f64,
}

impl Shape {
    /// Texels that count under such a footprint: its area, or that of the ellipse at which Gaussians end.
    pub fn texels(&self) -> f64 {
        let deviations = match self.filter {
            // Edges of 2 σ.
            Filter::Box => 4.0,
            Filter::Gaussian => TAU / 2.0 * 4.8 * 4.8,
        };
        // A footprint lies on a texel at least, and on parts of its neighbours.
        deviations * self.sigma * self.sigma + 4.0
    }

    /// A footprint of this shape on `map` anywhere, turned by any angle.
    pub fn footprint(&self, map: &NormalMap, stream: &mut Stream) -> Footprint {
        let [u, v, turn] = stream.uniforms();
        self.placed([u, v], TAU * turn, map)
    }

    /// `count` footprints of this shape in a row, each an edge beside the last, as pixels ask.
    pub fn row(&self, count: usize, map: &NormalMap, stream: &mut Stream) -> Vec<Footprint> {
        let [u, v, turn] = stream.uniforms();
        let first = self.placed([u, v], TAU * turn, map);
        (0..count)
            .map(|step| Footprint {
                centre: [0, 1]
                    .map(|axis: usize| first.centre[axis] + step as f64 * first.edge_1[axis]),
                ..first
            })
            .collect()
    }

    fn placed(&self, centre: [f64; 2], angle: f64, map: &NormalMap) -> Footprint {
        let size = [f64::from(map.width()), f64::from(map.height())];
        let root = self.anisotropy.sqrt();
        let (long, short) = (2.0 * self.sigma * root, 2.0 * self.sigma / root);
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        Footprint {
            centre,
            edge_1: [long * cosine / size[0], long * sine / size[1]],
            edge_2: [-short * sine / size[0], short * cosine / size[1]],
        }
    }
}

/// Both kinds of half vectors, in the order in which they are asked.
pub const KINDS: [HalfVectors; 2] = [HalfVectors::Found, HalfVectors::Uniform];

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::model::Wrap;

    #[test]
    fn sizes_run_from_a_quarter_of_a_texel_to_the_map() {
        let map = |width, height| {
            let texels = vec![[0.0; 2]; width as usize * height as usize];
            NormalMap::new(width, height, Wrap::Repeat, texels)
        };
        assert_eq!(sigmas(&map(32, 8)), [0.25, 1.0, 4.0, 16.0]);
        assert_eq!(sigmas(&map(40, 8)), [0.25, 1.0, 4.0, 16.0, 20.0]);
        assert_eq!(sigmas(&map(1, 1)), [0.25, 0.5]);
    }

    #[test]
    fn footprints_have_the_area_of_their_size_whatever_the_shape() {
        let map = NormalMap::new(8, 4, Wrap::Repeat, vec![[0.0; 2]; 32]);
        for anisotropy in ANISOTROPIES {
            let shape = Shape {
                filter: Filter::Box,
                sigma: 3.0,
                anisotropy,
            };
            let footprint = shape.footprint(&map, &mut Stream::new(5));
            let [a, b] = [footprint.edge_1, footprint.edge_2].map(|[u, v]| [u * 8.0, v * 4.0]);
            assert!((a[0] * b[1] - a[1] * b[0] - 36.0).abs() < 1e-9);
            assert!((a[0].hypot(a[1]) / b[0].hypot(b[1]) - anisotropy).abs() < 1e-9);
        }
    }

    #[test]
    fn large_footprints_are_few_and_have_more_half_vectors() {
        assert_eq!(Effort::QUICK.counts(4.0), (32, 2));
        assert_eq!(Effort::QUICK.counts(2e5), (4, 16));
        assert_eq!(Effort::QUICK.counts(1e9), (4, 4));
    }
}
