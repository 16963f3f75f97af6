//! Formats, and kinds of files, whose decoders give all rows at once.

use super::bands::Source;
use super::complete;
use super::error::ImageError;
use super::paged::PagedFile;
use super::raster::{Format, Header, Layout, SampleType, Samples};
use super::read::{Limits, from_image, from_io};
use ::image::codecs::jpeg::JpegDecoder;
use ::image::codecs::png::PngDecoder;
use ::image::codecs::tga::TgaDecoder;
use ::image::codecs::tiff::TiffDecoder;
use ::image::codecs::webp::WebPDecoder;
use ::image::{ColorType, ImageDecoder};
use std::io::{Seek, SeekFrom};

/// An image of which the header has been read, and nothing else.
struct Whole<D> {
    /// None once the image has been handed out.
    decoder: Option<D>,
    shown: String,
    format: Format,
    kind: SampleType,
    sample_count: usize,
}

/// The decoder of `file` by the image crate, and what the image is.
pub(super) fn open(
    mut file: PagedFile,
    shown: &str,
    name: &str,
    format: Format,
    limits: Limits,
) -> Result<(Header, Box<dyn Source>), ImageError> {
    let io_error = |source| from_io(shown, format, source);
    match format {
        Format::Jpeg => {
            // The decoder reads the whole file first.
            if file.length() > limits.longest_file() {
                return Err(ImageError::TooLarge {
                    file: shown.to_owned(),
                    detail: format!(
                        "{} bytes is more than the largest image would need",
                        file.length()
                    ),
                });
            }
            complete::jpeg(&mut file).map_err(io_error)?;
        }
        Format::WebP => {
            let length = file.length();
            complete::webp(&mut file, length).map_err(io_error)?;
        }
        Format::Png | Format::Tiff | Format::Tga | Format::OpenExr => {}
    }
    file.seek(SeekFrom::Start(0)).map_err(io_error)?;

    // Sides are left to our own check, which can name them.
    let mut budget = ::image::Limits::no_limits();
    budget.max_alloc = Some(limits.budget());
    let from_image = |error| from_image(shown, format, error);
    let describe = Describe {
        shown,
        name,
        format,
        limits,
        budget: budget.clone(),
    };
    match format {
        Format::Png => describe.source(PngDecoder::with_limits(file, budget).map_err(from_image)?),
        Format::Tiff => describe.source(TiffDecoder::new(file).map_err(from_image)?),
        Format::Jpeg => describe.source(JpegDecoder::new(file).map_err(from_image)?),
        Format::WebP => describe.source(WebPDecoder::new(file).map_err(from_image)?),
        Format::Tga => describe.source(TgaDecoder::new(file).map_err(from_image)?),
        Format::OpenExr => unreachable!("read by its own decoder"),
    }
}

/// What is known of an image before its decoder is asked.
struct Describe<'a> {
    shown: &'a str,
    name: &'a str,
    format: Format,
    limits: Limits,
    budget: ::image::Limits,
}

impl Describe<'_> {
    /// The header that `decoder` has read, and the decoder as a source.
    fn source<D: ImageDecoder + Send + 'static>(
        self,
        mut decoder: D,
    ) -> Result<(Header, Box<dyn Source>), ImageError> {
        let Self { shown, format, .. } = self;
        decoder
            .set_limits(self.budget)
            .map_err(|error| from_image(shown, format, error))?;
        let (width, height) = decoder.dimensions();
        self.limits.check(shown, width.into(), height.into())?;
        if width == 0 || height == 0 {
            return Err(ImageError::Corrupt {
                file: shown.to_owned(),
                format: format.name(),
                detail: format!("its header says {width} x {height} texels"),
            });
        }
        let color = decoder.color_type();
        let layout = match color.channel_count() {
            1 => Layout::Gray,
            2 => Layout::GrayAlpha,
            3 => Layout::Rgb,
            _ => Layout::Rgba,
        };
        let kind = match color {
            ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => SampleType::U8,
            ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
                SampleType::U16
            }
            ColorType::Rgb32F | ColorType::Rgba32F => SampleType::F32,
            other => {
                return Err(ImageError::Unsupported {
                    file: shown.to_owned(),
                    format: format.name(),
                    detail: format!("its samples are {other:?}"),
                });
            }
        };
        let header = Header {
            name: self.name.to_owned(),
            width,
            height,
            format,
            layout,
            kind,
        };
        let source = Whole {
            decoder: Some(decoder),
            shown: shown.to_owned(),
            format,
            kind,
            sample_count: header.sample_count(),
        };
        Ok((header, Box::new(source)))
    }
}

impl<D: ImageDecoder + Send> Source for Whole<D> {
    fn next(&mut self) -> Result<Option<Samples>, ImageError> {
        let Some(decoder) = self.decoder.take() else {
            return Ok(None);
        };
        let mut samples = Samples::zeros(self.kind, self.sample_count);
        decoder
            .read_image(samples.as_mut_bytes())
            .map_err(|error| from_image(&self.shown, self.format, error))?;
        Ok(Some(samples))
    }
}
