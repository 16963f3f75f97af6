//! Opening, recognising and decoding a file.

use super::error::ImageError;
use super::identity::file_name;
use super::raster::{Format, Layout, Raster, Samples};
use super::{complete, guard, open_exr};
use ::image::{ColorType, ImageDecoder, ImageFormat, ImageReader};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use zerocopy::IntoBytes;

/// The largest image that is decoded.
///
/// A header beyond it is refused before anything of its size is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Default for Limits {
    /// 16384 × 16384.
    fn default() -> Self {
        Self {
            width: 16_384,
            height: 16_384,
        }
    }
}

/// Bytes of a texel of four floats, the widest raster there is.
const WIDEST_TEXEL: u64 = 16;

/// What decoders may allocate besides the image: tables, rows, profiles. Generous, but not an image.
const WORKING_MEMORY: u64 = 64 << 20;

impl Limits {
    /// Refuses a size beyond the limits.
    pub(super) fn check(self, file: &str, width: u64, height: u64) -> Result<(), ImageError> {
        if width <= u64::from(self.width) && height <= u64::from(self.height) {
            return Ok(());
        }
        Err(ImageError::TooLarge {
            file: file.to_owned(),
            detail: format!(
                "its header says {width} x {height} texels, beyond the limit of {} x {}",
                self.width, self.height
            ),
        })
    }

    fn texels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
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
/// The file is read through a buffer, except that JPEG is held in memory as a whole by its decoder; the peak is the
/// raster plus that, or twice the raster for TIFF.
///
/// # Errors
/// Every [`ImageError`]; never a panic, whatever the file holds.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Raster, ImageError> {
    let (file, length) = open(path)?;
    let shown = path.display().to_string();
    let mut file = BufReader::with_capacity(64 * 1024, file);
    let format = recognise(path, &shown, &mut file, length)?;
    let name = file_name(path);
    let asks_for_exr = options.exr_layer.is_some() || options.exr_channels.is_some();
    if asks_for_exr && format != Format::OpenExr {
        return Err(ImageError::Selection {
            file: shown,
            detail: "a layer or channels were asked for, which only OpenEXR files have by name"
                .to_owned(),
            available: format!("one {} image", format.name()),
        });
    }
    let decoded = guard::catch(|| match format {
        Format::OpenExr => open_exr::read(file, &shown, &name, options),
        _ => decode(file, &shown, &name, format, length, options.limits),
    });
    decoded.unwrap_or_else(|panic| {
        Err(ImageError::Corrupt {
            file: shown,
            format: format.name(),
            detail: format!("the decoder gave up on it ({panic})"),
        })
    })
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
fn recognise(
    path: &Path,
    shown: &str,
    file: &mut BufReader<File>,
    length: u64,
) -> Result<Format, ImageError> {
    let unknown = |found: String| ImageError::UnknownFormat {
        file: shown.to_owned(),
        found,
    };
    let io_error = |source| ImageError::Io {
        file: shown.to_owned(),
        source,
    };
    if length == 0 {
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

/// Decodes anything but EXR.
fn decode(
    mut file: BufReader<File>,
    shown: &str,
    name: &str,
    format: Format,
    length: u64,
    limits: Limits,
) -> Result<Raster, ImageError> {
    let io_error = |source: io::Error| from_io(shown, format, source);
    let image_format = match format {
        Format::Png => {
            let (width, height) = complete::png(&mut file).map_err(io_error)?;
            limits.check(shown, width.into(), height.into())?;
            ImageFormat::Png
        }
        Format::Jpeg => {
            // The decoder reads the whole file first; no compressed image is larger than an uncompressed one.
            if length > limits.texels() * 4 + WORKING_MEMORY {
                return Err(ImageError::TooLarge {
                    file: shown.to_owned(),
                    detail: format!("{length} bytes is more than the largest image would need"),
                });
            }
            complete::jpeg(&mut file).map_err(io_error)?;
            ImageFormat::Jpeg
        }
        Format::WebP => {
            complete::webp(&mut file, length).map_err(io_error)?;
            ImageFormat::WebP
        }
        Format::Tiff => ImageFormat::Tiff,
        Format::Tga => ImageFormat::Tga,
        Format::OpenExr => unreachable!("read by its own decoder"),
    };
    file.seek(SeekFrom::Start(0)).map_err(io_error)?;

    let mut reader = ImageReader::with_format(file, image_format);
    // The crate's default of 512 MiB would refuse a 16384² map. Sides are left to our own check below, which can
    // name them.
    let mut budget = ::image::Limits::no_limits();
    budget.max_alloc = Some(limits.texels() * WIDEST_TEXEL + WORKING_MEMORY);
    reader.limits(budget);
    let from_image = |error| from_image(shown, format, error);
    let decoder = reader.into_decoder().map_err(from_image)?;
    let (width, height) = decoder.dimensions();
    limits.check(shown, width.into(), height.into())?;
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
    let count = width as usize * height as usize * layout.channels();
    // `vec![0; n]` asks the system for zero pages, which cost nothing until the decoder fills them.
    let samples = match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            let mut samples = vec![0_u8; count];
            decoder.read_image(&mut samples).map_err(from_image)?;
            Samples::U8(samples)
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let mut samples = vec![0_u16; count];
            decoder
                .read_image(samples.as_mut_bytes())
                .map_err(from_image)?;
            Samples::U16(samples)
        }
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let mut samples = vec![0_f32; count];
            decoder
                .read_image(samples.as_mut_bytes())
                .map_err(from_image)?;
            Samples::F32(samples)
        }
        other => {
            return Err(ImageError::Unsupported {
                file: shown.to_owned(),
                format: format.name(),
                detail: format!("its samples are {other:?}"),
            });
        }
    };
    Ok(Raster::new(name, width, height, format, layout, samples))
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
fn from_image(shown: &str, format: Format, error: ::image::ImageError) -> ImageError {
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
