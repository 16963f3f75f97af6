//! `bake`, `inspect` and `verify` on sound input.

use crate::workshop::Workshop;

#[test]
fn a_bake_says_what_is_in_the_package_and_the_package_is_sound() {
    let workshop = Workshop::with_map();
    let said = workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--method=flake-bins",
        "--roughness=0.005,0.02",
    ]);
    let lines: Vec<_> = said.lines().collect();
    assert_eq!(lines.len(), 5, "{said}");
    let bytes = workshop.read("map.glint").len() as f64;
    assert_eq!(
        lines[0],
        format!(
            "map.glint: {:.1} KB, {:.2} bytes a texel",
            bytes / 1e3,
            bytes / (96.0 * 40.0)
        )
    );
    assert!(
        lines[1].starts_with("  instance 1: flake-bins 96 x 40, roughness 0.005, 472 x 472 bins"),
        "{said}"
    );
    assert!(
        lines[2].starts_with("  instance 2: flake-bins 96 x 40, roughness 0.02, 118 x 118 bins"),
        "{said}"
    );
    assert!(
        lines[3].starts_with("  normals: length 1.0000 on average"),
        "{said}"
    );
    assert!(lines[4].ends_with("0 clamped, 0 repaired"), "{said}");
    assert_eq!(
        workshop.succeeds(&["verify", "map.glint"]),
        "map.glint: sound (structure, checksums and hash)\n"
    );
    assert_eq!(
        workshop.succeeds(&["verify", "map.glint", "--full"]),
        "map.glint: sound (structure, checksums and hash)\n"
    );
    assert_eq!(
        workshop.succeeds(&["verify", "map.glint", "--structure", "--no-mmap"]),
        "map.glint: sound (structure)\n"
    );
}

#[test]
fn a_raster_of_normals_is_stored_once_and_listed() {
    let workshop = Workshop::with_map();
    let tree = ["--method=cluster-tree", "--roughness=0.1,0.2"];
    let bake = |more: &[&str]| {
        workshop.succeeds(&[&["bake", "map.png", "-o=map.glint"], &tree[..], more].concat());
        workshop.succeeds(&["verify", "map.glint", "--full"]);
        let listing = workshop.succeeds(&["inspect", "map.glint"]);
        let rasters = listing
            .lines()
            .filter(|line| {
                ["RAST", "RASH"]
                    .iter()
                    .any(|kind| line.trim_start().starts_with(kind))
            })
            .count();
        (rasters, workshop.read("map.glint").len())
    };
    let (none, without) = bake(&[]);
    let (one, with) = bake(&["--raster-normals"]);
    assert_eq!((none, one), (0, 1));
    // 96 x 40 texels in blocks, an entry of the table, and what metadata says of it.
    let more = with - without;
    assert!((4 * 96 * 40..4 * 96 * 40 + 600).contains(&more), "{more}");
}

#[test]
fn several_methods_take_the_options_that_are_theirs() {
    let workshop = Workshop::with_map();
    let options = [
        "--method=specular-bins,flake-bins",
        "--roughness=0.1",
        "--intrinsic-roughness=0.03",
        "--bins=31",
        "--index=forest",
        "--leaf-size=7",
        "--exact-normals",
    ];
    workshop.succeeds(&[&["bake", "map.png", "-o=map.glint"], &options[..]].concat());
    let document = workshop.document(&["inspect", "map.glint", "--json"]);
    let instances = document["instances"].as_array().expect("instances");
    let facts: Vec<_> = instances
        .iter()
        .map(|instance| {
            (
                instance["method"].as_str().expect("a word"),
                instance["roughness"].as_f64(),
                instance["bins-per-side"].as_u64().expect("a number"),
                instance["leaf-size"].as_u64().expect("a number"),
            )
        })
        .collect();
    // ceil(5 / sin(atan(3 α / √2))) of [AWKK21] eq. 16, by hand.
    assert_eq!(
        facts,
        [
            ("specular-bins", None, 31, 7),
            ("flake-bins", Some(0.1), 25, 7),
            ("flake-bins", Some(0.03 * 2_f64.sqrt()), 56, 7),
        ]
    );
    let exact: Vec<_> = document["sections"]
        .as_array()
        .expect("sections")
        .iter()
        .filter(|section| section["kind"] == "EXNM")
        .map(|section| section["instance"].as_u64())
        .collect();
    assert_eq!(exact, [Some(3)], "once, with the finest bins");
    workshop.succeeds(&["verify", "map.glint"]);
}

#[test]
fn mirrors_need_no_roughness_and_have_127_bins_by_default() {
    let workshop = Workshop::with_map();
    let said = workshop.succeeds(&["bake", "map.png", "-o=map.glint", "--method=specular-bins"]);
    assert!(
        said.contains("specular-bins 96 x 40, 127 x 127 bins"),
        "{said}"
    );
}

#[test]
fn inspect_shows_header_instances_sections_and_where_the_map_came_from() {
    let workshop = Workshop::with_package();
    let said = workshop.succeeds(&["inspect", "map.glint"]);
    let input = format!("  input map.png, {} bytes", workshop.read("map.png").len());
    for text in [
        "map.glint: glintbake package version 1.6, ",
        "  instance 1: flake-bins 96 x 40, roughness 0.2",
        "  instance 3: specular-bins 96 x 40",
        "  INST     all                3  ",
        "  TMAP     2               3840  7680 B       2.000\n",
        "  index: none for instance 1: a scan of all 3840 texels takes no longer than finding lists\n",
        input.as_str(),
        "  normals: mean (",
        "  MASK     1               2048  4096 B       1.067\n",
        "  left out: EXNM of instance 1: not asked for; --exact-normals adds it\n",
        "  left out: MASK of instance 3: stored once, with the first instance of the map\n",
        "  recipe  ",
        "  content ",
    ] {
        assert!(said.contains(text), "{text:?} in {said}");
    }
    for option in ["--no-mmap", "--trust", "--quiet"] {
        assert_eq!(workshop.succeeds(&["inspect", "map.glint", option]), said);
    }
}

#[test]
fn masking_is_stored_once_and_left_out_when_asked_to() {
    let workshop = Workshop::with_map();
    let bake = |output: &str, extra: &[&str]| {
        let options = ["--method=flake-bins,specular-bins", "--roughness=0.2,0.02"];
        workshop.succeeds(&[&["bake", "map.png", "-o", output], &options[..], extra].concat());
        workshop.succeeds(&["verify", output]);
        let document = workshop.document(&["inspect", output, "--json"]);
        let mut holders = Vec::new();
        for section in document["sections"].as_array().expect("sections") {
            if section["kind"] == "MASK" {
                assert_eq!(section["bytes"], 4096);
                assert_eq!(section["critical"], false);
                holders.push(section["instance"].as_u64().expect("a number"));
            }
        }
        let reasons: Vec<_> = document["metadata"]["left-out"]
            .as_array()
            .expect("what was left out")
            .iter()
            .filter(|left_out| left_out["section"] == "MASK")
            .map(|left_out| {
                (
                    left_out["instance"].as_u64().expect("a number"),
                    left_out["reason"].as_str().expect("words").to_owned(),
                )
            })
            .collect();
        let asked = document["metadata"]["recipe"]["methods"][0]["masking"].as_bool();
        (holders, reasons, asked)
    };
    let once = "stored once, with the first instance of the map".to_owned();
    assert_eq!(
        bake("with.glint", &[]),
        (vec![1], vec![(2, once.clone()), (3, once)], Some(true))
    );
    let no = "left out by --no-masking".to_owned();
    assert_eq!(
        bake("without.glint", &["--no-masking"]),
        (
            vec![],
            vec![(1, no.clone()), (2, no.clone()), (3, no)],
            Some(false)
        )
    );
    assert!(workshop.read("with.glint").len() >= workshop.read("without.glint").len() + 4096);

    // The distribution itself is the same; the option is another recipe, so the package is baked anew.
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.3,0.4,0.5,0,0,0.5,0.1,0\n",
    );
    let query = |package: &str| {
        let options = ["--queries=q.csv", "--roughness=0.2"];
        workshop.succeeds(&[&["query", package], &options[..]].concat())
    };
    assert_eq!(query("with.glint"), query("without.glint"));
    let before = workshop.read("with.glint");
    assert!(bake("with.glint", &["--no-masking"]).0.is_empty());
    assert!(workshop.read("with.glint") != before);
    // Pictures take cavities for it.
    workshop.succeeds(&[
        "picture",
        "ball",
        "without.glint",
        "--roughness=0.2",
        "-o=ball.png",
    ]);
    assert!(
        workshop
            .succeeds(&["bake", "--help"])
            .contains("--no-masking")
    );
}

#[test]
fn maps_of_one_texel_and_of_one_row_are_maps() {
    let workshop = Workshop::new();
    for size in ["1x1", "1x40", "40x1"] {
        let size = format!("--size={size}");
        workshop.succeeds(&["sample", "noise", &size, "-o=map.png"]);
        workshop.succeeds(&[
            "bake",
            "map.png",
            "-o=map.glint",
            "--method=flake-bins,specular-bins",
            "--roughness=0.2",
            "--exact-normals",
            "--index=forest",
            "--leaf-size=1",
        ]);
        workshop.succeeds(&["verify", "map.glint"]);
        workshop.write(
            "q.csv",
            "u,v,e1u,e1v,e2u,e2v,s,t\n0.3,0.4,1,0,0,1,0,0\n-7.1,3,2.5,0.5,0,0.01,0.1,0.2\n",
        );
        assert_eq!(
            workshop
                .succeeds(&["query", "map.glint", "--queries=q.csv"])
                .lines()
                .count(),
            4
        );
    }
}

#[test]
fn a_preview_is_a_picture_beside_the_package() {
    let workshop = Workshop::with_map();
    let said = workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--roughness=0.2",
        "--preview=ball.png",
    ]);
    assert!(said.ends_with("ball.png: preview\n"), "{said}");
    let picture = image::open(workshop.path("ball.png")).expect("a PNG");
    assert_eq!((picture.width(), picture.height()), (512, 512));
}
