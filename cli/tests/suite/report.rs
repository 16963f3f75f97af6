//! `report`: what it writes, what it refuses, and what it leaves alone.

use crate::workshop::Workshop;
use serde_json::Value;
use std::fs;

/// As little as can be measured.
const LITTLE: [&str; 4] = [
    "--quick",
    "--method=flake-bins",
    "--sigma=1",
    "--roughness=0.1",
];

fn report(workshop: &Workshop, folder: &str) -> Value {
    let text = fs::read_to_string(workshop.path(folder).join("report.json")).expect("a report");
    serde_json::from_str(&text).expect("a JSON document")
}

#[test]
fn a_report_has_a_row_for_everyone_in_every_cell() {
    let workshop = Workshop::with_map();
    workshop.succeeds(&[&["report", "map.png", "-o", "out"], &LITTLE[..]].concat());
    let report = report(&workshop, "out");
    assert_eq!(report["format"], "glintbake-report");
    assert_eq!(report["complete"], true);
    let command = report["head"]["command"].as_str().expect("words");
    assert_eq!(
        command,
        "glintbake report map.png -o out --quick --method=flake-bins --sigma=1 --roughness=0.1"
    );
    let map = &report["maps"][0];
    assert_eq!(
        (&map["name"], &map["width"]),
        (&"map.png".into(), &96.into())
    );
    let rows = map["rows"].as_array().expect("rows");
    // Three variants, the scan, three point samplings and the paper's forest; two shapes, two kinds of half vectors.
    assert_eq!(rows.len(), 8 * 2 * 2);
    for row in rows {
        assert!(
            row["times"]["eval"]["median-ns"].as_f64() > Some(0.0),
            "{row}"
        );
        let is_method =
            row["contestant"]["role"] != "baseline" && row["contestant"]["method"] == "flake-bins";
        for time in ["sample", "pdf"] {
            assert_eq!(row["times"][time].is_object(), is_method, "{row}");
        }
        assert_eq!(row["model"].is_object(), is_method, "{row}");
        let found = row["half-vectors"] == "found";
        assert_eq!(row["energy"].is_object(), is_method && found, "{row}");
        if row["contestant"]["variant"] == "exact" {
            assert!(row["truth"]["relative-l1"].as_f64() < Some(1e-4), "{row}");
        }
    }
    for package in map["packages"].as_array().expect("packages") {
        assert!(package["bytes"].as_u64() > Some(0), "{package}");
    }
}

#[test]
fn answers_do_not_depend_on_threads_or_time() {
    let workshop = Workshop::with_map();
    let errors = |threads: &str| {
        let arguments = ["report", "map.png", "-o", threads, "--threads", threads];
        workshop.succeeds(&[&arguments, &LITTLE[..]].concat());
        let report = report(&workshop, threads);
        let rows = report["maps"][0]["rows"].as_array().expect("rows").clone();
        rows.into_iter()
            .map(|row| [&row["truth"], &row["model"], &row["energy"]].map(Value::to_string))
            .collect::<Vec<_>>()
    };
    assert_eq!(errors("1"), errors("3"));
}

#[test]
fn json_is_the_report_itself() {
    let workshop = Workshop::with_map();
    let said = workshop.document(&[&["report", "map.png", "--json"], &LITTLE[..]].concat());
    assert_eq!(said, report(&workshop, "report"));
}

#[test]
fn what_cannot_be_measured_is_refused_before_anything_is() {
    let workshop = Workshop::with_package();
    let refuses = |code, arguments: &[&str], says: &[&str]| {
        workshop.refuses(code, &[&["report"], arguments].concat(), says);
        assert!(!workshop.path("report").exists(), "{arguments:?}");
    };
    refuses(2, &["map.png", "--roughness=0"], &["--roughness", "0.0001"]);
    refuses(2, &["map.png", "--sigma=-1"], &["--sigma", "above 0"]);
    refuses(2, &["map.png", "--sigma=1,1"], &["--sigma 1", "twice"]);
    refuses(
        2,
        &["map.png", "--method=flake-bins,flake-bins"],
        &["flake-bins", "twice"],
    );
    refuses(2, &["map.png", "--fail-on=error:5%"], &["--compare"]);
    refuses(3, &["absent.png"], &["absent.png"]);
    refuses(3, &["map.glint"], &["map.glint"]);
    refuses(
        7,
        &["map.png", "-o", "map.glint"],
        &["map.glint", "it is a file"],
    );
    refuses(7, &["map.png", "-o", "no/such/folder"], &["folder"]);
}

#[test]
fn what_is_only_for_maps_that_repeat_is_said_to_be_left_out() {
    let workshop = Workshop::with_map();
    let said = workshop.succeeds(
        &[
            &["report", "map.png", "-o", "out", "--wrap=clamp"],
            &LITTLE[..],
        ]
        .concat(),
    );
    assert!(
        said.contains("not measured: exact-scan: it is for maps that repeat"),
        "{said}"
    );
    let report = report(&workshop, "out");
    let skipped = report["maps"][0]["skipped"].as_array().expect("a list");
    assert_eq!(skipped.len(), 2, "{skipped:?}");
}

#[test]
fn a_report_is_compared_with_an_older_one_and_can_fail_for_it() {
    let workshop = Workshop::with_map();
    let with = |extra: &[&str]| {
        let arguments = [&["report", "map.png", "-o", "out"], &LITTLE[..], extra].concat();
        workshop.run(&arguments)
    };
    assert_eq!(with(&[]).code, Some(0));
    fs::copy(workshop.path("out/report.json"), workshop.path("old.json")).expect("a copy");
    let same = with(&["--compare=old.json", "--fail-on=error:1%,bytes:1%"]);
    assert_eq!(same.code, Some(0), "{same:#?}");
    // As if answers had been better once.
    let mut old = report(&workshop, "out");
    let rows = old["maps"][0]["rows"].as_array_mut().expect("rows");
    for row in rows {
        let error = &mut row["truth"]["relative-l1"];
        if let Some(number) = error.as_f64() {
            *error = (0.5 * number).into();
        }
    }
    workshop.write("old.json", old.to_string());
    let worse = with(&["--compare=old.json", "--fail-on=error:5%"]);
    worse.error(1, &["--fail-on", "flake-bins"]);
    assert!(worse.stdout.contains("flake-bins bins-45"), "{worse:#?}");
    let unlimited = with(&["--compare=old.json"]);
    assert_eq!(unlimited.code, Some(0), "{unlimited:#?}");
}

#[test]
fn what_is_no_report_is_not_compared_with() {
    let workshop = Workshop::with_map();
    workshop.write("text.json", "glints");
    workshop.write("other.json", r#"{"format": "other", "version": 1}"#);
    let refuses = |code, arguments: &[&str], says: &[&str]| {
        workshop.refuses(code, &[&["report", "map.png"], arguments].concat(), says);
    };
    refuses(3, &["--compare=absent.json"], &["absent.json"]);
    refuses(3, &["--compare=text.json"], &["text.json", "JSON"]);
    refuses(
        3,
        &["--compare=other.json"],
        &["other.json", "glintbake-report"],
    );
    refuses(
        2,
        &["--compare=text.json", "--fail-on=beauty:5%"],
        &["beauty", "error"],
    );
}
