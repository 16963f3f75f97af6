//! Opacity maps: look-ups against the plain average of texels, and what is stored.

use super::{open, patches};
use glintbake_bake::oracle::layers::coverage;
use glintbake_format::Container;
use glintbake_format::check;
use glintbake_format::model::{Footprint, Wrap};
use glintbake_tests::fixtures::Stream;
use glintbake_tests::materials::{Layer, material};

/// A map of random cells, as flakes are, of which six in ten cover.
fn cells(width: u32, height: u32, size: u32) -> Vec<u8> {
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x / size, y / size)))
        .map(|(x, y)| {
            let mut stream = Stream::new(u64::from(1000 * y + x));
            if stream.uniform() < 0.6 { 255 } else { 0 }
        })
        .collect()
}

/// A material of one layer that covers what `texels` say.
fn covering(width: u32, height: u32, texels: &[u8], wrap: Wrap) -> Vec<u8> {
    let base = Layer::base([0.04; 3], [0.5; 3], 0.4);
    material(&[base.covering(width, height, texels.to_vec(), wrap)])
}

/// Mean and greatest difference of look-ups from the average of texels, over turned squares of `edge` texels, `ratio` times as
/// long as wide.
fn errors(width: u32, height: u32, texels: &[u8], wrap: Wrap, edge: f64, ratio: f64) -> [f64; 2] {
    let bytes = covering(width, height, texels, wrap);
    let material = open(&bytes);
    let layer = material.layers().next().unwrap();
    let mut stream = Stream::new(9);
    let count = 60;
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for _ in 0..count {
        let angle = stream.between(0.0, 6.3);
        let (x, y) = (edge * angle.cos(), edge * angle.sin());
        let size = [f64::from(width), f64::from(height)];
        let footprint = Footprint {
            centre: [stream.between(-1.0, 2.0), stream.between(-1.0, 2.0)],
            edge_1: [x / size[0] * ratio, y / size[1] * ratio],
            edge_2: [-y / size[0], x / size[1]],
        };
        let got = layer.opacity(&footprint).unwrap();
        let error = (got - coverage(width, height, texels, wrap, &footprint)).abs();
        sum += error / f64::from(count);
        most = most.max(error);
    }
    [sum, most]
}

#[test]
fn look_ups_are_as_near_to_the_average_of_texels_as_documented() {
    // Flakes of four texels, and a gradient: the figures in docs/materials.md.
    let flakes = cells(64, 48, 4);
    let gradient: Vec<u8> = (0..64 * 48).map(|texel| (texel % 64 * 4) as u8).collect();
    for (edge, mean, most) in [
        (0.5, 0.03, 0.25),
        (2.0, 0.01, 0.05),
        (8.0, 0.11, 0.32),
        (32.0, 0.03, 0.09),
    ] {
        let [of_mean, of_most] = errors(64, 48, &flakes, Wrap::Repeat, edge, 1.0);
        assert!(
            of_mean <= mean && of_most <= most,
            "{edge}: {of_mean} {of_most}"
        );
        let [of_mean, of_most] = errors(64, 48, &gradient, Wrap::Clamp, edge, 1.0);
        assert!(
            edge > 8.0 || of_most <= 0.06,
            "gradient, {edge}: {of_mean} {of_most}"
        );
        let [of_mean, of_most] = errors(64, 48, &flakes, Wrap::Repeat, edge, 6.0);
        assert!(of_mean <= mean, "long, {edge}: {of_mean} {of_most}");
    }
    // Under the whole map the look-up is the whole map's average.
    let whole = Footprint {
        centre: [0.3, 0.8],
        edge_1: [1.0, 0.0],
        edge_2: [0.0, 1.0],
    };
    let bytes = covering(64, 64, &cells(64, 64, 4), Wrap::Repeat);
    let got = open(&bytes)
        .layers()
        .next()
        .unwrap()
        .opacity(&whole)
        .unwrap();
    let average = coverage(64, 64, &cells(64, 64, 4), Wrap::Repeat, &whole);
    assert!(
        (got - average).abs() <= 0.5 / 255.0 + 1e-12,
        "{got} {average}"
    );
}

#[test]
fn opacity_is_continuous_and_within_its_bounds() {
    let bytes = covering(16, 8, &patches(), Wrap::Repeat);
    let material = open(&bytes);
    let layer = material.layers().next().unwrap();
    for size in [0.0, 0.03, 0.4, 3.0] {
        let mut last: Option<f64> = None;
        for step in 0..4000 {
            let t = f64::from(step) / 4000.0;
            let footprint = Footprint {
                centre: [1.3 * t - 0.2, 0.4 + 0.7 * t],
                edge_1: [size * (1.0 + 4.0 * t), 0.1 * size],
                edge_2: [0.02 * t, size],
            };
            let opacity = layer.opacity(&footprint).unwrap();
            assert!((0.0..=1.0).contains(&opacity));
            if let Some(last) = last {
                assert!(
                    (opacity - last).abs() < 0.01,
                    "{size} {step}: {last} {opacity}"
                );
            }
            last = Some(opacity);
        }
    }
}

#[test]
fn maps_of_any_size_are_sound_and_constant_ones_exact() {
    for (width, height) in [(1, 1), (1, 7), (5, 3), (16, 8), (13, 64), (300, 1)] {
        let texels: Vec<u8> = (0..width * height)
            .map(|texel| (texel * 37 % 256) as u8)
            .collect();
        let bytes = covering(width, height, &texels, Wrap::Clamp);
        check::full(&Container::open(&bytes).unwrap(), &mut |finding| {
            panic!("{finding}")
        });
        let bytes = covering(
            width,
            height,
            &vec![77; (width * height) as usize],
            Wrap::Repeat,
        );
        let material = open(&bytes);
        let mut stream = Stream::new(2);
        for _ in 0..50 {
            let edge = 10_f64.powf(stream.between(-4.0, 1.0));
            let footprint = Footprint {
                centre: [stream.between(-9.0, 9.0), stream.between(-9.0, 9.0)],
                edge_1: [edge, 0.3 * edge],
                edge_2: [-0.2 * edge, 0.6 * edge],
            };
            let opacity = material
                .layers()
                .next()
                .unwrap()
                .opacity(&footprint)
                .unwrap();
            assert!((opacity - 77.0 / 255.0).abs() < 1e-12, "{opacity}");
        }
    }
}
