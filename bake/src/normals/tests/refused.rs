//! Texels and options that are moved, repaired or refused.

use super::{direction, floats, heights, one, rgb8, with};
use crate::image::{ReadOptions, Samples, read};
use crate::normals::*;
use glintbake_format::model::Wrap;

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
fn a_file_with_a_bad_texel_is_refused_by_its_name_and_repaired_on_request() {
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
