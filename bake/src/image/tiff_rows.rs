//! TIFF, by strips or rows of tiles.

use super::bands::{Source, rows_in_a_band};
use super::error::ImageError;
use super::raster::{Format, Header, Layout, SampleType, Samples};
use super::read::{Limits, from_io};
use std::io::{Read, Seek};
use tiff::decoder::{ChunkType, Decoder, DecodingResult};
use tiff::tags::{SampleFormat, Tag};
use tiff::{ColorType, TiffError};

/// Samples of all channels together, as opposed to one plane after the other.
const CHUNKY: u16 = 1;

/// A TIFF image of grey or colour in 8 or 16 bit, or of float colour, whose channels are interleaved.
pub(super) struct TiffRows<R: Read + Seek> {
    decoder: Decoder<R>,
    shown: String,
    rows_at_once: u32,
    width: usize,
    channels: usize,
    kind: SampleType,
    /// Tiles beside each other; 1 for strips.
    across: u32,
    /// The next strip, or the first tile of the next row of them.
    next_chunk: u32,
    rows_left: u32,
}

impl<R: Read + Seek> TiffRows<R> {
    /// The first image in `file`, and what it is; none if it is of a kind that has to be read as a whole.
    pub(super) fn open(
        file: R,
        shown: &str,
        name: &str,
        limits: Limits,
        band_texels: usize,
    ) -> Result<Option<(Header, Self)>, ImageError> {
        let from_tiff = |error| from_tiff(shown, error);
        let budget = usize::try_from(limits.budget()).unwrap_or(usize::MAX);
        let mut allowed = tiff::decoder::Limits::default();
        allowed.decoding_buffer_size = budget;
        allowed.intermediate_buffer_size = budget;
        allowed.ifd_value_size = budget;
        let mut decoder = Decoder::new(file).map_err(from_tiff)?.with_limits(allowed);
        let (width, height) = decoder.dimensions().map_err(from_tiff)?;
        limits.check(shown, width.into(), height.into())?;
        let Some((layout, kind)) = plain(&mut decoder) else {
            return Ok(None);
        };
        let (chunk_width, chunk_height) = decoder.chunk_dimensions();
        if width == 0 || height == 0 || chunk_width == 0 || chunk_height == 0 {
            return Ok(None);
        }
        let header = Header {
            name: name.to_owned(),
            width,
            height,
            format: Format::Tiff,
            layout,
            kind,
        };
        let across = match decoder.get_chunk_type() {
            ChunkType::Strip => 1,
            ChunkType::Tile => width.div_ceil(chunk_width),
        };
        let rows = Self {
            decoder,
            shown: shown.to_owned(),
            rows_at_once: rows_in_a_band(&header, band_texels),
            width: width as usize,
            channels: header.layout.channels(),
            kind,
            across,
            next_chunk: 0,
            rows_left: height,
        };
        Ok(Some((header, rows)))
    }

    /// The rows of the next strip or row of tiles.
    fn next_rows(&mut self) -> Result<(u32, Samples), ImageError> {
        let first = self.next_chunk;
        self.next_chunk += self.across;
        let (_, rows) = self.decoder.chunk_data_dimensions(first);
        let rows = rows.min(self.rows_left);
        if self.across == 1 {
            return Ok((rows, self.chunk(first, rows as usize * self.width)?));
        }
        let mut joined = Samples::zeros(self.kind, rows as usize * self.width * self.channels);
        let mut column = 0;
        for tile in first..first + self.across {
            let (tile_width, _) = self.decoder.chunk_data_dimensions(tile);
            let texels = self.chunk(tile, rows as usize * tile_width as usize)?;
            place(
                &mut joined,
                self.width * self.channels,
                column,
                &texels,
                rows as usize,
            );
            column += tile_width as usize * self.channels;
        }
        Ok((rows, joined))
    }

    /// The samples of one strip or tile of `texels` texels.
    fn chunk(&mut self, number: u32, texels: usize) -> Result<Samples, ImageError> {
        let read = self.decoder.read_chunk(number);
        let samples = match read.map_err(|error| from_tiff(&self.shown, error))? {
            DecodingResult::U8(samples) => Samples::U8(samples),
            DecodingResult::U16(samples) => Samples::U16(samples),
            DecodingResult::F32(samples) => Samples::F32(samples),
            _ => return Err(self.corrupt("its samples are not of one type")),
        };
        if samples.kind() != self.kind || samples.len() != texels * self.channels {
            return Err(self.corrupt("a strip or tile of it has another size than its header says"));
        }
        Ok(samples)
    }

    fn corrupt(&self, detail: &str) -> ImageError {
        ImageError::Corrupt {
            file: self.shown.clone(),
            format: Format::Tiff.name(),
            detail: detail.to_owned(),
        }
    }
}

impl<R: Read + Seek + Send> Source for TiffRows<R> {
    fn next(&mut self) -> Result<Option<Samples>, ImageError> {
        let mut band = Samples::none(self.kind);
        let mut rows = 0;
        let most = self.rows_at_once.min(self.rows_left) as usize * self.width * self.channels;
        while self.rows_left > 0 && rows < self.rows_at_once {
            let (more, samples) = self.next_rows()?;
            let appended = band.append(samples, most);
            appended.map_err(|_| ImageError::out_of_memory(&self.shown))?;
            rows += more;
            self.rows_left -= more;
        }
        Ok((rows > 0).then_some(band))
    }
}

/// Copies `texels`, as many rows of a tile, to the rows of `joined` that are `stride` long, from `column` on.
fn place(joined: &mut Samples, stride: usize, column: usize, texels: &Samples, rows: usize) {
    fn copy<T: Copy>(joined: &mut [T], stride: usize, column: usize, texels: &[T], rows: usize) {
        let length = texels.len() / rows;
        for (row, texels) in joined
            .chunks_exact_mut(stride)
            .zip(texels.chunks_exact(length))
        {
            row[column..column + length].copy_from_slice(texels);
        }
    }
    match (joined, texels) {
        (Samples::U8(joined), Samples::U8(texels)) => copy(joined, stride, column, texels, rows),
        (Samples::U16(joined), Samples::U16(texels)) => copy(joined, stride, column, texels, rows),
        (Samples::F32(joined), Samples::F32(texels)) => copy(joined, stride, column, texels, rows),
        _ => unreachable!("every tile has the type of the image, or was refused"),
    }
}

/// Layout and sample type, if the file needs no more than its chunks side by side.
fn plain<R: Read + Seek>(decoder: &mut Decoder<R>) -> Option<(Layout, SampleType)> {
    let (layout, bits) = match decoder.colortype().ok()? {
        ColorType::Gray(bits) => (Layout::Gray, bits),
        ColorType::GrayA(bits) => (Layout::GrayAlpha, bits),
        ColorType::RGB(bits) => (Layout::Rgb, bits),
        ColorType::RGBA(bits) => (Layout::Rgba, bits),
        _ => return None,
    };
    let planes = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration);
    if planes.ok()?.unwrap_or(CHUNKY) != CHUNKY {
        return None;
    }
    let formats = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat);
    let formats = formats.ok()?.unwrap_or_default();
    let all = |wanted| {
        let mut formats = formats.iter().copied();
        formats.all(|format| SampleFormat::from_u16(format) == Some(wanted))
    };
    match bits {
        8 if all(SampleFormat::Uint) => Some((layout, SampleType::U8)),
        16 if all(SampleFormat::Uint) => Some((layout, SampleType::U16)),
        32 if !formats.is_empty()
            && all(SampleFormat::IEEEFP)
            && matches!(layout, Layout::Rgb | Layout::Rgba) =>
        {
            Some((layout, SampleType::F32))
        }
        _ => None,
    }
}

/// An error of the tiff crate in our words.
fn from_tiff(shown: &str, error: TiffError) -> ImageError {
    let file = shown.to_owned();
    let format = Format::Tiff.name();
    match error {
        TiffError::IoError(source) => from_io(shown, Format::Tiff, source),
        TiffError::UnsupportedError(what) => ImageError::Unsupported {
            file,
            format,
            detail: what.to_string(),
        },
        TiffError::LimitsExceeded => ImageError::TooLarge {
            file,
            detail: "decoding it needs more than the limits allow".to_owned(),
        },
        error => ImageError::Corrupt {
            file,
            format,
            detail: error.to_string(),
        },
    }
}
