//! Decoding against values worked out by hand, and against what must not change.

mod bands;
mod heights;
mod refused;

use super::*;
use crate::image::{Format, Layout, Raster, Samples};

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
