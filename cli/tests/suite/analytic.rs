//! `analytic`: surfaces between texels, and what `picture ndf` sets beside them, as a user types it.

use crate::densities::{QUERY, asked, error, oracle_map, query, write_queries};
use crate::workshop::Workshop;
use glintbake_bake::oracle::analytic::Prepared;
use glintbake_format::model::Interpolation;
use serde_json::{Value, json};

const BAKE: [&str; 4] = ["bake", "map.png", "-o=map.glint", "--method=analytic"];

/// A folder with a smooth map, `map.glint` baked for `analytic` with `options`, and `q.csv`.
fn workshop(options: &[&str]) -> Workshop {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "waves", "--size=32x20", "-o=map.png"]);
    workshop.succeeds(&[&BAKE, options].concat());
    write_queries(&workshop);
    workshop
}

#[test]
fn every_interpolation_is_baked_and_answers_as_the_integral_does_in_both_forms() {
    for (options, interpolation) in [
        (&[][..], Interpolation::Linear),
        (&["--interpolate=none"], Interpolation::None),
        (&["--interpolate=linear"], Interpolation::Linear),
        (&["--interpolate=catmull-rom"], Interpolation::CatmullRom),
    ] {
        let workshop = workshop(options);
        let name = interpolation.name();
        let line = format!(
            "instance 1: analytic 32 x 20, any roughness (0.02 by default), interpolation {name}, repeat"
        );
        let text = workshop.succeeds(&["inspect", "map.glint"]);
        assert!(text.contains(&line), "{text}");
        assert!(
            workshop
                .succeeds(&["verify", "map.glint"])
                .contains("sound")
        );
        let document = workshop.document(&["inspect", "map.glint", "--json"]);
        let instance = &document["instances"][0];
        assert_eq!(
            json!([
                instance["interpolation"],
                instance["filter"],
                instance["kernel"]
            ]),
            json!([name, "gaussian", "disk"])
        );
        if !options.is_empty() {
            let recipe = &document["metadata"]["recipe"]["methods"][0];
            assert_eq!(recipe["interpolation"], name);
        }

        let map = oracle_map(&workshop);
        for (option, alpha) in [("--roughness=0.1", 0.1), ("--roughness=3", 3.0)] {
            let expected: Vec<f64> = asked()
                .map(|(footprint, half_vector)| {
                    Prepared::new(&map, &footprint, interpolation).ndf(half_vector, alpha)
                })
                .collect();
            // The paper's error function is within 0.01 of the true one.
            for (setting, word, bound) in
                [(None, "default", 1e-3), (Some("--paper"), "paper", 0.05)]
            {
                let options: Vec<_> = [option].into_iter().chain(setting).collect();
                let (said, found) = query(&workshop, &options);
                let words = format!(
                    "# method=analytic kernel=disk filter=gaussian roughness={alpha} interpolation={name} setting={word}"
                );
                assert_eq!(said, words);
                let off = error(&found, &expected);
                assert!(off < bound, "{said}: {off}, {found:?} for {expected:?}");
            }
        }
    }
}

#[test]
fn what_it_does_not_answer_for_is_refused_and_its_option_is_its_own() {
    let workshop = workshop(&[]);
    let refuses = |code: i32, options: &[&str], says: &[&str]| {
        workshop.refuses(code, &[&QUERY[..], options].concat(), says);
    };
    refuses(
        2,
        &["--filter=box"],
        &["--filter box: analytic is made for Gaussian footprints"],
    );
    refuses(
        2,
        &["--roughness=11"],
        &["--roughness 11: Beckmann roughness must lie between 0.000001 and 10"],
    );
    refuses(2, &["--kernel=beckmann"], &["analytic answers"]);
    refuses(
        6,
        &["--exact"],
        &["a setting of flake-bins, and analytic answers"],
    );
    let bakes = |options: &[&str], says: &[&str]| {
        let bake = ["bake", "map.png", "-o=new.glint"];
        workshop.refuses(2, &[&bake, options].concat(), says);
    };
    for (method, name) in [(&[][..], "cluster-tree"), (&["--method=lobes"], "lobes")] {
        let says = format!(
            "--interpolate catmull-rom: {name} has no surface between texels; leave the option out, or add --method analytic"
        );
        bakes(&[method, &["--interpolate=catmull-rom"]].concat(), &[&says]);
    }
    let analytic = "--method=analytic";
    bakes(
        &[analytic, "--interpolate=cubic"],
        &["--interpolate", "none, linear, catmull-rom"],
    );
    bakes(
        &[analytic, "--lobes=flat"],
        &["--lobes flat: analytic has no lobes"],
    );
    bakes(
        &[analytic, "--filter=box"],
        &["--filter box: analytic is made for Gaussian footprints; leave the option out"],
    );
}

/// A picture of `map.glint` beside samples of its map.
fn beside(workshop: &Workshop, options: &[&str]) -> Value {
    let picture = [
        "picture",
        "ndf",
        "map.glint",
        "-o=a.png",
        "--pixels=16",
        "--texels=6",
        "--roughness=0.1",
        "--reference=map.png",
        "--json",
    ];
    workshop.document(&[&picture, options].concat())
}

#[test]
fn samples_of_the_map_add_up_to_its_answer() {
    let workshop = workshop(&["--interpolate=catmull-rom"]);
    let found = beside(&workshop, &["--samples=2e6"]);
    let reference = &found["reference"];
    let keys: Vec<_> = reference.as_object().expect("an object").keys().collect();
    assert_eq!(
        keys,
        ["distance", "integral", "interpolation", "peak", "samples"]
    );
    assert_eq!(
        (&reference["interpolation"], &reference["samples"]),
        (&"catmull-rom".into(), &2_000_000.into())
    );
    let distance = |document: &Value| {
        document["reference"]["distance"]
            .as_f64()
            .expect("a number")
    };
    assert!(distance(&found) < 0.02, "{found}");
    let few = beside(&workshop, &["--samples=2e3"]);
    assert!(distance(&few) > 0.05, "{few}");
    // Two squares with a column between.
    let bytes = workshop.read("a.png");
    let [width, height] =
        [16, 20].map(|at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four")));
    assert_eq!([width, height], [33, 16]);
    let other = beside(&workshop, &["--samples=2e6", "--interpolate=none"]);
    assert_eq!(other["reference"]["interpolation"], "none");
    assert!(distance(&other) > distance(&found), "{other}");
    let mirrored = beside(&workshop, &["--samples=2e6", "--y=dx"]);
    assert!(distance(&mirrored) > 0.1, "{mirrored}");
}

#[test]
fn a_reference_that_cannot_be_compared_is_refused() {
    let workshop = workshop(&[]);
    workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--method=analytic,cluster-tree",
    ]);
    workshop.succeeds(&["sample", "flat", "--size=8", "-o=small.png"]);
    let refuses = |code: i32, options: &[&str], says: &[&str]| {
        let picture = ["picture", "ndf", "map.glint", "-o=new.png", "--pixels=4"];
        workshop.refuses(code, &[&picture, options].concat(), says);
    };
    let reference = "--reference=map.png";
    refuses(
        2,
        &[reference, "--method=cluster-tree"],
        &["--reference: samples are drawn from a Gaussian; add --filter gaussian"],
    );
    refuses(
        2,
        &[reference, "--method=cluster-tree", "--filter=gaussian"],
        &["cluster-tree answers with beckmann", "--kernel disk"],
    );
    refuses(
        2,
        &["--reference=small.png"],
        &["--reference small.png: it has 8 x 8 texels, and the package 32 x 20"],
    );
    refuses(
        2,
        &[reference, "--wrap=clamp"],
        &[
            "--reference map.png: the package continues beyond its border by repeat; add --wrap repeat",
        ],
    );
    refuses(3, &["--reference=none.png"], &["none.png"]);
    refuses(2, &["--samples=2e6"], &["--reference"]);
    for samples in ["0", "-1", "1.5", "many", "1e12", "NaN"] {
        let option = format!("--samples={samples}");
        refuses(
            2,
            &[reference, &option],
            &["--samples", samples, "such as 2e7"],
        );
    }
}
