//! A Gaussian: texels weigh as much of it as they hold.
#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use super::{Origin, Region};
use crate::ndf::cluster_tree::lanes::{
    LANES, LEAST_TERM, Lanes, Place, Spread, Texels, exponential, get, inverse_root, max,
};
use crate::overlap::GaussianFootprint;

/// A Gaussian.
#[derive(Clone, Copy, Debug)]
pub(in crate::ndf::cluster_tree) struct GaussianRegion<'a> {
    footprint: &'a GaussianFootprint,
    /// `|L x|²` is the squared distance from the centre in standard deviations: rows of L, of the Gaussian and a texel convolved.
    root: [[f32; 2]; 2],
    /// Variances of the Gaussian and a texel convolved.
    variances: [f32; 2],
    /// Root of the determinant of their covariance.
    area: f32,
    /// Whether the convolution is a texel's weight; else that is integrated.
    is_smooth: bool,
    /// How far the exponent may range over a cluster that is taken as a whole.
    tolerance: f32,
    unit: f64,
}

impl<'a> GaussianRegion<'a> {
    pub fn new(footprint: &'a GaussianFootprint, tolerance: f64) -> Self {
        let [xx, yy, xy] = footprint.covariance();
        // Of a texel, 1/12 in either direction.
        let texel = 1.0 / 12.0;
        let determinant = footprint.determinant_root() * footprint.determinant_root()
            + texel * (xx + yy)
            + texel * texel;
        let (xx, yy) = (xx + texel, yy + texel);
        let deviation = libm::sqrt(xx);
        let root = libm::sqrt(determinant);
        let is_smooth = footprint.is_smooth();
        Self {
            footprint,
            root: [
                [(1.0 / deviation) as f32, 0.0],
                [(-xy / (deviation * root)) as f32, (deviation / root) as f32],
            ],
            variances: [xx as f32, yy as f32],
            area: root as f32,
            is_smooth,
            tolerance: tolerance as f32,
            // A texel at the peak.
            unit: if is_smooth {
                1.0 / (core::f64::consts::TAU * root)
            } else {
                1.0
            },
        }
    }

    /// Least and greatest exponents over a box.
    #[inline(always)]
    fn range(&self, place: Place) -> (f32, f32) {
        let Place {
            x,
            y,
            half_x,
            half_y,
        } = place;
        let [[a, _], [b, c]] = self.root;
        let (u, v) = ((a * x).abs(), (b * x + c * y).abs());
        let (reach_u, reach_v) = (a * half_x, b.abs() * half_x + c * half_y);
        let (low_u, low_v) = (max(u - reach_u, 0.0), max(v - reach_v, 0.0));
        let (high_u, high_v) = (u + reach_u, v + reach_v);
        (
            0.5 * (low_u * low_u + low_v * low_v),
            0.5 * (high_u * high_u + high_v * high_v),
        )
    }

    /// The least exponent over a box of texels, for tiles.
    pub fn least(&self, middle: [f64; 2], half: [f64; 2]) -> f32 {
        let (least, _) = self.range(Place {
            x: middle[0] as f32,
            y: middle[1] as f32,
            half_x: half[0] as f32,
            half_y: half[1] as f32,
        });
        least
    }
}

impl Region for GaussianRegion<'_> {
    const HAS_TAIL: bool = true;

    fn weight_error(&self, place: Place, weight: f32) -> f32 {
        let (least, most) = self.range(place);
        let (high, low) = (exponential(-least), exponential(-most));
        // Weights range from `low` to `high`, and so does their mean; term and weight may go together. The box of a node that lies
        // may run backwards.
        (high - low).abs() + max((weight - low).abs(), (high - weight).abs())
    }

    #[inline(always)]
    fn relation(&self, place: Place, exponent: f32, limit: f32) -> [f32; 2] {
        let (least, _) = self.range(place);
        [least + exponent - limit, 1.0]
    }

    #[inline(always)]
    fn cluster_weight(&self, place: Place, spread: Spread, exponent: f32) -> [f32; 2] {
        let (least, most) = self.range(place);
        // What is small matters less.
        let excess = most - least - self.tolerance * (1.0 + 0.5 * (exponent + least));
        let (x, y) = (place.x + spread.mean[0], place.y + spread.mean[1]);
        // The cluster's places as a Gaussian that is as much longer than wide as its box.
        let variance = 8.0 * spread.variance;
        let [xx, yy] = self.variances;
        let (a, b) = (
            variance * place.half_x * place.half_x,
            variance * place.half_y * place.half_y,
        );
        // Of sums alone: of a long Gaussian a difference of products would leave nothing.
        let area = self.area * self.area;
        let determinant = area + a * yy + b * xx + a * b;
        let root = inverse_root(determinant);
        let [[l, _], [m, n]] = self.root;
        let (u, v) = (l * x, m * x + n * y);
        let square = (area * (u * u + v * v) + b * x * x + a * y * y) * root * root;
        let weight = self.area * root * exponential(-0.5 * square);
        [
            weight,
            if self.is_smooth {
                excess
            } else {
                f32::INFINITY
            },
        ]
    }

    #[inline(always)]
    fn most_blurred(&self) -> f32 {
        if self.is_smooth { f32::INFINITY } else { 0.0 }
    }

    #[inline(always)]
    fn weights(
        &self,
        texels: &Texels,
        origin: &Origin,
        first: [u8; 2],
        count: u32,
        weights: &mut Lanes,
    ) {
        if self.is_smooth {
            let [[a, _], [b, c]] = self.root;
            let (low_x, low_y) = (
                origin.offset[0] + f32::from(first[0]) + 0.5,
                origin.offset[1] + f32::from(first[1]) + 0.5,
            );
            for lane in 0..LANES {
                let (x, y) = (low_x + texels.x[lane], low_y + texels.y[lane]);
                let (u, v) = (a * x, b * x + c * y);
                weights[lane] = exponential(-0.5 * (u * u + v * v));
            }
            return;
        }
        for (lane, weight) in weights.iter_mut().enumerate() {
            *weight = 0.0;
            if (lane as u32) < count && get(&texels.distances, lane) <= LEAST_TERM {
                let column = get(&texels.x, lane) as i64 + i64::from(first[0]) + origin.texel[0];
                let row = get(&texels.y, lane) as i64 + i64::from(first[1]) + origin.texel[1];
                *weight = self.footprint.texel_weight(column, row) as f32;
            }
        }
    }

    fn unit(&self) -> f64 {
        self.unit
    }
}
