//! JSON results and errors: one document, keys sorted, the same on every run.

use crate::workshop::Workshop;
use serde_json::Value;

/// `value` as text with every object's keys sorted, whatever the map type of this build's `serde_json` does.
fn canonical(value: &Value, indent: usize, text: &mut String) {
    let line = |text: &mut String, depth: usize| {
        text.push('\n');
        text.push_str(&"  ".repeat(depth));
    };
    match value {
        Value::Object(map) if !map.is_empty() => {
            let mut keys: Vec<_> = map.keys().collect();
            keys.sort();
            text.push('{');
            for (place, key) in keys.into_iter().enumerate() {
                text.push_str(if place > 0 { "," } else { "" });
                line(text, indent + 1);
                text.push_str(&format!("{}: ", Value::String(key.clone())));
                canonical(&map[key], indent + 1, text);
            }
            line(text, indent);
            text.push('}');
        }
        Value::Array(values) if !values.is_empty() => {
            text.push('[');
            for (place, value) in values.iter().enumerate() {
                text.push_str(if place > 0 { "," } else { "" });
                line(text, indent + 1);
                canonical(value, indent + 1, text);
            }
            line(text, indent);
            text.push(']');
        }
        other => text.push_str(&other.to_string()),
    }
}

/// The document in `text`, which must be all of it, with sorted keys.
fn sorted_document(text: &str) -> Value {
    let value: Value = serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let mut expected = String::new();
    canonical(&value, 0, &mut expected);
    assert_eq!(text, format!("{expected}\n"));
    value
}

fn keys(value: &Value) -> Vec<&str> {
    let map = value.as_object().expect("an object");
    map.keys().map(String::as_str).collect()
}

#[test]
fn every_command_has_a_document_of_stable_keys() {
    let workshop = Workshop::new();
    let document = |arguments: &[&str]| {
        let text = workshop.succeeds(&[arguments, &["--json"]].concat());
        sorted_document(&text)
    };
    let sample = document(&["sample", "waves", "--size=24x16", "--seed=3", "-o=map.png"]);
    assert_eq!(
        keys(&sample),
        [
            "bits",
            "density",
            "height",
            "kind",
            "output",
            "roughness",
            "scale",
            "seed",
            "width"
        ]
    );
    assert_eq!((&sample["width"], &sample["seed"]), (&24.into(), &3.into()));

    let bake = ["bake", "map.png", "-o=map.glint", "--roughness=0.2"];
    let baked = document(&[&bake[..], &["--method=flake-bins,specular-bins"]].concat());
    assert_eq!(
        keys(&baked),
        [
            "bytes",
            "bytes-per-texel",
            "instances",
            "layers",
            "output",
            "preview",
            "statistics",
            "up-to-date"
        ]
    );
    assert_eq!(baked["bytes"], workshop.read("map.glint").len());
    assert_eq!(baked["instances"].as_array().map(Vec::len), Some(2));

    let inspected = document(&["inspect", "map.glint"]);
    assert_eq!(
        keys(&inspected),
        [
            "bytes",
            "bytes-per-texel",
            "content-hash",
            "instances",
            "layers",
            "metadata",
            "recipe-hash",
            "sections",
            "version"
        ]
    );
    assert_eq!(
        keys(&inspected["instances"][0]),
        [
            "binning",
            "bins-per-side",
            "filter",
            "height",
            "index",
            "inverse",
            "kernel",
            "keys",
            "layer",
            "leaf-size",
            "method",
            "number",
            "roughness",
            "width",
            "wrap"
        ]
    );
    assert_eq!(
        keys(&inspected["metadata"]),
        [
            "chosen",
            "convention",
            "inputs",
            "left-out",
            "recipe",
            "statistics",
            "tool"
        ]
    );
    let input = &inspected["metadata"]["inputs"][0];
    let map = workshop.read("map.png");
    assert_eq!(
        (&input["name"], &input["bytes"]),
        (&"map.png".into(), &map.len().into())
    );
    assert_eq!(input["blake3"].as_str().map(str::len), Some(64));
    let bytes: u64 = inspected["sections"]
        .as_array()
        .expect("sections")
        .iter()
        .map(|section| section["bytes"].as_u64().expect("a number"))
        .sum();
    assert!(bytes < inspected["bytes"].as_u64().expect("a number"));

    let verified = document(&["verify", "map.glint"]);
    assert_eq!(
        verified,
        serde_json::json!({"checked": "full", "findings": [], "sound": true})
    );
    assert_eq!(
        document(&["verify", "map.glint", "--structure"])["checked"],
        "structure"
    );

    workshop.write("q.csv", "u,v,e1u,e1v,e2u,e2v,s,t\n0,0,0.1,0,0,0.1,0,0\n");
    let queried = document(&["query", "map.glint", "--queries=q.csv", "-o=a.csv"]);
    assert_eq!(keys(&queried), ["output", "rows", "setting"]);
    assert_eq!(queried["rows"], 1);

    let ndf = document(&["picture", "ndf", "map.glint", "-o=ndf.png", "--pixels=8"]);
    assert_eq!(
        keys(&ndf),
        [
            "integral", "output", "peak", "setting", "sigma", "texels", "uv", "zoom"
        ]
    );
    let ball = document(&["picture", "ball", "map.glint", "-o=ball.png", "--pixels=8"]);
    assert_eq!(keys(&ball), ["output", "setting", "tiles"]);
}

#[test]
fn a_document_is_the_same_on_every_run() {
    let workshop = Workshop::with_package();
    let inspect = ["inspect", "map.glint", "--json"];
    assert_eq!(workshop.succeeds(&inspect), workshop.succeeds(&inspect));
}

#[test]
fn errors_are_documents_on_standard_output() {
    let workshop = Workshop::with_package();
    workshop.write("text.png", "words");
    workshop.write("q.csv", "u\n");
    workshop.write("cut.glint", &workshop.read("map.glint")[..4000]);
    let bake = ["bake", "map.png", "-o=new.glint", "--roughness=0.1"];
    let with = |extra: &'static str| [&bake[..], &[extra]].concat();
    let cases: [(i32, &str, Vec<&str>, &str); 8] = [
        (2, "usage", with("--bins=3"), "--bins 3: "),
        (2, "usage", with("--range=snorm"), "map.png: --range snorm"),
        (
            3,
            "input",
            vec!["bake", "text.png", "-o=n", "--roughness=0.1"],
            "text.png: ",
        ),
        (3, "input", vec!["verify", "none.glint"], "none.glint: "),
        (
            4,
            "content",
            vec!["query", "map.glint", "--queries=q.csv", "-o=a"],
            "q.csv: ",
        ),
        (
            5,
            "package",
            vec!["inspect", "cut.glint"],
            "cut.glint: [1005] ",
        ),
        (
            6,
            "not-baked",
            vec!["query", "map.glint", "--queries=q.csv", "-o=a", "--exact"],
            "map.glint: ",
        ),
        (
            7,
            "output",
            vec!["sample", "flat", "-o=none/a"],
            "cannot write none/a: ",
        ),
    ];
    for (code, kind, arguments, says) in cases {
        let before = workshop.files();
        let run = workshop.run(&[&arguments[..], &["--json"]].concat());
        assert_eq!(
            (run.code, run.stderr.as_str()),
            (Some(code), ""),
            "{run:#?}"
        );
        assert!(workshop.files() == before, "{run:#?}");
        let error = &sorted_document(&run.stdout)["error"];
        assert_eq!(keys(error), ["exit-code", "kind", "message"], "{run:#?}");
        assert_eq!(
            (&error["exit-code"], &error["kind"]),
            (&code.into(), &kind.into())
        );
        let message = error["message"].as_str().expect("a text");
        assert!(message.starts_with(says), "{run:#?}");
    }
}

#[test]
fn findings_are_a_document_with_stable_numbers() {
    let workshop = Workshop::with_package();
    let whole = workshop.read("map.glint");
    workshop.write("cut.glint", &whole[..4000]);
    let run = workshop.run(&["verify", "cut.glint", "--json"]);
    assert_eq!(run.code, Some(1), "{run:#?}");
    let document = sorted_document(&run.stdout);
    assert_eq!(document["sound"], false);
    let finding = &document["findings"][0];
    assert_eq!(
        keys(finding),
        ["at", "expected", "got", "number", "section", "text"]
    );
    assert_eq!(
        (&finding["number"], &finding["expected"], &finding["got"]),
        (&1005.into(), &whole.len().into(), &4000.into())
    );
}

#[test]
fn a_table_on_standard_output_and_a_document_there_exclude_each_other() {
    let workshop = Workshop::with_package();
    workshop.refuses(
        2,
        &["query", "map.glint", "--queries=q.csv", "--json"],
        &["--output"],
    );
}
