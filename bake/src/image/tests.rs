//! Files made in code, read back, and broken on purpose.

use super::*;
use ::image::{ExtendedColorType, ImageEncoder, ImageFormat, codecs};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage, f16,
};
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

/// The parts of a two-part test file: beauty and N, each of one type.
fn exr_file(path: &Path, half: bool) {
    let plane = |offset: f32| -> FlatSamples {
        let values = (0..6).map(|i| offset + i as f32 / 8.0);
        if half {
            FlatSamples::F16(values.map(f16::from_f32).collect())
        } else {
            FlatSamples::F32(values.collect())
        }
    };
    let layer = |name: &str, channels: [(&str, f32); 4]| {
        Layer::new(
            (3, 2),
            LayerAttributes::named(name),
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(
                channels
                    .iter()
                    .map(|&(name, offset)| AnyChannel::new(name, plane(offset)))
                    .collect(),
            ),
        )
    };
    let beauty = [("R", 1.0), ("G", 2.0), ("B", 3.0), ("depth.V", 9.0)];
    let normals = [("X", 4.0), ("Y", 5.0), ("Z", 6.0), ("W", 7.0)];
    Image::empty(exr::meta::header::ImageAttributes::with_size(Vec2(3, 2)))
        .with_layer(layer("beauty", beauty))
        .with_layer(layer("N", normals))
        .write()
        .to_file(path)
        .expect("a test file");
}

#[test]
fn exr_layers_and_channels_are_interleaved_in_the_order_asked_for() {
    let folder = folder();
    for half in [false, true] {
        let path = folder.path().join("map.exr");
        exr_file(&path, half);
        let ask = |layer: Option<&str>, channels: Option<&[&str]>| {
            let options = ReadOptions {
                exr_layer: layer.map(str::to_owned),
                exr_channels: channels.map(|names| names.iter().map(ToString::to_string).collect()),
                limits: Limits::default(),
            };
            read(&path, &options)
        };
        let expected = |offsets: &[f32]| {
            Samples::F32(
                (0..6)
                    .flat_map(|i| offsets.iter().map(move |offset| offset + i as f32 / 8.0))
                    .collect(),
            )
        };
        let beauty = ask(None, None).unwrap();
        assert_eq!(beauty.samples(), &expected(&[1.0, 2.0, 3.0]), "half {half}");
        assert_eq!((beauty.width(), beauty.height()), (3, 2));
        assert_eq!(
            beauty.layout(),
            &Layout::Named(vec!["R".into(), "G".into(), "B".into()])
        );
        assert_eq!(
            ask(Some("N"), None).unwrap().samples(),
            &expected(&[4.0, 5.0, 6.0])
        );
        assert_eq!(
            ask(Some("N"), Some(&["W", "X", "W"])).unwrap().samples(),
            &expected(&[7.0, 4.0, 7.0])
        );
        assert_eq!(
            ask(None, Some(&["depth.V"])).unwrap().samples(),
            &expected(&[9.0])
        );
        let missing = ask(Some("N"), Some(&["Q"])).unwrap_err();
        assert!(matches!(missing, ImageError::Selection { .. }));
        let message = missing.to_string();
        assert!(
            message.contains("no channels Q in layer N") && message.contains("W (layer N)"),
            "{message}"
        );
    }
}

#[test]
fn exr_tiles_and_every_compression_give_the_same_map() {
    use exr::meta::attribute::Compression;
    use exr::prelude::{Blocks, LineOrder};
    let folder = folder();
    let (width, height) = (70_usize, 41_usize);
    let plane = |seed: usize| -> Vec<f32> {
        (0..width * height)
            .map(|i| ((i * 37 + seed * 11) % 256) as f32 / 256.0 - 0.5)
            .collect()
    };
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
    ] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(32, 16))] {
            let encoding = Encoding {
                compression,
                blocks,
                line_order: LineOrder::Increasing,
            };
            let channels = ["X", "Y", "Z"]
                .iter()
                .enumerate()
                .map(|(seed, name)| AnyChannel::new(*name, FlatSamples::F32(plane(seed))))
                .collect();
            let path = folder.path().join("map.exr");
            Image::from_layer(Layer::new(
                (width, height),
                LayerAttributes::default(),
                encoding,
                AnyChannels::sort(channels),
            ))
            .write()
            .to_file(&path)
            .unwrap();
            let raster = get(&path).unwrap();
            let expected: Vec<f32> = (0..width * height)
                .flat_map(|i| [0, 1, 2].map(|seed| plane(seed)[i]))
                .collect();
            assert!(
                raster.samples() == &Samples::F32(expected),
                "{compression:?} {blocks:?}"
            );
        }
    }
}

#[test]
fn exr_integers_and_shifted_windows_are_refused() {
    let folder = folder();
    let path = folder.path().join("map.exr");
    let write = |attributes: LayerAttributes, samples: FlatSamples| {
        Image::from_layer(Layer::new(
            (2, 1),
            attributes,
            Encoding::UNCOMPRESSED,
            AnyChannels::sort([AnyChannel::new("X", samples)].into_iter().collect()),
        ))
    };
    write(LayerAttributes::default(), FlatSamples::U32(vec![1, 2]))
        .write()
        .to_file(&path)
        .unwrap();
    let message = get(&path).unwrap_err().to_string();
    assert!(message.contains("channel X holds integers"), "{message}");

    let mut shifted = write(
        LayerAttributes::default().with_position(Vec2(1, 0)),
        FlatSamples::F32(vec![1.0, 2.0]),
    );
    shifted.attributes.display_window.position = Vec2(0, 0);
    shifted.write().to_file(&path).unwrap();
    let error = get(&path).unwrap_err();
    assert!(matches!(error, ImageError::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("data window"), "{error}");
}

#[test]
fn choices_for_exr_are_refused_elsewhere() {
    let folder = folder();
    let bytes = png(&[1, 2, 3], [1, 1], ExtendedColorType::Rgb8);
    let options = ReadOptions {
        exr_layer: Some("N".into()),
        ..ReadOptions::default()
    };
    assert!(matches!(
        read(&write(&folder, "map.png", &bytes), &options),
        Err(ImageError::Selection { .. })
    ));
}

#[test]
fn what_cannot_be_opened_says_so() {
    let folder = folder();
    let missing = folder.path().join("missing.png");
    let error = get(&missing).unwrap_err();
    assert!(matches!(&error, ImageError::Open { source, .. }
        if source.kind() == std::io::ErrorKind::NotFound));
    assert!(error.to_string().contains("missing.png"), "{error}");
    assert!(matches!(
        get(folder.path()),
        Err(ImageError::NotAFile {
            found: "a folder",
            ..
        })
    ));
    assert!(matches!(
        identify(folder.path()),
        Err(ImageError::NotAFile { .. })
    ));
}

#[test]
fn what_is_no_image_says_so() {
    let folder = folder();
    for (name, content) in [
        ("empty.png", &b""[..]),
        ("text.png", b"not an image, but long enough to look at"),
        ("zeros.exr", &[0; 4096]),
        ("one.jpg", &[0xff]),
        ("animation.gif", b"GIF89a\x01\x00\x01\x00\x00\x00\x00;"),
    ] {
        let error = get(&write(&folder, name, content)).unwrap_err();
        assert!(
            matches!(error, ImageError::UnknownFormat { .. }),
            "{name}: {error:?}"
        );
        assert!(error.to_string().contains(name));
    }
}

#[test]
fn a_header_that_lies_is_refused_by_its_numbers() {
    let folder = folder();
    let honest = png(&[0; 12], [2, 2], ExtendedColorType::Rgb8);
    for (width, height) in [
        (1_u32 << 31, 1_u32),
        (0x7fff_ffff, 0x7fff_ffff),
        (16_385, 1),
        (1, 16_385),
    ] {
        let mut bytes = honest.clone();
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        let mut checksum = crc32fast::Hasher::new();
        checksum.update(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.finalize().to_be_bytes());
        let error = get(&write(&folder, "lie.png", &bytes)).unwrap_err();
        assert!(matches!(error, ImageError::TooLarge { .. }), "{error}");
        assert!(
            error.to_string().contains(&format!("{width} x {height}")),
            "{error}"
        );
    }
    // TGA: 65535 x 65535, uncompressed, 24 bit.
    let mut tga = vec![0; 18];
    tga[2] = 2;
    tga[12..16].fill(0xff);
    tga[16] = 24;
    let error = get(&write(&folder, "lie.tga", &tga)).unwrap_err();
    assert!(matches!(error, ImageError::TooLarge { .. }), "{error}");
}

#[test]
fn an_exr_header_that_lies_is_refused_by_its_numbers() {
    let folder = folder();
    let path = folder.path().join("map.exr");
    exr_single(&path);
    let mut bytes = fs::read(&path).unwrap();
    // dataWindow and displayWindow hold x_min, y_min, x_max, y_max.
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
        bytes[at + 8..at + 12].copy_from_slice(&1_000_000_000_i32.to_le_bytes());
    }
    let error = get(&write(&folder, "lie.exr", &bytes)).unwrap_err();
    assert!(matches!(error, ImageError::TooLarge { .. }), "{error}");
    assert!(error.to_string().contains("1000000001 x 4"), "{error}");
}

fn exr_single(path: &Path) {
    let plane = || FlatSamples::F32((0..20).map(|i| i as f32 / 20.0).collect());
    let channels = ["X", "Y", "Z"].map(|name| AnyChannel::new(name, plane()));
    Image::from_layer(Layer::new(
        (5, 4),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(channels.into_iter().collect()),
    ))
    .write()
    .to_file(path)
    .unwrap();
}

#[test]
fn limits_can_be_set() {
    let folder = folder();
    let bytes = png(&[0; 18], [3, 2], ExtendedColorType::Rgb8);
    let path = write(&folder, "map.png", &bytes);
    let limited = |width, height| {
        let options = ReadOptions {
            limits: Limits { width, height },
            ..ReadOptions::default()
        };
        read(&path, &options)
    };
    assert!(limited(3, 2).is_ok());
    assert!(matches!(limited(2, 2), Err(ImageError::TooLarge { .. })));
    assert!(matches!(limited(3, 1), Err(ImageError::TooLarge { .. })));
}

/// One small noisy file of each format.
fn one_of_each() -> Vec<(&'static str, Vec<u8>)> {
    let size = [24, 17];
    let samples = noise(24 * 17 * 3);
    let folder = folder();
    let path = folder.path().join("map.exr");
    exr_single(&path);
    let rgb = ExtendedColorType::Rgb8;
    vec![
        ("map.png", png(&samples, size, rgb)),
        ("map.tga", encoded(ImageFormat::Tga, &samples, size, rgb)),
        ("map.tif", encoded(ImageFormat::Tiff, &samples, size, rgb)),
        ("map.webp", encoded(ImageFormat::WebP, &samples, size, rgb)),
        ("map.jpg", encoded(ImageFormat::Jpeg, &samples, size, rgb)),
        ("map.exr", fs::read(&path).unwrap()),
    ]
}

#[test]
fn a_file_cut_off_anywhere_is_an_error() {
    let folder = folder();
    for (name, bytes) in one_of_each() {
        get(&write(&folder, name, &bytes)).expect(name);
        // Every length near both ends, and some in between.
        let middle = (64..bytes.len().saturating_sub(64)).step_by(7);
        let ends = (0..64.min(bytes.len())).chain(bytes.len().saturating_sub(64)..bytes.len());
        for length in ends.chain(middle) {
            let result = get(&write(&folder, name, &bytes[..length]));
            let Err(error) = result else {
                panic!("{name} cut to {length} of {} bytes was read", bytes.len());
            };
            if ["map.png", "map.jpg", "map.webp"].contains(&name) && length >= 16 {
                assert!(
                    matches!(error, ImageError::Truncated { .. }),
                    "{name} cut to {length}: {error}"
                );
            }
        }
    }
}

#[test]
fn a_cut_off_exr_is_called_so() {
    let folder = folder();
    let (name, bytes) = one_of_each().pop().unwrap();
    let error = get(&write(&folder, name, &bytes[..bytes.len() - 1])).unwrap_err();
    assert!(matches!(error, ImageError::Truncated { .. }), "{error}");
}

#[test]
fn damaged_bytes_never_panic() {
    let folder = folder();
    let randomness = noise(4096);
    for (name, bytes) in one_of_each() {
        let path = folder.path().join(name);
        // Each byte of the first 256, where headers are, and a sample of the rest.
        for at in (0..256.min(bytes.len())).chain((256..bytes.len()).step_by(29)) {
            for flip in [0xff, 1 << (at % 8)] {
                let mut damaged = bytes.clone();
                damaged[at] ^= flip;
                fs::write(&path, &damaged).unwrap();
                let _may_be_either = get(&path);
            }
        }
        // The magic number, then noise.
        for length in [32, 300, 4096] {
            let mut garbage = randomness[..length].to_vec();
            garbage[..16].copy_from_slice(&bytes[..16]);
            fs::write(&path, &garbage).unwrap();
            let result = get(&path);
            if name != "map.tga" {
                assert!(
                    result.is_err(),
                    "{name} of {length} bytes of noise was read"
                );
            }
        }
    }
}

#[test]
fn a_jpeg_may_go_on_after_its_end_and_hold_a_thumbnail_with_another() {
    let folder = folder();
    let (_, bytes) = one_of_each().swap_remove(4);
    let mut trailing = bytes.clone();
    trailing.extend_from_slice(b"maker's notes");
    assert!(get(&write(&folder, "map.jpg", &trailing)).is_ok());
    // An APP1 segment that itself ends like a JPEG, before an image that does not.
    let mut thumbnail = bytes[..2].to_vec();
    thumbnail.extend_from_slice(&[0xff, 0xe1, 0x00, 0x06, 1, 2, 0xff, 0xd9]);
    thumbnail.extend_from_slice(&bytes[2..]);
    assert!(get(&write(&folder, "map.jpg", &thumbnail)).is_ok());
    thumbnail.truncate(thumbnail.len() - 2);
    assert!(matches!(
        get(&write(&folder, "map.jpg", &thumbnail)),
        Err(ImageError::Truncated { .. })
    ));
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
