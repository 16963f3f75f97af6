//! EXR: the layer and channels asked for, straight to interleaved floats.
//!
//! Works on blocks rather than on the crate's image types, so that memory is the chosen channels plus one block,
//! and so that the header is checked before anything of its size is allocated.

use super::error::ImageError;
use super::exr_channels::{Selection, select};
use super::raster::{Format, Layout, Raster, Samples};
use super::read::ReadOptions;
use exr::block::reader::ChunksReader;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::f16;
use std::cell::Cell;
use std::io::{self, Read, Seek, SeekFrom};

/// The most bytes of one block of scan lines or one tile, over all its channels.
const LARGEST_BLOCK: usize = 1 << 30;

/// Notices when a decoder ran into the end of the file, which the exr crate reports like any other fault.
struct EndWatch<'a, R> {
    inner: R,
    hit_end: &'a Cell<bool>,
}

impl<R: Read> Read for EndWatch<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        if count == 0 && !buffer.is_empty() {
            self.hit_end.set(true);
        }
        Ok(count)
    }
}

impl<R: Seek> Seek for EndWatch<'_, R> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.inner.seek(position)
    }
}

/// The chosen channels of the EXR image in `file`, as floats.
pub(super) fn read(
    file: impl Read + Seek,
    shown: &str,
    name: &str,
    options: &ReadOptions,
) -> Result<Raster, ImageError> {
    let hit_end = Cell::new(false);
    let from_exr = |error| from_exr(shown, hit_end.get(), error);
    let watched = EndWatch {
        inner: file,
        hit_end: &hit_end,
    };
    let reader = exr::block::read(watched, false).map_err(from_exr)?;
    let selection = select(shown, reader.headers(), options)?;
    let header = &reader.headers()[selection.part];
    check(shown, header, &selection, options)?;

    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    let stride = selection.channels.len();
    let names = selection
        .channels
        .iter()
        .map(|&channel| header.channels.list[channel].name.to_string())
        .collect();
    let mut samples = vec![0_f32; width * height * stride];
    // Where a channel of the file goes in a texel; a channel may be asked for more than once.
    let mut places = vec![Vec::new(); header.channels.list.len()];
    for (place, &channel) in selection.channels.iter().enumerate() {
        places[channel].push(place);
    }

    let mut filled = 0_u64;
    reader
        .filter_chunks(false, |_, _, block| {
            block.layer == selection.part && block.level.0 == 0 && block.level.1 == 0
        })
        .map_err(from_exr)?
        .decompress_sequential(false, |meta, block| {
            let channels = &meta.headers[selection.part].channels;
            for line in block.lines(channels) {
                let start = line.location.position.y() * width + line.location.position.x();
                let texels =
                    &mut samples[start * stride..(start + line.location.sample_count) * stride];
                for &place in &places[line.location.channel] {
                    filled += line.location.sample_count as u64;
                    let targets = texels.iter_mut().skip(place).step_by(stride);
                    match channels.list[line.location.channel].sample_type {
                        SampleType::F16 => {
                            let (values, _) = line.value.as_chunks::<2>();
                            for (target, &bytes) in targets.zip(values) {
                                *target = f16::from_ne_bytes(bytes).to_f32();
                            }
                        }
                        // Integer channels have been refused by now.
                        SampleType::F32 | SampleType::U32 => {
                            let (values, _) = line.value.as_chunks::<4>();
                            for (target, &bytes) in targets.zip(values) {
                                *target = f32::from_ne_bytes(bytes);
                            }
                        }
                    }
                }
            }
            Ok(())
        })
        .map_err(from_exr)?;
    // Blocks that no offset leads to leave texels unset, and would bake as if they were zero.
    if filled != samples.len() as u64 {
        return Err(ImageError::Corrupt {
            file: shown.to_owned(),
            format: Format::OpenExr.name(),
            detail: format!("{filled} of {} samples are there", samples.len()),
        });
    }
    Ok(Raster::new(
        name,
        width as u32,
        height as u32,
        Format::OpenExr,
        Layout::Named(names),
        Samples::F32(samples),
    ))
}

/// Refuses what cannot be a map, before memory is asked for.
fn check(
    shown: &str,
    header: &Header,
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
        if channel.sample_type == SampleType::U32 {
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
