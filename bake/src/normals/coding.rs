//! Stored components to points of the disk.
//!
//! Components are kept as *numerators*: integers of the file's lattice, exact in f64, over a common denominator that
//! cancels when a vector is normalised. `2 x - 255` over 255, or `x - 128` over 127.

use super::channels::Places;
use super::decode::RIM_STEPS;
use super::options::{DecodeOptions, GreenAxis, Range, Zero};
use crate::image::SampleType;

/// Smallest length of a vector of floats that has a direction: the smallest half float, 2⁻²⁴.
const SHORTEST_FLOAT: f64 = 1.0 / 16_777_216.0;

/// Lattice step of floats: that of half floats between 1/2 and 1, 2⁻¹¹.
const FLOAT_STEP: f64 = 1.0 / 2048.0;

/// How samples become numerators, and how far these may be off.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coding {
    factor: f64,
    offset: f64,
    /// Numerators below stand for this one (the second -1 of `--zero 128`).
    least: f64,
    /// The numerator of 1.
    pub(super) unit: f64,
    /// Vectors shorter than this have no direction.
    pub(super) shortest: f64,
    /// How far beyond the rim a component may lie.
    rim: f64,
    /// -1 where the second component points down, else 1.
    up: f64,
}

impl Coding {
    /// The coding of samples of type `kind` under `options`, whose lattice, if it is one, has every `stride`-th value
    /// of the type.
    pub(super) fn new(kind: SampleType, options: &DecodeOptions, stride: u16) -> Self {
        let up = match options.green {
            GreenAxis::Gl => 1.0,
            GreenAxis::Dx => -1.0,
        };
        let Some(maximum) = kind.maximum() else {
            let (factor, offset) = match options.range {
                Range::Unorm => (2.0, -1.0),
                Range::Auto | Range::Snorm => (1.0, 0.0),
            };
            return Self {
                factor,
                offset,
                least: f64::NEG_INFINITY,
                unit: 1.0,
                shortest: SHORTEST_FLOAT,
                rim: RIM_STEPS * FLOAT_STEP,
                up,
            };
        };
        let (factor, offset, unit) = match options.zero {
            Zero::Half => (2.0, -f64::from(maximum), f64::from(maximum)),
            Zero::Centred => {
                let centre = f64::from(maximum / 2) + 1.0;
                (1.0, -centre, centre - 1.0)
            }
        };
        let step = factor * f64::from(stride);
        Self {
            factor,
            offset,
            least: -unit,
            unit,
            shortest: step,
            rim: RIM_STEPS * step,
            up,
        }
    }

    /// The lattice step as a component.
    pub(super) fn step(&self) -> f64 {
        self.shortest / self.unit
    }

    #[inline]
    pub(super) fn numerator(&self, sample: impl Into<f64>) -> f64 {
        (sample.into() * self.factor + self.offset).max(self.least)
    }

    /// The normal of three numerators.
    fn three(&self, [x, y, z]: [f64; 3]) -> Result<Vector, &'static str> {
        let squared = x * x + y * y + z * z;
        if !squared.is_finite() {
            return Err("a component is not a finite number");
        }
        let length = squared.sqrt();
        if length < self.shortest {
            return Err("it has no length, and so no direction");
        }
        if z < -self.rim {
            return Err("it points below the surface");
        }
        let (along, clamped) = if z >= 0.0 {
            (length, false)
        } else {
            ((x * x + y * y).sqrt(), true)
        };
        if along < self.shortest {
            return Err("it has no length, and so no direction");
        }
        Ok(Vector {
            point: self.point(x / along, y / along),
            length,
            clamped,
        })
    }

    /// The normal of two numerators.
    fn two(&self, [x, y]: [f64; 2]) -> Result<Vector, &'static str> {
        let (s, t) = (x / self.unit, y / self.unit);
        let squared = s * s + t * t;
        if !squared.is_finite() {
            return Err("a component is not a finite number");
        }
        if squared <= 1.0 {
            return Ok(Vector {
                point: self.point(s, t),
                length: self.unit,
                clamped: false,
            });
        }
        let length = squared.sqrt();
        if length > 1.0 + self.rim / self.unit {
            return Err("it lies outside the unit disk");
        }
        Ok(Vector {
            point: self.point(s / length, t / length),
            length: self.unit,
            clamped: true,
        })
    }

    #[inline]
    pub(super) fn point(&self, s: f64, t: f64) -> [f32; 2] {
        without_negative_zero([s, t * self.up])
    }

    /// The normal of a texel whose sample at each of `places` is `sample`.
    pub(super) fn vector(
        &self,
        places: &Places,
        sample: impl Fn(usize) -> f64,
    ) -> Result<Vector, &'static str> {
        let at = |place| self.numerator(sample(place));
        match *places {
            Places::Three([x, y, z]) => self.three([at(x), at(y), at(z)]),
            Places::Two([x, y]) => self.two([at(x), at(y)]),
        }
    }
}

/// The point in f32; a zero is positive, so that equal normals are equal bytes.
#[inline]
pub(super) fn without_negative_zero([s, t]: [f64; 2]) -> [f32; 2] {
    [s as f32 + 0.0, t as f32 + 0.0]
}

/// A normal, and what became of it.
pub(super) struct Vector {
    pub point: [f32; 2],
    /// Before normalising, as a numerator.
    pub length: f64,
    pub clamped: bool,
}
