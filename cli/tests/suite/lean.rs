//! `--method lean`: baked, described, queried and pictured without bins.

use crate::workshop::Workshop;

fn with_lean() -> Workshop {
    let workshop = Workshop::with_map();
    let said = workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--method=lean",
        "--roughness=0.2,0.02",
        "--finest-level=1",
    ]);
    assert!(
        said.contains("instance 2: lean 96 x 40, roughness 0.02, levels 1 to 6, repeat"),
        "{said}"
    );
    workshop
}

#[test]
fn every_command_takes_a_package_without_bins() {
    let workshop = with_lean();
    workshop.succeeds(&["verify", "map.glint"]);
    let text = workshop.succeeds(&["inspect", "map.glint"]);
    for words in [
        "lean 96 x 40",
        "MEAN",
        "SPRD",
        "left out: MEAN of instance 2",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let document = workshop.document(&["inspect", "map.glint", "--json"]);
    let instance = &document["instances"][1];
    assert_eq!(
        (
            &instance["kernel"],
            &instance["finest-level"],
            &instance["top-level"]
        ),
        (&"disk".into(), &1.into(), &6.into())
    );
    assert!(instance.get("bins-per-side").is_none());
    assert_eq!(
        document["metadata"]["recipe"]["methods"][0]["finest-level"],
        1
    );

    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.4,0.2,0.1,0,0,0.1,0,0\n0.4,0.2,9,0,0,7,0.1,0\n",
    );
    for (filter, says) in [
        (
            "box",
            "# method=lean kernel=disk filter=box roughness=0.02 finest-level=1 setting=default",
        ),
        (
            "gaussian",
            "# method=lean kernel=disk filter=gaussian roughness=0.02 finest-level=1 setting=default",
        ),
    ] {
        let filter = format!("--filter={filter}");
        let query = [
            "query",
            "map.glint",
            "--queries=q.csv",
            "--roughness=0.02",
            &filter,
        ];
        let answer = workshop.succeeds(&query);
        assert!(answer.starts_with(says), "{answer}");
        let densities = answer.lines().skip(2).map(|row| {
            let density = row.rsplit(',').next().expect("a column");
            density.parse::<f64>().expect("a number")
        });
        assert!(
            densities.filter(|density| *density > 0.0).count() == 2,
            "{answer}"
        );
    }
    workshop.succeeds(&["picture", "ndf", "map.glint", "-o=ndf.png", "--pixels=16"]);
    workshop.succeeds(&["picture", "ball", "map.glint", "-o=ball.png", "--pixels=16"]);
}

#[test]
fn settings_of_other_methods_are_refused() {
    let workshop = with_lean();
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.4,0.2,0.1,0,0,0.1,0,0\n",
    );
    let query = ["query", "map.glint", "--queries=q.csv"];
    for setting in ["--exact", "--paper"] {
        let run = workshop.run(&[&query[..], &[setting]].concat());
        assert_ne!(run.code, Some(0));
        assert!(run.stderr.contains("lean has no such setting"), "{run:#?}");
    }
    let tolerance = ["--filter=gaussian", "--tolerance=0.1"];
    workshop.refuses(
        2,
        &[&query[..], &tolerance].concat(),
        &["--tolerance: lean weighs no texels"],
    );
    workshop.refuses(
        6,
        &[&query[..], &["--method=flake-bins"]].concat(),
        &[
            "method flake-bins is not in the package",
            "lean with roughness 0.2",
        ],
    );
}

#[test]
fn options_of_bins_are_refused_and_levels_are_lean_s_alone() {
    let workshop = Workshop::with_map();
    let refuses = |options: &[&str], says: &[&str]| {
        workshop.refuses(
            2,
            &[&["bake", "map.png", "-o=map.glint"], options].concat(),
            says,
        );
    };
    let lean = ["--method=lean", "--roughness=0.1"];
    for (option, says) in [
        ("--bins=5", "--bins 5: lean has no bins"),
        ("--index=tiles", "--index tiles: lean has no bins"),
        ("--exact-normals", "--exact-normals: lean keeps moments"),
        ("--raster-normals", "--raster-normals: lean keeps moments"),
        (
            "--finest-level=7",
            "--finest-level 7: a map of 96 x 40 texels has levels 0 to 6",
        ),
        ("--finest-level=-1", "--finest-level"),
    ] {
        refuses(&[lean[0], lean[1], option], &[says]);
    }
    refuses(
        &[lean[0], lean[1], "--index=forest", "--leaf-size=8"],
        &["lean has no bins"],
    );
    refuses(
        &["--method=lean"],
        &["--roughness: lean is baked for given roughnesses"],
    );
    refuses(
        &["--method=flake-bins", "--roughness=0.1", "--finest-level=0"],
        &["--finest-level 0: flake-bins has no levels"],
    );
    // Two methods with a roughness, and still none that counts bins.
    refuses(
        &["--method=flake-bins,lean", "--roughness=0.1", "--bins=5"],
        &["--bins 5: flake-bins derives its bins"],
    );
}

#[test]
fn one_command_bakes_all_methods_and_each_option_finds_its_own() {
    let workshop = Workshop::with_map();
    workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=all.glint",
        "--method=specular-bins,lean,flake-bins",
        "--roughness=0.1",
        "--bins=9",
        "--finest-level=2",
        "--index=forest",
        "--leaf-size=8",
        "--exact-normals",
    ]);
    workshop.succeeds(&["verify", "all.glint"]);
    let document = workshop.document(&["inspect", "all.glint", "--json"]);
    let instances = document["instances"].as_array().expect("instances");
    assert_eq!(instances[0]["bins-per-side"], 9);
    assert_eq!(instances[1]["finest-level"], 2);
    assert_eq!(instances[2]["leaf-size"], 8);
}
