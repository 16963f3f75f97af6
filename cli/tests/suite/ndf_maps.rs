//! `ndf-maps`: noise maps, tiny examples, and the surfaces that their copies make up, as a user types it.

use crate::workshop::Workshop;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use glintbake_bake::noise::{self, NoiseCopy};

const BAKE: [&str; 5] = [
    "bake",
    "tiny.png",
    "-o=tiny.glint",
    "--method=ndf-maps",
    "--intrinsic-roughness=0.03",
];

/// A folder with an example of eight texels a side.
fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "waves", "--size=8", "-o=tiny.png"]);
    workshop
}

#[test]
fn noise_maps_say_the_same_as_exr_and_nearly_as_png() {
    let workshop = workshop();
    let make = |name: &str| {
        workshop.succeeds(&["sample", "noise-map", "--instances=60", "--seed=3", name]);
    };
    make("-o=noise.exr");
    make("-o=noise.png");
    let read = |name: &str| {
        noise::read(&workshop.path(name))
            .expect("a noise map")
            .copies
    };
    let (exact, rounded) = (read("noise.exr"), read("noise.png"));
    assert_eq!((exact.len(), rounded.len()), (60, 60));
    for (one, other) in exact.iter().zip(&rounded) {
        for axis in 0..2 {
            assert!((one.centre[axis] - other.centre[axis]).abs() < 1.1 / 65536.0);
            for entry in 0..2 {
                let difference = one.matrix[axis][entry] - other.matrix[axis][entry];
                assert!(difference.abs() < 1e-3, "{one:?} {other:?}");
            }
        }
    }
}

#[test]
fn a_surface_is_baked_from_a_noise_map_inspected_verified_and_expanded() {
    let workshop = workshop();
    workshop.succeeds(&[
        "sample",
        "noise-map",
        "--instances=100",
        "--seed=3",
        "-o=noise.exr",
    ]);
    let options = ["--noise=noise.exr", "--size=80", "--depfile=tiny.d"];
    let said = workshop.succeeds(&[&BAKE[..], &options].concat());
    assert!(said.contains("% of the surface covered"), "{said}");
    let rule = workshop.text("tiny.d");
    assert!(
        rule.contains("tiny.png") && rule.contains("noise.exr"),
        "{rule}"
    );
    let text = workshop.succeeds(&["inspect", "tiny.glint"]);
    assert!(
        text.contains("scattered copies of 8 x 8 texels, 86 NDF images"),
        "{text}"
    );
    let verified = workshop.succeeds(&["verify", "tiny.glint", "--full"]);
    assert!(verified.contains("sound"), "{verified}");
    let said = workshop.succeeds(&["expand", "tiny.glint", "--size=160", "-o=large.png"]);
    assert!(said.contains("160 x 160"), "{said}");
    // Nothing has changed, then the noise has.
    let again = workshop.succeeds(&[&BAKE[..], &options].concat());
    assert!(again.contains("up to date"), "{again}");
    workshop.succeeds(&[
        "sample",
        "noise-map",
        "--instances=100",
        "--seed=4",
        "-o=noise.exr",
    ]);
    let again = workshop.succeeds(&[&BAKE[..], &options].concat());
    assert!(!again.contains("up to date"), "{again}");
}

#[test]
fn what_is_seen_through_the_command_line_is_what_is_baked() {
    let workshop = workshop();
    workshop.succeeds(&[&BAKE[..], &["--tiled", "--transform=scale=2,rotate=30"]].concat());
    let text = workshop.succeeds(&["inspect", "tiny.glint"]);
    assert!(text.contains("tiled copies of 8 x 8 texels"), "{text}");
    workshop.succeeds(&[&BAKE[..], &["--instances=40", "--seed=7", "--size=50"]].concat());
    let text = workshop.succeeds(&["inspect", "tiny.glint"]);
    assert!(text.contains("40 seen, 0 hidden"), "{text}");
    workshop.succeeds(&["picture", "ndf", "tiny.glint", "--texels=4", "-o=ndf.png"]);
    workshop.succeeds(&[
        "picture",
        "ball",
        "tiny.glint",
        "--pixels=32",
        "-o=ball.png",
    ]);
}

/// Writes `copies` as `noise.exr`.
fn write_noise(workshop: &Workshop, copies: &[NoiseCopy]) {
    let channel = |name: &str, value: &dyn Fn(&NoiseCopy) -> f64| {
        let samples = copies.iter().map(|copy| value(copy) as f32).collect();
        AnyChannel::new(name, FlatSamples::F32(samples))
    };
    let channels = [
        channel("center.x", &|copy| copy.centre[0]),
        channel("center.y", &|copy| copy.centre[1]),
        channel("matrix.xx", &|copy| copy.matrix[0][0]),
        channel("matrix.xy", &|copy| copy.matrix[0][1]),
        channel("matrix.yx", &|copy| copy.matrix[1][0]),
        channel("matrix.yy", &|copy| copy.matrix[1][1]),
    ];
    let layer = Layer::new(
        (copies.len(), 1),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    Image::from_layer(layer)
        .write()
        .to_file(workshop.path("noise.exr"))
        .expect("written");
}

#[test]
fn hostile_noise_maps_are_refused_with_the_pixel_at_fault() {
    let workshop = workshop();
    let plain = NoiseCopy {
        centre: [0.5; 2],
        matrix: [[1.0, 0.0], [0.0, 1.0]],
    };
    let nan = f64::NAN;
    for (copy, what) in [
        (
            NoiseCopy {
                centre: [7.0, 0.5],
                ..plain
            },
            "beyond the surface",
        ),
        (
            NoiseCopy {
                centre: [nan, 0.5],
                ..plain
            },
            "the centre is no number",
        ),
        (
            NoiseCopy {
                matrix: [[1.0, 2.0], [2.0, 4.0]],
                ..plain
            },
            "singular",
        ),
        (
            NoiseCopy {
                matrix: [[1.0, nan], [0.0, 1.0]],
                ..plain
            },
            "no number",
        ),
        (
            NoiseCopy {
                matrix: [[1e9, 0.0], [0.0, 1e9]],
                ..plain
            },
            "scales by",
        ),
    ] {
        write_noise(&workshop, &[plain, copy]);
        let options = ["--noise=noise.exr", "--size=64"];
        workshop.refuses(4, &[&BAKE[..], &options].concat(), &["pixel (1, 0)", what]);
    }
    workshop.write("noise.exr", b"no image");
    let options = ["--noise=noise.exr", "--size=64"];
    workshop.refuses(3, &[&BAKE[..], &options].concat(), &["noise.exr"]);
    let options = ["--noise=tiny.png", "--size=64"];
    let what = "red, green, blue and alpha";
    workshop.refuses(4, &[&BAKE[..], &options].concat(), &[what]);
    for count in ["0", "10000000"] {
        let options = [&*format!("--instances={count}"), "--size=64"];
        let what = "1 to 4194304 copies";
        workshop.refuses(2, &[&BAKE[..], &options].concat(), &[what]);
    }
}
