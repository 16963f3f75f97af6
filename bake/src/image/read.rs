//! Opening and recognising a file, and the limits it must keep.

use super::bands::Bands;
use super::error::ImageError;
use super::paged::PagedFile;
use super::raster::{Format, Raster, Samples};
use ::image::ImageFormat;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// The largest image that is decoded.
///
/// A header beyond it is refused before anything of its size is allocated. Memory goes by texels, whatever the shape
/// of the map, and grows with the rows that have really come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Texels in all.
    pub texels: u64,
}

impl Default for Limits {
    /// 65 535 × 65 535, the largest map a package can hold, but no more texels than 16 384 × 16 384.
    fn default() -> Self {
        Self {
            width: 65_535,
            height: 65_535,
            texels: 1 << 28,
        }
    }
}

/// Bytes of a texel of four floats, the widest raster there is.
const WIDEST_TEXEL: u64 = 16;

/// What decoders may allocate besides the image: tables, rows, profiles. Generous, but not an image.
pub(super) const WORKING_MEMORY: u64 = 64 << 20;

impl Limits {
    /// Refuses a size beyond the limits.
    pub(super) fn check(self, file: &str, width: u64, height: u64) -> Result<(), ImageError> {
        let beyond = if width > u64::from(self.width) || height > u64::from(self.height) {
            format!("the limit of {} x {}", self.width, self.height)
        } else if width * height > self.most_texels() {
            format!(
                "the {} in all that the memory limit leaves room for (see --memory)",
                self.most_texels()
            )
        } else {
            return Ok(());
        };
        Err(ImageError::TooLarge {
            file: file.to_owned(),
            detail: format!("its header says {width} x {height} texels, beyond {beyond}"),
        })
    }

    /// The texels allowed, and no more than memory has addresses for.
    fn most_texels(self) -> u64 {
        let sides = u64::from(self.width) * u64::from(self.height);
        self.texels.min(sides).min(isize::MAX as u64 / WIDEST_TEXEL)
    }

    /// The most bytes that decoding the largest image may take.
    pub(super) fn budget(self) -> u64 {
        (self.most_texels() * WIDEST_TEXEL).saturating_add(WORKING_MEMORY)
    }

    /// The longest file that is read into memory: no compressed image is larger than an uncompressed one.
    pub(super) fn longest_file(self) -> u64 {
        (self.most_texels() * 4).saturating_add(WORKING_MEMORY)
    }
}

/// What to read of a file.
///
/// The two choices for EXR are refused for any other format. A layer is a part of that name, or else the
/// channels whose names start with it and a dot. Channels are named in the order in which they are wanted, in full
/// (`N.X`) or within the layer (`X`).
///
/// Without names, the first that exists of (X, Y, Z), (x, y, z), (R, G, B), (r, g, b), (X, Y), (x, y), (R, G),
/// (r, g) is taken, then a layer's only channel. Without a layer they are looked for among the names without a dot
/// in each part, first part first, then in every layer; two layers that fit are an error that lists them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The layer of an EXR file.
    pub exr_layer: Option<String>,
    /// One to four channels of an EXR file, in order.
    pub exr_channels: Option<Vec<String>>,
    /// The largest image accepted.
    pub limits: Limits,
}

/// The image in the file at `path`, with its samples in their own type.
///
/// The peak is the raster and what [`Bands`] needs besides.
///
/// # Errors
/// Every [`ImageError`] but [`ImageError::Changed`]; never a panic, whatever the file holds.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Raster, ImageError> {
    let mut bands = Bands::open(path, options)?;
    let header = bands.header().clone();
    let mut samples = Samples::none(header.kind);
    while let Some(band) = bands.next_band()? {
        let appended = samples.append(band, header.sample_count());
        appended.map_err(|_| ImageError::out_of_memory(&path.display().to_string()))?;
    }
    Ok(Raster::from_parts(header, samples))
}

/// The opened file and its length.
pub(super) fn open(path: &Path) -> Result<(File, u64), ImageError> {
    let file = || path.display().to_string();
    let cannot_open = |source| ImageError::Open {
        file: file(),
        source,
    };
    // Asked before opening, for opening a pipe that nobody writes to would wait for ever.
    let metadata = std::fs::metadata(path).map_err(cannot_open)?;
    if !metadata.is_file() {
        return Err(ImageError::NotAFile {
            file: file(),
            found: if metadata.is_dir() {
                "a folder"
            } else {
                "a pipe or a device"
            },
        });
    }
    Ok((File::open(path).map_err(cannot_open)?, metadata.len()))
}

/// The format by the first bytes; TGA, which has no signature, by the file name.
pub(super) fn recognise(
    path: &Path,
    shown: &str,
    file: &mut PagedFile,
) -> Result<Format, ImageError> {
    let unknown = |found: String| ImageError::UnknownFormat {
        file: shown.to_owned(),
        found,
    };
    let io_error = |source| ImageError::Io {
        file: shown.to_owned(),
        source,
    };
    if file.length() == 0 {
        return Err(unknown("is empty".to_owned()));
    }
    let mut start = Vec::with_capacity(16);
    file.by_ref()
        .take(16)
        .read_to_end(&mut start)
        .map_err(io_error)?;
    file.seek(SeekFrom::Start(0)).map_err(io_error)?;
    match ::image::guess_format(&start) {
        Ok(ImageFormat::Png) => Ok(Format::Png),
        Ok(ImageFormat::Tiff) => Ok(Format::Tiff),
        Ok(ImageFormat::Jpeg) => Ok(Format::Jpeg),
        Ok(ImageFormat::WebP) => Ok(Format::WebP),
        Ok(ImageFormat::OpenExr) => Ok(Format::OpenExr),
        Ok(other) => Err(unknown(format!("looks like {other:?}, which is not read"))),
        Err(_) => {
            let extension = path
                .extension()
                .map(|extension| extension.to_string_lossy().to_ascii_lowercase());
            match extension.as_deref() {
                Some("tga" | "targa" | "icb" | "vda" | "vst") => Ok(Format::Tga),
                _ => Err(unknown("is not an image of any known format".to_owned())),
            }
        }
    }
}

/// An error of the file system, sorted into the file's fault or the disk's.
pub(super) fn from_io(shown: &str, format: Format, source: io::Error) -> ImageError {
    let file = shown.to_owned();
    match source.kind() {
        io::ErrorKind::UnexpectedEof => ImageError::Truncated {
            file,
            format: format.name(),
            detail: "it ends before its image does".to_owned(),
        },
        // Decoders wrap complaints about content as these kinds; the system never reports a read so.
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::Other => {
            ImageError::Corrupt {
                file,
                format: format.name(),
                detail: source.to_string(),
            }
        }
        _ => ImageError::Io { file, source },
    }
}

/// An error of the image crate in our words.
pub(super) fn from_image(shown: &str, format: Format, error: ::image::ImageError) -> ImageError {
    let file = shown.to_owned();
    match error {
        ::image::ImageError::IoError(source) => from_io(shown, format, source),
        ::image::ImageError::Limits(limit) => ImageError::TooLarge {
            file,
            detail: format!("decoding it needs more than the limits allow ({limit})"),
        },
        ::image::ImageError::Unsupported(what) => ImageError::Unsupported {
            file,
            format: format.name(),
            detail: what.to_string(),
        },
        other => ImageError::Corrupt {
            file,
            format: format.name(),
            detail: other.to_string(),
        },
    }
}
