//! Stored components to points of the disk.
//!
//! Components are kept as *numerators*: integers of the file's lattice, exact in f64, over a common denominator that
//! cancels when a vector is normalised. `2 x - 255` over 255, or `x - 128` over 127.

use super::channels::Places;
use super::decode::RIM_STEPS;
use super::options::{DecodeOptions, GreenAxis, Range, Zero};
use crate::image::Samples;
use rayon::prelude::*;

/// Texels converted, and summed up, as one piece of work. Fixed, so that no sum depends on the number of threads.
pub(super) const CHUNK_TEXELS: usize = 1 << 14;

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
    unit: f64,
    /// Vectors shorter than this have no direction.
    shortest: f64,
    /// How far beyond the rim a component may lie.
    rim: f64,
    /// -1 where the second component points down, else 1.
    up: f64,
}

impl Coding {
    /// The coding of `samples` under `options`, whose lattice, if it is one, has every `stride`-th value of the type.
    pub(super) fn new(samples: &Samples, options: &DecodeOptions, stride: u16) -> Self {
        let up = match options.green {
            GreenAxis::Gl => 1.0,
            GreenAxis::Dx => -1.0,
        };
        let Some(maximum) = samples.maximum() else {
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
    fn numerator(&self, sample: impl Into<f64>) -> f64 {
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
    fn point(&self, s: f64, t: f64) -> [f32; 2] {
        without_negative_zero([s, t * self.up])
    }

    /// The normal of a texel whose sample at each of `places` is `sample`.
    fn vector(
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
struct Vector {
    point: [f32; 2],
    /// Before normalising, as a numerator.
    length: f64,
    clamped: bool,
}

/// What was met among some texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tally {
    pub valid: u64,
    pub length_sum: f64,
    pub shortest: f64,
    pub longest: f64,
    pub clamped: u64,
    pub bad: u64,
    /// Index of the first bad texel.
    pub first_bad: Option<usize>,
}

impl Tally {
    const NONE: Self = Self {
        valid: 0,
        length_sum: 0.0,
        shortest: f64::INFINITY,
        longest: 0.0,
        clamped: 0,
        bad: 0,
        first_bad: None,
    };

    /// Counts a valid vector of this length.
    #[inline]
    fn count(&mut self, length: f64) {
        self.valid += 1;
        self.length_sum += length;
        self.shortest = self.shortest.min(length);
        self.longest = self.longest.max(length);
    }

    /// Both together; `later` follows `self` in the map.
    fn then(self, later: &Self) -> Self {
        Self {
            valid: self.valid + later.valid,
            length_sum: self.length_sum + later.length_sum,
            shortest: self.shortest.min(later.shortest),
            longest: self.longest.max(later.longest),
            clamped: self.clamped + later.clamped,
            bad: self.bad + later.bad,
            first_bad: self.first_bad.or(later.first_bad),
        }
    }
}

/// Disk points of all texels, NaN where there is none, and what was met; lengths are relative to 1.
pub(super) fn convert(
    samples: &Samples,
    channels: usize,
    places: &Places,
    coding: &Coding,
) -> (Vec<[f32; 2]>, Tally) {
    let mut tally;
    let texels;
    match samples {
        Samples::U8(samples) => (texels, tally) = all(samples, channels, places, coding),
        Samples::U16(samples) => (texels, tally) = all(samples, channels, places, coding),
        Samples::F32(samples) => (texels, tally) = all(samples, channels, places, coding),
    }
    tally.length_sum /= coding.unit;
    tally.shortest /= coding.unit;
    tally.longest /= coding.unit;
    (texels, tally)
}

/// Why texel `index` is bad.
pub(super) fn fault(
    samples: &Samples,
    channels: usize,
    places: &Places,
    coding: &Coding,
    index: usize,
) -> &'static str {
    let vector = coding.vector(places, |place| {
        let at = index * channels + place;
        match samples {
            Samples::U8(samples) => samples[at].into(),
            Samples::U16(samples) => samples[at].into(),
            Samples::F32(samples) => samples[at].into(),
        }
    });
    vector.err().unwrap_or("it is valid")
}

/// [`chunked`] for the number of channels known when compiling, which halves the time.
fn all<S: Copy + Sync + Into<f64>>(
    samples: &[S],
    channels: usize,
    places: &Places,
    coding: &Coding,
) -> (Vec<[f32; 2]>, Tally) {
    match channels {
        2 => chunked(samples.as_chunks::<2>().0, places, coding),
        3 => chunked(samples.as_chunks::<3>().0, places, coding),
        4 => chunked(samples.as_chunks::<4>().0, places, coding),
        other => unreachable!("{other} channels hold no normal, and have been refused"),
    }
}

fn chunked<S: Copy + Sync + Into<f64>, const C: usize>(
    samples: &[[S; C]],
    places: &Places,
    coding: &Coding,
) -> (Vec<[f32; 2]>, Tally) {
    let mut texels = vec![[0.0; 2]; samples.len()];
    let tallies: Vec<Tally> = texels
        .par_chunks_mut(CHUNK_TEXELS)
        .zip(samples.par_chunks(CHUNK_TEXELS))
        .enumerate()
        .map(|(chunk, (texels, samples))| {
            let mut tally = Tally::NONE;
            let mut index = chunk * CHUNK_TEXELS;
            for (texels, samples) in texels.chunks_mut(BLOCK).zip(samples.chunks(BLOCK)) {
                let plain = match (<&mut Block<_>>::try_from(&mut *texels), samples.try_into()) {
                    (Ok(texels), Ok(samples)) => {
                        plain_block(texels, samples, places, coding, &mut tally)
                    }
                    // The last texels of a map.
                    _ => false,
                };
                if !plain {
                    any_block(texels, samples, places, coding, &mut tally, index);
                }
                index += texels.len();
            }
            tally
        })
        .collect();
    let tally = tallies.iter().fold(Tally::NONE, Tally::then);
    (texels, tally)
}

/// Texels that are tried together, in loops a compiler can turn into vector instructions.
const BLOCK: usize = 64;

type Block<T> = [T; BLOCK];

/// Converts a block in which every texel is an ordinary normal; false, with nothing counted, if one is not.
///
/// The same operations as [`Coding::three`] and [`Coding::two`] on such texels, so the same bits.
fn plain_block<S: Copy + Into<f64>, const C: usize>(
    texels: &mut Block<[f32; 2]>,
    samples: &Block<[S; C]>,
    places: &Places,
    coding: &Coding,
    tally: &mut Tally,
) -> bool {
    let mut plain = true;
    let mut lengths = [coding.unit; BLOCK];
    let mut points = [[0.0; BLOCK]; 2];
    let component = |place: usize| {
        let mut numerators = [0.0; BLOCK];
        for (numerator, texel) in numerators.iter_mut().zip(samples) {
            *numerator = coding.numerator(texel[place]);
        }
        numerators
    };
    match *places {
        Places::Three(places) => {
            let (x, y, z) = (
                component(places[0]),
                component(places[1]),
                component(places[2]),
            );
            let shortest = coding.shortest * coding.shortest;
            for i in 0..BLOCK {
                let squared = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
                plain &= (z[i] >= 0.0) & (squared >= shortest) & (squared <= f64::MAX);
                lengths[i] = squared.sqrt();
                points[0][i] = x[i] / lengths[i];
                points[1][i] = y[i] / lengths[i];
            }
        }
        Places::Two(places) => {
            let (x, y) = (component(places[0]), component(places[1]));
            for i in 0..BLOCK {
                let (s, t) = (x[i] / coding.unit, y[i] / coding.unit);
                plain &= s * s + t * t <= 1.0;
                points[0][i] = s;
                points[1][i] = t;
            }
        }
    }
    if !plain {
        return false;
    }
    for (i, texel) in texels.iter_mut().enumerate() {
        *texel = coding.point(points[0][i], points[1][i]);
    }
    for length in lengths {
        tally.count(length);
    }
    true
}

/// Converts texels one by one, whatever they are; `first` is the index of the first.
fn any_block<S: Copy + Into<f64>, const C: usize>(
    texels: &mut [[f32; 2]],
    samples: &[[S; C]],
    places: &Places,
    coding: &Coding,
    tally: &mut Tally,
    first: usize,
) {
    for (index, (texel, samples)) in texels.iter_mut().zip(samples).enumerate() {
        match coding.vector(places, |place| samples[place].into()) {
            Ok(vector) => {
                *texel = vector.point;
                tally.count(vector.length);
                tally.clamped += u64::from(vector.clamped);
            }
            Err(_) => {
                *texel = [f32::NAN; 2];
                tally.bad += 1;
                tally.first_bad.get_or_insert(first + index);
            }
        }
    }
}
