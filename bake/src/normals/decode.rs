//! From a raster to a normal map.

use super::channels::{Places, places};
use super::error::NormalsError;
use super::height;
use super::map::NormalMap;
use super::options::{Channels, DecodeOptions, GreenAxis, Input, Range, Zero};
use super::repair::repair;
use super::statistics::{Lattice, Lengths, Moments, Statistics};
use super::vectors::{self, Coding};
use crate::image::{Raster, Samples};
use rayon::prelude::*;

/// How many lattice steps beyond the rim of the disk a texel may lie and still be taken for a normal on the rim.
///
/// Rounding alone leaves half a step per component, a filter with negative lobes or one round of 8-bit filtering a
/// step or two; four is where an angle that is plainly wrong begins (8 bit: 1.8° below the surface).
pub const RIM_STEPS: f64 = 4.0;

/// The largest height of white: squares of the slopes of any f32 heights then stay far below the largest f64.
const LARGEST_HEIGHT_SCALE: f64 = 1e9;

/// 8-bit samples widened to 16 bit are multiples of this: 65535 / 255.
const WIDENING: u16 = 257;

/// The normals of `raster`, and what they are like; see the [module](super) for every rule.
///
/// Takes the raster to drop it: the peak is the raster and 8 bytes a texel.
///
/// # Errors
/// [`NormalsError`]; with [`DecodeOptions::repair`], bad texels are one only if there are no others.
pub fn decode(
    raster: Raster,
    options: &DecodeOptions,
) -> Result<(NormalMap, Statistics), NormalsError> {
    check(&raster, options)?;
    match options.input {
        Input::Normals => from_vectors(raster, options),
        Input::Height => from_heights(raster, options),
    }
}

/// Refuses options that the input gives no meaning to.
fn check(raster: &Raster, options: &DecodeOptions) -> Result<(), NormalsError> {
    let refuse = |option: String, reason: &str| {
        Err(NormalsError::Option {
            name: raster.name().to_owned(),
            option,
            reason: reason.to_owned(),
        })
    };
    let integers = raster.samples().maximum().is_some();
    if options.input == Input::Height {
        let reasonable = -LARGEST_HEIGHT_SCALE..=LARGEST_HEIGHT_SCALE;
        if !reasonable.contains(&options.height_scale) {
            return refuse(
                format!("--height-scale {}", options.height_scale),
                "is not a number of texels; give the height of white, at most 1e9",
            );
        }
        if options.channels != Channels::Xyz {
            return refuse(
                format!("--channels {}", options.channels),
                "has no meaning for a height map, whose first channel counts; leave it out",
            );
        }
        if options.green != GreenAxis::Gl {
            return refuse(
                format!("--y {}", options.green),
                "has no meaning for a height map, whose rows tell what is up; leave it out",
            );
        }
        if options.range == Range::Snorm {
            return refuse(
                format!("--range {}", options.range),
                "has no meaning for a height map, where 0 is black and 1 is white; leave it out",
            );
        }
        if options.zero != Zero::Half {
            return refuse(
                format!("--zero {}", options.zero),
                "has no meaning for a height map, where only differences count; leave it out",
            );
        }
        return Ok(());
    }
    if integers && options.range == Range::Snorm {
        return refuse(
            format!("--range {}", options.range),
            "needs floats, and the samples are unsigned integers; leave it out",
        );
    }
    if !integers && options.zero != Zero::Half {
        return refuse(
            format!("--zero {}", options.zero),
            "chooses between integers, and the samples are floats; leave it out",
        );
    }
    Ok(())
}

fn from_vectors(
    raster: Raster,
    options: &DecodeOptions,
) -> Result<(NormalMap, Statistics), NormalsError> {
    let places = places(options.channels, raster.layout(), raster.name())?;
    let channels = raster.layout().channels();
    let stride = lattice_stride(raster.samples(), channels, places.as_slice());
    let coding = Coding::new(raster.samples(), options, stride);
    let lattice = bits(raster.samples(), stride).map(|bits| Lattice {
        bits,
        step: coding.step(),
    });
    let (mut texels, tally) = vectors::convert(raster.samples(), channels, &places, &coding);
    let bad = tally.first_bad.map(|index| Bad {
        index,
        count: tally.bad,
        value: value(raster.samples(), channels, places.as_slice(), index),
        reason: vectors::fault(raster.samples(), channels, &places, &coding, index),
    });
    let repaired = mend(&raster, options, &mut texels, bad, |[s, _]| !s.is_nan())?;
    let lengths = match places {
        Places::Three(_) => Some(Lengths {
            mean: tally.length_sum / tally.valid as f64,
            shortest: tally.shortest,
            longest: tally.longest,
        }),
        Places::Two(_) => None,
    };
    Ok(finish(
        raster,
        options,
        texels,
        Facts {
            lengths,
            lattice,
            clamped_to_rim: tally.clamped,
            repaired,
        },
    ))
}

fn from_heights(
    mut raster: Raster,
    options: &DecodeOptions,
) -> Result<(NormalMap, Statistics), NormalsError> {
    let mut channels = raster.layout().channels();
    let scale = options.height_scale / f64::from(raster.samples().maximum().unwrap_or(1));
    let stride = lattice_stride(raster.samples(), channels, &[0]);
    let lattice = bits(raster.samples(), stride).map(|bits| Lattice {
        bits,
        step: (scale * f64::from(stride)).abs() / 2.0,
    });
    let mut repaired = 0;
    // Integers are heights whatever they are.
    if let Samples::F32(heights) = &mut raster.samples {
        let mut heights = std::mem::take(heights);
        keep_first(&mut heights, channels);
        channels = 1;
        let bad = |height: &f32| !height.is_finite();
        let found = heights.par_iter().position_first(bad).map(|index| Bad {
            index,
            count: heights.par_iter().filter(|height| bad(height)).count() as u64,
            value: heights[index].to_string(),
            reason: "it is not a finite height",
        });
        repaired = mend(&raster, options, &mut heights, found, |height| !bad(height))?;
        raster.samples = Samples::F32(heights);
    }
    let grid = height::Grid {
        width: raster.width() as usize,
        height: raster.height() as usize,
        channels,
        wrap: options.wrap,
    };
    let texels = height::convert(raster.samples(), grid, scale);
    Ok(finish(
        raster,
        options,
        texels,
        Facts {
            lengths: None,
            lattice,
            clamped_to_rim: 0,
            repaired,
        },
    ))
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
    raster: &Raster,
    options: &DecodeOptions,
    texels: &mut [T],
    bad: Option<Bad>,
    valid: impl Fn(&T) -> bool,
) -> Result<u64, NormalsError> {
    let Some(bad) = bad else {
        return Ok(0);
    };
    let name = raster.name().to_owned();
    if bad.count == texels.len() as u64 {
        return Err(NormalsError::NoValidTexel {
            name,
            texels: bad.count,
            value: bad.value,
            reason: bad.reason,
        });
    }
    let width = raster.width() as usize;
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
    raster: Raster,
    options: &DecodeOptions,
    texels: Vec<[f32; 2]>,
    facts: Facts,
) -> (NormalMap, Statistics) {
    let (width, height) = (raster.width(), raster.height());
    drop(raster);
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

/// 257 if the samples are 16 bit but hold 8 bit, else 1.
fn lattice_stride(samples: &Samples, channels: usize, places: &[usize]) -> u16 {
    let Samples::U16(samples) = samples else {
        return 1;
    };
    // A true 16-bit map says no within its first texels.
    let widened = samples
        .par_chunks(vectors::CHUNK_TEXELS * channels)
        .all(|chunk| {
            chunk
                .chunks_exact(channels)
                .all(|texel| places.iter().all(|&at| texel[at].is_multiple_of(WIDENING)))
        });
    if widened { WIDENING } else { 1 }
}

fn bits(samples: &Samples, stride: u16) -> Option<u8> {
    match samples {
        Samples::U8(_) => Some(8),
        Samples::U16(_) if stride == WIDENING => Some(8),
        Samples::U16(_) => Some(16),
        Samples::F32(_) => None,
    }
}

/// The samples of texel `index` at `places`, as the file holds them: "(128, 127, 255)".
fn value(samples: &Samples, channels: usize, places: &[usize], index: usize) -> String {
    let one = |place: &usize| {
        let at = index * channels + place;
        match samples {
            Samples::U8(samples) => samples[at].to_string(),
            Samples::U16(samples) => samples[at].to_string(),
            Samples::F32(samples) => samples[at].to_string(),
        }
    };
    let values: Vec<_> = places.iter().map(one).collect();
    format!("({})", values.join(", "))
}

/// Drops all but the first of every `channels` samples, in place.
fn keep_first(samples: &mut Vec<f32>, channels: usize) {
    if channels > 1 {
        let texels = samples.len() / channels;
        for texel in 0..texels {
            samples[texel] = samples[texel * channels];
        }
        samples.truncate(texels);
        samples.shrink_to_fit();
    }
}
