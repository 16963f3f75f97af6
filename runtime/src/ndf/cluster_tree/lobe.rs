//! The kernel about one half vector: what a texel's normal, or a cluster of normals, adds to the density.
//!
//! Normals are given by their offset (s, t) from the half vector on the disk, in units of σr. Terms are shares of the kernel's
//! peak, `1 / (2π σr²)` of either kernel.

use super::lanes::{exponential, inverse_root, max, min};
use crate::microfacet::vector::frame;
use glintbake_format::model::HalfVector;

/// Terms of a kernel.
pub(super) trait Lobe: Copy {
    /// Exponent and factor of a texel: its term is `factor e^-exponent`. The exponent is at least `(s² + t²) / 2`.
    fn exponent(&self, s: f32, t: f32) -> [f32; 2];

    /// A cluster's distance from the half vector in the kernel's own chart, its covariance there, and what its terms are
    /// multiplied by.
    fn chart(&self, mean: [f32; 2], covariance: [f32; 3]) -> Chart;

    /// Of `variance` as much as a cluster may have on the disk whose normals run from `low` to `high`, so that the chart is all but
    /// even over it.
    fn most_variance(&self, variance: f32, low: [f32; 2], high: [f32; 2]) -> f32;
}

/// A cluster as one Gaussian of the kernel's chart, in units of σr.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chart {
    pub mean: [f32; 2],
    pub covariance: [f32; 3],
    pub factor: f32,
}

impl Chart {
    /// The mean term of the cluster's texels, each normal distributed by the Gaussian.
    #[inline(always)]
    pub fn term(&self) -> f32 {
        let [ss, st, tt] = self.covariance;
        let (a, b) = (1.0 + ss, 1.0 + tt);
        let determinant = max(a * b - st * st, 1.0);
        let [s, t] = self.mean;
        let root = inverse_root(determinant);
        let square = (b * s * s - 2.0 * st * s * t + a * t * t) * (root * root);
        self.factor * exponential(-0.5 * max(square, 0.0)) * root
    }
}

/// A Gaussian on the disk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disk;

impl Lobe for Disk {
    #[inline(always)]
    fn exponent(&self, s: f32, t: f32) -> [f32; 2] {
        [0.5 * (s * s + t * t), 1.0]
    }

    #[inline(always)]
    fn chart(&self, mean: [f32; 2], covariance: [f32; 3]) -> Chart {
        Chart {
            mean,
            covariance,
            factor: 1.0,
        }
    }

    #[inline(always)]
    fn most_variance(&self, variance: f32, _: [f32; 2], _: [f32; 2]) -> f32 {
        variance
    }
}

/// Beckmann's distribution about each normal, \[AWKK21\] eq. 14.
///
/// Its chart is the plane that touches the sphere at the half vector h: a normal m lies at `g = m / (m·h) - h`, and `|g|` is
/// the tangent of the angle between both. There the kernel is a Gaussian of variance σr² but for the factor `1 / (m·h)⁴`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beckmann {
    h: [f32; 3],
    first: [f32; 3],
    second: [f32; 3],
    sigma: f32,
    /// What variance there may be at height 1, beside the limit.
    curve: f32,
    /// The rise of the rim, in units of σr.
    most_rise: f32,
}

impl Beckmann {
    pub fn new(half_vector: HalfVector, sigma: f64) -> Self {
        let direction = half_vector.direction();
        let [first, second] = frame(direction);
        let narrow = |vector: [f64; 3]| vector.map(|x| x as f32);
        Self {
            h: narrow(direction),
            first: narrow(first),
            second: narrow(second),
            sigma: sigma as f32,
            curve: (CURVE / (sigma * sigma)) as f32,
            most_rise: ((direction[2] * direction[2] - f64::from(LEAST_SQUARE)) / sigma) as f32,
        }
    }

    /// The normal at offset (s, t) as its difference from h in units of σr, and its z.
    #[inline(always)]
    fn difference(&self, s: f32, t: f32) -> ([f32; 3], f32) {
        let [x, y, z] = self.h;
        let (ds, dt) = (s * self.sigma, t * self.sigma);
        // z'² = z² - σr rise, so that (z' - z) / σr = -rise / (z' + z): no small number comes from a difference of large ones.
        let rise = s * (2.0 * x + ds) + t * (2.0 * y + dt);
        // A normal that rounding puts beyond the rim is one on it.
        let rise = min(rise, self.most_rise);
        let square = max(z * z - rise * self.sigma, LEAST_SQUARE);
        let height = square * inverse_root(square);
        ([s, t, -rise / (height + z)], height)
    }
}

/// The least cosine between half vector and normal: beyond, terms are nothing for any roughness that is allowed but the
/// greatest, and `1 / cos⁴` stays finite.
const LEAST_COSINE: f32 = 1e-4;
/// The square of a height that is as good as none.
const LEAST_SQUARE: f32 = 1e-12;
/// The least height that clusters are taken at.
const LEAST_HEIGHT: f32 = 1e-2;
/// The greatest variance of a cluster's normals on the disk, at the greatest limit of those relative to the kernel, as a share of
/// the limit: beyond, the chart is too uneven.
const CURVE: f64 = 0.02;

impl Lobe for Beckmann {
    #[inline(always)]
    fn exponent(&self, s: f32, t: f32) -> [f32; 2] {
        let ([ds, dt, dz], _) = self.difference(s, t);
        let square = ds * ds + dt * dt + dz * dz;
        let chord = square * (self.sigma * self.sigma);
        let cosine = 1.0 - 0.5 * chord;
        let bounded = max(cosine, LEAST_COSINE);
        let inverse = 1.0 / (bounded * bounded);
        // Of normals far beyond the disk, as trees that lie have, the quotient is negative.
        let exponent = max(
            0.5 * square * (1.0 - 0.25 * chord) * inverse,
            0.5 * (ds * ds + dt * dt),
        );
        let factor = if cosine > LEAST_COSINE {
            inverse * inverse
        } else {
            0.0
        };
        [exponent, factor]
    }

    /// With C a cluster's covariance on the disk and z the height of its mean, its mean normal is lower by
    /// `(C_ss + C_tt) / 2z + pᵀ C p / 2z³`, p its mean on the disk. The mean of g is that normal's and `σ² S g / (1 + σ²|g|²)`
    /// more, S the covariance of g: of m = (g + h) / √(1 + |g|²) it is the share that falls off as `|g|` grows. `1 / (m·h)⁴`
    /// is (1 + |g|²)², and where cluster and kernel meet, g is `(I + S)⁻¹` of its mean.
    #[inline(always)]
    fn chart(&self, [s, t]: [f32; 2], covariance: [f32; 3]) -> Chart {
        let ([ds, dt, dz], height) = self.difference(s, t);
        let [ss, st, tt] = covariance;
        let sigma = self.sigma;
        let down = 1.0 / max(height, LEAST_HEIGHT);
        let p = [self.h[0] + s * sigma, self.h[1] + t * sigma];
        let steep = (p[0] * p[0] * ss + 2.0 * p[0] * p[1] * st + p[1] * p[1] * tt) * down * down;
        let d = [ds, dt, dz - 0.5 * sigma * down * (ss + tt + steep)];
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cosine = 1.0 + sigma * dot(d, self.h);
        let is_seen = cosine > LEAST_COSINE;
        let inverse = 1.0 / max(cosine, LEAST_COSINE);
        let g = [dot(d, self.first) * inverse, dot(d, self.second) * inverse];
        // m is the normal; ∂m/∂s = (1, 0, -m_s / m_z), and likewise for t.
        let along_s = [1.0, 0.0, -p[0] * down];
        let along_t = [0.0, 1.0, -p[1] * down];
        let change = |axis: [f32; 3], g: f32, along: [f32; 3]| {
            (dot(axis, along) - g * sigma * dot(self.h, along)) * inverse
        };
        let (a, b) = (
            change(self.first, g[0], along_s),
            change(self.first, g[0], along_t),
        );
        let (c, e) = (
            change(self.second, g[1], along_s),
            change(self.second, g[1], along_t),
        );
        let variance = sigma * sigma;
        let [xx, xy, yy] = [
            a * a * ss + 2.0 * a * b * st + b * b * tt,
            a * c * ss + (a * e + b * c) * st + b * e * tt,
            c * c * ss + 2.0 * c * e * st + e * e * tt,
        ];
        let fall = variance / (1.0 + variance * (g[0] * g[0] + g[1] * g[1]));
        let mean = [
            g[0] + fall * (xx * g[0] + xy * g[1]),
            g[1] + fall * (xy * g[0] + yy * g[1]),
        ];
        let inverse = 1.0 / ((1.0 + xx) * (1.0 + yy) - xy * xy);
        let meet = [
            ((1.0 + yy) * mean[0] - xy * mean[1]) * inverse,
            ((1.0 + xx) * mean[1] - xy * mean[0]) * inverse,
        ];
        // The trace of (I + S)⁻¹ S.
        let spread = (xx + yy + 2.0 * (xx * yy - xy * xy)) * inverse;
        let square = 1.0 + variance * (meet[0] * meet[0] + meet[1] * meet[1] + spread);
        Chart {
            mean,
            covariance: [xx, xy, yy],
            factor: if is_seen { square * square } else { 0.0 },
        }
    }

    /// Distances on the chart are up to `1 / (z (m·h)²)` of those on the disk, and change by as much as 1/z² over a length of 1.
    #[inline(always)]
    fn most_variance(&self, variance: f32, low: [f32; 2], high: [f32; 2]) -> f32 {
        let far = |middle: f32, low: f32, high: f32| {
            let (a, b) = (middle + low * self.sigma, middle + high * self.sigma);
            (max(a.abs(), b.abs()), 0.5 * (a + b))
        };
        let [x, y, z] = self.h;
        let ((s, mean_s), (t, mean_t)) = (far(x, low[0], high[0]), far(y, low[1], high[1]));
        let square = max(1.0 - s * s - t * t, 0.0);
        let height = max(1.0 - mean_s * mean_s - mean_t * mean_t, 1e-12);
        let cosine = max(
            x * mean_s + y * mean_t + z * height * inverse_root(height),
            0.0,
        );
        let slope = square * cosine * cosine * cosine * cosine;
        slope * min(2.0 * variance, self.curve * variance * square)
    }
}

/// [`Beckmann`] where all normals that count are so near to the half vector that series stand for its roots and quotients:
/// half the operations, and none that others wait for.
#[derive(Clone, Copy, Debug)]
pub(super) struct NarrowBeckmann {
    whole: Beckmann,
    /// Twice the half vector, in units of 1 / σr: the fall of height along s and t.
    slope: [f32; 2],
    /// σr² / z².
    curve: f32,
    /// z / σr.
    height: f32,
    /// σr².
    variance: f32,
}

impl NarrowBeckmann {
    /// The kernel about `half_vector` of deviation `sigma`, if series are good for all exponents up to `limit`: within 1e-5 of
    /// the exponents and 5e-5 of the factors.
    pub fn new(half_vector: HalfVector, sigma: f64, limit: f32) -> Option<Self> {
        let [x, y, z] = half_vector.direction();
        let reach = libm::sqrt(2.0 * f64::from(limit)) * sigma;
        let tilt = libm::sqrt(x * x + y * y);
        let is_near = reach * (2.0 * tilt + reach) <= 0.12 * z * z && reach * reach <= 0.02;
        is_near.then(|| Self {
            whole: Beckmann::new(half_vector, sigma),
            slope: [(2.0 * x / sigma) as f32, (2.0 * y / sigma) as f32],
            curve: (sigma * sigma / (z * z)) as f32,
            height: (z / sigma) as f32,
            variance: (sigma * sigma) as f32,
        })
    }
}

impl Lobe for NarrowBeckmann {
    /// With q = 1 - z'²/z² for a normal of height z', `z - z' = z (1 - √(1 - q)) = z (q/2 + q²/8 + q³/16 + 5 q⁴/128 + …)`. With
    /// c the squared chord, `tan² = c (1 - c/4) / (1 - c/2)² = c (1 + 3c/4 + c²/2 + …)` and `1 / cos⁴ = 1 + 2c + 5c²/2 + …`.
    #[inline(always)]
    fn exponent(&self, s: f32, t: f32) -> [f32; 2] {
        let flat = s * s + t * t;
        let q = (flat + s * self.slope[0] + t * self.slope[1]) * self.curve;
        let square = q * q;
        let fall = self.height * (q * (0.5 + 0.125 * q) + square * q * (0.0625 + 0.039_062_5 * q));
        let whole = flat + fall * fall;
        let chord = whole * self.variance;
        // Beyond where series are good for it is what is on the disk that keeps terms small.
        let exponent = max(
            0.5 * whole * (1.0 + chord * (0.75 + 0.5 * chord)),
            0.5 * flat,
        );
        [exponent, 1.0 + chord * (2.0 + 2.5 * chord)]
    }

    #[inline(always)]
    fn chart(&self, mean: [f32; 2], covariance: [f32; 3]) -> Chart {
        self.whole.chart(mean, covariance)
    }

    // So near to the half vector, and so high above the rim as series want it, the chart is even.
    #[inline(always)]
    fn most_variance(&self, variance: f32, _: [f32; 2], _: [f32; 2]) -> f32 {
        variance
    }
}
