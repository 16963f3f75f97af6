//! `stress`: what it takes, what it says, and how it ends.

use crate::workshop::Workshop;
use glintbake_format::Container;
use serde_json::Value;

const CHECKS: [&str; 7] = [
    "accuracy",
    "continuity",
    "energy",
    "precision",
    "reciprocity",
    "refusals",
    "sampling",
];

/// A folder with a small map and a package of it, whose tests take a second.
fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "flakes", "--size=12x9", "-o=map.png"]);
    workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--method=flake-bins,specular-bins",
        "--roughness=0.05",
    ]);
    workshop
}

fn cases(document: &Value) -> &[Value] {
    document["cases"].as_array().expect("a list of cases")
}

#[test]
fn a_package_is_put_to_the_test_with_what_it_holds() {
    let workshop = workshop();
    let document = workshop.document(&["stress", "map.glint", "--json"]);
    assert_eq!(document["verdict"], "pass");
    assert_eq!(document["input"], "map.glint");
    assert_eq!(document["counts"]["fail"], 0);
    for method in ["flake-bins", "specular-bins"] {
        for check in CHECKS {
            let found = cases(&document).iter().find(|case| {
                case["check"] == check && case["method"] == method && case["verdict"] != "skipped"
            });
            let case = found.unwrap_or_else(|| panic!("{check} of {method}"));
            assert!(case["answers"].as_u64() > Some(0), "{case}");
            assert!(!case["reason"].as_str().expect("a reason").is_empty());
        }
    }
    let exact = cases(&document)
        .iter()
        .find(|case| case["setting"] == "exact");
    let exact = exact.expect("what cannot be tried is said");
    assert_eq!(exact["verdict"], "skipped");
    let reason = exact["reason"].as_str().expect("a reason");
    assert!(reason.contains("--exact-normals"), "{reason}");
}

#[test]
fn exact_normals_make_the_exact_setting_testable() {
    let workshop = workshop();
    workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=exact.glint",
        "--method=flake-bins",
        "--roughness=0.3",
        "--exact-normals",
    ]);
    let document = workshop.document(&["stress", "exact.glint", "--json"]);
    let mut exact = cases(&document)
        .iter()
        .filter(|case| case["setting"] == "exact");
    assert!(exact.any(|case| case["check"] == "accuracy" && case["verdict"] == "pass"));
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let workshop = workshop();
    let by = |threads| workshop.succeeds(&["stress", "map.glint", "--json", threads]);
    assert_eq!(by("--threads=1"), by("--threads=3"));
}

#[test]
fn a_map_is_baked_for_every_method() {
    let workshop = workshop();
    let document = workshop.document(&["stress", "map.png", "--quick", "--json"]);
    assert_eq!(document["verdict"], "pass");
    for method in glintbake_format::model::METHODS {
        let mut of_method = cases(&document)
            .iter()
            .filter(|case| case["method"] == method.name());
        // The map is no example to make copies of, and refused as such.
        let check = if method.name() == "ndf-maps" {
            "refusals"
        } else {
            "accuracy"
        };
        assert!(of_method.any(|case| case["check"] == check && case["map"] == "map.png"));
    }
    let worst = &cases(&document)[0]["worst-at"];
    for key in ["footprint", "half-vector", "what"] {
        assert!(worst.get(key).is_some(), "{worst}");
    }
}

#[test]
fn the_table_fits_a_hundred_columns() {
    let table = workshop().succeeds(&["stress", "map.glint"]);
    let rows: Vec<_> = table
        .lines()
        .take_while(|line| !line.starts_with("skipped"))
        .collect();
    assert!(rows.len() > 20 && rows[0].starts_with("check"), "{table}");
    assert!(rows.iter().all(|row| row.chars().count() <= 100), "{table}");
    assert!(
        table
            .lines()
            .last()
            .is_some_and(|line| line.contains("checks pass")),
        "{table}"
    );
}

#[test]
fn a_damaged_package_is_refused_before_anything_is_asked() {
    let workshop = workshop();
    let mut bytes = workshop.read("map.glint");
    let container = Container::open(&bytes).expect("a sound package");
    let names = ["BMAP", "TMAP"];
    let mut entries = container.entries().iter();
    let entry = entries.find(|entry| names.contains(&entry.kind.to_string().as_str()));
    let place = entry.expect("a bin map").offset.get() as usize;
    bytes[place] ^= 1;
    workshop.write("bad.glint", &bytes);
    workshop.refuses(5, &["stress", "bad.glint"], &["bad.glint: ["]);
}

#[test]
fn what_is_neither_package_nor_map_is_refused() {
    let workshop = workshop();
    workshop.write("text.txt", "no map");
    workshop.refuses(3, &["stress", "none.png"], &["none.png: cannot be opened"]);
    workshop.refuses(3, &["stress", "text.txt"], &["text.txt: "]);
    let mut bytes = workshop.read("map.glint");
    bytes.truncate(700);
    workshop.write("cut.glint", &bytes);
    workshop.refuses(5, &["stress", "cut.glint"], &["cut.glint: [1005]"]);
    workshop.refuses(2, &["stress", "map.png", "--channels=rgb"], &["xyz, xy"]);
}
