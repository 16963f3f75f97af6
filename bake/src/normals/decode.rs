//! From samples to a normal map.

use super::channels::{Places, places};
use super::check::check;
use super::coding::Coding;
use super::error::NormalsError;
use super::height;
use super::map::NormalMap;
use super::options::{DecodeOptions, Input};
use super::repair::repair;
use super::statistics::{Lattice, Lengths, Moments, Statistics};
use super::vectors::{CHUNK_TEXELS, Conversion};
use crate::image::{Header, Raster, SampleType, Samples, reserve};
use rayon::prelude::*;
use std::collections::TryReserveError;

/// How many lattice steps beyond the rim of the disk a texel may lie and still be taken for a normal on the rim.
///
/// Rounding alone leaves half a step per component, a filter with negative lobes or one round of 8-bit filtering a
/// step or two; four is where an angle that is plainly wrong begins (8 bit: 1.8° below the surface).
pub const RIM_STEPS: f64 = 4.0;

/// 8-bit samples widened to 16 bit are multiples of this: 65535 / 255.
const WIDENING: u16 = 257;

/// The normals of `raster`, and what they are like; see the [module](super) for every rule.
///
/// Takes the raster to drop it: the peak is the raster and 8 bytes a texel. [`read`](super::read()) does without it.
///
/// # Errors
/// [`NormalsError`]; with [`DecodeOptions::repair`], bad texels are one only if there are no others.
pub fn decode(
    raster: Raster,
    options: &DecodeOptions,
) -> Result<(NormalMap, Statistics), NormalsError> {
    let (header, samples) = raster.into_parts();
    let mut decoder = Decoder::new(header, options, Widening::Possible)?;
    match decoder.push(samples) {
        Ok(()) => decoder.finish(),
        Err(Interruption::Error(error)) => Err(error),
        Err(Interruption::NotWidened) => unreachable!("the whole map was looked at before"),
    }
}

/// Whether 16-bit samples may be 8-bit ones that were widened, and so lie on the coarser lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Widening {
    /// They are, as far as anybody knows.
    Possible,
    /// One of them is not.
    Refuted,
}

/// Why decoding cannot go on.
#[derive(Debug)]
pub(super) enum Interruption {
    /// The first bands looked widened and were taken for that, which this one refutes: begin again, saying so.
    ///
    /// True 16-bit maps tell within their first texels, so this is rare; yet the lattice decides which texels are
    /// bad, and a texel is judged when it comes by.
    NotWidened,
    /// The map is refused.
    Error(NormalsError),
}

/// A map in the making, whose samples come in bands.
///
/// The result does not depend on where bands begin and end.
pub(super) struct Decoder {
    header: Header,
    options: DecodeOptions,
    /// None until the first band has come.
    widened: Option<bool>,
    content: Content,
}

/// What has come so far.
enum Content {
    /// Normals, as points of the disk, from the components at their places; none before the first band, which decides
    /// the coding.
    Vectors(Places, Option<Box<Conversion>>),
    /// The first channel of height maps, for their normals need neighbours: at most 4 bytes a texel.
    Heights(Samples),
}

impl Decoder {
    /// A decoder of the map with this `header`, of which nothing has come.
    ///
    /// # Errors
    /// [`NormalsError::Option`] or [`NormalsError::Channels`].
    pub(super) fn new(
        header: Header,
        options: &DecodeOptions,
        widening: Widening,
    ) -> Result<Self, NormalsError> {
        check(&header, options)?;
        let content = match options.input {
            Input::Normals => {
                let places = places(options.channels, &header.layout, &header.name)?;
                Content::Vectors(places, None)
            }
            Input::Height => Content::Heights(Samples::none(header.kind)),
        };
        Ok(Self {
            widened: (widening == Widening::Refuted || header.kind != SampleType::U16)
                .then_some(false),
            header,
            options: options.clone(),
            content,
        })
    }

    /// Takes the samples of the next rows.
    pub(super) fn push(&mut self, samples: Samples) -> Result<(), Interruption> {
        let (header, options) = (&self.header, &self.options);
        let channels = header.layout.channels();
        let pushed = match &mut self.content {
            Content::Vectors(places, conversion) => {
                if self.widened != Some(false) {
                    let widened = is_widened(&samples, channels, places.as_slice());
                    if self.widened == Some(true) && !widened {
                        return Err(Interruption::NotWidened);
                    }
                    self.widened = Some(widened);
                }
                let stride = stride(self.widened);
                let conversion = conversion.get_or_insert_with(|| {
                    let coding = Coding::new(header.kind, options, stride);
                    let total = header.texel_count();
                    Box::new(Conversion::new(channels, *places, coding, total))
                });
                conversion.push(&samples)
            }
            Content::Heights(heights) => {
                if self.widened != Some(false) {
                    self.widened = Some(is_widened(&samples, channels, &[0]));
                }
                let first = first_channel(samples, channels);
                first.and_then(|first| heights.append(first, header.texel_count()))
            }
        };
        pushed.map_err(|_| {
            Interruption::Error(NormalsError::Memory {
                name: header.name.clone(),
                width: header.width,
                height: header.height,
            })
        })
    }

    /// The map, all of whose samples have come.
    pub(super) fn finish(self) -> Result<(NormalMap, Statistics), NormalsError> {
        let (header, options) = (&self.header, &self.options);
        let stride = stride(self.widened);
        match self.content {
            Content::Vectors(_, conversion) => from_vectors(
                header,
                options,
                stride,
                *conversion.expect("maps have rows"),
            ),
            Content::Heights(heights) => from_heights(header, options, stride, heights),
        }
    }
}

fn from_vectors(
    header: &Header,
    options: &DecodeOptions,
    stride: u16,
    conversion: Conversion,
) -> Result<(NormalMap, Statistics), NormalsError> {
    let (places, coding) = conversion.rules();
    let (mut texels, tally, first_bad) = conversion.finish();
    let bad = first_bad.map(|first| Bad {
        index: first.index,
        count: tally.bad,
        value: first.value,
        reason: first.reason,
    });
    let repaired = mend(header, options, &mut texels, bad, |[s, _]| !s.is_nan())?;
    let lengths = match places {
        Places::Three(_) => Some(Lengths {
            mean: tally.length_sum / tally.valid as f64,
            shortest: tally.shortest,
            longest: tally.longest,
        }),
        Places::Two(_) => None,
    };
    let facts = Facts {
        lengths,
        lattice: bits(header.kind, stride).map(|bits| Lattice {
            bits,
            step: coding.step(),
        }),
        clamped_to_rim: tally.clamped,
        repaired,
    };
    Ok(finish(header, options, texels, facts))
}

fn from_heights(
    header: &Header,
    options: &DecodeOptions,
    stride: u16,
    mut heights: Samples,
) -> Result<(NormalMap, Statistics), NormalsError> {
    let scale = options.height_scale / f64::from(header.kind.maximum().unwrap_or(1));
    let lattice = bits(header.kind, stride).map(|bits| Lattice {
        bits,
        step: (scale * f64::from(stride)).abs() / 2.0,
    });
    let mut repaired = 0;
    // Integers are heights whatever they are.
    if let Samples::F32(heights) = &mut heights {
        let bad = |height: &f32| !height.is_finite();
        let found = heights.par_iter().position_first(bad).map(|index| Bad {
            index,
            count: heights.par_iter().filter(|height| bad(height)).count() as u64,
            value: heights[index].to_string(),
            reason: "it is not a finite height",
        });
        repaired = mend(header, options, heights, found, |height| !bad(height))?;
    }
    let grid = height::Grid {
        width: header.width as usize,
        height: header.height as usize,
        wrap: options.wrap,
    };
    let texels = height::convert(&heights, grid, scale);
    drop(heights);
    let facts = Facts {
        lengths: None,
        lattice,
        clamped_to_rim: 0,
        repaired,
    };
    Ok(finish(header, options, texels, facts))
}

/// The bad texels of a map, by their first.
struct Bad {
    index: usize,
    count: u64,
    value: String,
    reason: &'static str,
}

/// Repairs bad texels if that is asked for; the number repaired.
fn mend<T: Copy>(
    header: &Header,
    options: &DecodeOptions,
    texels: &mut [T],
    bad: Option<Bad>,
    valid: impl Fn(&T) -> bool,
) -> Result<u64, NormalsError> {
    let Some(bad) = bad else {
        return Ok(0);
    };
    let name = header.name.clone();
    if bad.count == texels.len() as u64 {
        return Err(NormalsError::NoValidTexel {
            name,
            texels: bad.count,
            value: bad.value,
            reason: bad.reason,
        });
    }
    let width = header.width as usize;
    if !options.repair {
        return Err(NormalsError::BadTexels {
            name,
            column: (bad.index % width) as u32,
            row: (bad.index / width) as u32,
            value: bad.value,
            reason: bad.reason,
            others: bad.count - 1,
        });
    }
    let filled = repair(texels, width, options.wrap, valid);
    debug_assert_eq!(filled, Some(bad.count), "every bad texel is reached");
    Ok(bad.count)
}

/// What only the conversion knows.
struct Facts {
    lengths: Option<Lengths>,
    lattice: Option<Lattice>,
    clamped_to_rim: u64,
    repaired: u64,
}

fn finish(
    header: &Header,
    options: &DecodeOptions,
    texels: Vec<[f32; 2]>,
    facts: Facts,
) -> (NormalMap, Statistics) {
    let (width, height) = (header.width, header.height);
    let map = NormalMap::new(width, height, options.wrap, texels);
    let moments = Moments::of(&map);
    let statistics = Statistics {
        texels: u64::from(width) * u64::from(height),
        lengths: facts.lengths,
        clamped_to_rim: facts.clamped_to_rim,
        repaired: facts.repaired,
        mean: moments.mean,
        covariance: moments.covariance,
        mean_cosine: moments.mean_cosine,
        largest_tilt_degrees: moments.largest_tilt_degrees,
        lattice: facts.lattice,
    };
    (map, statistics)
}

/// Whether every sample of 16 bit at `places` is an 8-bit one widened.
fn is_widened(samples: &Samples, channels: usize, places: &[usize]) -> bool {
    let Samples::U16(samples) = samples else {
        return false;
    };
    // A true 16-bit map says no within its first texels.
    samples.par_chunks(CHUNK_TEXELS * channels).all(|chunk| {
        chunk
            .chunks_exact(channels)
            .all(|texel| places.iter().all(|&at| texel[at].is_multiple_of(WIDENING)))
    })
}

/// From one value of the lattice to the next, in values of the type.
fn stride(widened: Option<bool>) -> u16 {
    if widened == Some(true) { WIDENING } else { 1 }
}

fn bits(kind: SampleType, stride: u16) -> Option<u8> {
    match kind {
        SampleType::U8 => Some(8),
        SampleType::U16 if stride == WIDENING => Some(8),
        SampleType::U16 => Some(16),
        SampleType::F32 => None,
    }
}

/// The first of every `channels` samples.
fn first_channel(samples: Samples, channels: usize) -> Result<Samples, TryReserveError> {
    fn thin<T: Copy>(samples: Vec<T>, channels: usize) -> Result<Vec<T>, TryReserveError> {
        if channels == 1 {
            return Ok(samples);
        }
        let count = samples.len() / channels;
        let mut thinned = Vec::new();
        reserve(&mut thinned, count, count)?;
        thinned.extend(samples.iter().step_by(channels));
        Ok(thinned)
    }
    Ok(match samples {
        Samples::U8(samples) => Samples::U8(thin(samples, channels)?),
        Samples::U16(samples) => Samples::U16(thin(samples, channels)?),
        Samples::F32(samples) => Samples::F32(thin(samples, channels)?),
    })
}
