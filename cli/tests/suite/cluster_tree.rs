//! `cluster-tree`, what is baked if nothing else is asked for: one package, and every roughness, kernel and error by query.

use crate::densities::{QUERIES, QUERY, asked, error, oracle_map, query, write_queries};
use crate::workshop::Workshop;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::{disk, flake_bins, texel_weights};
use glintbake_format::model::{Filter, beckmann_from_intrinsic};

/// A folder with a map, the package that `bake` makes of it without being told how, and `q.csv`.
fn workshop() -> Workshop {
    let workshop = Workshop::with_map();
    workshop.succeeds(&["bake", "map.png", "-o=map.glint"]);
    write_queries(&workshop);
    workshop
}

/// The sums over texels that the queries ask for.
fn truth(map: &NormalMap, alpha: f64, is_disk: bool, filter: Filter) -> Vec<f64> {
    asked()
        .map(|(footprint, h)| {
            let texels = texel_weights(map, &footprint, filter);
            if is_disk {
                return disk::Prepared::from_weights(map, &texels, alpha).ndf(h);
            }
            let exact = flake_bins::Setting::Exact;
            flake_bins::Prepared::from_weights(map, &texels, alpha, exact).ndf(h)
        })
        .collect()
}

#[test]
fn a_bake_that_names_no_method_makes_a_tree() {
    let workshop = workshop();
    let words = "instance 1: cluster-tree 96 x 40, any roughness (0.02 by default), kernel beckmann by default, repeat";
    let said = workshop.succeeds(&["bake", "map.png", "-o=other.glint"]);
    assert!(said.contains(words), "{said}");
    let named = ["bake", "map.png", "-o=named.glint", "--method=cluster-tree"];
    workshop.succeeds(&named);
    assert!(workshop.read("named.glint") == workshop.read("map.glint"));

    workshop.succeeds(&["verify", "map.glint"]);
    let text = workshop.succeeds(&["inspect", "map.glint"]);
    for words in [words, "ROOT", "NODE", "LEAF", "MASK"] {
        assert!(text.contains(words), "{words:?} in {text}");
    }
    let document = workshop.document(&["inspect", "map.glint", "--json"]);
    assert_eq!(document["version"], serde_json::json!([1, 6]));
    let instance = &document["instances"][0];
    assert_eq!(
        (
            &instance["method"],
            &instance["roughness"],
            &instance["kernel"]
        ),
        (&"cluster-tree".into(), &0.02.into(), &"beckmann".into())
    );
    assert!(instance.get("bins-per-side").is_none());
}

#[test]
fn what_is_stored_is_what_a_query_gets_that_names_nothing() {
    let workshop = workshop();
    let default =
        "# method=cluster-tree kernel=beckmann filter=box roughness=0.02 eps=0.002 setting=default";
    assert_eq!(query(&workshop, &[]).0, default);
    workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--roughness=0.3,0.05",
        "--kernel=disk",
        "--filter=gaussian",
    ]);
    let document = workshop.document(&["inspect", "map.glint", "--json"]);
    let nodes = document["sections"].as_array().expect("sections").iter();
    let nodes = nodes.filter(|section| section["kind"] == "NODE");
    assert_eq!(nodes.count(), 1, "one tree for both");
    let text = workshop.succeeds(&["inspect", "map.glint"]);
    assert!(
        text.contains("left out: NODE of instance 2: stored once"),
        "{text}"
    );
    let (said, first) = query(&workshop, &[]);
    let stored = "# method=cluster-tree kernel=disk filter=gaussian roughness=0.3 eps=0.002 ";
    assert!(said.starts_with(stored), "{said}");
    let named = ["--roughness=0.05", "--kernel=beckmann", "--filter=box"];
    let (said, second) = query(&workshop, &named);
    let stored = "# method=cluster-tree kernel=beckmann filter=box roughness=0.05 eps=0.002 ";
    assert!(said.starts_with(stored), "{said}");
    assert_ne!(first, second);
}

#[test]
fn one_package_answers_for_every_roughness_kernel_filter_and_error() {
    let workshop = workshop();
    let map = oracle_map(&workshop);
    for (option, alpha) in [
        ("--roughness=0.01", 0.01),
        ("--roughness=0.25", 0.25),
        ("--intrinsic-roughness=0.05", beckmann_from_intrinsic(0.05)),
        // The ends of what it takes, given either way.
        ("--roughness=0.0001", 1e-4),
        ("--roughness=1", 1.0),
        (
            "--intrinsic-roughness=0.0001",
            beckmann_from_intrinsic(1e-4),
        ),
        ("--intrinsic-roughness=0.25", beckmann_from_intrinsic(0.25)),
    ] {
        for (filter, of_filter) in [
            ("--filter=box", Filter::Box),
            ("--filter=gaussian", Filter::Gaussian),
        ] {
            for (kernel, is_disk) in [("--kernel=beckmann", false), ("--kernel=disk", true)] {
                let (said, found) = query(&workshop, &[option, filter, kernel]);
                assert!(said.contains(&format!(" roughness={alpha} ")), "{said}");
                let expected = truth(&map, alpha, is_disk, of_filter);
                // Needles may miss every texel of the table: then there is nothing to be off by.
                if expected.iter().sum::<f64>() < 1e-3 {
                    assert!(found.iter().sum::<f64>() < 2e-3, "{said}: {found:?}");
                    continue;
                }
                let off = error(&found, &expected);
                assert!(off < 5e-3, "{said}: {off}, {found:?} for {expected:?}");
                let (tight, found) = query(&workshop, &[option, filter, kernel, "--eps=1e-6"]);
                assert!(tight.contains(" eps=0.000001 "), "{tight}");
                // Needles see the rounding of normals in leaves; under blunt kernels errors follow eps less evenly.
                if alpha > 0.005 && alpha < 0.3 {
                    let off = error(&found, &expected);
                    assert!(off < 4e-4, "{tight}: {off}, {found:?} for {expected:?}");
                }
            }
        }
    }
}

#[test]
fn pictures_and_documents_name_what_was_asked_for() {
    let workshop = workshop();
    let pictures: [&[&str]; 2] = [
        &["picture", "ndf", "map.glint", "-o=a.png", "--pixels=16"],
        &["picture", "ball", "map.glint", "-o=a.png", "--pixels=16"],
    ];
    for picture in pictures {
        let mut drawn = Vec::new();
        for options in [
            &["--roughness=0.3"][..],
            &["--roughness=0.3", "--kernel=disk", "--eps=0.01"],
            &["--intrinsic-roughness=0.01"],
        ] {
            let document = workshop.document(&[picture, options, &["--json"]].concat());
            let setting = document["setting"].as_str().expect("words");
            assert!(setting.starts_with("method=cluster-tree "), "{setting}");
            for option in options {
                let (name, value) = option.trim_start_matches("--").split_once('=').expect("=");
                let word = match name {
                    "intrinsic-roughness" => {
                        let sigma = value.parse().expect("a number");
                        format!("roughness={}", beckmann_from_intrinsic(sigma))
                    }
                    _ => format!("{name}={value}"),
                };
                assert!(setting.split(' ').any(|found| found == word), "{setting}");
            }
            drawn.push(workshop.read("a.png"));
        }
        assert!(drawn[0] != drawn[1] && drawn[0] != drawn[2] && drawn[1] != drawn[2]);
    }
    let queried = workshop.document(
        &[
            &QUERY[..],
            &["-o=a.csv", "--roughness=0.3", "--eps=1e-5", "--json"],
        ]
        .concat(),
    );
    assert_eq!(
        (&queried["rows"], &queried["setting"]),
        (
            &QUERIES.len().into(),
            &"method=cluster-tree kernel=beckmann filter=box roughness=0.3 eps=0.00001 setting=default".into()
        )
    );
}

#[test]
fn what_a_tree_does_not_answer_for_is_refused_with_what_it_does() {
    let workshop = workshop();
    let range = "must lie between 0.0001 and 1";
    let refuses = |code: i32, options: &[&str], says: &[&str]| {
        let commands: [&[&str]; 3] = [
            &QUERY,
            &["picture", "ndf", "map.glint", "-o=new.png"],
            &["picture", "ball", "map.glint", "-o=new.png"],
        ];
        for command in commands {
            workshop.refuses(code, &[command, options].concat(), says);
        }
    };
    for alpha in ["0", "-1", "0.00009", "1.01", "inf", "NaN"] {
        let option = format!("--roughness={alpha}");
        let says = format!("map.glint: --roughness {alpha}: Beckmann roughness ");
        refuses(2, &[&option], &[&says, range]);
    }
    refuses(
        2,
        &["--intrinsic-roughness=0.8"],
        &["--intrinsic-roughness 0.8 (roughness 1.13", range],
    );
    refuses(2, &["--roughness=ten"], &["--roughness", "ten"]);
    for eps in ["0", "-0.1", "0.2", "1e-10", "inf", "nan", "small"] {
        let option = format!("--eps={eps}");
        refuses(2, &[&option], &["--eps", eps, "a number from 1e-9 to 0.1"]);
    }
    for kernel in ["bin-average", "gaussian", ""] {
        let option = format!("--kernel={kernel}");
        refuses(2, &[&option], &["--kernel", "beckmann or disk"]);
    }
    refuses(
        2,
        &["--filter=gaussian", "--tolerance=0.1"],
        &["--tolerance: cluster-tree ", "use --eps instead"],
    );
    for setting in ["--exact", "--paper"] {
        refuses(
            6,
            &[setting],
            &["map.glint: ", setting, "of flake-bins", "leave it out"],
        );
    }
    refuses(
        6,
        &["--method=flake-bins", "--roughness=0.1"],
        &[
            "method flake-bins and roughness 0.1 is not in the package",
            "which holds: cluster-tree with any roughness;",
        ],
    );
    let run = workshop.run(&[&QUERY[..], &["-o=a.csv", "--roughness=7", "--json"]].concat());
    let document: serde_json::Value = serde_json::from_str(&run.stdout).expect("a document");
    assert_eq!(run.code, Some(2), "{run:#?}");
    assert_eq!(document["error"]["kind"], "usage");
    assert_eq!(document["error"]["exit-code"], 2);
}

#[test]
fn other_methods_answer_for_what_they_were_baked_for_alone() {
    let workshop = workshop();
    for (method, roughness, taker) in [
        (
            "flake-bins",
            "--roughness=0.2",
            "bake with --method cluster-tree",
        ),
        ("lean", "--roughness=0.2", "bake with --method cluster-tree"),
        (
            "specular-bins",
            "--bins=9",
            "bake with --method cluster-tree",
        ),
    ] {
        let method_option = format!("--method={method}");
        let bake = ["bake", "map.png", "-o=map.glint", &method_option, roughness];
        workshop.succeeds(&bake);
        for option in ["--kernel=disk", "--eps=0.01"] {
            let name = option.split('=').next().expect("a name");
            workshop.refuses(
                2,
                &[&QUERY[..], &[option]].concat(),
                &["map.glint: ", name, "only cluster-tree", method, taker],
            );
        }
        for option in ["--roughness=0.1", "--intrinsic-roughness=0.1"] {
            workshop.refuses(
                6,
                &[&QUERY[..], &[option]].concat(),
                &[
                    "roughness 0.1",
                    "is not in the package, which holds: ",
                    method,
                    "or with cluster-tree, which answers for all",
                ],
            );
        }
        workshop.refuses(
            2,
            &[&bake[..], &["--kernel=disk"]].concat(),
            &["--kernel disk: ", method, "has one kernel"],
        );
    }
}

#[test]
fn options_of_other_methods_are_refused_with_the_method_that_takes_them() {
    let workshop = Workshop::with_map();
    let refuses = |option: &str, says: &[&str]| {
        for method in [None, Some("--method=cluster-tree")] {
            let bake = ["bake", "map.png", "-o=map.glint"].into_iter();
            let arguments: Vec<_> = bake.chain(method).chain(option.split(' ')).collect();
            workshop.refuses(2, &arguments, says);
        }
    };
    let has = |option: &str, why: &str, taker: &str| {
        let says = format!("cluster-tree {why}; leave the option out, or add --method {taker}");
        refuses(&format!("--{option}"), &[&says]);
    };
    has("bins=9", "has no bins", "specular-bins");
    for index in ["forest", "tiles", "none"] {
        let why = "has no bins whose texels are looked for";
        has(&format!("index={index}"), why, "flake-bins");
    }
    has(
        "index=forest --leaf-size=8",
        "has no bins whose texels are looked for",
        "flake-bins",
    );
    has(
        "exact-normals",
        "keeps every normal, and with --raster-normals in a raster too",
        "flake-bins",
    );
    has("finest-level=1", "keeps every texel", "lean");
    refuses(
        "--leaf-size=8",
        &[
            "--leaf-size 8: only a forest has leaves to choose; add --method flake-bins --index forest",
        ],
    );
    refuses("--kernel=bin-average", &["beckmann or disk"]);
    // And with it they are taken.
    for added in [
        "--method=flake-bins,cluster-tree --roughness=0.1 --index=forest --leaf-size=8 --exact-normals",
        "--method=cluster-tree,specular-bins --bins=9",
        "--method=cluster-tree,lean --roughness=0.1 --finest-level=1",
        "--kernel=disk",
        "--index=auto",
    ] {
        let bake = ["bake", "map.png", "-o=map.glint"].into_iter();
        let arguments: Vec<_> = bake.chain(added.split(' ')).collect();
        workshop.succeeds(&arguments);
        workshop.succeeds(&["verify", "map.glint"]);
    }
}

#[test]
fn of_several_methods_the_tree_serves_the_roughness_that_none_was_baked_for() {
    let workshop = workshop();
    workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--method=flake-bins,cluster-tree",
        "--roughness=0.1",
    ]);
    for (options, answers) in [
        (&[][..], "# method=flake-bins "),
        (&["--roughness=0.1"], "# method=flake-bins "),
        (&["--roughness=0.2"], "# method=cluster-tree "),
        (&["--method=cluster-tree"], "# method=cluster-tree "),
        (
            &["--method=cluster-tree", "--kernel=disk"],
            "# method=cluster-tree kernel=disk ",
        ),
    ] {
        let (said, _) = query(&workshop, options);
        assert!(said.starts_with(answers), "{options:?}: {said}");
    }
    let kernel = [&QUERY[..], &["--kernel=disk"]].concat();
    workshop.refuses(
        2,
        &kernel,
        &["flake-bins answers; add --method cluster-tree"],
    );
    let both = ["--method=flake-bins", "--roughness=0.2"];
    workshop.refuses(
        6,
        &[&QUERY[..], &both].concat(),
        &["cluster-tree with any roughness"],
    );
}
