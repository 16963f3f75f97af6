//! `query` on sound input: every density against the oracle, every column in its place.

use crate::workshop::Workshop;
use glintbake_bake::image::{self, ReadOptions};
use glintbake_bake::normals::{self, DecodeOptions, NormalMap};
use glintbake_bake::oracle::{self, flake_bins, specular_bins};
use glintbake_format::model::{Filter, Footprint, HalfVector, Neighbourhood};

/// Relative error the densities are promised to keep to.
const TOLERANCE: f64 = 1e-5;

/// Densities below this share of the table's largest are compared absolutely.
const FLOOR: f64 = 1e-6;

/// Footprints and half vectors in the order of the table's columns u, v, e1u, e1v, e2u, e2v, s, t.
const QUERIES: [[f64; 8]; 7] = [
    [0.5, 0.5, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0],
    [0.1, 0.9, 0.05, 0.02, -0.03, 0.08, 0.1, -0.05],
    [-3.25, 7.5, 0.4, 0.1, 0.2, -0.5, -0.15, 0.2],
    [0.75, 0.25, 0.001, 0.0, 0.0, 0.001, 0.02, 0.03],
    [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.05, 0.05],
    [0.3, 0.6, 2.5, 0.3, -0.4, 1.5, 0.0, -0.1],
    [0.3, 0.6, 0.2, 0.0, 0.0, 0.2, 0.9, 0.9],
];

fn footprint([u, v, e1u, e1v, e2u, e2v, ..]: [f64; 8]) -> Footprint {
    Footprint {
        centre: [u, v],
        edge_1: [e1u, e1v],
        edge_2: [e2u, e2v],
    }
}

fn half_vector([.., s, t]: [f64; 8]) -> HalfVector {
    HalfVector { s, t }
}

/// `map.png` as the oracle sees it: decoded, never baked.
fn oracle_map(workshop: &Workshop) -> NormalMap {
    let raster = image::read(&workshop.path("map.png"), &ReadOptions::default()).expect("a map");
    let (map, _) = normals::decode(raster, &DecodeOptions::default()).expect("normals");
    map
}

fn table() -> String {
    let mut table = "u,v,e1u,e1v,e2u,e2v,s,t\n".to_owned();
    for query in QUERIES {
        table.push_str(&query.map(|x| x.to_string()).join(","));
        table.push('\n');
    }
    table
}

/// A folder with a map, a package with exact normals for roughness 0.2 and 0.05 and for mirrors, and `q.csv`.
fn workshop() -> Workshop {
    let workshop = Workshop::with_map();
    workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--method=flake-bins,specular-bins",
        "--roughness=0.2,0.05",
        "--bins=15",
        "--exact-normals",
    ]);
    workshop.write("q.csv", table());
    workshop
}

/// The last column of a table, below its comment and header.
fn answers(table: &str) -> Vec<f64> {
    table
        .lines()
        .skip(2)
        .map(|line| line.rsplit(',').next().expect("a field"))
        .map(|field| field.parse().expect("a number"))
        .collect()
}

fn compare(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let floor = FLOOR * expected.iter().copied().fold(0.0, f64::max);
    assert!(floor > 0.0, "{what}: only zeros are compared");
    for (row, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!(
            (found - expected).abs() <= tolerance * expected + floor,
            "{what}, row {row}: {found} instead of {expected}"
        );
    }
}

#[test]
fn densities_are_the_oracles_under_gaussian_footprints() {
    let workshop = workshop();
    let map = oracle_map(&workshop);
    let setting = flake_bins::Setting::Binned(Neighbourhood::Bins45);
    let expected: Vec<f64> = QUERIES
        .into_iter()
        .map(|query| {
            let texels = oracle::texel_weights(&map, &footprint(query), Filter::Gaussian);
            flake_bins::Prepared::from_weights(&map, &texels, 0.2, setting).ndf(half_vector(query))
        })
        .collect();
    let query = ["query", "map.glint", "--queries=q.csv", "--filter=gaussian"];
    for (options, said_of_it) in [
        (
            &["--tolerance=0"][..],
            "filter=gaussian tolerance=0 roughness=0.2",
        ),
        (&[], "filter=gaussian tolerance=0.125 roughness=0.2"),
    ] {
        let said = workshop.succeeds(&[&query[..], options].concat());
        let comment = said.lines().next().expect("a line");
        assert!(comment.contains(said_of_it), "{comment}");
        let tolerance = if options.is_empty() { 0.05 } else { 1e-4 };
        compare(&answers(&said), &expected, tolerance, said_of_it);
    }
}

#[test]
fn densities_are_the_oracles_under_every_setting() {
    let workshop = workshop();
    let map = oracle_map(&workshop);
    let flakes = |alpha: f64, setting: flake_bins::Setting| -> Vec<f64> {
        let ndf =
            |query| flake_bins::ndf(&map, &footprint(query), half_vector(query), alpha, setting);
        QUERIES.into_iter().map(ndf).collect()
    };
    let bins_45 = flake_bins::Setting::Binned(Neighbourhood::Bins45);
    let bins_21 = flake_bins::Setting::Binned(Neighbourhood::Bins21);
    let mirrors: Vec<f64> = QUERIES
        .into_iter()
        .map(|query| specular_bins::ndf(&map, &footprint(query), half_vector(query), 15))
        .collect();
    let first = "method=flake-bins kernel=beckmann filter=box roughness=0.2";
    let cases: [(&[&str], Vec<f64>, &str, &str); 8] = [
        (&[], flakes(0.2, bins_45), first, "bins-45"),
        (&["--filter=box"], flakes(0.2, bins_45), first, "bins-45"),
        (
            &["--method=flake-bins"],
            flakes(0.2, bins_45),
            first,
            "bins-45",
        ),
        (
            &["--roughness=0.05"],
            flakes(0.05, bins_45),
            "roughness=0.05",
            "bins-45",
        ),
        (
            &["--intrinsic-roughness=0.0353553390593274"],
            flakes(0.05, bins_45),
            "roughness=0.05",
            "bins-45",
        ),
        (&["--paper"], flakes(0.2, bins_21), first, "bins-21"),
        (
            &["--exact", "--roughness=0.05"],
            flakes(0.05, flake_bins::Setting::Exact),
            "roughness=0.05",
            "exact",
        ),
        (
            &["--method=specular-bins"],
            mirrors,
            "method=specular-bins kernel=bin-average filter=box bins=15",
            "default",
        ),
    ];
    for (options, expected, instance, setting) in cases {
        let query = ["query", "map.glint", "--queries=q.csv"];
        let said = workshop.succeeds(&[&query, options].concat());
        let comment = said.lines().next().expect("a line");
        assert!(
            comment.starts_with("# ")
                && comment.contains(instance)
                && comment.ends_with(&format!(" setting={setting}")),
            "{options:?}: {comment}"
        );
        assert_eq!(said.lines().nth(1), Some("u,v,e1u,e1v,e2u,e2v,s,t,ndf"));
        // Exact normals are stored in 2^-16 of a bin, which moves the kernel a little.
        let tolerance = if setting == "exact" { 1e-3 } else { TOLERANCE };
        compare(
            &answers(&said),
            &expected,
            tolerance,
            &format!("{options:?}"),
        );
    }
    let apart = |one: &[f64], other: &[f64]| {
        let far = |(one, other): (&f64, &f64)| (one - other).abs() > 1e-2 * one;
        one.iter().zip(other).any(far)
    };
    let exact = flakes(0.05, flake_bins::Setting::Exact);
    assert!(
        apart(&flakes(0.2, bins_45), &flakes(0.2, bins_21))
            && apart(&exact, &flakes(0.05, bins_45)),
        "settings must differ by more than the tolerance for the comparison to tell them apart"
    );
}

#[test]
fn answers_depend_on_neither_threads_nor_the_way_of_opening() {
    let workshop = workshop();
    let query = ["query", "map.glint", "--queries=q.csv"];
    let first = workshop.succeeds(&query);
    for option in [
        "--threads=1",
        "--threads=8",
        "--no-mmap",
        "--trust",
        "--quiet",
    ] {
        assert_eq!(
            workshop.succeeds(&[&query[..], &[option]].concat()),
            first,
            "{option}"
        );
    }
    let said = workshop.succeeds(&[&query[..], &["-o=a.csv"]].concat());
    assert_eq!(workshop.text("a.csv"), first);
    assert!(
        said.starts_with("a.csv: 7 rows, method=flake-bins kernel="),
        "{said}"
    );
}

/// The package's answer to a table of one row, whatever the table looks like.
fn answer(workshop: &Workshop, table: &str) -> (String, String) {
    workshop.write("t.csv", table);
    let said = workshop.succeeds(&["query", "map.glint", "--queries=t.csv"]);
    let mut lines = said.lines().skip(1).map(str::to_owned);
    let (header, row) = (
        lines.next().expect("a header"),
        lines.next().expect("a row"),
    );
    assert_eq!(lines.next(), None);
    (header, row)
}

#[test]
fn columns_come_in_any_order_with_others_between() {
    let workshop = workshop();
    let plain = "u,v,e1u,e1v,e2u,e2v,s,t\n0.5,0.6,0.2,0.01,0.02,0.3,0.1,-0.1\n";
    let (header, row) = answer(&workshop, plain);
    assert_eq!(header, "u,v,e1u,e1v,e2u,e2v,s,t,ndf");
    let density = row.rsplit(',').next().expect("a field");
    assert!(density.parse::<f64>().expect("a number") > 0.0, "{row}");
    let expect = |table: &str, header: &str, row: &str| {
        let row = row.replace('D', density);
        assert_eq!(
            answer(&workshop, table),
            (header.to_owned(), row),
            "{table:?}"
        );
    };
    expect(
        "t,s,e2v,e2u,e1v,e1u,v,u\n-0.1,0.1,0.3,0.02,0.01,0.2,0.6,0.5\n",
        "t,s,e2v,e2u,e1v,e1u,v,u,ndf",
        "-0.1,0.1,0.3,0.02,0.01,0.2,0.6,0.5,D",
    );
    expect(
        "id,u,v,e1u,e1v,note,e2u,e2v,s,t\n7,0.5,0.6,0.2,0.01,\"a, \"\"b\"\" \",0.02,0.3,0.1,-0.1\n",
        "id,u,v,e1u,e1v,note,e2u,e2v,s,t,ndf",
        "7,0.5,0.6,0.2,0.01,\"a, \"\"b\"\" \",0.02,0.3,0.1,-0.1,D",
    );
    expect(
        "u,v,ndf,e1u,e1v,e2u,e2v,s,t\n0.5,0.6,old,0.2,0.01,0.02,0.3,0.1,-0.1\n",
        "u,v,ndf,e1u,e1v,e2u,e2v,s,t",
        "0.5,0.6,D,0.2,0.01,0.02,0.3,0.1,-0.1",
    );
    // As spreadsheets write it: a mark of byte order, blanks, CR LF, no line end at the end.
    expect(
        "\u{feff}u, v, e1u, e1v, e2u, e2v, s, t\r\n5e-1, 0.6,.2,0.01,0.02,0.3,+0.1,-0.1",
        "u,v,e1u,e1v,e2u,e2v,s,t,ndf",
        "5e-1, 0.6,.2,0.01,0.02,0.3,+0.1,-0.1,D",
    );
    expect(
        "# from the renderer\n\nu,v,e1u,e1v,e2u,e2v,s,t\n# row\n\n0.5,0.6,0.2,0.01,0.02,0.3,0.1,-0.1\n# end",
        "u,v,e1u,e1v,e2u,e2v,s,t,ndf",
        "0.5,0.6,0.2,0.01,0.02,0.3,0.1,-0.1,D",
    );
}

#[test]
fn a_table_that_was_written_can_be_read_back() {
    let workshop = workshop();
    workshop.write(
        "t.csv",
        "name,u,v,e1u,e1v,e2u,e2v,s,t\n\"#1\",0.5,0.5,0.1,0,0,0.1,0,0\n\"#2, \",0.5,0.5,0.1,0,0,0.1,0,0\n",
    );
    workshop.succeeds(&["query", "map.glint", "--queries=t.csv", "-o=a.csv"]);
    let said = workshop.succeeds(&["query", "map.glint", "--queries=a.csv", "-o=b.csv"]);
    assert!(
        said.contains("b.csv: 2 rows"),
        "a name with # must not become a comment: {said}"
    );
    assert_eq!(workshop.text("a.csv"), workshop.text("b.csv"));
}

#[test]
fn a_table_without_rows_has_no_answers() {
    let workshop = workshop();
    workshop.write("t.csv", "u,v,e1u,e1v,e2u,e2v,s,t\n");
    let said = workshop.succeeds(&["query", "map.glint", "--queries=t.csv"]);
    assert_eq!(
        said.lines().skip(1).collect::<Vec<_>>(),
        ["u,v,e1u,e1v,e2u,e2v,s,t,ndf"]
    );
}

#[cfg(unix)]
#[test]
fn a_table_may_come_through_a_pipe() {
    let workshop = workshop();
    let mut command = assert_cmd::Command::new(crate::workshop::PROGRAM);
    command
        .args(["query", "map.glint", "--queries=/dev/stdin"])
        .write_stdin(table());
    let run = workshop.finish(command);
    assert_eq!(run.code, Some(0), "{run:#?}");
    assert_eq!(answers(&run.stdout).len(), QUERIES.len());
}

#[test]
fn a_density_beyond_the_rim_is_zero() {
    let workshop = workshop();
    let (_, row) = answer(
        &workshop,
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.5,0.6,0.2,0.01,0.02,0.3,0.8,-0.7\n",
    );
    assert!(row.ends_with(",0"), "{row}");
}
