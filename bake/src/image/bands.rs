//! An image as bands of whole rows, from the top, whatever its format.

use super::error::ImageError;
use super::identity::{HashedFile, file_name};
use super::open_exr::ExrRows;
use super::paged::{Changed, PagedFile};
use super::png_rows::PngRows;
use super::raster::{Format, Header, Samples};
use super::read::{ReadOptions, from_io, open, recognise};
use super::tiff_rows::TiffRows;
use super::{complete, guard, whole};
use std::io::{Seek, SeekFrom};
use std::path::Path;

/// Texels of a band, where the format leaves the choice: 2 MiB of the widest integers, 4 MiB of floats.
const BAND_TEXELS: usize = 1 << 18;

/// A decoder that hands out rows.
pub(super) trait Source: Send {
    /// The samples of the next rows, any number of whole ones; none after the last.
    fn next(&mut self) -> Result<Option<Samples>, ImageError>;
}

/// How many rows make a band of about `band_texels`, at least one.
pub(super) fn rows_in_a_band(header: &Header, band_texels: usize) -> u32 {
    let rows = band_texels / header.width.max(1) as usize;
    u32::try_from(rows).unwrap_or(u32::MAX).max(1)
}

/// The rows of an image file, in bands from the top.
///
/// | format | memory besides the band |
/// |---|---|
/// | PNG | a few rows; interlaced or animated: the image |
/// | TIFF | a strip or a row of tiles; planar or CMYK: twice the image |
/// | EXR | a row of blocks; as much of the image as lies out of order in a file that is not written top down |
/// | TGA, WebP | the image, as one band |
/// | JPEG | the image, as one band, and the file |
///
/// Nothing of the image's size is allocated before its rows have arrived, except where it is one band; those pages
/// are the system's until they are written.
pub struct Bands {
    header: Header,
    shown: String,
    source: Box<dyn Source>,
    changed: Changed,
    rows_left: u32,
}

impl Bands {
    /// The image in the file at `path`, of which the header has been read.
    ///
    /// # Errors
    /// Every [`ImageError`] but [`ImageError::Changed`]; never a panic, whatever the file holds.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, ImageError> {
        Self::open_with(path, options, BAND_TEXELS)
    }

    /// The image in `file`, whose every byte must still be what it was when it was hashed.
    ///
    /// # Errors
    /// Every [`ImageError`].
    pub fn of(file: &HashedFile, options: &ReadOptions) -> Result<Self, ImageError> {
        Self::new(file.path(), file.reopen()?, options, BAND_TEXELS)
    }

    /// [`open`](Self::open) with bands of about `band_texels`.
    pub(crate) fn open_with(
        path: &Path,
        options: &ReadOptions,
        band_texels: usize,
    ) -> Result<Self, ImageError> {
        let (file, length) = open(path)?;
        let file = PagedFile::new(file, length, None);
        Self::new(path, file, options, band_texels)
    }

    fn new(
        path: &Path,
        mut file: PagedFile,
        options: &ReadOptions,
        band_texels: usize,
    ) -> Result<Self, ImageError> {
        let shown = path.display().to_string();
        let changed = file.changed();
        let format = recognise(path, &shown, &mut file).map_err(|error| {
            if changed.get() {
                ImageError::Changed {
                    file: shown.clone(),
                }
            } else {
                error
            }
        })?;
        let asks_for_exr = options.exr_layer.is_some() || options.exr_channels.is_some();
        if asks_for_exr && format != Format::OpenExr {
            return Err(ImageError::Selection {
                file: shown,
                detail: "a layer or channels were asked for, which only OpenEXR files have by name"
                    .to_owned(),
                available: format!("one {} image", format.name()),
            });
        }
        let name = file_name(path);
        let (header, source) = guarded(&shown, format, &changed, || {
            open_source(file, &shown, &name, format, options, band_texels)
        })?;
        Ok(Self {
            rows_left: header.height,
            header,
            shown,
            source,
            changed,
        })
    }

    /// What the image is.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The samples of the next rows, at least one; none after the last row, or after an error.
    ///
    /// # Errors
    /// [`ImageError`], also for an image that has fewer rows than its header says.
    pub fn next_band(&mut self) -> Result<Option<Samples>, ImageError> {
        if self.rows_left == 0 {
            return Ok(None);
        }
        let rows_left = std::mem::take(&mut self.rows_left);
        let (header, source) = (&self.header, &mut self.source);
        let band = guarded(&self.shown, header.format, &self.changed, || source.next())?;
        let length = band.as_ref().map_or(0, Samples::len);
        let rows = (length / header.row_length()) as u32;
        let whole = length > 0 && length.is_multiple_of(header.row_length());
        if !whole || rows > rows_left {
            return Err(ImageError::Corrupt {
                file: self.shown.clone(),
                format: header.format.name(),
                detail: format!(
                    "it has other rows than its header says, which are {}",
                    header.height
                ),
            });
        }
        self.rows_left = rows_left - rows;
        Ok(band)
    }
}

/// What `decode` gives, with panics turned into errors, and errors of a file that has changed into that.
fn guarded<T>(
    shown: &str,
    format: Format,
    changed: &Changed,
    decode: impl FnOnce() -> Result<T, ImageError>,
) -> Result<T, ImageError> {
    let decoded = guard::catch(decode).unwrap_or_else(|panic| {
        Err(ImageError::Corrupt {
            file: shown.to_owned(),
            format: format.name(),
            detail: format!("the decoder gave up on it ({panic})"),
        })
    });
    // Also if the decoder has forgiven it.
    if changed.get() {
        return Err(ImageError::Changed {
            file: shown.to_owned(),
        });
    }
    decoded
}

/// The decoder of `file`, by rows where there is one.
fn open_source(
    mut file: PagedFile,
    shown: &str,
    name: &str,
    format: Format,
    options: &ReadOptions,
    band_texels: usize,
) -> Result<(Header, Box<dyn Source>), ImageError> {
    let io_error = |source| from_io(shown, format, source);
    match format {
        Format::Png => {
            let found = complete::png(&mut file).map_err(io_error)?;
            options
                .limits
                .check(shown, found.width.into(), found.height.into())?;
            if !found.interlaced && !found.animated {
                file.seek(SeekFrom::Start(0)).map_err(io_error)?;
                let (header, rows) = PngRows::open(file, shown, name, band_texels)?;
                return Ok((header, Box::new(rows)));
            }
        }
        Format::Tiff => {
            // Seen through a reference, so that it is still there for the other decoder.
            if let Some((header, _)) =
                TiffRows::open(&mut file, shown, name, options.limits, band_texels)?
            {
                file.seek(SeekFrom::Start(0)).map_err(io_error)?;
                let again = TiffRows::open(file, shown, name, options.limits, band_texels)?;
                let (_, rows) = again.expect("the same bytes are of the same kind");
                return Ok((header, Box::new(rows)));
            }
        }
        Format::OpenExr => {
            let (header, rows) = ExrRows::open(file, shown, name, options, band_texels)?;
            return Ok((header, Box::new(rows)));
        }
        Format::Tga | Format::Jpeg | Format::WebP => {}
    }
    whole::open(file, shown, name, format, options.limits)
}
