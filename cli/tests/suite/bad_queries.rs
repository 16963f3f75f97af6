//! Tables that cannot be answered, by line and column, and questions the package was not baked for.

use crate::workshop::Workshop;

const HEADER: &str = "u,v,e1u,e1v,e2u,e2v,s,t";
const ROW: &str = "0.5,0.5,0.1,0,0,0.1,0,0";

/// A query of `table` over an older answer must fail with `code`.
fn refuses(workshop: &Workshop, code: i32, table: impl AsRef<[u8]>, says: &[&str]) {
    workshop.write("q.csv", table);
    workshop.write("old.csv", "older answers");
    let query = ["query", "map.glint", "--queries=q.csv"];
    workshop.refuses(code, &query, says);
    workshop.refuses(code, &[&query[..], &["-o=old.csv"]].concat(), says);
}

#[test]
fn columns_must_be_named_and_named_once() {
    let workshop = Workshop::with_package();
    let missing = ["q.csv: has no column ", "u,v,e1u,e1v,e2u,e2v,s,t"];
    refuses(&workshop, 4, "", &missing);
    refuses(&workshop, 4, "# nothing but a comment\n", &missing);
    refuses(&workshop, 4, ROW, &missing);
    refuses(&workshop, 4, "u;v;e1u;e1v;e2u;e2v;s;t\n", &missing);
    refuses(
        &workshop,
        4,
        format!("u,v,e1u,e1v,e2u,s,t\n{ROW}\n"),
        &["q.csv: has no column e2v", "u,v,e1u,e1v,e2u,e2v,s,t"],
    );
    for twice in ["s", "ndf,ndf"] {
        let name = twice.split(',').next().expect("a name");
        refuses(
            &workshop,
            4,
            format!("{HEADER},{twice}\n"),
            &[&format!("q.csv: has two columns {name};")],
        );
    }
}

#[test]
fn cells_must_be_finite_numbers() {
    let workshop = Workshop::with_package();
    for (cell, wrong) in [
        ("", "not a number"),
        ("abc", "not a number"),
        ("1,5", "has 9 fields where the first line names 8 columns"),
        ("0x10", "not a number"),
        ("1e999", "not a finite number"),
        ("nan", "not a finite number"),
        ("NaN", "not a finite number"),
        ("-inf", "not a finite number"),
    ] {
        let row = format!("0.5,0.5,0.1,0,0,0.1,{cell},0");
        let table = format!("{HEADER}\n{ROW}\n{row}\n{ROW}\n");
        let mut says = vec!["q.csv, line 3: ", wrong];
        if !cell.contains(',') {
            says.push("column s holds");
        }
        refuses(&workshop, 4, table, &says);
    }
}

#[test]
fn lines_are_counted_as_an_editor_counts_them() {
    let workshop = Workshop::with_package();
    let comments =
        format!("# one\n\n{HEADER}\n# four\n{ROW}\n\n# seven\n# eight\n0.5,0.5,0.1,0,0,0.1,0,x\n");
    let returns = comments.replace('\n', "\r\n");
    let says = ["q.csv, line 9: column t holds \"x\""];
    refuses(&workshop, 4, comments, &says);
    refuses(&workshop, 4, returns, &says);
    let quoted = format!("note,{HEADER}\n\"two\nlines\",{ROW}\nplain,0.5,0.5,0.1,0,0,0.1,0,x\n");
    refuses(&workshop, 4, quoted, &["q.csv, line 4: column t"]);
    let marked = format!("\u{feff}{HEADER}\n# two\n\n0.5,0.5,0.1,0,0,0.1,0,x\n");
    refuses(&workshop, 4, marked, &["q.csv, line 4: column t"]);
}

#[test]
fn rows_must_be_as_long_as_the_header() {
    let workshop = Workshop::with_package();
    refuses(
        &workshop,
        4,
        format!("{HEADER}\n{ROW}\n# three\n0.5,0.5,0.1\n"),
        &["q.csv, line 4: has 3 fields where the first line names 8 columns"],
    );
}

#[test]
fn tables_must_be_utf_8() {
    let workshop = Workshop::with_package();
    let says = ["is not UTF-8 text", "save the table as UTF-8"];
    let row = format!("note,{HEADER}\n\n");
    let table = [row.as_bytes(), b"caf\xe9,", ROW.as_bytes(), b"\n"].concat();
    refuses(
        &workshop,
        4,
        table,
        &[&says[..], &["q.csv, line 3: "]].concat(),
    );
    let header = [b"caf\xe9,", HEADER.as_bytes(), b"\n"].concat();
    refuses(
        &workshop,
        4,
        header,
        &[&says[..], &["q.csv, line 1: "]].concat(),
    );
    let wide: Vec<u8> = HEADER.bytes().flat_map(|byte| [byte, 0]).collect();
    refuses(&workshop, 4, wide, &["q.csv: has no column u"]);
}

#[test]
fn footprints_must_not_span_hundreds_of_tiles() {
    let workshop = Workshop::with_package();
    let says = [
        "q.csv, line 3: ",
        "more than 256 tiles",
        "query one whole tile",
    ];
    for wide in ["257", "1e30", "-1e308"] {
        let table = format!("{HEADER}\n{ROW}\n0.5,0.5,{wide},0,0,0.1,0,0\n");
        refuses(&workshop, 4, table, &says);
    }
}

#[test]
fn the_first_bad_row_is_named_whatever_the_threads_do() {
    let workshop = Workshop::with_package();
    let mut table = format!("{HEADER}\n");
    for row in 0..2000 {
        let wide = if row % 300 == 299 { "1e9" } else { "0.1" };
        table.push_str(&format!("0.5,0.5,{wide},0,0,0.1,0,0\n"));
    }
    for _ in 0..5 {
        refuses(&workshop, 4, &table, &["q.csv, line 301: "]);
    }
}

#[test]
fn tables_that_cannot_be_read() {
    let workshop = Workshop::with_package();
    std::fs::create_dir(workshop.path("folder.csv")).expect("a folder");
    for name in ["none.csv", "folder.csv"] {
        let queries = format!("--queries={name}");
        workshop.refuses(
            3,
            &["query", "map.glint", &queries],
            &[&format!("{name}: cannot be read: ")],
        );
    }
}

#[test]
fn what_was_not_baked_is_answered_with_what_was() {
    let workshop = Workshop::with_package();
    workshop.write("q.csv", format!("{HEADER}\n{ROW}\n"));
    let refuses = |options: &[&str], says: &[&str]| {
        let commands: [&[&str]; 3] = [
            &["query", "map.glint", "--queries=q.csv"],
            &["picture", "ndf", "map.glint", "-o=new.png"],
            &["picture", "ball", "map.glint", "-o=new.png"],
        ];
        for command in commands {
            let error = workshop.refuses(6, &[command, options].concat(), says);
            assert!(error.starts_with("map.glint: "), "{error}");
        }
    };
    let holds = [
        "the package, which holds: ",
        "flake-bins with roughness 0.2 (intrinsic 0.141421), ",
        "flake-bins with roughness 0.02 (intrinsic 0.014142), ",
        "specular-bins with 127 bins a side",
        "bake again",
    ];
    let with = |wanted: &'static str| [&[wanted], &holds[..]].concat();
    refuses(&["--roughness=0.3"], &with("roughness 0.3 is not in"));
    refuses(&["--roughness=nan"], &with("roughness NaN is not in"));
    refuses(&["--roughness", "-1"], &with("roughness -1 is not in"));
    refuses(
        &["--intrinsic-roughness=0.5"],
        &with("intrinsic roughness 0.5 (roughness 0.707"),
    );
    refuses(
        &["--method=specular-bins", "--roughness=0.2"],
        &with("method specular-bins and roughness 0.2 is not in"),
    );
    refuses(
        &["--exact"],
        &["no section EXNM", "bake it with --exact-normals"],
    );
    for setting in ["--exact", "--paper"] {
        refuses(
            &["--method=specular-bins", setting],
            &["specular-bins has no such setting", "leave it out"],
        );
    }
}

#[test]
fn a_tolerance_needs_a_gaussian_and_lies_between_0_and_1() {
    let workshop = Workshop::with_package();
    let query = ["query", "map.glint", "--queries=q.csv"];
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.5,0.5,0.1,0,0,0.1,0,0\n",
    );
    workshop.refuses(
        2,
        &[&query[..], &["--tolerance=0.1"]].concat(),
        &[
            "--tolerance: only Gaussian footprints have one",
            "--filter gaussian",
        ],
    );
    for wrong in [
        "--tolerance=-1",
        "--tolerance=nan",
        "--tolerance=1.5",
        "--tolerance=x",
    ] {
        workshop.refuses(
            2,
            &[&query[..], &["--filter=gaussian", wrong]].concat(),
            &["it must be a number from 0 to 1"],
        );
    }
}

#[test]
fn settings_that_contradict_each_other_are_usage_errors() {
    let workshop = Workshop::with_package();
    let query = ["query", "map.glint", "--queries=q.csv"];
    for pair in [
        ["--exact", "--paper"],
        ["--roughness=0.2", "--intrinsic-roughness=0.1"],
    ] {
        workshop.refuses(
            2,
            &[&query[..], &pair[..]].concat(),
            &["cannot be used with"],
        );
    }
    workshop.refuses(
        2,
        &["verify", "map.glint", "--full", "--structure"],
        &["cannot be used with"],
    );
    workshop.refuses(2, &["query", "map.glint"], &["--queries"]);
    workshop.refuses(2, &["bake", "map.png"], &["--output"]);
}
