//! EXR: what is chosen, and what is refused.

use super::{folder, get, png, write};
use crate::image::*;
use ::image::ExtendedColorType;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage, f16,
};
use std::fs;
use std::path::Path;

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

/// A 5 × 4 map of X, Y and Z.
pub(super) fn exr_single(path: &Path) {
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
fn a_cut_off_exr_is_called_so() {
    let folder = folder();
    let path = folder.path().join("map.exr");
    exr_single(&path);
    let bytes = fs::read(&path).unwrap();
    let error = get(&write(&folder, "cut.exr", &bytes[..bytes.len() - 1])).unwrap_err();
    assert!(matches!(error, ImageError::Truncated { .. }), "{error}");
}
