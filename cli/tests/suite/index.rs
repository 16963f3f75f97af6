//! `bake --index`: other sections, the same answers.

use crate::workshop::Workshop;
use serde_json::Value;

const KINDS: [&str; 4] = ["auto", "tiles", "forest", "none"];

/// Bakes `map.png` to `KIND.glint` for each kind.
fn bake_each(workshop: &Workshop) {
    for kind in KINDS {
        let (output, index) = (format!("-o={kind}.glint"), format!("--index={kind}"));
        let said = workshop.succeeds(&[
            "bake",
            "map.png",
            &output,
            &index,
            "--method=flake-bins,specular-bins",
            "--roughness=0.2,0.02",
            "--exact-normals",
        ]);
        let words = match kind {
            "forest" => ", forest of leaf size 32, ",
            "none" => ", bin map alone, ",
            _ => ", tile lists, ",
        };
        assert_eq!(said.matches(words).count(), 3, "{said}");
        workshop.succeeds(&["verify", &format!("{kind}.glint")]);
    }
}

fn inspected(workshop: &Workshop, kind: &str) -> Value {
    workshop.document(&["inspect", &format!("{kind}.glint"), "--json"])
}

/// Kinds of the sections of instance 2.
fn sections(document: &Value) -> Vec<&str> {
    let sections = document["sections"].as_array().expect("sections");
    sections
        .iter()
        .filter(|section| section["instance"] == 2)
        .map(|section| section["kind"].as_str().expect("four letters"))
        .collect()
}

#[test]
fn each_kind_has_its_sections_and_inspect_says_which() {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "scratches", "--size=160x136", "-o=map.png"]);
    bake_each(&workshop);
    for (kind, inverse, leaf_size, own) in [
        ("auto", "tiles", 0, &["LBLK", "LCNT", "LIST", "PAGE"][..]),
        ("tiles", "tiles", 0, &["LBLK", "LCNT", "LIST", "PAGE"]),
        ("forest", "forest", 32, &["FRST", "IBMP", "INDX"]),
        ("none", "none", 0, &[]),
    ] {
        let document = inspected(&workshop, kind);
        for instance in document["instances"].as_array().expect("instances") {
            assert_eq!(instance["inverse"], inverse);
            assert_eq!(instance["leaf-size"], leaf_size);
        }
        for method in 0..2 {
            let recipe = &document["metadata"]["recipe"]["methods"][method];
            assert_eq!(recipe["inverse"], kind);
        }
        let all = ["FRST", "IBMP", "INDX", "LBLK", "LCNT", "LIST", "PAGE"];
        let found = sections(&document);
        let expected: Vec<_> = all.into_iter().filter(|name| own.contains(name)).collect();
        let inverse: Vec<_> = found
            .iter()
            .copied()
            .filter(|name| all.contains(name))
            .collect();
        assert_eq!(inverse, expected, "{kind}");
        assert!(found.contains(&"TMAP"), "{kind}: {found:?}");
    }
    let size = |kind: &str| workshop.read(&format!("{kind}.glint")).len();
    assert!(size("none") < size("tiles"));
    assert!(size("tiles") < size("forest"));
}

#[test]
fn every_kind_gives_the_same_densities() {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "scratches", "--size=160x136", "-o=map.png"]);
    bake_each(&workshop);
    let mut table = "u,v,e1u,e1v,e2u,e2v,s,t\n".to_owned();
    for size in [0.003, 0.05, 0.3, 1.0, 2.7] {
        for half_vector in ["0,0", "0.02,-0.03", "-0.15,0.1"] {
            let edges = format!("{size},{},{},{size}", 0.2 * size, -0.3 * size);
            table.push_str(&format!("0.37,-4.81,{edges},{half_vector}\n"));
        }
    }
    workshop.write("q.csv", table);
    for settings in [
        &["--method=flake-bins", "--roughness=0.2"][..],
        &["--method=flake-bins", "--roughness=0.02"],
        &["--method=flake-bins", "--roughness=0.02", "--paper"],
        &["--method=flake-bins", "--roughness=0.02", "--exact"],
        &["--method=specular-bins"],
    ] {
        let densities = |kind: &str| -> Vec<f64> {
            let package = format!("{kind}.glint");
            let query = ["query", &package, "--queries=q.csv"];
            let text = workshop.succeeds(&[&query, settings].concat());
            let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
            rows.map(|row| {
                let density = row.rsplit(',').next().expect("a column");
                density.parse().expect("a number")
            })
            .collect()
        };
        let [auto, others @ ..] = KINDS;
        let expected = densities(auto);
        assert_eq!(expected.len(), 15);
        assert!(expected.iter().filter(|density| **density > 0.0).count() > 7);
        for kind in others {
            for (density, expected) in densities(kind).into_iter().zip(&expected) {
                assert!(
                    (density - expected).abs() <= 1e-9 * expected,
                    "{density} by {kind}, {expected} by {auto}, {settings:?}"
                );
            }
        }
    }
}

#[test]
fn the_choice_and_its_reason_are_in_the_package() {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "flakes", "--size=256", "-o=map.png"]);
    for (index, kind, reason) in [
        ("auto", "tiles", "bytes a texel"),
        ("forest", "forest", "asked for"),
        ("none", "none", "asked for"),
    ] {
        let index = format!("--index={index}");
        let bake = ["bake", "map.png", "-o=f.glint", "--method=flake-bins"];
        workshop.succeeds(&[&bake[..], &["--roughness=0.01", &index]].concat());
        let text = workshop.succeeds(&["inspect", "f.glint"]);
        let line = format!("  index: {kind} for instance 1: ");
        let found = text.lines().find_map(|text| text.strip_prefix(&line));
        assert!(found.is_some_and(|found| found.contains(reason)), "{text}");
        let document = workshop.document(&["inspect", "f.glint", "--json"]);
        assert_eq!(document["metadata"]["chosen"][0]["inverse"], kind);
    }
}
