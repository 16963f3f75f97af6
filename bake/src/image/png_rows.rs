//! PNG, row by row.

use super::bands::{Source, rows_in_a_band};
use super::error::ImageError;
use super::raster::{Format, Header, Layout, SampleType, Samples};
use super::read::{WORKING_MEMORY, from_io};
use png::{BitDepth, ColorType, DecodingError, Transformations};
use std::io::{BufRead, Seek};

/// A PNG image that is neither interlaced nor animated.
pub(super) struct PngRows<R: BufRead + Seek> {
    reader: png::Reader<R>,
    shown: String,
    rows_at_once: u32,
    rows_left: u32,
    row_length: usize,
    kind: SampleType,
}

impl<R: BufRead + Seek> PngRows<R> {
    /// The image in `file`, which is at its start, and what it is.
    pub(super) fn open(
        file: R,
        shown: &str,
        name: &str,
        band_texels: usize,
    ) -> Result<(Header, Self), ImageError> {
        let limits = png::Limits {
            bytes: WORKING_MEMORY as usize,
        };
        let mut decoder = png::Decoder::new_with_limits(file, limits);
        // Neither has a say in a map, so neither may refuse it.
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        decoder.set_transformations(Transformations::EXPAND);
        let reader = decoder
            .read_info()
            .map_err(|error| from_png(shown, error))?;
        let (color, depth) = reader.output_color_type();
        let layout = match color {
            ColorType::Grayscale => Layout::Gray,
            ColorType::GrayscaleAlpha => Layout::GrayAlpha,
            ColorType::Rgb => Layout::Rgb,
            ColorType::Rgba => Layout::Rgba,
            ColorType::Indexed => unreachable!("palettes are expanded"),
        };
        let (width, height) = reader.info().size();
        let header = Header {
            name: name.to_owned(),
            width,
            height,
            format: Format::Png,
            layout,
            kind: if depth == BitDepth::Sixteen {
                SampleType::U16
            } else {
                SampleType::U8
            },
        };
        let rows = Self {
            reader,
            shown: shown.to_owned(),
            rows_at_once: rows_in_a_band(&header, band_texels),
            rows_left: height,
            row_length: header.row_length(),
            kind: header.kind,
        };
        Ok((header, rows))
    }
}

impl<R: BufRead + Seek + Send> Source for PngRows<R> {
    fn next(&mut self) -> Result<Option<Samples>, ImageError> {
        if self.rows_left == 0 {
            return Ok(None);
        }
        let rows = self.rows_at_once.min(self.rows_left);
        let mut samples = Samples::zeros(self.kind, rows as usize * self.row_length);
        let bytes = samples.as_mut_bytes();
        let row_bytes = bytes.len() / rows as usize;
        for row in bytes.chunks_exact_mut(row_bytes) {
            let read = self.reader.read_row(row);
            read.map_err(|error| from_png(&self.shown, error))?;
        }
        self.rows_left -= rows;
        if self.rows_left == 0 {
            // The checksum of the image data lies behind its last row.
            let read = self.reader.read_row(&mut []);
            read.map_err(|error| from_png(&self.shown, error))?;
        }
        if let Samples::U16(samples) = &mut samples {
            for sample in samples {
                *sample = u16::from_be(*sample);
            }
        }
        Ok(Some(samples))
    }
}

/// An error of the png crate in our words.
fn from_png(shown: &str, error: DecodingError) -> ImageError {
    let file = shown.to_owned();
    match error {
        DecodingError::IoError(source) => from_io(shown, Format::Png, source),
        DecodingError::LimitsExceeded => ImageError::TooLarge {
            file,
            detail: "decoding it needs more memory than a row of its size could".to_owned(),
        },
        error @ (DecodingError::Format(_) | DecodingError::Parameter(_)) => ImageError::Corrupt {
            file,
            format: Format::Png.name(),
            detail: error.to_string(),
        },
    }
}
