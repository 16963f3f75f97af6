//! PNG files, published whole or not at all.

use crate::exit::CommandError;
use glintbake_bake::package::publish;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageError};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes 8-bit RGB `pixels`, row-major from the top, `3 * width * height` bytes, to a PNG file at `path`.
///
/// The same pixels give the same bytes.
///
/// # Errors
/// [`Failure::Output`](crate::exit::Failure::Output) naming the file; an older file of that name is untouched.
///
/// # Panics
/// If `pixels` has another length.
pub fn write_rgb8(path: &Path, width: u32, height: u32, pixels: &[u8]) -> Result<(), CommandError> {
    write(path, |output| {
        encode(output, width, height, pixels, ExtendedColorType::Rgb8)
    })
}

/// Writes 16-bit RGB `pixels`, row-major from the top, `3 * width * height` samples, to a PNG file at `path`.
///
/// # Errors
/// As [`write_rgb8`].
///
/// # Panics
/// If `pixels` has another length.
pub fn write_rgb16(
    path: &Path,
    width: u32,
    height: u32,
    pixels: &[u16],
) -> Result<(), CommandError> {
    write_words(path, width, height, pixels, ExtendedColorType::Rgb16)
}

/// As [`write_rgb16`], with a fourth channel.
///
/// # Errors
/// As [`write_rgb8`].
///
/// # Panics
/// If `pixels` has not four samples a pixel.
pub fn write_rgba16(
    path: &Path,
    width: u32,
    height: u32,
    pixels: &[u16],
) -> Result<(), CommandError> {
    write_words(path, width, height, pixels, ExtendedColorType::Rgba16)
}

fn write_words(
    path: &Path,
    width: u32,
    height: u32,
    pixels: &[u16],
    kind: ExtendedColorType,
) -> Result<(), CommandError> {
    // The encoder takes samples in the machine's order and swaps them itself.
    let bytes: Vec<u8> = pixels
        .iter()
        .flat_map(|sample| sample.to_ne_bytes())
        .collect();
    write(path, |output| encode(output, width, height, &bytes, kind))
}

fn write(
    path: &Path,
    encode: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), CommandError> {
    publish(path, |file| {
        let mut output = BufWriter::new(file);
        encode(&mut output)?;
        output.flush()
    })?;
    Ok(())
}

fn encode(
    output: &mut impl Write,
    width: u32,
    height: u32,
    bytes: &[u8],
    kind: ExtendedColorType,
) -> io::Result<()> {
    PngEncoder::new_with_quality(output, effort(kind), FilterType::Adaptive)
        .write_image(bytes, width, height, kind)
        .map_err(|error| match error {
            ImageError::IoError(error) => error,
            other => io::Error::other(other),
        })
}

/// How hard to compress. Measured on 2048² samples (flakes, leather, brushed): the low bytes of 16-bit maps are noise,
/// so that level 1 is within 2 % of level 6 (16 % for flakes) in a fifth of its time; 8-bit pictures gain 10 % from
/// level 3. Adaptive filters beat any single one.
fn effort(kind: ExtendedColorType) -> CompressionType {
    CompressionType::Level(if kind == ExtendedColorType::Rgb16 {
        1
    } else {
        3
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exit::Failure;
    use image::{ImageReader, Rgb};

    /// A number for each sample of a picture `width` pixels wide, so that no two pixels may be exchanged.
    fn sample(index: usize) -> u16 {
        (index * 40_503 % 65_536) as u16
    }

    #[test]
    fn sixteen_bit_samples_come_back_as_they_were() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("map.png");
        let pixels: Vec<u16> = (0..3 * 5 * 7).map(sample).collect();
        write_rgb16(&path, 5, 7, &pixels).expect("the folder is writable");
        let read = ImageReader::open(&path)
            .expect("the file is there")
            .decode()
            .expect("it is a PNG")
            .into_rgb16();
        assert_eq!((read.width(), read.height()), (5, 7));
        assert_eq!(read.as_raw(), &pixels);
        let index = 3 * (2 + 5 * 4);
        assert_eq!(
            read.get_pixel(2, 4),
            &Rgb([pixels[index], pixels[index + 1], pixels[index + 2]]),
            "rows run from the top, pixels from the left"
        );
    }

    #[test]
    fn eight_bit_samples_come_back_as_they_were() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("picture.png");
        let pixels: Vec<u8> = (0..3 * 5 * 7).map(|index| sample(index) as u8).collect();
        write_rgb8(&path, 5, 7, &pixels).expect("the folder is writable");
        let read = image::open(&path).expect("it is a PNG");
        assert_eq!(read.color(), image::ColorType::Rgb8);
        assert_eq!(read.into_rgb8().as_raw(), &pixels);
    }

    #[test]
    fn a_missing_folder_is_an_output_failure_that_names_the_file() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("absent").join("picture.png");
        let error = write_rgb8(&path, 1, 1, &[1, 2, 3]).expect_err("there is no such folder");
        assert_eq!(error.failure, Failure::Output);
        assert!(error.message.contains("picture.png"), "{}", error.message);
    }
}
