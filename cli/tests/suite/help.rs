//! Help, version, and what a wrong word is answered with.

use crate::workshop::Workshop;
use std::collections::BTreeSet;

const VERBS: [&str; 8] = [
    "sample", "bake", "inspect", "verify", "query", "picture", "report", "stress",
];

#[test]
fn without_arguments_the_verbs_are_listed_on_standard_error() {
    let run = Workshop::new().run(&[]);
    assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""));
    for verb in VERBS {
        assert!(run.stderr.contains(&format!("\n  {verb} ")), "{run:#?}");
    }
}

#[test]
fn help_and_version_are_results_of_every_verb() {
    let workshop = Workshop::new();
    let help = workshop.succeeds(&["--help"]);
    for verb in VERBS {
        assert!(help.contains(&format!("\n  {verb} ")), "{help}");
        let of_verb = workshop.succeeds(&[verb, "--help"]);
        assert!(
            of_verb.contains(&format!("Usage: glintbake {verb} ")),
            "{of_verb}"
        );
    }
    assert_eq!(
        workshop.succeeds(&["--version"]),
        concat!("glintbake ", env!("CARGO_PKG_VERSION"), "\n")
    );
}

#[test]
fn help_names_every_method_and_kind() {
    let workshop = Workshop::new();
    for verb in ["bake", "query", "report"] {
        let help = workshop.succeeds(&[verb, "--help"]);
        for method in glintbake_format::model::METHODS {
            assert!(help.contains(method.name()), "{}: {help}", method.name());
        }
    }
    let help = workshop.succeeds(&["sample", "--help"]);
    for kind in glintbake_samples::KINDS {
        assert!(help.contains(kind.description()), "{kind}: {help}");
    }
}

#[test]
fn a_wrong_word_is_answered_with_the_right_ones() {
    let workshop = Workshop::with_package();
    let bake = ["bake", "map.png", "-o", "new.glint", "--roughness=0.1"];
    let wrong = |extra: &[&'static str], right: &[&str]| {
        workshop.refuses(2, &[&bake, extra].concat(), right);
    };
    wrong(&["--method=flake"], &["flake-bins, specular-bins"]);
    wrong(&["--channels=rgb"], &["xyz, xy, rg, ga, ra, ag"]);
    wrong(&["--y=up"], &["gl, dx"]);
    wrong(&["--zero=127"], &["127.5, 128"]);
    wrong(&["--wrap=mirror"], &["repeat, clamp"]);
    wrong(&["--input=bump"], &["normal, height"]);
    wrong(&["--range=half"], &["auto, unorm, snorm"]);
    workshop.refuses(
        2,
        &["sample", "flake", "-o", "new.png"],
        &[
            "flakes, voronoi, scratches, brushed, dents, waves, spectrum, ocean, leather, flat, noise",
        ],
    );
    workshop.refuses(
        2,
        &["query", "map.glint", "--queries=q.csv", "--filter=tent"],
        &["box or gaussian"],
    );
    workshop.refuses(2, &["polish"], &["unrecognized subcommand 'polish'"]);
}

/// The codes at the end of `--help`.
fn documented_codes(help: &str) -> BTreeSet<i32> {
    let (_, codes) = help.split_once("Exit codes:\n").expect("a list of codes");
    codes
        .lines()
        .map(|line| line.split_whitespace().next().expect("a code"))
        .map(|code| code.parse().expect("a number"))
        .collect()
}

#[test]
fn every_exit_code_of_the_help_but_that_for_defects_can_be_had() {
    let workshop = Workshop::with_package();
    workshop.write("text.csv", "u,v\n0,0\n");
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.5,0.5,0.1,0,0,0.1,0,0\n",
    );
    let mut bytes = workshop.read("map.glint");
    bytes.truncate(5000);
    workshop.write("cut.glint", bytes);
    let produced: BTreeSet<i32> = [
        &["verify", "map.glint"][..],
        &["verify", "cut.glint"],
        &["bake", "map.png", "-o", "new.glint", "--roughness=7"],
        &["bake", "none.png", "-o", "new.glint", "--roughness=0.1"],
        &["query", "map.glint", "--queries=text.csv"],
        &["inspect", "cut.glint"],
        &["query", "map.glint", "--queries=q.csv", "--roughness=0.3"],
        &["sample", "flat", "-o", "none/new.png"],
    ]
    .into_iter()
    .map(|arguments| workshop.run(arguments).code.expect("a code"))
    .collect();
    let mut documented = documented_codes(&workshop.succeeds(&["--help"]));
    assert!(documented.remove(&70), "defects have a code of their own");
    assert_eq!(produced, documented);
}
