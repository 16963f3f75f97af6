//! Decoding against values worked out by hand, and against what must not change.

use super::*;
use crate::image::{Format, Layout, Raster, ReadOptions, Samples, read};
use glintbake_format::model::Wrap;
use std::f64::consts::PI;

fn raster(width: u32, height: u32, layout: Layout, samples: Samples) -> Raster {
    Raster::new("map.png", width, height, Format::Png, layout, samples)
}

fn rgb8(width: u32, height: u32, samples: &[u8]) -> Raster {
    raster(width, height, Layout::Rgb, Samples::U8(samples.to_vec()))
}

fn floats(width: u32, height: u32, samples: &[f32]) -> Raster {
    let names = ["X", "Y", "Z"].map(str::to_owned).to_vec();
    raster(
        width,
        height,
        Layout::Named(names),
        Samples::F32(samples.to_vec()),
    )
}

fn heights(width: u32, height: u32, samples: Samples) -> Raster {
    raster(width, height, Layout::Gray, samples)
}

/// The only texel of a 1 × 1 map.
fn one(raster: Raster, options: &DecodeOptions) -> ([f32; 2], Statistics) {
    let (map, statistics) = decode(raster, options).expect("a valid texel");
    assert_eq!((map.width(), map.height()), (1, 1));
    (map.texels()[0], statistics)
}

fn with(change: impl FnOnce(&mut DecodeOptions)) -> DecodeOptions {
    let mut options = DecodeOptions::default();
    change(&mut options);
    options
}

/// The f32 nearest to the first two components of a vector, normalised.
fn direction([x, y, z]: [f64; 3]) -> [f32; 2] {
    let length = (x * x + y * y + z * z).sqrt();
    [(x / length) as f32, (y / length) as f32]
}

#[test]
fn eight_and_sixteen_bits_decode_to_the_nearest_float() {
    let default = DecodeOptions::default();
    let vector =
        |maximum: f64, sample: [f64; 3]| direction(sample.map(|x| x / maximum * 2.0 - 1.0));
    for sample in [
        [128_u8, 128, 255],
        [255, 128, 140],
        [37, 220, 201],
        [127, 128, 255],
    ] {
        let (point, _) = one(rgb8(1, 1, &sample), &default);
        let expected = vector(255.0, sample.map(f64::from));
        assert!(
            (0..2).all(|i| (point[i] - expected[i]).abs() <= 1e-7),
            "{sample:?}: {point:?} against {expected:?}"
        );
    }
    for sample in [[32_768_u16, 32_767, 65_535], [60_000, 12_345, 45_678]] {
        let raster = raster(1, 1, Layout::Rgb, Samples::U16(sample.to_vec()));
        let (point, _) = one(raster, &default);
        let expected = vector(65_535.0, sample.map(f64::from));
        assert!(
            (0..2).all(|i| (point[i] - expected[i]).abs() <= 1e-7),
            "{sample:?}: {point:?} against {expected:?}"
        );
    }
    // By hand: (128, 127, 255) is (1, -1, 255) / 255.
    let (point, statistics) = one(rgb8(1, 1, &[128, 127, 255]), &default);
    let length = 65_027_f64.sqrt();
    assert_eq!(point, [(1.0 / length) as f32, (-1.0 / length) as f32]);
    let mean = statistics.lengths.unwrap().mean;
    assert!((mean - length / 255.0).abs() < 1e-15, "{mean}");
}

#[test]
fn the_two_camps_disagree_on_zero() {
    let centred = with(|options| options.zero = Zero::Centred);
    let (flat, _) = one(rgb8(1, 1, &[128, 128, 255]), &centred);
    assert_eq!(flat, [0.0, 0.0]);
    // 0 and 1 are both -1: the same vector (-127, 0, 127).
    for least in [0, 1] {
        let (point, _) = one(rgb8(1, 1, &[least, 128, 255]), &centred);
        assert_eq!(point, [-0.5_f64.sqrt() as f32, 0.0]);
    }
    let wide = raster(
        1,
        1,
        Layout::Rgb,
        Samples::U16(vec![32_768, 32_768 + 1, 65_535]),
    );
    let (point, statistics) = one(wide, &centred);
    assert_eq!(point[0], 0.0);
    assert_eq!(point[1], direction([0.0, 1.0, 32_767.0])[1]);
    let step = statistics.lattice.unwrap().step;
    assert!((step - 1.0 / 32_767.0).abs() < 1e-18);

    let (half, _) = one(rgb8(1, 1, &[128, 128, 255]), &DecodeOptions::default());
    assert_eq!(half, direction([1.0, 1.0, 255.0]));
}

#[test]
fn dx_turns_t_around_and_zero_stays_positive() {
    let dx = with(|options| options.green = GreenAxis::Dx);
    let (gl_point, _) = one(rgb8(1, 1, &[200, 60, 220]), &DecodeOptions::default());
    let (dx_point, _) = one(rgb8(1, 1, &[200, 60, 220]), &dx);
    assert_eq!(dx_point, [gl_point[0], -gl_point[1]]);
    assert!(gl_point[1] < 0.0, "green below the middle points down");
    let (flat, _) = one(floats(1, 1, &[-0.0, 0.0, 1.0]), &dx);
    assert_eq!(flat.map(f32::to_bits), [0, 0], "one zero, one set of bytes");
}

#[test]
fn floats_are_signed_unless_said_otherwise() {
    let (point, statistics) = one(floats(1, 1, &[0.6, -0.3, 2.0]), &DecodeOptions::default());
    let expected = direction([f64::from(0.6_f32), f64::from(-0.3_f32), 2.0]);
    assert_eq!(point, expected);
    assert_eq!(statistics.lattice, None);
    let unorm = with(|options| options.range = Range::Unorm);
    let (point, _) = one(floats(1, 1, &[0.75, 0.5, 1.0]), &unorm);
    assert_eq!(point, direction([0.5, 0.0, 1.0]));
    let snorm = with(|options| options.range = Range::Snorm);
    assert_eq!(
        one(floats(1, 1, &[0.75, 0.5, 1.0]), &snorm).0,
        direction([0.75, 0.5, 1.0])
    );
}

#[test]
fn two_channel_maps_take_s_and_t_from_the_letters() {
    // Red 10, green 100, blue 200, alpha 180.
    let texel = [10_u8, 100, 200, 180];
    let decoded = |x: u8| ((2.0 * f64::from(x) - 255.0) / 255.0) as f32;
    for (channels, s, t) in [
        (Channels::Xy, 10, 100),
        (Channels::Rg, 10, 100),
        (Channels::Ga, 100, 180),
        (Channels::Ag, 180, 100),
    ] {
        let options = with(|options| options.channels = channels);
        let map = raster(1, 1, Layout::Rgba, Samples::U8(texel.to_vec()));
        let (point, statistics) = one(map, &options);
        assert_eq!(point, [decoded(s), decoded(t)], "{channels}");
        assert_eq!(statistics.lengths, None, "{channels}");
    }
    let options = with(|options| options.channels = Channels::Ra);
    let map = raster(1, 1, Layout::Rgba, Samples::U8(vec![90, 1, 1, 180]));
    assert_eq!(one(map, &options).0, [decoded(90), decoded(180)]);
    let map = raster(1, 1, Layout::GrayAlpha, Samples::U8(vec![90, 180]));
    assert_eq!(one(map, &options).0, [decoded(90), decoded(180)]);
}

#[test]
fn two_channel_points_just_outside_are_moved_to_the_rim_and_others_refused() {
    let options = with(|options| options.channels = Channels::Xy);
    let (point, statistics) = one(rgb8(1, 1, &[255, 129, 0]), &options);
    assert_eq!(statistics.clamped_to_rim, 1);
    let [s, t] = point.map(f64::from);
    assert!((s.hypot(t) - 1.0).abs() < 1e-7 && (t / s - 3.0 / 255.0).abs() < 1e-7);
    // The bound is 1 + 8/255 = 1.0314: t of 63/255 makes a length of 1.0301, t of 65/255 one of 1.0320.
    let at = |green: u8| rgb8(1, 1, &[255, green, 0]);
    assert!(decode(at(159), &options).is_ok());
    let error = decode(at(160), &options).unwrap_err().to_string();
    assert!(
        error.contains("(255, 160): it lies outside the unit disk"),
        "{error}"
    );
}

#[test]
fn texels_just_below_the_horizon_are_clamped_and_counted() {
    let default = DecodeOptions::default();
    // z = (2 * 124 - 255) / 255 = -7 / 255: within four steps of 2 / 255.
    let (point, statistics) = one(rgb8(1, 1, &[255, 128, 124]), &default);
    assert_eq!(statistics.clamped_to_rim, 1);
    assert_eq!(statistics.repaired, 0);
    let [s, t] = point.map(f64::from);
    assert!((s * s + t * t - 1.0).abs() < 1e-6 && s * s + t * t <= 1.0);
    assert!((statistics.largest_tilt_degrees - 90.0).abs() < 0.05);
    assert!((t / s - 1.0 / 255.0).abs() < 1e-6);
    // One step further it points into the surface.
    let error = decode(rgb8(1, 1, &[255, 128, 123]), &default).unwrap_err();
    assert!(matches!(error, NormalsError::NoValidTexel { .. }));
    assert!(error.to_string().contains("below the surface"), "{error}");
}

#[test]
fn bad_texels_are_named_counted_and_refused() {
    let good = [0.0, 0.0, 1.0];
    let mut samples = good.repeat(6 * 5);
    let texel = |column: usize, row: usize| 3 * (row * 6 + column);
    samples[texel(4, 1)..][..3].copy_from_slice(&[0.5, f32::NAN, 1.0]);
    samples[texel(0, 3)..][..3].copy_from_slice(&[0.0, 0.0, 0.0]);
    samples[texel(5, 4)..][..3].copy_from_slice(&[0.0, f32::NEG_INFINITY, 0.5]);
    let map = || floats(6, 5, &samples);
    let error = decode(map(), &DecodeOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "map.png: texel (4, 1) is (0.5, NaN, 1): a component is not a finite number, and 2 more are no better; pass \
         --repair to take the nearest valid texel"
    );
    let repair = with(|options| options.repair = true);
    let (repaired, statistics) = decode(map(), &repair).unwrap();
    assert_eq!(statistics.repaired, 3);
    assert!(repaired.texels().iter().all(|texel| *texel == [0.0, 0.0]));
    assert_eq!(
        statistics.lengths.unwrap().shortest,
        1.0,
        "bad texels have no say in the lengths"
    );
}

#[test]
fn zero_at_eight_bits_is_whatever_rounds_to_it() {
    for texel in [[127_u8, 128, 127], [128, 128, 128]] {
        let map = rgb8(2, 1, &[texel, [128, 128, 255]].concat());
        let error = decode(map, &DecodeOptions::default()).unwrap_err();
        assert!(
            matches!(
                &error,
                NormalsError::BadTexels {
                    column: 0,
                    row: 0,
                    others: 0,
                    ..
                }
            ),
            "{error}"
        );
        assert!(error.to_string().contains("no length"), "{error}");
    }
    let centred = with(|options| options.zero = Zero::Centred);
    assert!(decode(rgb8(1, 1, &[128, 128, 128]), &centred).is_err());
    assert!(decode(rgb8(1, 1, &[128, 128, 129]), &centred).is_ok());
}

#[test]
fn repair_takes_the_nearest_valid_texel_across_the_border_of_a_repeating_map() {
    let left = [180_u8, 128, 220];
    let right = [60_u8, 128, 220];
    let bad = [0_u8, 0, 0];
    let samples = [left, bad, left, left, right].concat();
    let row = |wrap| {
        let options = with(|options| {
            options.repair = true;
            options.wrap = wrap;
        });
        let mut samples = samples.clone();
        samples[..3].copy_from_slice(&bad);
        decode(rgb8(5, 1, &samples), &options).unwrap()
    };
    let (clamped, statistics) = row(Wrap::Clamp);
    assert_eq!(statistics.repaired, 2);
    assert!(clamped.texels()[0][0] > 0.0 && clamped.texels()[1][0] > 0.0);
    let (repeated, _) = row(Wrap::Repeat);
    assert!(repeated.texels()[0][0] < 0.0 && repeated.texels()[1][0] > 0.0);
    assert_eq!(repeated.wrap(), Wrap::Repeat);
}

#[test]
fn a_map_without_one_valid_texel_is_refused_even_with_repair() {
    let repair = with(|options| options.repair = true);
    let error = decode(rgb8(3, 2, &[0; 18]), &repair).unwrap_err();
    assert_eq!(
        error.to_string(),
        "map.png: none of its 6 texels is valid (the first is (0, 0, 0): it points below the surface); check --input, \
         --channels and --range"
    );
    let nan = heights(2, 1, Samples::F32(vec![f32::NAN, f32::INFINITY]));
    let options = with(|options| {
        options.repair = true;
        options.input = Input::Height;
    });
    assert!(matches!(
        decode(nan, &options),
        Err(NormalsError::NoValidTexel { texels: 2, .. })
    ));
}

#[test]
fn a_plane_keeps_its_slope_to_a_clamped_border() {
    // Rises by 2 texels per column and falls by 0.5 per row; h is exact in f32.
    let (width, height) = (7_u32, 5_u32);
    let samples: Vec<f32> = (0..height)
        .flat_map(|row| (0..width).map(move |column| 2.0 * column as f32 - 0.5 * row as f32))
        .collect();
    let options = with(|options| {
        options.input = Input::Height;
        options.wrap = Wrap::Clamp;
    });
    let (map, statistics) = decode(
        heights(width, height, Samples::F32(samples.clone())),
        &options,
    )
    .unwrap();
    // Uphill is to the right, so the normal leans left; uphill is up the picture, so it leans down.
    let expected = direction([-2.0, -0.5, 1.0]);
    assert!(
        map.texels().iter().all(|texel| *texel == expected),
        "{expected:?}"
    );
    assert_eq!(statistics.covariance, [0.0; 3]);
    assert_eq!(statistics.lengths, None);

    let repeat = with(|options| options.input = Input::Height);
    let (map, _) = decode(heights(width, height, Samples::F32(samples)), &repeat).unwrap();
    assert_eq!(map.texels()[8], expected, "the inside is the same");
    // Over the border the plane falls from column 6 to column 0: (2 - 12) / 2 = -5 a column.
    assert_eq!(map.texels()[7], direction([5.0, -0.5, 1.0]));
}

#[test]
fn a_sine_has_the_slope_of_its_central_differences() {
    let (size, waves, amplitude) = (64_u32, 3.0, 5.0);
    let phase = |index: u32| 2.0 * PI * waves * f64::from(index) / f64::from(size);
    let samples: Vec<f32> = (0..size)
        .flat_map(|row| {
            (0..size).map(move |column| {
                (0.5 + 0.25 * libm::sin(phase(column)) + 0.25 * libm::cos(phase(row))) as f32
            })
        })
        .collect();
    let options = with(|options| {
        options.input = Input::Height;
        options.height_scale = amplitude;
    });
    let (map, statistics) = decode(heights(size, size, Samples::F32(samples)), &options).unwrap();
    // Exactly, (sin(x + d) - sin(x - d)) / 2 = sin(d) cos(x): the derivative, with sin d for d.
    let slope = amplitude * 0.25 * libm::sin(phase(1));
    for (index, texel) in map.texels().iter().enumerate() {
        let (column, row) = (index as u32 % size, index as u32 / size);
        let right = slope * libm::cos(phase(column));
        let down = -slope * libm::sin(phase(row));
        let expected = direction([-right, down, 1.0]);
        for i in 0..2 {
            assert!(
                (texel[i] - expected[i]).abs() < 2e-6,
                "({column}, {row}): {texel:?} against {expected:?}"
            );
        }
    }
    assert!(statistics.mean[0].abs() < 1e-7 && statistics.mean[1].abs() < 1e-7);
}

#[test]
fn integer_heights_are_scaled_to_texels_of_white() {
    let options = with(|options| {
        options.input = Input::Height;
        options.height_scale = 10.0;
        options.wrap = Wrap::Clamp;
    });
    let (map, statistics) = decode(heights(2, 1, Samples::U8(vec![51, 102])), &options).unwrap();
    assert_eq!(map.texels(), [direction([-2.0, 0.0, 1.0]); 2]);
    assert_eq!(
        statistics.lattice,
        Some(Lattice {
            bits: 8,
            step: 10.0 / 255.0 / 2.0
        })
    );
    let (map, _) = decode(
        heights(1, 2, Samples::U16(vec![13_107, 0])),
        &with(|options| {
            options.input = Input::Height;
            options.height_scale = -5.0;
            options.wrap = Wrap::Clamp;
        }),
    )
    .unwrap();
    // Upside down the upper texel is the lower one, by 1: the surface rises down the picture, so it leans up.
    assert_eq!(map.texels(), [direction([0.0, 1.0, 1.0]); 2]);
    // Of red, green and blue, red counts.
    let colours = raster(2, 1, Layout::Rgb, Samples::U8(vec![51, 9, 200, 102, 90, 3]));
    let (coloured, _) = decode(colours, &options).unwrap();
    assert_eq!(coloured.texels(), [direction([-2.0, 0.0, 1.0]); 2]);
    // One texel has no slope, whatever surrounds it.
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let options = with(|options| {
            options.input = Input::Height;
            options.wrap = wrap;
        });
        let (map, _) = decode(heights(1, 1, Samples::U8(vec![77])), &options).unwrap();
        assert_eq!(map.texels()[0].map(f32::to_bits), [0, 0]);
    }
}

#[test]
fn bad_heights_are_named_and_repaired_before_slopes_are_taken() {
    let names = vec!["h".to_owned(), "other".to_owned()];
    let samples = [1.0, f32::NAN, f32::INFINITY, 0.0, 1.0, 5.0];
    let map = || {
        raster(
            3,
            1,
            Layout::Named(names.clone()),
            Samples::F32(samples.to_vec()),
        )
    };
    let options = with(|options| options.input = Input::Height);
    let error = decode(map(), &options).unwrap_err();
    assert_eq!(
        error.to_string(),
        "map.png: texel (1, 0) is inf: it is not a finite height; pass --repair to take the nearest valid texel"
    );
    let options = with(|options| {
        options.input = Input::Height;
        options.repair = true;
    });
    let (map, statistics) = decode(map(), &options).unwrap();
    assert_eq!(map.texels(), [[0.0; 2]; 3]);
    assert_eq!(statistics.repaired, 1);
}

#[test]
fn the_steepest_heights_stay_on_the_disk() {
    let samples = vec![f32::MAX, -f32::MAX, f32::MAX, 0.0];
    let options = with(|options| {
        options.input = Input::Height;
        options.height_scale = 1e9;
        options.wrap = Wrap::Clamp;
    });
    let (map, _) = decode(heights(2, 2, Samples::F32(samples)), &options).unwrap();
    for texel in map.texels() {
        let [s, t] = texel.map(f64::from);
        assert!(
            s * s + t * t <= 1.0 && s * s + t * t > 0.999_999,
            "{texel:?}"
        );
    }
}

#[test]
fn options_without_meaning_are_refused() {
    let grey = || heights(1, 1, Samples::U8(vec![1]));
    let normal = || rgb8(1, 1, &[128, 128, 255]);
    let float = || floats(1, 1, &[0.0, 0.0, 1.0]);
    type Change = fn(&mut DecodeOptions);
    let height: [(Change, &str); 7] = [
        (|options| options.green = GreenAxis::Dx, "--y dx"),
        (|options| options.channels = Channels::Rg, "--channels rg"),
        (|options| options.zero = Zero::Centred, "--zero 128"),
        (|options| options.range = Range::Snorm, "--range snorm"),
        (
            |options| options.height_scale = f64::NAN,
            "--height-scale NaN",
        ),
        (
            |options| options.height_scale = -2e9,
            "--height-scale -2000000000",
        ),
        (
            |options| options.height_scale = f64::INFINITY,
            "--height-scale inf",
        ),
    ];
    for (change, option) in height {
        let mut options = with(change);
        options.input = Input::Height;
        let error = decode(grey(), &options).unwrap_err();
        assert!(
            matches!(&error, NormalsError::Option { option: named, .. } if named == option),
            "{error}"
        );
    }
    let snorm = with(|options| options.range = Range::Snorm);
    assert!(
        decode(normal(), &snorm)
            .unwrap_err()
            .to_string()
            .contains("--range snorm")
    );
    assert!(decode(float(), &snorm).is_ok());
    let centred = with(|options| options.zero = Zero::Centred);
    assert!(
        decode(float(), &centred)
            .unwrap_err()
            .to_string()
            .contains("--zero 128")
    );
    assert!(decode(normal(), &centred).is_ok());
    assert!(matches!(
        decode(grey(), &DecodeOptions::default()),
        Err(NormalsError::Channels { .. })
    ));
}

#[test]
fn statistics_of_a_small_map_are_those_of_the_definition() {
    let vectors = [
        [0.3, 0.4, 1.0],
        [-0.6, 0.0, 0.8],
        [0.0, 0.0, 0.5],
        [0.1, -0.9, 0.2],
    ];
    let samples: Vec<f32> = vectors.iter().flatten().map(|&x: &f64| x as f32).collect();
    let (map, statistics) = decode(floats(2, 2, &samples), &DecodeOptions::default()).unwrap();
    let points: Vec<[f64; 2]> = map
        .texels()
        .iter()
        .map(|texel| texel.map(f64::from))
        .collect();
    let average =
        |f: &dyn Fn([f64; 2]) -> f64| points.iter().map(|&point| f(point)).sum::<f64>() / 4.0;
    let mean = [average(&|[s, _]| s), average(&|[_, t]| t)];
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} against {b}");
    near(statistics.mean[0], mean[0]);
    near(statistics.mean[1], mean[1]);
    near(
        statistics.covariance[0],
        average(&|[s, _]| (s - mean[0]) * (s - mean[0])),
    );
    near(
        statistics.covariance[1],
        average(&|[s, t]| (s - mean[0]) * (t - mean[1])),
    );
    near(
        statistics.covariance[2],
        average(&|[_, t]| (t - mean[1]) * (t - mean[1])),
    );
    near(
        statistics.spread(),
        ((statistics.covariance[0] + statistics.covariance[2]) / 2.0).sqrt(),
    );
    near(
        statistics.mean_cosine,
        average(&|[s, t]| (1.0 - (s * s + t * t)).sqrt()),
    );
    let lengths = statistics.lengths.unwrap();
    let each: Vec<f64> = samples
        .chunks(3)
        .map(|v| {
            v.iter()
                .map(|&x| f64::from(x) * f64::from(x))
                .sum::<f64>()
                .sqrt()
        })
        .collect();
    near(lengths.mean, each.iter().sum::<f64>() / 4.0);
    near(lengths.shortest, 0.5);
    near(lengths.longest, each[0]);
    // The last texel: sine of the tilt sqrt(0.82 / 0.86).
    let tilt = libm::asin(libm::sqrt(0.82 / 0.86)).to_degrees();
    assert!((statistics.largest_tilt_degrees - tilt).abs() < 1e-5);
    assert_eq!(statistics.texels, 4);
    let json = serde_json::to_string(&statistics).unwrap();
    assert!(json.contains("\"clamped-to-rim\":0") && json.contains("\"lattice\":null"));
    // The parser may be off by the last digit of a float.
    let read: Statistics = serde_json::from_str(&json).unwrap();
    assert_eq!((read.texels, read.lattice), (4, None));
    near(read.covariance[1], statistics.covariance[1]);
    near(read.lengths.unwrap().mean, lengths.mean);
}

#[test]
fn sixteen_bits_that_are_eight_in_disguise_are_found_out() {
    let vector = [140_u16, 120, 250];
    let lattice = |samples: Vec<u16>| {
        let map = raster(2, 1, Layout::Rgb, Samples::U16(samples));
        decode(map, &DecodeOptions::default()).unwrap().1.lattice
    };
    let widened: Vec<u16> = vector.iter().chain(&vector).map(|x| x * 257).collect();
    let eight = lattice(widened.clone()).unwrap();
    assert_eq!(eight.bits, 8);
    assert!((eight.step - 2.0 / 255.0).abs() < 1e-17);
    let mut true_16 = widened;
    true_16[4] += 1;
    let sixteen = lattice(true_16).unwrap();
    assert_eq!(sixteen.bits, 16);
    assert!((sixteen.step - 2.0 / 65_535.0).abs() < 1e-18);
}

/// A map of several chunks and rows that do not end with them, with texels to clamp and to repair.
fn large() -> Raster {
    let (width, height) = (331_u32, 173_u32);
    let mut state = 99_u32;
    let samples = (0..width * height * 3)
        .map(|index| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let value = (state >> 16) as u16;
            if index % 3 == 2 {
                value / 2 + 32_767
            } else {
                value
            }
        })
        .collect();
    raster(width, height, Layout::Rgb, Samples::U16(samples))
}

#[test]
fn nothing_depends_on_the_number_of_threads() {
    let options = with(|options| options.repair = true);
    let height = with(|options| {
        options.input = Input::Height;
        options.height_scale = 3.0;
    });
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            [&options, &height].map(|options| {
                let (map, statistics) = decode(large(), options).unwrap();
                let bits: Vec<_> = map.texels().iter().map(|t| t.map(f32::to_bits)).collect();
                (bits, serde_json::to_string(&statistics).unwrap())
            })
        })
    };
    let one = run(1);
    assert!(one == run(2));
    assert!(one == run(7));
}

#[test]
fn files_of_both_sample_types_decode_to_the_same_normals() {
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("map.png");
    ::image::save_buffer(
        &png,
        &[128, 128, 255, 255, 128, 128, 0, 0, 0, 64, 190, 230],
        2,
        2,
        ::image::ExtendedColorType::Rgb8,
    )
    .unwrap();
    let raster = read(&png, &ReadOptions::default()).unwrap();
    let error = decode(raster.clone(), &DecodeOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "map.png: texel (0, 1) is (0, 0, 0): it points below the surface; pass --repair to take the nearest valid \
         texel"
    );
    let repair = with(|options| options.repair = true);
    let (map, statistics) = decode(raster, &repair).unwrap();
    assert_eq!(statistics.repaired, 1);
    // The neighbour to the left, over the border of a repeating map.
    assert_eq!(map.texels()[2], map.texels()[3]);
    assert_eq!(map.texels()[0], direction([1.0, 1.0, 255.0]));
}
