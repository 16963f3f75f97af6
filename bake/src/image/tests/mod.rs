//! Files made in code, read back, and broken on purpose.

mod bands;
mod exr_files;
mod hostile;

use super::*;
use ::image::{ExtendedColorType, ImageEncoder, ImageFormat, codecs};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn write(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("a temporary file");
    path
}

fn get(path: &Path) -> Result<Raster, ImageError> {
    read(path, &ReadOptions::default())
}

/// Samples without a pattern that an encoder could find, from a linear congruential generator.
fn noise(count: usize) -> Vec<u8> {
    let mut state = 12_345_u32;
    let next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    std::iter::repeat_with(next).take(count).collect()
}

fn encoded(
    format: ImageFormat,
    samples: &[u8],
    [width, height]: [u32; 2],
    color: ExtendedColorType,
) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    ::image::write_buffer_with_format(&mut bytes, samples, width, height, color, format)
        .expect("an encoder's own samples");
    bytes.into_inner()
}

fn png(samples: &[u8], size: [u32; 2], color: ExtendedColorType) -> Vec<u8> {
    encoded(ImageFormat::Png, samples, size, color)
}

fn u16_bytes(samples: &[u16]) -> Vec<u8> {
    samples.iter().flat_map(|x| x.to_ne_bytes()).collect()
}

#[test]
fn lossless_8_bit_formats_give_back_every_sample() {
    let folder = folder();
    let samples = noise(5 * 3 * 4);
    for (format, extension) in [
        (ImageFormat::Png, "png"),
        (ImageFormat::Tga, "tga"),
        (ImageFormat::Tiff, "tif"),
        (ImageFormat::WebP, "webp"),
    ] {
        for (color, layout) in [
            (ExtendedColorType::Rgb8, Layout::Rgb),
            (ExtendedColorType::Rgba8, Layout::Rgba),
        ] {
            let samples = &samples[..15 * layout.channels()];
            let bytes = encoded(format, samples, [5, 3], color);
            let raster = get(&write(&folder, &format!("map.{extension}"), &bytes)).unwrap();
            assert_eq!(
                (raster.width(), raster.height(), raster.layout()),
                (5, 3, &layout),
                "{format:?}"
            );
            assert_eq!(
                raster.samples(),
                &Samples::U8(samples.to_vec()),
                "{format:?}"
            );
            assert_eq!(raster.name(), format!("map.{extension}"));
        }
    }
}

#[test]
fn sixteen_bits_keep_all_their_bits() {
    let folder = folder();
    let samples: Vec<u16> = noise(60)
        .chunks(2)
        .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
        .collect();
    for format in [ImageFormat::Png, ImageFormat::Tiff] {
        let bytes = encoded(
            format,
            &u16_bytes(&samples),
            [5, 2],
            ExtendedColorType::Rgb16,
        );
        let raster = get(&write(&folder, "map", &bytes)).unwrap();
        assert_eq!(raster.samples(), &Samples::U16(samples.clone()));
    }
    let grey = png(&u16_bytes(&samples), [6, 5], ExtendedColorType::L16);
    let raster = get(&write(&folder, "map", &grey)).unwrap();
    assert_eq!(raster.layout(), &Layout::Gray);
    assert_eq!(raster.description(), "6 x 5, 16-bit PNG (one grey channel)");
}

#[test]
fn float_tiff_is_read_as_floats() {
    let folder = folder();
    let samples = [-1.0_f32, 0.25, f32::NAN, 3.0e38, 1.0e-40, -0.0];
    let bytes: Vec<u8> = samples.iter().flat_map(|x| x.to_ne_bytes()).collect();
    let tiff = encoded(ImageFormat::Tiff, &bytes, [1, 2], ExtendedColorType::Rgb32F);
    let raster = get(&write(&folder, "map.tiff", &tiff)).unwrap();
    let Samples::F32(read) = raster.samples() else {
        panic!("floats expected, got {}", raster.description());
    };
    assert!(
        read.iter()
            .zip(samples)
            .all(|(a, b)| a.to_bits() == b.to_bits())
    );
}

#[test]
fn jpeg_comes_close_and_grey_stays_grey() {
    let folder = folder();
    let samples = [200_u8, 100, 50].repeat(16 * 16);
    let mut bytes = Vec::new();
    codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100)
        .write_image(&samples, 16, 16, ExtendedColorType::Rgb8)
        .unwrap();
    let raster = get(&write(&folder, "map.jpg", &bytes)).unwrap();
    let Samples::U8(read) = raster.samples() else {
        panic!("bytes expected");
    };
    assert_eq!(raster.layout(), &Layout::Rgb);
    assert!(read.iter().zip(&samples).all(|(a, b)| a.abs_diff(*b) <= 2));

    let grey = encoded(ImageFormat::Jpeg, &[90; 64], [8, 8], ExtendedColorType::L8);
    assert_eq!(
        get(&write(&folder, "grey.jpg", &grey)).unwrap().layout(),
        &Layout::Gray
    );
}

#[test]
fn content_decides_the_format_and_not_the_name() {
    let folder = folder();
    let bytes = png(&[1, 2, 3], [1, 1], ExtendedColorType::Rgb8);
    let raster = get(&write(&folder, "map.tga", &bytes)).unwrap();
    assert_eq!(raster.format(), Format::Png);
}

#[test]
fn an_input_is_known_by_name_length_and_hash() {
    let folder = folder();
    let content = noise(200_000);
    let file = identify(&write(&folder, "leather.png", &content)).unwrap();
    assert_eq!(file.name, "leather.png");
    assert_eq!(file.bytes, 200_000);
    assert_eq!(file.blake3, *blake3::hash(&content).as_bytes());
    assert!(matches!(
        identify(&folder.path().join("none")),
        Err(ImageError::Open { .. })
    ));
}
