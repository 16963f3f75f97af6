//! Maps read from files, band by band, against the same samples as one raster.

use super::with;
use crate::error::BakeError;
use crate::image::{
    Bands, Format, HashedFile, ImageError, Layout, Raster, ReadOptions, SampleType, Samples,
};
use crate::normals::stream::from_bands;
use crate::normals::*;
use crate::progress::{Progress, Stage};
use ::image::ExtendedColorType;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use std::cell::Cell;
use std::path::Path;
use std::sync::Mutex;
use zerocopy::IntoBytes;

/// Several chunks, of which no row or band is a part.
const SIZE: (u32, u32) = (331, 173);

/// A map, and how it is decoded.
struct Case {
    name: &'static str,
    channels: usize,
    samples: Samples,
    options: DecodeOptions,
}

fn texels() -> usize {
    (SIZE.0 * SIZE.1) as usize
}

/// Numbers without a pattern.
fn numbers() -> impl Iterator<Item = u32> {
    let mut state = 99_u32;
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    })
}

/// Vectors of which most point up, some lie just below the horizon, and some far below.
fn vectors(channels: usize, maximum: u32) -> Vec<u32> {
    let component = |(index, number): (usize, u32)| match index % channels {
        2 if number.is_multiple_of(97) => number % maximum / 2,
        2 => maximum / 2 - maximum / 40 + number % (maximum / 2),
        _ => number % (maximum + 1),
    };
    let samples = numbers().enumerate().map(component);
    samples.take(channels * texels()).collect()
}

fn cases() -> Vec<Case> {
    let case = |name, channels, samples, options| Case {
        name,
        channels,
        samples,
        options,
    };
    let bytes = |samples: Vec<u32>| Samples::U8(samples.into_iter().map(|x| x as u8).collect());
    let words = |samples: Vec<u32>| Samples::U16(samples.into_iter().map(|x| x as u16).collect());
    let floats = |channels: usize| -> Vec<f32> {
        let samples = vectors(channels, 65_535).into_iter();
        samples.map(|x| x as f32 / 32_767.5 - 1.0).collect()
    };
    let repair = with(|options| options.repair = true);
    let clamp = with(|options| {
        options.repair = true;
        options.wrap = glintbake_format::model::Wrap::Clamp;
        options.green = GreenAxis::Dx;
    });
    let two = |channels| {
        with(|options| {
            options.repair = true;
            options.channels = channels;
        })
    };
    let height = with(|options| {
        options.input = Input::Height;
        options.height_scale = 3.0;
    });
    let repaired_height = DecodeOptions {
        repair: true,
        ..height.clone()
    };
    let widened = |samples: Vec<u32>| samples.into_iter().map(|x| 257 * x).collect::<Vec<_>>();
    // (128, 128, 128) has no length at 8 bit, and (1, 1, 1) / 65535 has one at 16: which of them it is shows last.
    let late = |last: u32| {
        let mut samples = [128_u32, 128, 200].map(|x| 257 * x).repeat(texels());
        samples[3 * 500..][..3].fill(257 * 128);
        samples[3 * 20_000..][..3].fill(257 * 128);
        *samples.last_mut().unwrap() += last;
        words(samples)
    };
    let mut damaged = floats(3);
    for at in [5, 3 * 16_384 + 1, 3 * 40_000, 3 * 40_001 + 2] {
        damaged[at] = f32::NAN;
    }
    let default = DecodeOptions::default();
    vec![
        case("8-bit, refused", 3, bytes(vectors(3, 255)), default.clone()),
        case("8-bit, repaired", 3, bytes(vectors(3, 255)), repair.clone()),
        case("8-bit with alpha", 4, bytes(vectors(4, 255)), clamp.clone()),
        case("8-bit ga", 4, bytes(vectors(4, 255)), two(Channels::Ga)),
        case("8-bit grey", 2, bytes(vectors(2, 255)), two(Channels::Ag)),
        case(
            "8-bit, none valid",
            3,
            bytes(vec![0; 3 * texels()]),
            repair.clone(),
        ),
        case(
            "16-bit, refused",
            3,
            words(vectors(3, 65_535)),
            default.clone(),
        ),
        case("16-bit, repaired", 3, words(vectors(3, 65_535)), clamp),
        case("16-bit xy", 3, words(vectors(3, 65_535)), two(Channels::Xy)),
        case(
            "16-bit with alpha",
            4,
            words(vectors(4, 65_535)),
            repair.clone(),
        ),
        case(
            "widened",
            3,
            words(widened(vectors(3, 255))),
            repair.clone(),
        ),
        case("widened, refused", 3, late(0), default.clone()),
        case("widened but for the last", 3, late(1), default.clone()),
        case("widened, repaired", 3, late(0), repair.clone()),
        case("floats, refused", 3, Samples::F32(damaged.clone()), default),
        case("floats, repaired", 3, Samples::F32(damaged.clone()), repair),
        case("8-bit heights", 1, bytes(vectors(1, 255)), height.clone()),
        case(
            "16-bit heights",
            1,
            words(vectors(1, 65_535)),
            height.clone(),
        ),
        case(
            "heights in red",
            3,
            words(vectors(3, 65_535)),
            height.clone(),
        ),
        case(
            "widened heights",
            1,
            words(widened(vectors(1, 255))),
            height.clone(),
        ),
        case(
            "float heights, refused",
            3,
            Samples::F32(damaged.clone()),
            height,
        ),
        case(
            "float heights, repaired",
            3,
            Samples::F32(damaged),
            repaired_height,
        ),
    ]
}

impl Case {
    /// Writes the map: floats as EXR, integers as PNG.
    fn write(&self, path: &Path) {
        let (width, height) = SIZE;
        if let Samples::F32(samples) = &self.samples {
            let channels = ["X", "Y", "Z"].iter().enumerate().map(|(place, name)| {
                let plane = samples.iter().skip(place).step_by(3).copied();
                AnyChannel::new(*name, FlatSamples::F32(plane.collect()))
            });
            Image::from_layer(Layer::new(
                (width as usize, height as usize),
                LayerAttributes::default(),
                Encoding::SMALL_LOSSLESS,
                AnyChannels::sort(channels.collect()),
            ))
            .write()
            .to_file(path)
            .unwrap();
            return;
        }
        use ExtendedColorType::{L8, L16, La8, La16, Rgb8, Rgb16, Rgba8, Rgba16};
        let (colors, bytes) = match &self.samples {
            Samples::U8(samples) => ([L8, La8, Rgb8, Rgba8], samples.as_bytes()),
            Samples::U16(samples) => ([L16, La16, Rgb16, Rgba16], samples.as_bytes()),
            Samples::F32(_) => unreachable!("written above"),
        };
        let format = ::image::ImageFormat::Png;
        let color = colors[self.channels - 1];
        ::image::save_buffer_with_format(path, bytes, width, height, color, format).unwrap();
    }

    fn raster(&self, name: &str) -> Raster {
        let (format, layout) = match (self.samples.kind(), self.channels) {
            (SampleType::F32, _) => {
                let names = ["X", "Y", "Z"].map(str::to_owned).to_vec();
                (Format::OpenExr, Layout::Named(names))
            }
            (_, 1) => (Format::Png, Layout::Gray),
            (_, 2) => (Format::Png, Layout::GrayAlpha),
            (_, 3) => (Format::Png, Layout::Rgb),
            _ => (Format::Png, Layout::Rgba),
        };
        Raster::new(name, SIZE.0, SIZE.1, format, layout, self.samples.clone())
    }
}

#[test]
fn maps_by_bands_are_maps_by_rasters_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map");
    let (mut refused, mut repaired, mut clamped) = (0, 0, 0);
    for case in cases() {
        case.write(&path);
        let expected = decode(case.raster("map"), &case.options);
        match &expected {
            Ok((_, statistics)) => {
                repaired += u64::from(statistics.repaired > 0);
                clamped += u64::from(statistics.clamped_to_rim > 0);
            }
            Err(_) => refused += 1,
        }
        for band_texels in [1, 1000, 16_384, 20_000, 1 << 18] {
            let open = || Bands::open_with(&path, &ReadOptions::default(), band_texels);
            let what = format!("{} in bands of {band_texels}", case.name);
            match (from_bands(open, &case.options, &()), &expected) {
                (Ok((map, statistics)), Ok((whole, of_whole))) => {
                    let bits = |map: &NormalMap| -> Vec<_> {
                        map.texels().iter().map(|t| t.map(f32::to_bits)).collect()
                    };
                    assert!(bits(&map) == bits(whole), "{what}");
                    assert_eq!(&statistics, of_whole, "{what}");
                }
                (Err(BakeError::Normals(error)), Err(of_whole)) => {
                    // As text, for NaN does not equal itself.
                    assert_eq!(error.to_string(), of_whole.to_string(), "{what}");
                }
                (found, _) => panic!("{what}: {:?}, expected {expected:?}", found.err()),
            }
        }
    }
    assert!(
        refused >= 5 && repaired >= 8 && clamped >= 5,
        "{refused} {repaired} {clamped}"
    );
}

#[test]
fn only_a_map_that_stops_looking_widened_is_read_twice() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map");
    let times = |name: &str, band_texels: usize| {
        let case = cases().into_iter().find(|case| case.name == name).unwrap();
        case.write(&path);
        let times = Cell::new(0);
        let open = || {
            times.set(times.get() + 1);
            Bands::open_with(&path, &ReadOptions::default(), band_texels)
        };
        let _either = from_bands(open, &case.options, &());
        times.get()
    };
    assert_eq!(times("widened but for the last", 1000), 2);
    assert_eq!(times("widened but for the last", 1 << 18), 1);
    for name in [
        "widened",
        "widened, refused",
        "16-bit, repaired",
        "16-bit heights",
    ] {
        assert_eq!(times(name, 1000), 1, "{name}");
    }
}

/// Everything that was reported.
#[derive(Default)]
struct Notes(Mutex<Vec<(Stage, u64, u64)>>);

impl Progress for Notes {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        self.0.lock().unwrap().push((stage, done, total));
    }
}

#[test]
fn a_bake_tells_of_every_stage_in_order_and_to_its_end() {
    use glintbake_format::model::Method;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    let case = cases().swap_remove(7);
    case.write(&path);
    let notes = Notes::default();
    let file = HashedFile::open(&path, &notes).unwrap();
    let (map, statistics) = read(&file, &ReadOptions::default(), &case.options, &notes).unwrap();
    let recipe = crate::Recipe {
        exr_layer: None,
        exr_channels: None,
        decode: case.options,
        methods: vec![
            crate::MethodRecipe::new(Method::FlakeBins, &[0.1, 0.2]),
            crate::MethodRecipe::new(Method::SpecularBins, &[]),
        ],
    };
    let source = crate::Source {
        input: file.identity().clone(),
        statistics,
    };
    let plan = crate::bake_with_progress(&map, &recipe, Some(&source), &notes).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    plan.write_with_progress(&mut bytes, &notes).unwrap();
    assert!(
        bytes.into_inner()
            == crate::bake(&map, &recipe, Some(&source))
                .unwrap()
                .to_bytes(),
        "who listens changes nothing"
    );

    let notes = notes.0.into_inner().unwrap();
    let mut stages: Vec<_> = notes.iter().map(|(stage, ..)| *stage).collect();
    stages.dedup();
    let turns = [Stage::Bins, Stage::Structures].repeat(3);
    let expected = [&[Stage::Hash, Stage::Read][..], &turns, &[Stage::Write]].concat();
    assert_eq!(stages, expected);
    for stage in [
        Stage::Hash,
        Stage::Read,
        Stage::Bins,
        Stage::Structures,
        Stage::Write,
    ] {
        let reports: Vec<_> = notes.iter().filter(|note| note.0 == stage).collect();
        assert!(
            reports
                .windows(2)
                .all(|pair| pair[0].1 <= pair[1].1 && pair[0].2 == pair[1].2)
        );
        let &&(_, done, total) = reports.last().unwrap();
        match stage {
            Stage::Bins | Stage::Structures => assert_eq!((done, total), (2, 3), "{stage:?}"),
            Stage::Read => assert_eq!((done, total), (173, 173)),
            Stage::Hash | Stage::Write => assert!(done == total && total > 0, "{stage:?}"),
        }
    }
}

#[test]
fn a_damaged_file_is_the_files_fault_and_never_half_a_map() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    let case = cases().swap_remove(7);
    case.write(&path);
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x40;
    std::fs::write(&path, &bytes).unwrap();
    let open = || Bands::open_with(&path, &ReadOptions::default(), 1000);
    let error = from_bands(open, &case.options, &()).expect_err("a wrong checksum");
    assert!(
        matches!(&error, BakeError::Image(ImageError::Corrupt { .. })),
        "{error}"
    );
}
