//! Bands of rows against the same image as a whole, read by other means or known beforehand.

use super::{encoded, folder, noise, write};
use crate::image::*;
use ::image::{ColorType, ExtendedColorType, ImageDecoder, ImageFormat, ImageReader};
use std::path::Path;

/// Odd, so that no band ends where another thing does.
const SIZE: [u32; 2] = [37, 29];

/// Bands of a row, of some rows, and of all.
const BANDS: [usize; 4] = [1, 150, 500, 1 << 18];

/// The header of the image at `path`, and its bands of about `band_texels`.
fn bands(path: &Path, band_texels: usize) -> Result<(Header, Vec<Samples>), ImageError> {
    let mut bands = Bands::open_with(path, &ReadOptions::default(), band_texels)?;
    let header = bands.header().clone();
    let mut all = Vec::new();
    loop {
        match bands.next_band() {
            Ok(Some(band)) => all.push(band),
            Ok(None) => return Ok((header, all)),
            Err(error) => {
                assert!(
                    matches!(bands.next_band(), Ok(None)),
                    "nothing follows an error"
                );
                return Err(error);
            }
        }
    }
}

fn joined(header: &Header, bands: &[Samples]) -> Samples {
    let mut samples = Samples::none(header.kind);
    for band in bands {
        samples.append(band.clone(), 0).unwrap();
    }
    samples
}

/// The samples of a file, as the image crate reads it into one buffer.
fn whole(bytes: &[u8], format: ImageFormat) -> Samples {
    let reader = ImageReader::with_format(std::io::Cursor::new(bytes), format);
    let decoder = reader.into_decoder().unwrap();
    let color = decoder.color_type();
    let mut buffer = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut buffer).unwrap();
    match color {
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let floats = buffer.as_chunks::<4>().0.iter();
            Samples::F32(floats.map(|&bytes| f32::from_ne_bytes(bytes)).collect())
        }
        _ if color.bytes_per_pixel() > color.channel_count() => {
            let integers = buffer.as_chunks::<2>().0.iter();
            Samples::U16(integers.map(|&bytes| u16::from_ne_bytes(bytes)).collect())
        }
        _ => Samples::U8(buffer),
    }
}

/// Reads `bytes` in bands of every size; the number of bands of the smallest.
fn compare(name: &str, bytes: &[u8], expected: &Samples) -> usize {
    let folder = folder();
    let path = write(&folder, name, bytes);
    let mut most = 0;
    for band_texels in BANDS {
        let (header, bands) = bands(&path, band_texels).expect(name);
        assert!(
            &joined(&header, &bands) == expected,
            "{name} in bands of {band_texels}"
        );
        most = most.max(bands.len());
    }
    most
}

#[test]
fn every_format_and_depth_joins_to_the_image() {
    use ExtendedColorType::{L8, L16, La8, La16, Rgb8, Rgb16, Rgb32F, Rgba8, Rgba16, Rgba32F};
    let rows = SIZE[1] as usize;
    let formats: [(ImageFormat, &str, &[ExtendedColorType], usize); 5] = [
        (
            ImageFormat::Png,
            "map.png",
            &[L8, La8, Rgb8, Rgba8, L16, La16, Rgb16, Rgba16],
            rows,
        ),
        // The encoder makes strips of several rows, if the image is not smaller than one.
        (
            ImageFormat::Tiff,
            "map.tif",
            &[L8, Rgb8, Rgba8, L16, Rgb16, Rgba16, Rgb32F, Rgba32F],
            1,
        ),
        (ImageFormat::Tga, "map.tga", &[L8, La8, Rgb8, Rgba8], 1),
        (ImageFormat::WebP, "map.webp", &[Rgb8, Rgba8], 1),
        (ImageFormat::Jpeg, "map.jpg", &[L8, Rgb8], 1),
    ];
    for (format, name, colors, least_bands) in formats {
        for &color in colors {
            let texels = (SIZE[0] * SIZE[1]) as usize;
            let samples = noise(texels * usize::from(color.bits_per_pixel()) / 8);
            // Floats without NaN, which would not equal itself.
            let samples: Vec<u8> = match color {
                Rgb32F | Rgba32F => samples
                    .as_chunks::<4>()
                    .0
                    .iter()
                    .flat_map(|bytes| (f32::from(bytes[0]) / 256.0).to_ne_bytes())
                    .collect(),
                _ => samples,
            };
            let bytes = encoded(format, &samples, SIZE, color);
            let count = compare(name, &bytes, &whole(&bytes, format));
            assert!(count >= least_bands, "{name} {color:?}: {count} bands");
        }
    }
}

#[test]
fn a_large_tiff_comes_by_its_strips() {
    let size = [301, 997];
    let samples = noise(301 * 997 * 6);
    let bytes = encoded(ImageFormat::Tiff, &samples, size, ExtendedColorType::Rgb16);
    let count = compare("map.tif", &bytes, &whole(&bytes, ImageFormat::Tiff));
    assert!(count > 1, "{count} bands");
}

/// One PNG chunk.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(kind);
    checksum.update(data);
    [
        &(data.len() as u32).to_be_bytes(),
        &kind[..],
        data,
        &checksum.finalize().to_be_bytes(),
    ]
    .concat()
}

/// A PNG file of the given rows, filter bytes included, in one stored block.
fn png_file(
    size: [u32; 2],
    [depth, color, interlace]: [u8; 3],
    extra: &[u8],
    rows: &[u8],
) -> Vec<u8> {
    let (mut a, mut b) = (1_u32, 0_u32);
    for &byte in rows {
        a = (a + u32::from(byte)) % 65_521;
        b = (b + a) % 65_521;
    }
    let length = u16::try_from(rows.len()).expect("one stored block");
    let zlib = [
        &[0x78, 0x01, 0x01][..],
        &length.to_le_bytes(),
        &(!length).to_le_bytes(),
        rows,
        &(b << 16 | a).to_be_bytes(),
    ]
    .concat();
    let sides = size.map(u32::to_be_bytes).concat();
    let header = [&sides[..], &[depth, color, 0, 0, interlace]].concat();
    [
        &b"\x89PNG\r\n\x1a\n"[..],
        &chunk(b"IHDR", &header),
        extra,
        &chunk(b"IDAT", &zlib),
        &chunk(b"IEND", &[]),
    ]
    .concat()
}

#[test]
fn palettes_keys_and_single_bits_are_expanded_in_bands_too() {
    let row = |bytes: &[u8]| [&[0][..], bytes].concat();
    let palette = chunk(b"PLTE", &[10, 20, 30, 40, 50, 60, 70, 80, 90, 1, 2, 3]);
    let alpha = chunk(b"tRNS", &[7, 8, 9]);
    let indexed = [row(&[0, 1, 2]), row(&[3, 2, 1]), row(&[0, 0, 3])].concat();
    let key = chunk(b"tRNS", &[0, 1]);
    let bits = [row(&[0b1010_0000]), row(&[0b0110_0000]), row(&[0])].concat();
    for (format, extra, rows) in [
        ([8, 3, 0], palette.clone(), &indexed),
        ([8, 3, 0], [palette, alpha].concat(), &indexed),
        ([1, 0, 0], Vec::new(), &bits),
        ([1, 0, 0], key, &bits),
    ] {
        let bytes = png_file([3, 3], format, &extra, rows);
        let count = compare("map.png", &bytes, &whole(&bytes, ImageFormat::Png));
        assert_eq!(count, 3, "{format:?}");
    }
}

#[test]
fn an_interlaced_png_is_put_in_order() {
    // Adam7, 3 × 3, 8-bit grey: passes 1, 4, 5, 6 and 7 have texels.
    let rows = [
        &[0, 11][..],     // (0, 0)
        &[0, 13],         // (2, 0)
        &[0, 31, 33],     // (0, 2), (2, 2)
        &[0, 12],         // (1, 0)
        &[0, 32],         // (1, 2)
        &[0, 21, 22, 23], // row 1
    ]
    .concat();
    let bytes = png_file([3, 3], [8, 0, 1], &[], &rows);
    let expected = Samples::U8(vec![11, 12, 13, 21, 22, 23, 31, 32, 33]);
    assert_eq!(compare("map.png", &bytes, &expected), 1);
}

/// A little-endian TIFF of 16-bit RGB `samples` in tiles of 16 × 16.
fn tiled_tiff(samples: &[u16], [width, height]: [u32; 2]) -> Vec<u8> {
    let (across, down) = (width.div_ceil(16), height.div_ceil(16));
    let mut data = Vec::new();
    for tile in 0..across * down {
        for texel in 0..256 {
            let column = tile % across * 16 + texel % 16;
            let row = tile / across * 16 + texel / 16;
            for channel in 0..3 {
                let inside = column < width && row < height;
                let at = ((row * width + column) * 3 + channel) as usize;
                let sample = if inside { samples[at] } else { 0xabcd };
                data.extend(sample.to_le_bytes());
            }
        }
    }
    let entries = 11_u32;
    let (tiles, tile_bytes) = (across * down, 16 * 16 * 6);
    let bits_at = 8 + 2 + entries * 12 + 4;
    let offsets_at = bits_at + 6;
    let counts_at = offsets_at + 4 * tiles;
    let data_at = counts_at + 4 * tiles;
    let (short, long) = (3_u16, 4_u16);
    let directory = [
        (256, long, 1, width),
        (257, long, 1, height),
        (258, short, 3, bits_at),
        (259, short, 1, 1),
        (262, short, 1, 2),
        (277, short, 1, 3),
        (284, short, 1, 1),
        (322, short, 1, 16),
        (323, short, 1, 16),
        (324, long, tiles, offsets_at),
        (325, long, tiles, counts_at),
    ];
    let mut file = b"II*\0\x08\0\0\0".to_vec();
    file.extend((entries as u16).to_le_bytes());
    for (tag, kind, count, value) in directory {
        file.extend(u16::to_le_bytes(tag));
        file.extend(kind.to_le_bytes());
        file.extend(u32::to_le_bytes(count));
        file.extend(u32::to_le_bytes(value));
    }
    file.extend([0; 4]);
    file.extend([16_u16, 16, 16].map(u16::to_le_bytes).concat());
    for tile in 0..tiles {
        file.extend((data_at + tile * tile_bytes).to_le_bytes());
    }
    for _ in 0..tiles {
        file.extend(tile_bytes.to_le_bytes());
    }
    file.extend(data);
    file
}

#[test]
fn a_tiled_tiff_comes_by_rows_of_tiles() {
    let samples: Vec<u16> = noise(2 * 3 * (SIZE[0] * SIZE[1]) as usize)
        .as_chunks::<2>()
        .0
        .iter()
        .map(|&bytes| u16::from_ne_bytes(bytes))
        .collect();
    let bytes = tiled_tiff(&samples, SIZE);
    let count = compare("map.tif", &bytes, &Samples::U16(samples));
    assert_eq!(count, 2);
}

#[test]
fn exr_rows_come_in_order_whatever_the_order_of_the_file() {
    use exr::prelude::{
        AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, LayerAttributes,
        LineOrder, Vec2, WritableImage,
    };
    let [width, height] = SIZE.map(|side| side as usize);
    let plane = |seed: usize| -> Vec<f32> {
        (0..width * height)
            .map(|i| ((i * 37 + seed * 11) % 256) as f32 / 256.0)
            .collect()
    };
    let planes = [0, 1, 2].map(plane);
    let expected = (0..width * height).flat_map(|i| [0, 1, 2].map(|seed| planes[seed][i]));
    let expected = Samples::F32(expected.collect());
    let folder = folder();
    let path = folder.path().join("source.exr");
    for line_order in [LineOrder::Increasing, LineOrder::Decreasing] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 8))] {
            let channels = ["X", "Y", "Z"].iter().zip(&planes);
            let channels = channels
                .map(|(name, plane)| AnyChannel::new(*name, FlatSamples::F32(plane.clone())));
            let encoding = Encoding {
                compression: exr::meta::attribute::Compression::ZIP1,
                blocks,
                line_order,
            };
            Image::from_layer(Layer::new(
                (width, height),
                LayerAttributes::default(),
                encoding,
                AnyChannels::sort(channels.collect()),
            ))
            .write()
            .to_file(&path)
            .unwrap();
            let bytes = std::fs::read(&path).unwrap();
            let count = compare("map.exr", &bytes, &expected);
            assert_eq!(count, height, "{line_order:?} {blocks:?}");
        }
    }
}

#[test]
fn image_data_that_ends_early_is_an_error_at_any_row() {
    let folder = folder();
    let samples = noise(24 * 17 * 3);
    let size = [24, 17];
    let honest = encoded(ImageFormat::Png, &samples, size, ExtendedColorType::Rgb8);
    let at = honest.windows(4).position(|kind| kind == b"IDAT").unwrap();
    let length = u32::from_be_bytes(honest[at - 4..at].try_into().unwrap()) as usize;
    let data = &honest[at + 4..][..length];
    // A sound file in all but that: whole chunks, right checksums, and too little in them.
    // The last bytes are the checksum, behind the last row.
    for kept in (0..length - 8).step_by(13).chain(length - 20..length - 8) {
        let cut = [
            &honest[..at - 4],
            &chunk(b"IDAT", &data[..kept]),
            &chunk(b"IEND", &[]),
        ]
        .concat();
        let path = write(&folder, "cut.png", &cut);
        for band_texels in BANDS {
            let error = bands(&path, band_texels)
                .map(drop)
                .expect_err("rows are missing");
            assert!(
                matches!(
                    error,
                    ImageError::Truncated { .. } | ImageError::Corrupt { .. }
                ),
                "{kept} of {length} bytes: {error}"
            );
        }
    }
    let tiff = encoded(
        ImageFormat::Tiff,
        &noise(301 * 400 * 6),
        [301, 400],
        ExtendedColorType::Rgb16,
    );
    for kept in (0..tiff.len()).step_by(tiff.len() / 37) {
        let path = write(&folder, "cut.tif", &tiff[..kept]);
        for band_texels in [1, 1 << 18] {
            assert!(bands(&path, band_texels).is_err(), "{kept} bytes");
        }
    }
}

#[test]
fn a_file_that_changes_after_it_was_hashed_is_not_decoded() {
    let folder = folder();
    let size = [300, 200];
    let image = |seed: usize, format| {
        let samples = &noise(300 * 200 * 6 + 1)[seed..][..300 * 200 * 6];
        encoded(format, samples, size, ExtendedColorType::Rgb16)
    };
    for (name, format) in [
        ("map.png", ImageFormat::Png),
        ("map.tif", ImageFormat::Tiff),
    ] {
        let bytes = image(0, format);
        let path = write(&folder, name, &bytes);
        let file = HashedFile::open(&path, &()).unwrap();
        assert_eq!(file.identity(), &identify(&path).unwrap());
        let decode = || {
            let mut bands = Bands::of(&file, &ReadOptions::default())?;
            while bands.next_band()?.is_some() {}
            Ok::<(), ImageError>(())
        };
        let mut flipped = bytes.clone();
        flipped[bytes.len() / 2] ^= 1;
        let others = [
            flipped,
            image(1, format),
            bytes[..bytes.len() - 1].to_vec(),
            b"no image any more".to_vec(),
            Vec::new(),
        ];
        for other in others {
            write(&folder, name, &other);
            let error = decode().expect_err("other bytes");
            assert!(matches!(error, ImageError::Changed { .. }), "{error}");
            assert!(error.to_string().contains("run the command again"));
        }
        write(&folder, name, &bytes);
        decode().expect("the same bytes, though written anew");
        std::fs::remove_file(&path).unwrap();
        assert!(matches!(decode(), Err(ImageError::Open { .. })));
    }
}
