//! Naive point sampling: what a renderer does that has no filter for normals.

use crate::measure::stream::Stream;
use crate::measure::subject::standard_normal;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, HalfVector, Kernel, Wrap};
use std::f64::consts::{PI, SQRT_2, TAU};

/// Point samples of a map, so many a query.
#[derive(Clone, Copy, Debug)]
pub struct PointSampling<'m> {
    /// The map.
    pub map: &'m NormalMap,
    /// Points a query.
    pub points: u32,
}

impl PointSampling<'_> {
    /// The average of the kernel at `half_vector` over points drawn from `footprint`; the same for the same query.
    pub fn eval(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        filter: Filter,
        kernel: Kernel,
        roughness: f64,
    ) -> f64 {
        if !half_vector.is_on_disk() {
            return 0.0;
        }
        let direction = half_vector.direction();
        let seed = [footprint.centre[0], footprint.centre[1], half_vector.s]
            .map(f64::to_bits)
            .into_iter()
            .fold(0_u64, |seed, bits| seed.rotate_left(21) ^ bits);
        let mut stream = Stream::new(seed);
        let mut sum = 0.0;
        for _ in 0..self.points {
            let [a, b] = match filter {
                Filter::Box => [stream.uniform() - 0.5, stream.uniform() - 0.5],
                Filter::Gaussian => standard_normal(stream.uniforms()).map(|x| 0.5 * x),
            };
            let normal = self.normal_at([0, 1].map(|axis: usize| {
                footprint.centre[axis] + a * footprint.edge_1[axis] + b * footprint.edge_2[axis]
            }));
            sum += density(direction, normal, kernel, roughness);
        }
        sum / f64::from(self.points)
    }

    /// The point of the disk of the texel at (u, v).
    fn normal_at(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let place = |x: f64, size: u32| {
            let x = match self.map.wrap() {
                Wrap::Repeat => x - x.floor(),
                Wrap::Clamp => x.max(0.0),
            };
            ((x * f64::from(size)) as u32).min(size - 1) as usize
        };
        let index =
            place(v, self.map.height()) * self.map.width() as usize + place(u, self.map.width());
        self.map.texels()[index].map(f64::from)
    }
}

/// The kernel of one texel, as cheap as a renderer would write it.
fn density(half: [f64; 3], [s, t]: [f64; 2], kernel: Kernel, roughness: f64) -> f64 {
    if kernel == Kernel::Disk {
        let deviation = roughness / SQRT_2;
        let square = (half[0] - s).powi(2) + (half[1] - t).powi(2);
        let variance = deviation * deviation;
        return (-0.5 * square / variance).exp() / (TAU * variance);
    }
    let z = (1.0 - s * s - t * t).max(0.0).sqrt();
    let chord = (half[0] - s).powi(2) + (half[1] - t).powi(2) + (half[2] - z).powi(2);
    let cosine = 1.0 - 0.5 * chord;
    if cosine <= 0.0 {
        return 0.0;
    }
    let tangent = chord * (1.0 - 0.25 * chord) / (cosine * cosine);
    (-tangent / (roughness * roughness)).exp() / (PI * roughness * roughness * cosine.powi(4))
}
