//! The vectors of a map, converted and counted chunk by chunk.

use super::channels::Places;
use super::coding::Coding;
use crate::image::{Samples, each_type, reserve};
use rayon::prelude::*;
use std::collections::TryReserveError;

/// Texels converted, and summed up, as one piece of work. Fixed, so that no sum depends on the number of threads.
pub(super) const CHUNK_TEXELS: usize = 1 << 14;

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

/// Disk points of a map, NaN where there is none, as far as its samples have come.
///
/// Sums run over chunks of fixed size, counted from the first texel, each in the order of its texels: a chunk that
/// begins in one band goes on in the next, so that no figure depends on where bands end.
pub(super) struct Conversion {
    channels: usize,
    places: Places,
    coding: Coding,
    texels: Vec<[f32; 2]>,
    /// Texels there will be.
    total: usize,
    /// What was met in whole chunks.
    tally: Tally,
    /// What was met in the chunk that is not yet whole.
    chunk: Tally,
    first_bad: Option<FirstBad>,
}

/// The first texel that is no normal.
#[derive(Clone, Debug)]
pub(super) struct FirstBad {
    /// Its number, row by row.
    pub index: usize,
    /// Its samples as the file holds them: "(128, 127, 255)".
    pub value: String,
    /// What is wrong with them.
    pub reason: &'static str,
}

impl Conversion {
    /// No texels yet of `total`, which have `channels` samples each.
    pub(super) fn new(channels: usize, places: Places, coding: Coding, total: usize) -> Self {
        Self {
            channels,
            places,
            coding,
            texels: Vec::new(),
            total,
            tally: Tally::NONE,
            chunk: Tally::NONE,
            first_bad: None,
        }
    }

    /// Converts the next `samples`, of whole texels.
    pub(super) fn push(&mut self, samples: &Samples) -> Result<(), TryReserveError> {
        let first = self.texels.len();
        let more = samples.len() / self.channels;
        reserve(&mut self.texels, more, self.total)?;
        self.texels.resize(first + more, [0.0; 2]);
        each_type!(samples, samples => self.convert(samples, first));
        if self.first_bad.is_none() {
            let met = self.tally.then(&self.chunk).first_bad;
            self.first_bad = met.map(|index| self.look_at(samples, index, index - first));
        }
        Ok(())
    }

    /// The points, what was met (lengths are relative to 1), and the first texel that is none.
    pub(super) fn finish(self) -> (Vec<[f32; 2]>, Tally, Option<FirstBad>) {
        let mut tally = self.tally.then(&self.chunk);
        tally.length_sum /= self.coding.unit;
        tally.shortest /= self.coding.unit;
        tally.longest /= self.coding.unit;
        (self.texels, tally, self.first_bad)
    }

    /// The places of the components, and the coding.
    pub(super) fn rules(&self) -> (Places, Coding) {
        (self.places, self.coding)
    }

    /// [`chunked`](Self::chunked) for the number of channels known when compiling, which halves the time.
    fn convert<S: Copy + Sync + Into<f64>>(&mut self, samples: &[S], first: usize) {
        match self.channels {
            2 => self.chunked(samples.as_chunks::<2>().0, first),
            3 => self.chunked(samples.as_chunks::<3>().0, first),
            4 => self.chunked(samples.as_chunks::<4>().0, first),
            other => unreachable!("{other} channels hold no normal, and have been refused"),
        }
    }

    fn chunked<S: Copy + Sync + Into<f64>, const C: usize>(
        &mut self,
        samples: &[[S; C]],
        first: usize,
    ) {
        let (places, coding) = self.rules();
        let texels = &mut self.texels[first..];
        let begun = first % CHUNK_TEXELS;
        let rest = if begun == 0 { 0 } else { CHUNK_TEXELS - begun };
        let (end, texels) = texels.split_at_mut(rest.min(samples.len()));
        let (end_samples, samples) = samples.split_at(end.len());
        convert_chunk(end, end_samples, &places, &coding, &mut self.chunk, first);
        if end.len() < rest {
            return;
        }
        let first = first + rest;
        let tallies: Vec<Tally> = texels
            .par_chunks_mut(CHUNK_TEXELS)
            .zip(samples.par_chunks(CHUNK_TEXELS))
            .enumerate()
            .map(|(chunk, (texels, samples))| {
                let mut tally = Tally::NONE;
                let first = first + chunk * CHUNK_TEXELS;
                convert_chunk(texels, samples, &places, &coding, &mut tally, first);
                tally
            })
            .collect();
        for tally in tallies {
            self.tally = self.tally.then(&self.chunk);
            self.chunk = tally;
        }
    }

    /// Texel `index`, which is number `place` among `samples`.
    fn look_at(&self, samples: &Samples, index: usize, place: usize) -> FirstBad {
        let at = |channel: &usize| place * self.channels + channel;
        let values = each_type!(samples, samples => {
            let values = self.places.as_slice().iter();
            values.map(|channel| samples[at(channel)].to_string()).collect::<Vec<_>>()
        });
        let vector = self.coding.vector(
            &self.places,
            |channel| each_type!(samples, samples => samples[at(&channel)].into()),
        );
        FirstBad {
            index,
            value: format!("({})", values.join(", ")),
            reason: vector.err().unwrap_or("it is valid"),
        }
    }
}

/// Converts texels of one chunk, of which `first` is the number of the first, and counts them.
fn convert_chunk<S: Copy + Into<f64>, const C: usize>(
    texels: &mut [[f32; 2]],
    samples: &[[S; C]],
    places: &Places,
    coding: &Coding,
    tally: &mut Tally,
    first: usize,
) {
    let mut index = first;
    for (texels, samples) in texels.chunks_mut(BLOCK).zip(samples.chunks(BLOCK)) {
        let plain = match (<&mut Block<_>>::try_from(&mut *texels), samples.try_into()) {
            (Ok(texels), Ok(samples)) => plain_block(texels, samples, places, coding, tally),
            // The last texels of a chunk that a band has cut, or of the map.
            _ => false,
        };
        if !plain {
            any_block(texels, samples, places, coding, tally, index);
        }
        index += texels.len();
    }
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
