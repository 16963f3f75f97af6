//! Files that are missing, cut off, damaged, or lie.

use super::exr_files::exr_single;
use super::{encoded, folder, get, noise, png, write};
use crate::image::*;
use ::image::{ExtendedColorType, ImageFormat};
use std::fs;

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
        (65_536, 1),
        (1, 65_536),
        (16_385, 16_384),
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
fn limits_can_be_set() {
    let folder = folder();
    let bytes = png(&[0; 18], [3, 2], ExtendedColorType::Rgb8);
    let path = write(&folder, "map.png", &bytes);
    let limited = |width, height, texels| {
        let options = ReadOptions {
            limits: Limits {
                width,
                height,
                texels,
            },
            ..ReadOptions::default()
        };
        read(&path, &options)
    };
    assert!(limited(3, 2, u64::MAX).is_ok());
    assert!(limited(9, 9, 6).is_ok());
    for (width, height, texels) in [(2, 2, 9), (3, 1, 9), (9, 9, 5)] {
        assert!(matches!(
            limited(width, height, texels),
            Err(ImageError::TooLarge { .. })
        ));
    }
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
