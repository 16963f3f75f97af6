//! `sample`: every kind, at both depths, the same bytes for the same seed.

use crate::workshop::Workshop;
use glintbake_samples::{KINDS, Kind, Options, generate};

#[test]
fn every_kind_is_written_at_the_size_and_depth_asked_for() {
    let workshop = Workshop::new();
    for kind in KINDS {
        for bits in ["8", "16"] {
            let kind = kind.name();
            let said =
                workshop.succeeds(&["sample", kind, "--size=96x40", "--bits", bits, "-o=map.png"]);
            assert_eq!(
                said,
                format!("map.png: {kind} 96 x 40, seed 0, {bits} bit, OpenGL green\n")
            );
            let image = image::open(workshop.path("map.png")).expect("a PNG");
            assert_eq!((image.width(), image.height()), (96, 40));
            let color = match bits {
                "8" => image::ColorType::Rgb8,
                _ => image::ColorType::Rgb16,
            };
            assert_eq!(image.color(), color, "{kind}");
        }
    }
}

#[test]
fn texels_are_those_of_the_generator() {
    let workshop = Workshop::new();
    workshop.succeeds(&[
        "sample",
        "scratches",
        "--size=24x16",
        "--seed=7",
        "--scale=0.5",
        "--roughness=0.4",
        "--density=2",
        "-o=map.png",
    ]);
    let options = Options {
        width: 24,
        height: 16,
        seed: 7,
        scale: 0.5,
        roughness: 0.4,
        density: 2.0,
    };
    let expected = generate(Kind::Scratches, &options).expect("valid options");
    let image = image::open(workshop.path("map.png")).expect("a PNG");
    assert_eq!(image.into_rgb16().into_raw(), expected.rgb16());
}

#[test]
fn a_seed_gives_the_same_bytes_on_every_run_and_another_seed_others() {
    let workshop = Workshop::new();
    let bytes = |seed: &str, threads: &str, name: &str| {
        workshop.succeeds(&[
            "sample",
            "noise",
            "--size=33",
            "--seed",
            seed,
            "--threads",
            threads,
            "-o",
            name,
        ]);
        workshop.read(name)
    };
    let first = bytes("1", "1", "a.png");
    assert_eq!(first, bytes("1", "1", "a.png"));
    assert_eq!(first, bytes("1", "4", "b.png"));
    assert_ne!(first, bytes("2", "1", "a.png"));
}

#[test]
fn sizes_and_spreads_out_of_range_are_refused() {
    let workshop = Workshop::new();
    let refuses = |option: &str, says: &str| {
        workshop.refuses(2, &["sample", "flakes", "-o=map.png", option], &[says]);
    };
    for size in ["0", "x", "96x", "-5", "96x40x3", "16385", "4e2", ""] {
        let says = if size.is_empty() { "--size" } else { "16384" };
        refuses(&format!("--size={size}"), says);
    }
    refuses("--bits=12", "8 or 16");
    refuses("--roughness=-0.1", "roughness -0.1 is not a number from 0");
    refuses("--roughness=1.5", "roughness 1.5 is not a number from 0");
    refuses("--scale=nan", "scale NaN is not a number from");
    refuses("--density=-1", "density -1 is not a number from");
    refuses("--seed=-1", "--seed");
    workshop.refuses(
        2,
        &["sample", "flakes", "-o=map.png", "--roughness", "-0.1"],
        &["roughness -0.1 is not a number from 0"],
    );
}
