//! `lobes`: what is baked, what answers, and what is refused, as a user types it.

use crate::densities::{QUERY, asked, error, oracle_map, query, write_queries};
use crate::workshop::Workshop;
use glintbake_bake::oracle::lobes::Prepared;
use glintbake_format::model::{LobeLattice, beckmann_from_intrinsic};
use serde_json::json;

const BAKE: [&str; 4] = ["bake", "map.png", "-o=map.glint", "--method=lobes"];

/// A folder with a map, `map.glint` baked for `lobes` with `options`, and `q.csv`.
fn workshop(options: &[&str]) -> Workshop {
    let workshop = Workshop::with_map();
    workshop.succeeds(&[&BAKE, options].concat());
    write_queries(&workshop);
    workshop
}

#[test]
fn every_lattice_is_baked_described_and_verified() {
    let workshop = Workshop::with_map();
    for (options, words, curved, count) in [
        (&[][..], "curved lobes, 1 a texel", true, 1),
        (&["--lobes=curved"], "curved lobes, 1 a texel", true, 1),
        (&["--lobes=flat"], "flat lobes, 1 a texel", false, 1),
        (&["--lobes=curved-4"], "curved lobes, 4 a texel", true, 4),
        (&["--lobes=flat-4"], "flat lobes, 4 a texel", false, 4),
    ] {
        let said = workshop.succeeds(&[&BAKE[..], options, &["--force"]].concat());
        let line =
            format!("instance 1: lobes 96 x 40, any roughness (0.02 by default), {words}, repeat");
        assert!(said.contains(&line), "{said}");
        let found = workshop.succeeds(&["verify", "map.glint"]);
        assert!(found.contains("map.glint: sound"), "{found}");
        let text = workshop.succeeds(&["inspect", "map.glint"]);
        assert!(text.contains(&line), "{text}");
        let document = workshop.document(&["inspect", "map.glint", "--json"]);
        let instance = &document["instances"][0];
        let found = json!([
            instance["method"],
            instance["kernel"],
            instance["filter"],
            instance["roughness"],
            instance["curved"],
            instance["lobes-per-texel"]
        ]);
        assert_eq!(
            found,
            json!(["lobes", "disk", "gaussian", 0.02, curved, count])
        );
        let recipe = &document["metadata"]["recipe"]["methods"][0];
        match options.first().and_then(|option| option.split_once('=')) {
            Some((_, lattice)) => assert_eq!(recipe["lattice"], lattice),
            None => assert!(recipe.get("lattice").is_none(), "{recipe}"),
        }
        assert_eq!(recipe["filter"], "gaussian");
    }
}

#[test]
fn more_merging_makes_smaller_packages() {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "waves", "--size=128", "-o=map.png"]);
    let bytes = |options: &[&str]| {
        let baked = workshop.document(&[&BAKE[..], options, &["--json"]].concat());
        baked["bytes"].as_u64().expect("a number")
    };
    let (none, default, much) = (
        bytes(&["--merge-error=0", "--roughness=0.2"]),
        bytes(&["--roughness=0.2"]),
        bytes(&["--merge-error=0.2", "--roughness=0.2"]),
    );
    assert!(none >= default && default > much, "{none} {default} {much}");
}

#[test]
fn one_package_answers_for_every_roughness_as_the_sum_over_lobes_does() {
    for (name, lattice) in ["curved", "flat", "curved-4", "flat-4"]
        .into_iter()
        .zip(LobeLattice::ALL)
    {
        let lobes = format!("--lobes={name}");
        let workshop = workshop(&[&lobes, "--roughness=0.3,0.005"]);
        let map = oracle_map(&workshop);
        let (said, _) = query(&workshop, &[]);
        assert_eq!(
            said,
            format!(
                "# method=lobes kernel=disk filter=gaussian roughness=0.3 lobes={name} setting=default"
            )
        );
        for (option, alpha) in [
            ("--roughness=0.01", 0.01),
            ("--roughness=0.3", 0.3),
            ("--intrinsic-roughness=0.05", beckmann_from_intrinsic(0.05)),
            ("--roughness=3", 3.0),
        ] {
            let mut both = Vec::new();
            for (setting, is_normalised) in [(None, true), (Some("--paper"), false)] {
                let options: Vec<_> = [option].into_iter().chain(setting).collect();
                let (said, found) = query(&workshop, &options);
                let word = if is_normalised { "default" } else { "paper" };
                let words = format!(" roughness={alpha} lobes={name} setting={word}");
                assert!(said.ends_with(&words), "{said}");
                let expected: Vec<f64> = asked()
                    .map(|(footprint, half_vector)| {
                        Prepared::new(&map, &footprint, *lattice, is_normalised)
                            .ndf(half_vector, alpha)
                    })
                    .collect();
                let off = error(&found, &expected);
                assert!(off < 1e-3, "{said}: {off}, {found:?} for {expected:?}");
                both.push(found);
            }
            // The least footprint ripples, but for four lobes a texel as wide as it is.
            assert_ne!(both[0], both[1], "{name} {option}");
        }
    }
}

#[test]
fn what_lobes_do_not_answer_for_is_refused_with_what_does() {
    let workshop = workshop(&[]);
    let commands: [&[&str]; 3] = [
        &QUERY,
        &["picture", "ndf", "map.glint", "-o=new.png"],
        &["picture", "ball", "map.glint", "-o=new.png"],
    ];
    let refuses = |code: i32, options: &[&str], says: &[&str]| {
        for command in commands {
            workshop.refuses(code, &[command, options].concat(), says);
        }
    };
    refuses(
        2,
        &["--filter=box"],
        &[
            "map.glint: --filter box: lobes is made for Gaussian footprints",
            "bake with --method cluster-tree for boxes, or leave it out",
        ],
    );
    for option in ["--kernel=disk", "--eps=0.1"] {
        let (name, _) = option.split_once('=').expect("a value");
        let says = "only cluster-tree has a choice of it, and lobes answers";
        refuses(2, &[option], &["map.glint: ", name, says]);
    }
    refuses(
        2,
        &["--tolerance=0.1"],
        &["--tolerance: lobes weighs no texels and has none; leave it out"],
    );
    refuses(
        6,
        &["--exact"],
        &["--exact: a setting of flake-bins, and lobes answers"],
    );
    for alpha in ["0", "-1", "0.0000009", "10.1", "NaN"] {
        let option = format!("--roughness={alpha}");
        let says = "Beckmann roughness must lie between 0.000001 and 10";
        refuses(2, &[&option], &[&format!("--roughness {alpha}: "), says]);
    }
    let strict = [&QUERY[..], &["--strict"]].concat();
    workshop.refuses(
        2,
        &strict,
        &["only cluster-tree has bounds", "lobes answers"],
    );
    refuses(
        6,
        &["--method=lean", "--roughness=0.1"],
        &["which holds: lobes with any roughness;"],
    );
}

#[test]
fn options_of_lobes_are_theirs_alone_and_read_as_they_were_typed() {
    let workshop = Workshop::with_map();
    let refuses = |options: &[&str], says: &[&str]| {
        workshop.refuses(
            2,
            &[&["bake", "map.png", "-o=map.glint"], options].concat(),
            says,
        );
    };
    for (method, name) in [
        (&[][..], "cluster-tree"),
        (&["--method=lean", "--roughness=0.1"], "lean"),
        (&["--method=flake-bins", "--roughness=0.1"], "flake-bins"),
        (&["--method=specular-bins"], "specular-bins"),
    ] {
        for (option, said, thing) in [
            ("--lobes=flat-4", "--lobes flat-4", "lobes"),
            ("--lobes=curved", "--lobes curved", "lobes"),
            (
                "--merge-error=0.001",
                "--merge-error 0.001",
                "lobes to merge",
            ),
        ] {
            let says = format!(
                "{said}: {name} has no {thing}; leave the option out, or add --method lobes"
            );
            refuses(&[method, &[option]].concat(), &[&says]);
        }
    }
    let lobes = "--method=lobes";
    for word in ["round", "Curved", "curved-2", ""] {
        let option = format!("--lobes={word}");
        refuses(
            &[lobes, &option],
            &["--lobes", word, "curved, flat, curved-4, flat-4"],
        );
    }
    for error in ["-0.1", "0.51", "NaN", "inf"] {
        let option = format!("--merge-error={error}");
        let says = format!("--merge-error {error}: ");
        refuses(&[lobes, &option], &[&says, "between 0 and 0.5"]);
    }
    refuses(
        &[lobes, "--filter=box"],
        &[
            "--filter box: lobes is made for Gaussian footprints; leave the option out, or use cluster-tree",
        ],
    );
    for (option, says) in [
        ("--bins=9", "--bins 9: lobes has no bins"),
        (
            "--index=tiles",
            "--index tiles: lobes has no bins whose texels",
        ),
        ("--kernel=disk", "--kernel disk: lobes has no kernel but"),
        ("--exact-normals", "--exact-normals: lobes has no second"),
        ("--raster-normals", "--raster-normals: lobes has no second"),
        ("--finest-level=1", "--finest-level 1: lobes has no level"),
        (
            "--interpolate=linear",
            "--interpolate linear: lobes has no surface",
        ),
    ] {
        refuses(&[lobes, option], &[says]);
    }
    refuses(
        &[lobes, "--leaf-size=8"],
        &["add --method flake-bins --index forest"],
    );
}

#[test]
fn each_of_several_methods_has_its_own_filter_and_options() {
    let workshop = Workshop::with_map();
    write_queries(&workshop);
    let filters = |options: &[&str]| {
        let bake = ["bake", "map.png", "-o=map.glint", "--json"];
        let baked = workshop.document(&[&bake, options].concat());
        let instances = baked["instances"].as_array().expect("instances");
        let filters = instances.iter().map(|instance| &instance["filter"]);
        json!(filters.collect::<Vec<_>>())
    };
    let several = "--method=lobes,cluster-tree,lean";
    let of_both = [several, "--roughness=0.1", "--kernel=disk"];
    assert_eq!(filters(&of_both), json!(["gaussian", "box", "box"]));
    let boxes = [&of_both[..], &["--filter=box"]].concat();
    assert_eq!(filters(&boxes), json!(["gaussian", "box", "box"]));
    let gaussians = [&of_both[..], &["--filter=gaussian"]].concat();
    assert_eq!(
        filters(&gaussians),
        json!(["gaussian", "gaussian", "gaussian"])
    );
    filters(&[
        several,
        "--roughness=0.1",
        "--lobes=flat",
        "--merge-error=0.01",
    ]);
    workshop.succeeds(&["verify", "map.glint"]);
    // What is asked of nobody is asked of the first, of whatever roughness.
    for (options, answers) in [
        (&[][..], "# method=lobes "),
        (&["--roughness=0.3"], "# method=lobes "),
        (
            &["--roughness=0.3", "--method=cluster-tree"],
            "# method=cluster-tree ",
        ),
    ] {
        let (said, _) = query(&workshop, options);
        assert!(said.starts_with(answers), "{options:?}: {said}");
    }
    workshop.refuses(
        2,
        &[&QUERY[..], &["--filter=box"]].concat(),
        &["lobes is made for Gaussian footprints; add --method cluster-tree, or leave it out"],
    );
}

#[test]
fn roughnesses_too_sharp_for_the_lobes_are_warned_of() {
    let workshop = workshop(&["--roughness=0.2,0.05"]);
    let warning = |roughness: &str| {
        let run = workshop.run(&[&QUERY[..], &[roughness]].concat());
        assert_eq!(run.code, Some(0), "{run:#?}");
        run.stderr
    };
    let said = warning("--roughness=0.004");
    assert_eq!(said.lines().count(), 1, "{said}");
    for text in [
        "warning: map.glint: its lobes are rounded for a roughness of 0.05",
        "Bake with --roughness 0.004",
    ] {
        assert!(said.contains(text), "{text:?} in {said}");
    }
    assert_eq!(warning("--roughness=0.006"), "");
    assert_eq!(warning("--roughness=2"), "");
}

#[test]
fn flat_lobes_glint_in_rows_on_eight_bits_and_curved_ones_do_not() {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "waves", "--size=48", "--bits=8", "-o=map.png"]);
    write_queries(&workshop);
    let warning = |arguments: &[&str]| {
        let run = workshop.run(arguments);
        assert_eq!(run.code, Some(0), "{run:#?}");
        run.stderr
    };
    for (lobes, warns) in [("--lobes=flat", true), ("--lobes=curved", false)] {
        let bake = [&BAKE[..], &[lobes, "--force"]].concat();
        assert_eq!(warning(&bake), "", "the default must be wide enough");
        let said = warning(&[&QUERY[..], &["--roughness=0.003"]].concat());
        let rows = said.contains("map.glint: its normals lie on a lattice of step 0.00784");
        assert_eq!(rows, warns, "{lobes}: {said}");
        assert_eq!(said.lines().count(), usize::from(warns), "{said}");
    }
}

#[test]
fn pictures_are_drawn_of_lobes_with_their_setting() {
    let workshop = workshop(&["--lobes=flat"]);
    let mut drawn = Vec::new();
    for options in [&["--roughness=0.1"][..], &["--roughness=0.1", "--paper"]] {
        let of_a_point = [
            "picture",
            "ndf",
            "map.glint",
            "-o=a.png",
            "--pixels=16",
            "--texels=0.2",
        ];
        let document = workshop.document(&[&of_a_point, options, &["--json"]].concat());
        let setting = document["setting"].as_str().expect("words");
        let word = if options.len() > 1 {
            "paper"
        } else {
            "default"
        };
        assert!(
            setting.ends_with(&format!(" roughness=0.1 lobes=flat setting={word}")),
            "{setting}"
        );
        drawn.push(document["peak"].as_f64().expect("a number"));
    }
    assert!(drawn[0] != drawn[1], "the plain sum ripples: {drawn:?}");
    let ball = ["picture", "ball", "map.glint", "-o=b.png", "--pixels=16"];
    let document = workshop.document(&[&ball[..], &["--json"]].concat());
    assert_eq!(
        document["setting"],
        "method=lobes kernel=disk filter=gaussian roughness=0.02 lobes=flat setting=default"
    );
}
