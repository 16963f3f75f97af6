//! Values of options that no file can make right: refused before anything is read or written.

use crate::workshop::Workshop;

#[test]
fn roughness_out_of_range_or_named_twice_is_refused() {
    // The map need not exist: options are looked at first.
    let workshop = Workshop::new();
    let refuses = |options: &[&str], says: &[&str]| {
        workshop.refuses(
            2,
            &[&["bake", "map.png", "-o=map.glint"], options].concat(),
            says,
        );
    };
    let range = "must lie between 0.0001 and 1";
    for alpha in ["0", "-1", "10", "1.0001", "0.00009", "inf"] {
        let option = format!("--roughness={alpha}");
        refuses(&[&option], &[&format!("--roughness {alpha}: "), range]);
    }
    refuses(&["--roughness", "-1"], &["--roughness -1: ", range]);
    refuses(&["--roughness=nan"], &["--roughness NaN: ", range]);
    refuses(&["--roughness=0.1,ten"], &["--roughness", "ten"]);
    refuses(&["--roughness="], &["--roughness"]);
    for method in ["--method=flake-bins", "--method=flake-bins,cluster-tree"] {
        refuses(&[method], &["--roughness: flake-bins", "such as 0.01"]);
    }
    refuses(
        &["--roughness=0.1,0.2,0.1"],
        &["--roughness 0.1", "named twice"],
    );
    refuses(
        &["--intrinsic-roughness=1"],
        &["--intrinsic-roughness 1 (roughness 1.414", range],
    );
    refuses(
        &[
            "--roughness=0.1",
            "--intrinsic-roughness=0.0707106781186547",
        ],
        &["too near to 0.1 to be told apart"],
    );
}

#[test]
fn options_of_another_method_are_refused_with_the_reason() {
    let workshop = Workshop::new();
    let refuses = |options: &[&str], says: &[&str]| {
        workshop.refuses(
            2,
            &[&["bake", "map.png", "-o=map.glint"], options].concat(),
            says,
        );
    };
    refuses(
        &["--method=flake-bins", "--roughness=0.1", "--bins=64"],
        &["--bins 64", "derives its bins from the roughness"],
    );
    let mirrors = "--method=specular-bins";
    refuses(
        &[mirrors, "--roughness=0.1"],
        &["--roughness 0.1", "mirror flakes", "flake-bins"],
    );
    refuses(
        &[mirrors, "--exact-normals"],
        &["--exact-normals: mirror flakes"],
    );
    for method in [&[mirrors][..], &["--method=flake-bins", "--roughness=0.1"]] {
        refuses(
            &[method, &["--raster-normals"]].concat(),
            &["--raster-normals", "has no tree", "cluster-tree"],
        );
    }
    for bins in ["0", "65536"] {
        let option = format!("--bins={bins}");
        refuses(&[mirrors, &option], &["between 1 and 65535"]);
    }
    refuses(&[mirrors, "--bins=many"], &["--bins", "many"]);
    refuses(
        &[
            "--method=flake-bins",
            "--roughness=0.1",
            "--index=forest",
            "--leaf-size=0",
        ],
        &["--leaf-size 0", "at least 1"],
    );
    for index in [
        None,
        Some("--index=auto"),
        Some("--index=tiles"),
        Some("--index=none"),
    ] {
        let leaves = ["--method=flake-bins", "--roughness=0.1", "--leaf-size=8"];
        refuses(
            &leaves.into_iter().chain(index).collect::<Vec<_>>(),
            &["--leaf-size 8: only a forest has leaves to choose; add --index forest"],
        );
    }
    for index in ["trees", "Tiles", "dense", ""] {
        refuses(
            &["--roughness=0.1", &format!("--index={index}")],
            &["--index", index, "auto, forest, tiles, none"],
        );
    }
    refuses(
        &["--method=flake-bins,flake-bins", "--roughness=0.1"],
        &["--method flake-bins", "named twice"],
    );
    refuses(&["--method=", "--roughness=0.1"], &["--method"]);
}

#[test]
fn options_without_meaning_for_the_input_are_refused_with_its_name() {
    let workshop = Workshop::with_map();
    let refuses = |options: &[&str], says: &[&str]| {
        let bake = ["bake", "map.png", "-o=map.glint", "--roughness=0.1"];
        workshop.refuses(2, &[&bake, options].concat(), says);
    };
    refuses(&["--range=snorm"], &["map.png: ", "--range snorm"]);
    refuses(&["--exr-layer=N"], &["map.png: ", "only OpenEXR"]);
    refuses(&["--exr-channels=X,Y"], &["map.png: ", "only OpenEXR"]);
    refuses(
        &["--input=height", "--height-scale=nan"],
        &["map.png: ", "--height-scale NaN"],
    );
    refuses(
        &["--input=height", "--channels=ga"],
        &["map.png: ", "--channels"],
    );
}

#[test]
fn threads_are_a_number_a_machine_can_have() {
    let workshop = Workshop::with_map();
    for threads in ["-1", "1025", "100000", "two"] {
        let option = format!("--threads={threads}");
        workshop.refuses(
            2,
            &[
                "bake",
                "map.png",
                "-o=new.glint",
                "--roughness=0.1",
                &option,
            ],
            &["--threads", threads],
        );
    }
}

#[test]
fn sizes_of_pictures_are_checked_before_the_package_is_opened() {
    let workshop = Workshop::with_package();
    let ndf = |option: &[&str], says: &[&str]| {
        let picture = ["picture", "ndf", "map.glint", "-o=new.png"];
        workshop.refuses(2, &[&picture, option].concat(), says);
    };
    for uv in ["0.5", "0.5,", "a,b", "0.5;0.5", "nan,0", "0,inf", "1,2,3"] {
        ndf(&[&format!("--uv={uv}")], &["--uv", uv, "such as 0.5,0.5"]);
    }
    ndf(&["--texels=-1"], &["--texels", "0 or more"]);
    ndf(&["--texels", "-1"], &["--texels", "0 or more"]);
    ndf(&["--texels=nan"], &["--texels", "0 or more"]);
    ndf(&["--zoom=0"], &["--zoom", "above 0"]);
    ndf(&["--zoom", "-2"], &["--zoom", "above 0"]);
    ndf(&["--pixels=0"], &["--pixels", "from 1 to 16384"]);
    ndf(&["--pixels=16385"], &["--pixels", "from 1 to 16384"]);
    ndf(&["--exact", "--paper"], &["--exact", "--paper"]);
    let ball = |option: &str, says: &[&str]| {
        workshop.refuses(
            2,
            &["picture", "ball", "map.glint", "-o=new.png", option],
            says,
        );
    };
    ball("--tiles=0", &["--tiles", "above 0"]);
    ball("--tiles=inf", &["--tiles", "above 0"]);
    ball("--pixels=0", &["--pixels", "from 1 to 16384"]);
    workshop.refuses(2, &["picture", "cube", "map.glint"], &["cube"]);
}

#[test]
fn memory_is_a_size_with_its_unit() {
    let workshop = Workshop::new();
    for size in [
        "6", "GB", "6GiB", "-1GB", "0GB", "0.5MB", "nanGB", "infGB", "1e9GB", "6 gb",
    ] {
        let option = format!("--memory={size}");
        let bake = [
            "bake",
            "map.png",
            "-o=map.glint",
            "--roughness=0.1",
            &option,
        ];
        let run = workshop.run(&bake);
        assert_eq!(run.code, Some(2), "{size}: {run:#?}");
        assert!(
            run.stderr.contains("such as 6GB or 500MB"),
            "{size}: {run:#?}"
        );
    }
    let sound = Workshop::with_map();
    for size in ["6GB", "500MB", "0.25GB", "6 GB"] {
        let option = format!("--memory={size}");
        sound.succeeds(&[
            "bake",
            "map.png",
            "-o=map.glint",
            "--roughness=0.1",
            &option,
        ]);
    }
}
