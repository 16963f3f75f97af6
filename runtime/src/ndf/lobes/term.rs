//! The Gaussian of one lobe: in f64, one at a time, and in f32, a block at a time.
#![expect(
    clippy::indexing_slicing,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use super::frame::Frame;
use crate::lanes::{LANES, Lanes, exponential, inverse_root, least, sum};
use core::f64::consts::TAU;
use glintbake_format::model::HalfVector;
use glintbake_format::view::LobeNormal;

/// The Gaussian of normals of one lobe: a mean, and a covariance R + F Fᵀ.
#[derive(Clone, Copy, Debug)]
pub(in crate::ndf) struct Term {
    /// The mean normal, a point of the disk.
    pub mean: [f64; 2],
    /// R: variance of s, covariance, variance of t, the kernel's included.
    pub residual: [f64; 3],
    /// The columns of F.
    pub fan: [[f64; 2]; 2],
    /// |p|², p the whitened distance of positions.
    pub position_squared: f64,
}

impl Term {
    /// That of `lobe`, `offset` = `u_p` - `u_i` from the footprint's centre, with the residual covariance `residual`.
    #[inline(always)]
    pub(super) fn new(
        frame: &Frame,
        offset: [f64; 2],
        lobe: &LobeNormal,
        residual: [f64; 3],
    ) -> Self {
        let p = frame.whitened(offset);
        let [x, y] = frame.shift(p);
        Self {
            mean: lobe.at(x, y).normal,
            residual,
            fan: frame.fan(lobe.slope),
            position_squared: p[0] * p[0] + p[1] * p[1],
        }
    }

    /// The mean normal.
    pub const fn normal(&self) -> HalfVector {
        let [s, t] = self.mean;
        HalfVector { s, t }
    }

    /// det(R + F Fᵀ), a sum of positive parts: det R + Σ fᵀ adj(R) f + (f1 × f2)².
    #[inline(always)]
    fn determinant(&self) -> f64 {
        let [ss, st, tt] = self.residual;
        let [f, g] = self.fan;
        let adjoint = |[s, t]: [f64; 2]| tt * s * s - 2.0 * st * s * t + ss * t * t;
        let cross = f[0] * g[1] - f[1] * g[0];
        (ss * tt - st * st) + adjoint(f) + adjoint(g) + cross * cross
    }

    /// Half the squared distance from `point` in standard deviations, positions included, and the factor of its exponential,
    /// `1 / √det`, but for 2π.
    #[inline(always)]
    pub fn exponent(&self, point: [f64; 2]) -> (f64, f64) {
        let determinant = self.determinant();
        let [s, t] = [point[0] - self.mean[0], point[1] - self.mean[1]];
        let [ss, st, tt] = self.residual;
        let [f, g] = self.fan;
        let (across_f, across_g) = (f[0] * t - f[1] * s, g[0] * t - g[1] * s);
        let squared = (tt * s * s - 2.0 * st * s * t + ss * t * t)
            + across_f * across_f
            + across_g * across_g;
        let normal_squared = squared / determinant;
        (
            0.5 * (self.position_squared + normal_squared),
            1.0 / libm::sqrt(determinant),
        )
    }

    /// A lower triangular root of the covariance, `[a, b, c]`: the point `mean + (a x, b x + c y)` of unit Gaussians x, y.
    fn root(&self) -> [f64; 3] {
        let [ss, st, _] = self.residual;
        let [f, g] = self.fan;
        let variance = ss + f[0] * f[0] + g[0] * g[0];
        let covariance = st + f[0] * f[1] + g[0] * g[1];
        let a = libm::sqrt(variance);
        [
            a,
            covariance / a,
            libm::sqrt(self.determinant().max(0.0)) / a,
        ]
    }
}

impl Term {
    /// A normal drawn by two numbers in [0, 1), and its squared distance from the mean in deviations.
    pub fn draw(&self, [first, second]: [f64; 2]) -> (HalfVector, f64) {
        // Box and Muller 1958.
        let squared = -2.0 * libm::log1p(-first);
        let (sine, cosine) = libm::sincos(TAU * second);
        let radius = libm::sqrt(squared);
        let [a, b, c] = self.root();
        let (x, y) = (radius * cosine, radius * sine);
        let drawn = HalfVector {
            s: self.mean[0] + a * x,
            t: self.mean[1] + b * x + c * y,
        };
        (drawn, squared)
    }
}

/// A [`Frame`] for blocks, in f32, and where the first lobe of the block is.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockFrame {
    whiten: [f32; 3],
    shift: [f32; 3],
    spread: [[f32; 2]; 2],
}

/// Columns and rows of a block's lobes.
const COLUMNS: Lanes = {
    let mut lanes = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        lanes[lane] = (lane % 4) as f32;
        lane += 1;
    }
    lanes
};
const ROWS: Lanes = {
    let mut lanes = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        lanes[lane] = (lane / 4) as f32;
        lane += 1;
    }
    lanes
};

impl BlockFrame {
    pub fn new(frame: &Frame) -> Self {
        Self {
            whiten: frame.whiten.map(|x| x as f32),
            shift: frame.whiten.map(|x| (frame.variance * x) as f32),
            spread: frame.spread.map(|column| column.map(|x| x as f32)),
        }
    }

    /// The sum of `exp(-exponent) / √det` over the lobes of a block whose lane in `counts` is 1, not 0; `first` is p of the first
    /// one. As [`Term::exponent`], for a residual covariance of 1.
    #[inline(always)]
    pub fn curved(
        &self,
        [normals_s, normals_t]: &[Lanes; 2],
        [s_x, s_y, t_x, t_y]: &[Lanes; 4],
        first: [f32; 2],
        counts: &Lanes,
    ) -> f32 {
        let [a, b, c] = self.whiten;
        let [shift_a, shift_b, shift_c] = self.shift;
        let [[g_x, g_y], [h_x, h_y]] = self.spread;
        let mut values = [0.0; LANES];
        for lane in 0..LANES {
            // Offsets point from the lobe to the centre, so columns count backwards.
            let p = first[0] - a * COLUMNS[lane] - b * ROWS[lane];
            let q = first[1] - c * ROWS[lane];
            let (x, y) = (shift_a * p, shift_b * p + shift_c * q);
            let s = normals_s[lane] - (s_x[lane] * x + s_y[lane] * y);
            let t = normals_t[lane] - (t_x[lane] * x + t_y[lane] * y);
            let f_s = s_x[lane] * g_x + s_y[lane] * g_y;
            let f_t = t_x[lane] * g_x + t_y[lane] * g_y;
            let g_s = s_x[lane] * h_x + s_y[lane] * h_y;
            let g_t = t_x[lane] * h_x + t_y[lane] * h_y;
            let cross = f_s * g_t - f_t * g_s;
            let squares = f_s * f_s + f_t * f_t + g_s * g_s + g_t * g_t;
            let root = inverse_root(1.0 + squares + cross * cross);
            let (across_f, across_g) = (f_s * t - f_t * s, g_s * t - g_t * s);
            let normal = s * s + t * t + across_f * across_f + across_g * across_g;
            let exponent = p * p + q * q + normal * root * root;
            values[lane] = exponential(-0.5 * exponent) * root * counts[lane];
        }
        sum(&values)
    }

    /// The least squared distance of positions and, times `factor`, of normals.
    #[inline(always)]
    pub fn least(&self, [s, t]: &[Lanes; 2], first: [f32; 2], factor: f32) -> f32 {
        let [a, b, c] = self.whiten;
        let mut squares = [0.0; LANES];
        for lane in 0..LANES {
            let p = first[0] - a * COLUMNS[lane] - b * ROWS[lane];
            let q = first[1] - c * ROWS[lane];
            squares[lane] = p * p + q * q + factor * (s[lane] * s[lane] + t[lane] * t[lane]);
        }
        least(&squares)
    }

    /// As [`curved`](Self::curved) for lobes without slopes.
    #[inline(always)]
    pub fn flat(&self, [s, t]: &[Lanes; 2], first: [f32; 2], counts: &Lanes) -> f32 {
        let [a, b, c] = self.whiten;
        let mut values = [0.0; LANES];
        for lane in 0..LANES {
            let p = first[0] - a * COLUMNS[lane] - b * ROWS[lane];
            let q = first[1] - c * ROWS[lane];
            let exponent = p * p + q * q + s[lane] * s[lane] + t[lane] * t[lane];
            values[lane] = exponential(-0.5 * exponent) * counts[lane];
        }
        sum(&values)
    }
}

/// The half vector less normals on a plane, which is `normal` off it at the middle of the block.
#[inline(always)]
pub(super) fn plane(normal: [f32; 2], [s_x, s_y, t_x, t_y]: [f32; 4]) -> [Lanes; 2] {
    let mut normals = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        let (x, y) = (COLUMNS[lane] - 1.5, ROWS[lane] - 1.5);
        normals[0][lane] = normal[0] - (s_x * x + s_y * y);
        normals[1][lane] = normal[1] - (t_x * x + t_y * y);
    }
    normals
}
