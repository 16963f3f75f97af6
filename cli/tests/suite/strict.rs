//! `query --strict`: densities of `cluster-tree` with bounds that are proved, and who is refused them.

use crate::workshop::Workshop;
use glintbake_bake::image::{self, ReadOptions};
use glintbake_bake::normals::{self, DecodeOptions};
use glintbake_bake::oracle::{disk, texel_weights};
use glintbake_format::model::{Filter, Footprint, HalfVector};

const HEADER: &str = "u,v,e1u,e1v,e2u,e2v,s,t";

/// Footprints and half vectors in the order of the header; the last is beyond the disk.
const QUERIES: [[f64; 8]; 6] = [
    [0.5, 0.5, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0],
    [0.1, 0.9, 0.05, 0.02, -0.03, 0.08, 0.1, -0.05],
    [0.75, 0.25, 0.001, 0.0, 0.0, 0.001, 0.02, 0.03],
    [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.05, 0.05],
    [0.3, 0.6, 2.5, 0.3, -0.4, 1.5, 0.0, -0.1],
    [0.3, 0.6, 0.2, 0.0, 0.0, 0.2, 0.9, 0.9],
];

const STRICT: [&str; 5] = [
    "query",
    "map.glint",
    "--queries=q.csv",
    "--strict",
    "--kernel=disk",
];

/// A folder with a map, a package of a tree, and `q.csv`.
fn workshop() -> Workshop {
    let workshop = Workshop::with_map();
    workshop.succeeds(&["bake", "map.png", "-o=map.glint"]);
    let rows = QUERIES.map(|query| query.map(|x| x.to_string()).join(",") + "\n");
    workshop.write("q.csv", format!("{HEADER}\n{}", rows.concat()));
    workshop
}

/// Density and bound of each row of a table: its last two columns, below comment and header.
fn answers(table: &str) -> Vec<[f64; 2]> {
    let rows = table.lines().skip(2);
    rows.map(|row| {
        let mut fields = row
            .rsplit(',')
            .map(|field| field.parse().expect("a number"));
        let bound = fields.next().expect("a bound");
        [fields.next().expect("a density"), bound]
    })
    .collect()
}

/// The sums over the texels of `map.png` that the queries ask for, of the kernel `disk`.
fn truth(workshop: &Workshop, alpha: f64, filter: Filter) -> Vec<f64> {
    let raster = image::read(&workshop.path("map.png"), &ReadOptions::default()).expect("a map");
    let (map, _) = normals::decode(raster, &DecodeOptions::default()).expect("normals");
    let sum = |[u, v, e1u, e1v, e2u, e2v, s, t]: [f64; 8]| {
        let footprint = Footprint {
            centre: [u, v],
            edge_1: [e1u, e1v],
            edge_2: [e2u, e2v],
        };
        let texels = texel_weights(&map, &footprint, filter);
        disk::Prepared::from_weights(&map, &texels, alpha).ndf(HalfVector { s, t })
    };
    QUERIES.into_iter().map(sum).collect()
}

#[test]
fn every_density_has_its_bound_beside_it_and_is_within() {
    let workshop = workshop();
    for (filter, of_filter) in [("box", Filter::Box), ("gaussian", Filter::Gaussian)] {
        for alpha in [0.02, 0.2] {
            let truth = truth(&workshop, alpha, of_filter);
            for (eps, said) in [("0.05", "0.05"), ("1e-3", "0.001")] {
                let options = [
                    format!("--filter={filter}"),
                    format!("--roughness={alpha}"),
                    format!("--eps={eps}"),
                ];
                let options: Vec<&str> = options.iter().map(String::as_str).collect();
                let table = workshop.succeeds(&[&STRICT[..], &options].concat());
                let mut lines = table.lines();
                let comment = format!(
                    "# method=cluster-tree kernel=disk filter={filter} roughness={alpha} eps={said} setting=default accuracy=strict"
                );
                assert_eq!(lines.next(), Some(comment.as_str()));
                assert_eq!(lines.next(), Some("u,v,e1u,e1v,e2u,e2v,s,t,ndf,ndf-bound"));
                let found = answers(&table);
                assert_eq!(found.len(), QUERIES.len());
                for ([density, bound], truth) in found.iter().zip(&truth) {
                    assert!(
                        bound.is_finite() && (density - truth).abs() <= *bound,
                        "{comment}: {density} ± {bound} for {truth}"
                    );
                }
                assert_eq!(found.last(), Some(&[0.0, 0.0]), "{comment}");
                // A bright density, which single precision is enough for.
                let [density, bound] = found[4];
                let eps: f64 = said.parse().expect("a number");
                if of_filter == Filter::Box && alpha > 0.1 {
                    assert!(0.0 < bound && bound <= eps * density, "{comment}: {bound}");
                }
            }
        }
    }
}

#[test]
fn left_to_itself_it_proves_the_error_that_is_the_default() {
    let workshop = workshop();
    let table = workshop.succeeds(&[&STRICT[..], &["--roughness=0.2"]].concat());
    assert!(table.contains(" eps=0.002 setting=default accuracy=strict\n"));
    let named = workshop.succeeds(&[&STRICT[..], &["--roughness=0.2", "--eps=0.002"]].concat());
    assert_eq!(table, named);
    // A kernel that was baked need not be named.
    workshop.succeeds(&["bake", "map.png", "-o=map.glint", "--kernel=disk"]);
    let [query @ .., _] = STRICT;
    assert_eq!(
        table,
        workshop.succeeds(&[&query[..], &["--roughness=0.2"]].concat())
    );
}

#[test]
fn the_document_says_what_the_bounds_come_to() {
    let workshop = workshop();
    let options = ["-o=a.csv", "--roughness=0.05", "--eps=1e-3"];
    let document = workshop.document(&[&STRICT[..], &options, &["--json"]].concat());
    let keys: Vec<_> = document.as_object().expect("an object").keys().collect();
    let expected = [
        "greatest-bound",
        "output",
        "rows",
        "rows-within-eps",
        "setting",
    ];
    assert_eq!(keys, expected);
    let found = answers(&workshop.text("a.csv"));
    let greatest = found.iter().map(|[_, bound]| *bound).fold(0.0, f64::max);
    let within = found
        .iter()
        .filter(|[density, bound]| *bound <= 1e-3 * density);
    let within = within.count();
    assert!(greatest > 0.0 && within > 0, "{found:?}");
    assert_eq!(document["greatest-bound"], greatest);
    assert_eq!(document["rows-within-eps"], within);
    assert_eq!(document["rows"], found.len());
    let said = workshop.succeeds(&[&STRICT[..], &options].concat());
    let words = format!("a.csv: 6 rows, bounds up to {greatest}, {within} within eps, method=");
    assert!(said.starts_with(&words), "{said}");
    // Without it there is nothing of the kind.
    let fast = [
        "query",
        "map.glint",
        "--queries=q.csv",
        "-o=a.csv",
        "--json",
    ];
    let document = workshop.document(&fast);
    let keys: Vec<_> = document.as_object().expect("an object").keys().collect();
    assert_eq!(keys, ["output", "rows", "setting"]);
}

#[test]
fn an_older_bound_is_replaced_and_never_left_beside_another_density() {
    let workshop = workshop();
    workshop.succeeds(&[&STRICT[..], &["-o=a.csv"]].concat());
    let strict = workshop.text("a.csv");
    let again = |options: &[&str]| {
        let query = ["query", "map.glint", "--queries=a.csv", "-o=b.csv"];
        workshop.succeeds(&[&query, options].concat());
        workshop.text("b.csv")
    };
    assert_eq!(again(&["--strict", "--kernel=disk"]), strict);
    let fast = again(&["--kernel=disk"]);
    assert!(
        fast.lines()
            .nth(1)
            .is_some_and(|header| header.ends_with(",ndf,ndf-bound"))
    );
    assert!(fast.lines().skip(2).all(|row| row.ends_with(',')), "{fast}");
    workshop.write("q.csv", format!("{HEADER},ndf-bound,ndf-bound\n"));
    workshop.refuses(4, &STRICT, &["has two columns ndf-bound"]);
    workshop.write("q.csv", format!("{HEADER}\n"));
    let none = workshop.succeeds(&STRICT);
    assert!(
        none.ends_with("\nu,v,e1u,e1v,e2u,e2v,s,t,ndf,ndf-bound\n"),
        "{none}"
    );
}

#[test]
fn what_has_no_proof_is_refused_with_what_has() {
    let workshop = workshop();
    let query = ["query", "map.glint", "--queries=q.csv", "--strict"];
    let says = [
        "map.glint: --strict: bounds are proved for the kernel disk alone, and beckmann answers",
        "add --kernel disk, or leave it out",
    ];
    workshop.refuses(2, &query, &says);
    workshop.refuses(2, &[&query[..], &["--kernel=beckmann"]].concat(), &says);
    let run = workshop.run(&[&query[..], &["-o=a.csv", "--json"]].concat());
    let document: serde_json::Value = serde_json::from_str(&run.stdout).expect("a document");
    assert_eq!(run.code, Some(2), "{run:#?}");
    assert_eq!(document["error"]["kind"], "usage");
    for (method, option) in [
        ("flake-bins", "--roughness=0.2"),
        ("lean", "--roughness=0.2"),
        ("specular-bins", "--bins=9"),
    ] {
        let refuses = |methods: &str, remedy: &str| {
            let methods = format!("--method={methods}");
            workshop.succeeds(&["bake", "map.png", "-o=map.glint", &methods, option]);
            let says = format!(
                "map.glint: --strict: only cluster-tree has bounds that are proved, of its kernel disk, and {method} answers; {remedy}, or leave it out"
            );
            workshop.refuses(2, &query, &[&says]);
        };
        refuses(method, "bake with --method cluster-tree");
        refuses(
            &format!("{method},cluster-tree"),
            "add --method cluster-tree --kernel disk",
        );
        workshop.succeeds(&[&STRICT[..], &["--method=cluster-tree"]].concat());
    }
    // Pictures have no place for bounds.
    workshop.refuses(
        2,
        &["picture", "ndf", "map.glint", "-o=a.png", "--strict"],
        &["unexpected argument '--strict'"],
    );
}
