//! The kernel about one half vector: what a texel's normal, or a cluster of normals, adds to the density.
//!
//! Normals are given by their offset (s, t) from the half vector on the disk, in units of σr. Terms are shares of the kernel's
//! peak, `1 / (2π σr²)` of either kernel.

use super::lanes::{Lanes, each, exponential, get, inverse_root, max};
use crate::microfacet::vector::frame;
use glintbake_format::model::HalfVector;

/// Terms of a kernel.
pub(super) trait Lobe: Copy {
    /// Exponents and factors of texels: a term is `factor e^-exponent`. An exponent is at least `(s² + t²) / 2`.
    fn exponents(&self, s: &Lanes, t: &Lanes) -> (Lanes, Lanes);

    /// A cluster's distance from the half vector in the kernel's own chart, its covariance there, and the factor at its mean.
    fn chart(&self, mean: [f32; 2], covariance: [f32; 3]) -> Chart;
}

/// A cluster as one Gaussian of the kernel's chart, in units of σr.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chart {
    pub mean: [f32; 2],
    pub covariance: [f32; 3],
    pub factor: f32,
}

impl Chart {
    /// The greater variance is at most this.
    #[inline(always)]
    pub fn variance(&self) -> f32 {
        let [ss, st, tt] = self.covariance;
        max(ss, tt) + st.abs()
    }

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
    fn exponents(&self, s: &Lanes, t: &Lanes) -> (Lanes, Lanes) {
        let exponents = each(|lane| {
            let (s, t) = (get(s, lane), get(t, lane));
            0.5 * (s * s + t * t)
        });
        (exponents, [1.0; super::lanes::LANES])
    }

    #[inline(always)]
    fn chart(&self, mean: [f32; 2], covariance: [f32; 3]) -> Chart {
        Chart {
            mean,
            covariance,
            factor: 1.0,
        }
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
        }
    }

    /// The normal at offset (s, t) as its difference from h in units of σr, and its z.
    #[inline(always)]
    fn difference(&self, s: f32, t: f32) -> ([f32; 3], f32) {
        let [x, y, z] = self.h;
        let (ds, dt) = (s * self.sigma, t * self.sigma);
        // z'² = z² - rise, so that z' - z = -rise / (z' + z): no small number comes from a difference of large ones.
        let rise = ds * (2.0 * x + ds) + dt * (2.0 * y + dt);
        let square = max(z * z - rise, 1e-12);
        let height = square * inverse_root(square);
        let fall = (s * (2.0 * x + ds) + t * (2.0 * y + dt)) / (height + z);
        ([s, t, -fall], height)
    }
}

/// The least cosine between half vector and normal: beyond, terms are nothing for any roughness that is allowed but the
/// greatest, and `1 / cos⁴` stays finite.
const LEAST_COSINE: f32 = 1e-4;

impl Lobe for Beckmann {
    #[inline(always)]
    fn exponents(&self, s: &Lanes, t: &Lanes) -> (Lanes, Lanes) {
        let mut factors = [0.0; super::lanes::LANES];
        let mut exponents = [0.0; super::lanes::LANES];
        let all = factors.iter_mut().zip(&mut exponents).zip(s.iter().zip(t));
        for ((factor, exponent), (&s, &t)) in all {
            let ([ds, dt, dz], _) = self.difference(s, t);
            let square = ds * ds + dt * dt + dz * dz;
            let chord = square * (self.sigma * self.sigma);
            let cosine = 1.0 - 0.5 * chord;
            let bounded = max(cosine, LEAST_COSINE);
            let inverse = 1.0 / (bounded * bounded);
            *exponent = 0.5 * square * (1.0 - 0.25 * chord) * inverse;
            *factor = if cosine > LEAST_COSINE {
                inverse * inverse
            } else {
                0.0
            };
        }
        (exponents, factors)
    }

    #[inline(always)]
    fn chart(&self, [s, t]: [f32; 2], covariance: [f32; 3]) -> Chart {
        let (d, height) = self.difference(s, t);
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let chord = dot(d, d) * (self.sigma * self.sigma);
        let cosine = 1.0 - 0.5 * chord;
        if cosine <= LEAST_COSINE {
            return Chart {
                mean: [0.0; 2],
                covariance: [f32::MAX, 0.0, f32::MAX],
                factor: 0.0,
            };
        }
        let inverse = 1.0 / cosine;
        let g = [dot(d, self.first) * inverse, dot(d, self.second) * inverse];
        // m is the normal; ∂m/∂s = (1, 0, -m_s / m_z), and likewise for t.
        let m = [self.h[0] + s * self.sigma, self.h[1] + t * self.sigma];
        let down = 1.0 / max(height, 1e-6);
        let along_s = [1.0, 0.0, -m[0] * down];
        let along_t = [0.0, 1.0, -m[1] * down];
        let change = |axis: [f32; 3], g: f32, along: [f32; 3]| {
            (dot(axis, along) - g * self.sigma * dot(self.h, along)) * inverse
        };
        let (a, b) = (
            change(self.first, g[0], along_s),
            change(self.first, g[0], along_t),
        );
        let (c, e) = (
            change(self.second, g[1], along_s),
            change(self.second, g[1], along_t),
        );
        let [ss, st, tt] = covariance;
        let square = inverse * inverse;
        Chart {
            mean: g,
            covariance: [
                a * a * ss + 2.0 * a * b * st + b * b * tt,
                a * c * ss + (a * e + b * c) * st + b * e * tt,
                c * c * ss + 2.0 * c * e * st + e * e * tt,
            ],
            factor: square * square,
        }
    }
}
