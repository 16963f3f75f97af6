//! EXR: the layer and channels asked for, row by row, straight to interleaved floats.
//!
//! Works on blocks rather than on the crate's image types, so that memory is the rows of the chosen channels that are
//! not yet complete, and so that the header is checked before anything of its size is allocated.

use super::bands::{Source, rows_in_a_band};
use super::error::ImageError;
use super::exr_channels::{Selection, select};
use super::raster::{Format, Header, Layout, SampleType, Samples};
use super::read::ReadOptions;
use exr::block::UncompressedBlock;
use exr::block::reader::ChunksReader;
use exr::meta::attribute::{ChannelList, SampleType as ExrType};
use exr::meta::header::Header as Part;
use exr::prelude::f16;
use std::collections::VecDeque;
use std::io::{self, Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The most bytes of one block of scan lines or one tile, over all its channels.
const LARGEST_BLOCK: usize = 1 << 30;

/// Notices when a decoder ran into the end of the file, which the exr crate reports like any other fault.
struct EndWatch<R> {
    inner: R,
    hit_end: Arc<AtomicBool>,
}

impl<R: Read> Read for EndWatch<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        if count == 0 && !buffer.is_empty() {
            self.hit_end.store(true, Ordering::Relaxed);
        }
        Ok(count)
    }
}

impl<R: Seek> Seek for EndWatch<R> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.inner.seek(position)
    }
}

/// Rows of an EXR image, put together from blocks as they lie in the file.
///
/// Files are written top down as a rule; of any other, rows wait here until those above them have come.
pub(super) struct ExrRows {
    blocks: Box<dyn Iterator<Item = exr::error::Result<UncompressedBlock>> + Send>,
    hit_end: Arc<AtomicBool>,
    shown: String,
    channels: ChannelList,
    /// Where each channel of the file goes in a texel; one may be asked for more than once.
    places: Vec<Vec<usize>>,
    width: usize,
    height: usize,
    /// Samples of a texel.
    stride: usize,
    rows_at_once: usize,
    /// Number of the first row that waits.
    first_row: usize,
    waiting: VecDeque<Row>,
}

/// A row in the making; without samples until the first of them comes.
#[derive(Default)]
struct Row {
    samples: Vec<f32>,
    filled: usize,
}

impl ExrRows {
    /// The chosen channels of the EXR image in `file`, and what they are.
    pub(super) fn open(
        file: impl Read + Seek + Send + 'static,
        shown: &str,
        name: &str,
        options: &ReadOptions,
        band_texels: usize,
    ) -> Result<(Header, Self), ImageError> {
        let hit_end = Arc::new(AtomicBool::new(false));
        let from_exr = |error| from_exr(shown, hit_end.load(Ordering::Relaxed), error);
        let watched = EndWatch {
            inner: file,
            hit_end: hit_end.clone(),
        };
        let reader = exr::block::read(watched, false).map_err(from_exr)?;
        let selection = select(shown, reader.headers(), options)?;
        let part = &reader.headers()[selection.part];
        check(shown, part, &selection, options)?;

        let (width, height) = (part.layer_size.width(), part.layer_size.height());
        let channels = part.channels.clone();
        let names = selection
            .channels
            .iter()
            .map(|&channel| channels.list[channel].name.to_string())
            .collect();
        let mut places = vec![Vec::new(); channels.list.len()];
        for (place, &channel) in selection.channels.iter().enumerate() {
            places[channel].push(place);
        }
        let header = Header {
            name: name.to_owned(),
            width: width as u32,
            height: height as u32,
            format: Format::OpenExr,
            layout: Layout::Named(names),
            kind: SampleType::F32,
        };
        let mut blocks = reader
            .filter_chunks(false, |_, _, block| {
                block.layer == selection.part && block.level.0 == 0 && block.level.1 == 0
            })
            .map_err(from_exr)?
            .sequential_decompressor(false);
        let rows = Self {
            blocks: Box::new(std::iter::from_fn(move || blocks.decompress_next_block())),
            hit_end: hit_end.clone(),
            shown: shown.to_owned(),
            channels,
            places,
            width,
            height,
            stride: selection.channels.len(),
            rows_at_once: rows_in_a_band(&header, band_texels) as usize,
            first_row: 0,
            waiting: VecDeque::new(),
        };
        Ok((header, rows))
    }

    /// Puts the samples of `block` into their rows.
    fn place(&mut self, block: &UncompressedBlock) -> Result<(), ImageError> {
        for line in block.lines(&self.channels) {
            let (column, row) = (line.location.position.x(), line.location.position.y());
            let count = line.location.sample_count;
            let places = &self.places[line.location.channel];
            if places.is_empty() {
                continue;
            }
            if row < self.first_row || row >= self.height || column + count > self.width {
                return Err(self.corrupt(format!("row {row} is in more blocks than one")));
            }
            let index = row - self.first_row;
            if self.waiting.len() <= index {
                self.waiting.resize_with(index + 1, Row::default);
            }
            let row = &mut self.waiting[index];
            if row.samples.is_empty() {
                row.samples = vec![0.0; self.width * self.stride];
            }
            row.filled += count * places.len();
            let texels = &mut row.samples[column * self.stride..][..count * self.stride];
            for &place in places {
                let targets = texels.iter_mut().skip(place).step_by(self.stride);
                match self.channels.list[line.location.channel].sample_type {
                    ExrType::F16 => {
                        let (values, _) = line.value.as_chunks::<2>();
                        for (target, &bytes) in targets.zip(values) {
                            *target = f16::from_ne_bytes(bytes).to_f32();
                        }
                    }
                    // Integer channels have been refused by now.
                    ExrType::F32 | ExrType::U32 => {
                        let (values, _) = line.value.as_chunks::<4>();
                        for (target, &bytes) in targets.zip(values) {
                            *target = f32::from_ne_bytes(bytes);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Complete rows at the head of those that wait, up to a band of them.
    fn complete_rows(&self) -> usize {
        let full = self.width * self.stride;
        let waiting = self.waiting.iter().take(self.rows_at_once);
        waiting.take_while(|row| row.filled == full).count()
    }

    fn corrupt(&self, detail: String) -> ImageError {
        ImageError::Corrupt {
            file: self.shown.clone(),
            format: Format::OpenExr.name(),
            detail,
        }
    }
}

impl Source for ExrRows {
    fn next(&mut self) -> Result<Option<Samples>, ImageError> {
        let wanted = self.rows_at_once.min(self.height - self.first_row);
        while self.complete_rows() < wanted {
            let Some(block) = self.blocks.next() else {
                // Blocks that no offset leads to leave texels unset, and would bake as if they were zero.
                return Err(self.corrupt(format!(
                    "row {} is not all there",
                    self.first_row + self.complete_rows()
                )));
            };
            let block = block.map_err(|error| {
                from_exr(&self.shown, self.hit_end.load(Ordering::Relaxed), error)
            })?;
            self.place(&block)?;
        }
        let mut band = Vec::with_capacity(wanted * self.width * self.stride);
        for row in self.waiting.drain(..wanted) {
            band.extend_from_slice(&row.samples);
        }
        self.first_row += wanted;
        Ok((wanted > 0).then_some(Samples::F32(band)))
    }
}

/// Refuses what cannot be a map, before memory is asked for.
fn check(
    shown: &str,
    header: &Part,
    selection: &Selection,
    options: &ReadOptions,
) -> Result<(), ImageError> {
    let size = header.layer_size;
    options
        .limits
        .check(shown, size.width() as u64, size.height() as u64)?;
    let block = header.max_block_pixel_size();
    let block_bytes = block
        .width()
        .min(size.width())
        .saturating_mul(block.height().min(size.height()))
        .saturating_mul(header.channels.bytes_per_pixel);
    if block_bytes > LARGEST_BLOCK {
        return Err(ImageError::TooLarge {
            file: shown.to_owned(),
            detail: format!(
                "one block of its {} channels takes {block_bytes} bytes, beyond the limit of {LARGEST_BLOCK}",
                header.channels.list.len()
            ),
        });
    }
    let unsupported = |detail: String| {
        Err(ImageError::Unsupported {
            file: shown.to_owned(),
            format: Format::OpenExr.name(),
            detail,
        })
    };
    let (data, display) = (
        header.data_window(),
        header.shared_attributes.display_window,
    );
    if data != display {
        return unsupported(format!(
            "its data window ({} x {} at {}, {}) is not its display window ({} x {} at {}, {})",
            data.size.width(),
            data.size.height(),
            data.position.x(),
            data.position.y(),
            display.size.width(),
            display.size.height(),
            display.position.x(),
            display.position.y(),
        ));
    }
    if let Some(channel) = header
        .channels
        .list
        .iter()
        .find(|channel| channel.sampling.x() != 1 || channel.sampling.y() != 1)
    {
        return unsupported(format!("channel {} is subsampled", channel.name));
    }
    for &channel in &selection.channels {
        let channel = &header.channels.list[channel];
        if channel.sample_type == ExrType::U32 {
            return unsupported(format!("channel {} holds integers", channel.name));
        }
    }
    Ok(())
}

/// An error of the exr crate in our words.
fn from_exr(shown: &str, hit_end: bool, error: exr::error::Error) -> ImageError {
    let file = shown.to_owned();
    let format = Format::OpenExr.name();
    match error {
        exr::error::Error::Io(source) => super::read::from_io(shown, Format::OpenExr, source),
        exr::error::Error::NotSupported(detail) => ImageError::Unsupported {
            file,
            format,
            detail: detail.into_owned(),
        },
        _ if hit_end => ImageError::Truncated {
            file,
            format,
            detail: "it ends before its image does".to_owned(),
        },
        error => ImageError::Corrupt {
            file,
            format,
            detail: error.to_string(),
        },
    }
}
