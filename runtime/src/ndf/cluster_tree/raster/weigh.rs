//! What a footprint weighs the texels of a block.

use super::super::lanes::{LANES, Lanes, exponential, max, set};
use super::areas::{Areas, Place};
use crate::overlap::{GaussianFootprint, GaussianRow, Outline, Parallelogram, TexelBox};
use glintbake_format::records::RASTER_SIDE;

const SIDE: usize = RASTER_SIDE as usize;

/// A block of texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Its first texel, copies of the map counted on.
    pub texel: [i64; 2],
    /// The same relative to the footprint's centre.
    pub corner: [f32; 2],
    /// Columns and rows of the map from there on; texels beyond weigh nothing.
    pub room: [f32; 2],
}

impl Block {
    /// Whether all of it is on the map.
    #[inline(always)]
    pub fn is_whole(&self) -> bool {
        self.room[0] >= SIDE as f32 && self.room[1] >= SIDE as f32
    }
}

/// Weights of a footprint.
pub(super) trait Weigh {
    /// The weight that counts 1 in sums.
    fn unit(&self) -> f64;

    /// How a block whose nearest normal is `exponent` away lies.
    fn place(&self, block: &Block, exponent: f32) -> Place;

    /// The weights of a block that is cut, in units of [`unit`](Self::unit).
    fn weights(&self, block: &Block) -> Lanes;
}

/// A parallelogram, by closed forms in single precision.
pub(super) struct WideBox {
    pub areas: Areas,
    pub unit: f64,
}

impl Weigh for WideBox {
    fn unit(&self) -> f64 {
        self.unit
    }

    #[inline(always)]
    fn place(&self, block: &Block, _: f32) -> Place {
        self.areas.place(block.corner[0], block.corner[1])
    }

    #[inline(always)]
    fn weights(&self, block: &Block) -> Lanes {
        let [x, y] = block.corner;
        self.areas.shares(x, y, block.room)
    }
}

/// A parallelogram of any shape, texel by texel in double precision.
pub(super) struct AnyBox<'a> {
    pub footprint: &'a Parallelogram,
    pub outline: Option<Outline>,
}

impl Weigh for AnyBox<'_> {
    fn unit(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn place(&self, _: &Block, _: f32) -> Place {
        Place::Cut
    }

    fn weights(&self, block: &Block) -> Lanes {
        let [first, top] = block.texel;
        let mut weights = [0.0; LANES];
        for (row, y) in (top..).enumerate().take(rows(block)) {
            let covered = self.outline.map(|outline| outline.row(self.footprint, y));
            for (column, x) in (first..).enumerate().take(columns(block)) {
                let weight = match &covered {
                    Some(covered) => covered.weight(x),
                    None => {
                        let low = [x as f64, y as f64];
                        self.footprint.weight(&TexelBox {
                            low,
                            high: [low[0] + 1.0, low[1] + 1.0],
                        })
                    }
                };
                set(&mut weights, SIDE * row + column, weight as f32);
            }
        }
        weights
    }
}

/// Columns of `block` on the map.
fn columns(block: &Block) -> usize {
    (block.room[0] as usize).min(SIDE)
}

/// Rows of `block` on the map.
fn rows(block: &Block) -> usize {
    (block.room[1] as usize).min(SIDE)
}

/// A Gaussian of at least half a texel's deviation: the value of it and a texel convolved, at texels' middles; below two
/// texels' deviation the mean of as many parts of a texel as make it two parts.
pub(super) struct SmoothGaussian {
    /// Parts a side.
    parts: u8,
    /// `|L x|²` is the squared distance from the centre in standard deviations.
    root: [[f32; 2]; 2],
    unit: f64,
    /// Exponents of weights and normals add up to this at most.
    limit: f32,
}

impl SmoothGaussian {
    #[inline(always)]
    pub fn new(footprint: &GaussianFootprint, limit: f32) -> Option<Self> {
        let least = footprint.least_deviation();
        let parts = if least >= 2.0 {
            1
        } else if least >= 1.0 {
            2
        } else if least >= 0.5 {
            4
        } else {
            return None;
        };
        let [xx, yy, xy] = footprint.covariance();
        // Of a part, 1/12 of its square in either direction.
        let count = f64::from(parts);
        let texel = 1.0 / (12.0 * count * count);
        let area = footprint.determinant_root();
        let determinant = area * area + texel * (xx + yy) + texel * texel;
        let deviation = libm::sqrt(xx + texel);
        let root = libm::sqrt(determinant);
        Some(Self {
            parts,
            root: [
                [(1.0 / deviation) as f32, 0.0],
                [(-xy / (deviation * root)) as f32, (deviation / root) as f32],
            ],
            unit: 1.0 / (core::f64::consts::TAU * root * count * count),
            limit,
        })
    }
}

impl Weigh for SmoothGaussian {
    fn unit(&self) -> f64 {
        self.unit
    }

    #[inline(always)]
    fn place(&self, block: &Block, exponent: f32) -> Place {
        let half = 0.5 * SIDE as f32;
        let [x, y] = block.corner.map(|x| x + half);
        let [[a, _], [b, c]] = self.root;
        let u = max((a * x).abs() - half * a, 0.0);
        let v = max((b * x + c * y).abs() - half * (b.abs() + c), 0.0);
        if exponent + 0.5 * (u * u + v * v) > self.limit {
            Place::Outside
        } else {
            Place::Cut
        }
    }

    #[inline(always)]
    fn weights(&self, block: &Block) -> Lanes {
        let mut weights = [0.0; LANES];
        let part = 1.0 / f32::from(self.parts);
        for row in 0..self.parts {
            for column in 0..self.parts {
                let place = [column, row].map(|part_number| part * (f32::from(part_number) + 0.5));
                self.add(block, place, &mut weights);
            }
        }
        weights
    }
}

impl SmoothGaussian {
    /// Adds to the weights of a block the values at `place` in each of its texels.
    #[inline(always)]
    fn add(&self, block: &Block, place: [f32; 2], weights: &mut Lanes) {
        let [[a, _], [b, c]] = self.root;
        let corner = [block.corner[0] + place[0], block.corner[1] + place[1]];
        for (lane, weight) in (0_i32..).zip(weights) {
            let (column, row) = ((lane & 3) as f32, (lane >> 2) as f32);
            let (x, y) = (corner[0] + column, corner[1] + row);
            let (u, v) = (a * x, b * x + c * y);
            let value = exponential(-0.5 * (u * u + v * v));
            let is_there = (column < block.room[0]) & (row < block.room[1]);
            *weight += if is_there { value } else { 0.0 };
        }
    }
}

/// A narrower Gaussian, integrated over texels in double precision.
pub(super) struct NarrowGaussian<'a> {
    pub footprint: &'a GaussianFootprint,
}

impl Weigh for NarrowGaussian<'_> {
    fn unit(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn place(&self, _: &Block, _: f32) -> Place {
        Place::Cut
    }

    fn weights(&self, block: &Block) -> Lanes {
        let [first, top] = block.texel;
        let mut weights = [0.0; LANES];
        for (row, y) in (top..).enumerate().take(rows(block)) {
            let texels: GaussianRow<'_> = self.footprint.row(y);
            for (column, x) in (first..).enumerate().take(columns(block)) {
                set(&mut weights, SIDE * row + column, texels.weight(x) as f32);
            }
        }
        weights
    }
}
