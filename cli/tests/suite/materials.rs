//! Layered materials, as a user writes and types them.

use crate::workshop::Workshop;
use serde_json::json;

const PAINT: &str = r#"
[[layer]]
kind = "coat"
roughness = 0.05

[[layer]]
kind = "glints"
map = "maps/map.png"
scale = 2
opacity-map = "cover.png"

[[layer]]
kind = "base"
diffuse = [0.01, 0.05, 0.25]
"#;

/// A folder with the material `paint.toml`, its maps, and `q.csv`.
fn workshop() -> Workshop {
    let workshop = Workshop::new();
    std::fs::create_dir(workshop.path("maps")).expect("a folder");
    workshop.succeeds(&["sample", "flakes", "--size=24x16", "-o=maps/map.png"]);
    image(&workshop, "cover.png", ::image::ColorType::L8);
    workshop.write("paint.toml", PAINT);
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.5,0.5,0.1,0,0,0.1,0,0\n",
    );
    workshop
}

/// An image of 8 × 4 texels of `colour`, of which the left half is full.
fn image(workshop: &Workshop, name: &str, colour: ::image::ColorType) {
    let texel = usize::from(colour.bytes_per_pixel());
    let texels: Vec<u8> = (0..32)
        .flat_map(|place| vec![if place % 8 < 4 { 255 } else { 0 }; texel])
        .collect();
    ::image::save_buffer(workshop.path(name), &texels, 8, 4, colour).expect(name);
}

/// Two layers with maps.
const TWO: &str = r#"
layer = [
    { kind = "coat", map = "maps/map.png", method = "lean", roughness = 0.1 },
    { kind = "glints", map = "maps/map.png" },
]
"#;

#[test]
fn one_command_bakes_a_material_and_inspect_lists_its_layers() {
    let workshop = workshop();
    let said = workshop.succeeds(&["bake", "paint.toml", "-o=paint.glint"]);
    for line in [
        "instance 1: cluster-tree 24 x 16",
        "layer 0: coat, roughness 0.05, ior 1.5, colour 1, opacity 1",
        "layer 1: glints, instance 1 repeated 2 x 2 times, f0 (0.912, 0.914, 0.92), opacity 1 of a map of 8 x 4",
        "layer 2: base, roughness 0.3, f0 0.04, diffuse (0.01, 0.05, 0.25), opacity 1",
    ] {
        assert!(said.contains(line), "{line} is not in {said}");
    }
    let text = workshop.succeeds(&["inspect", "paint.glint"]);
    assert!(text.contains("layer 1: normals: mean"), "{text}");
    assert!(text.contains("OPAC     layer 1"), "{text}");
    let document = workshop.document(&["inspect", "paint.glint", "--json"]);
    assert_eq!(
        document["layers"],
        json!([
            {
                "colour": [1.0, 1.0, 1.0], "f0": [0.0, 0.0, 0.0], "instance": null, "ior": 1.5, "kind": "coat", "layer": 0,
                "opacity": 1.0, "opacity-size": null, "opacity-wrap": null, "roughness": 0.05, "scale": [1.0, 1.0],
            },
            {
                "colour": [0.0, 0.0, 0.0], "f0": [0.912, 0.914, 0.92], "instance": 1, "ior": 0.0, "kind": "glints", "layer": 1,
                "opacity": 1.0, "opacity-size": [8, 4], "opacity-wrap": "repeat", "roughness": null, "scale": [2.0, 2.0],
            },
            {
                "colour": [0.01, 0.05, 0.25], "f0": [0.04, 0.04, 0.04], "instance": null, "ior": 0.0, "kind": "base", "layer": 2,
                "opacity": 1.0, "opacity-size": null, "opacity-wrap": null, "roughness": 0.3, "scale": [1.0, 1.0],
            },
        ])
    );
    assert_eq!(document["instances"][0]["layer"], 1);
    let names: Vec<_> = document["metadata"]["inputs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["name"].clone())
        .collect();
    assert_eq!(names, ["map.png", "cover.png"]);
    assert!(
        workshop
            .succeeds(&["verify", "paint.glint"])
            .contains("sound")
    );
}

#[test]
fn packages_of_materials_depend_on_the_material_and_its_maps_alone() {
    let workshop = workshop();
    workshop.succeeds(&[
        "bake",
        "paint.toml",
        "-o=one.glint",
        "--threads=1",
        "--depfile=one.d",
    ]);
    workshop.succeeds(&["bake", "paint.toml", "-o=many.glint", "--threads=7"]);
    assert_eq!(workshop.read("one.glint"), workshop.read("many.glint"));
    let rule = workshop.text("one.d");
    assert_eq!(rule, "one.glint: paint.toml maps/map.png cover.png\n");
    let again = workshop.succeeds(&["bake", "paint.toml", "-o=one.glint"]);
    assert!(again.contains("(up to date)"), "{again}");
    // Comments and order of keys are not in the recipe; everything else is.
    workshop.write(
        "paint.toml",
        PAINT
            .replace("scale = 2\n", "")
            .replace("kind = \"glints\"", "scale = 2 # twice\nkind = \"glints\""),
    );
    assert!(
        workshop
            .succeeds(&["bake", "paint.toml", "-o=one.glint"])
            .contains("(up to date)")
    );
    workshop.write("paint.toml", PAINT.replace("scale = 2", "scale = 3"));
    assert!(
        !workshop
            .succeeds(&["bake", "paint.toml", "-o=one.glint"])
            .contains("(up to date)")
    );
    image(&workshop, "cover.png", ::image::ColorType::La8);
    assert!(
        !workshop
            .succeeds(&["bake", "paint.toml", "-o=one.glint"])
            .contains("(up to date)")
    );
}

#[test]
fn queries_are_answered_by_one_layer() {
    let workshop = workshop();
    workshop.succeeds(&["bake", "paint.toml", "-o=paint.glint"]);
    let by_itself = workshop.succeeds(&["query", "paint.glint", "--queries=q.csv"]);
    assert!(
        by_itself.starts_with("# layer=1 method=cluster-tree "),
        "{by_itself}"
    );
    let named = workshop.succeeds(&["query", "paint.glint", "--queries=q.csv", "--layer=1"]);
    assert_eq!(by_itself, named);
    workshop.refuses(
        6,
        &["query", "paint.glint", "--queries=q.csv", "--layer=2"],
        &["--layer 2: it has no map; layers that have are 1 (cluster-tree)"],
    );

    workshop.write("two.toml", TWO);
    workshop.succeeds(&["bake", "two.toml", "-o=two.glint"]);
    workshop.refuses(
        2,
        &["query", "two.glint", "--queries=q.csv"],
        &["of layers 0 (lean), 1 (cluster-tree); say which"],
    );
    let top = workshop.succeeds(&["query", "two.glint", "--queries=q.csv", "--layer=0"]);
    assert!(top.starts_with("# layer=0 method=lean "), "{top}");
    // The same numbers as of a package with this map alone.
    workshop.succeeds(&[
        "bake",
        "maps/map.png",
        "-o=lean.glint",
        "--method=lean",
        "--roughness=0.1",
    ]);
    let alone = workshop.succeeds(&["query", "lean.glint", "--queries=q.csv"]);
    assert_eq!(top.replace("layer=0 ", ""), alone);
    workshop.refuses(
        6,
        &["query", "lean.glint", "--queries=q.csv", "--layer=1"],
        &["holds no material"],
    );
}

#[test]
fn balls_show_the_material_and_layers_one_by_one() {
    let workshop = workshop();
    workshop.succeeds(&["bake", "paint.toml", "-o=paint.glint"]);
    let ball = ["picture", "ball", "paint.glint", "--pixels=24", "--tiles=1"];
    let with = |more: &[&'static str]| [&ball[..], more].concat();
    let said = workshop.succeeds(&with(&["-o=all.png"]));
    assert!(
        said.contains("layers=coat,glints,base setting=default"),
        "{said}"
    );
    workshop.succeeds(&with(&["-o=again.png", "--threads=3"]));
    assert_eq!(workshop.read("all.png"), workshop.read("again.png"));
    let said = workshop.succeeds(&with(&["-o=paper.png", "--paper"]));
    assert!(said.contains("setting=paper"), "{said}");
    assert_ne!(workshop.read("all.png"), workshop.read("paper.png"));
    let said = workshop.succeeds(&with(&["-o=one.png", "--layer=1"]));
    assert!(said.contains("layer=1 method=cluster-tree"), "{said}");
    workshop.refuses(
        2,
        &with(&["-o=no.png", "--roughness=0.1"]),
        &["--roughness: a layered material says itself"],
    );
}

#[test]
fn materials_are_put_to_stress_as_materials_too() {
    let workshop = workshop();
    workshop.succeeds(&["bake", "paint.toml", "-o=paint.glint"]);
    let said = workshop.succeeds(&["stress", "paint.glint"]);
    for check in [
        "reciprocity material",
        "energy      material",
        "sampling    material",
        "continuity  material",
    ] {
        let line = said.lines().find(|line| line.starts_with(check));
        assert!(
            line.is_some_and(|line| line.ends_with("pass")),
            "{check}: {said}"
        );
    }
}

#[test]
fn material_files_that_cannot_be_baked_are_refused_with_their_line() {
    let workshop = workshop();
    let bake = ["bake", "paint.toml", "-o=paint.glint"];
    for (from, to, code, part) in [
        (
            "kind = \"base\"",
            "kind = \"bass\"",
            4,
            "paint.toml, line 13: kind: \"bass\" is none of coat, glints, base",
        ),
        (
            "scale = 2",
            "scale = 0",
            4,
            "paint.toml, line 9: scale of layer 1: 0: it must lie between 0.001 and 1000",
        ),
        ("maps/map.png", "map.png", 3, "map.png: cannot be opened"),
        ("maps/map.png", "cover.png", 4, "cover.png"),
        (
            "cover.png",
            "maps/map.png",
            4,
            "maps/map.png: red, green, blue where an opacity map has one grey channel",
        ),
        ("[[layer]]", "[layer]", 4, "paint.toml, line "),
    ] {
        workshop.write("paint.toml", PAINT.replace(from, to));
        workshop.refuses(code, &bake, &[part]);
    }
    workshop.write("paint.toml", PAINT);
    for (option, key) in [
        ("--roughness=0.1", "roughness"),
        ("--y=dx", "y"),
        ("--no-masking", "masking"),
        ("--method=lean", "method"),
    ] {
        workshop.refuses(
            2,
            &[&bake[..], &[option]].concat(),
            &[&format!("add the key {key} to")],
        );
    }
    workshop.refuses(
        3,
        &["bake", "paint-2.toml", "-o=paint.glint"],
        &["paint-2.toml: cannot be read"],
    );
    // No output may replace what a material is made from.
    for (lost, code) in [("paint.toml", 2), ("cover.png", 2)] {
        let output = format!("-o={lost}");
        workshop.refuses(code, &["bake", "paint.toml", &output], &["would be lost"]);
    }
}
