//! Queries whose densities are held to an oracle.

use crate::workshop::Workshop;
use glintbake_bake::image::{self, ReadOptions};
use glintbake_bake::normals::{self, DecodeOptions, NormalMap};
use glintbake_format::model::{Footprint, HalfVector};

/// Footprints and half vectors in the order of the table's columns u, v, e1u, e1v, e2u, e2v, s, t.
pub const QUERIES: [[f64; 8]; 7] = [
    [0.5, 0.5, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0],
    [0.1, 0.9, 0.05, 0.02, -0.03, 0.08, 0.1, -0.05],
    [-3.25, 7.5, 0.4, 0.1, 0.2, -0.5, -0.15, 0.2],
    [0.75, 0.25, 0.001, 0.0, 0.0, 0.001, 0.02, 0.03],
    [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.05, 0.05],
    [0.3, 0.6, 2.5, 0.3, -0.4, 1.5, 0.0, -0.1],
    [0.3, 0.6, 0.2, 0.0, 0.0, 0.2, 0.9, 0.9],
];

/// A query of `map.glint`.
pub const QUERY: [&str; 3] = ["query", "map.glint", "--queries=q.csv"];

/// Footprints and half vectors of [`QUERIES`].
pub fn asked() -> impl Iterator<Item = (Footprint, HalfVector)> {
    QUERIES.into_iter().map(|[u, v, e1u, e1v, e2u, e2v, s, t]| {
        let footprint = Footprint {
            centre: [u, v],
            edge_1: [e1u, e1v],
            edge_2: [e2u, e2v],
        };
        (footprint, HalfVector { s, t })
    })
}

/// Writes [`QUERIES`] to `q.csv`.
pub fn write_queries(workshop: &Workshop) {
    let rows = QUERIES.map(|query| query.map(|x| x.to_string()).join(",") + "\n");
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n".to_owned() + &rows.concat(),
    );
}

/// The comment of a query with `options`, and its densities.
pub fn query(workshop: &Workshop, options: &[&str]) -> (String, Vec<f64>) {
    let said = workshop.succeeds(&[&QUERY, options].concat());
    let comment = said.lines().next().expect("a comment").to_owned();
    let densities = said
        .lines()
        .skip(2)
        .map(|row| row.rsplit(',').next().expect("a column"))
        .map(|density| density.parse().expect("a number"))
        .collect();
    (comment, densities)
}

/// `map.png` as the oracle sees it: decoded, never baked.
pub fn oracle_map(workshop: &Workshop) -> NormalMap {
    let raster = image::read(&workshop.path("map.png"), &ReadOptions::default()).expect("a map");
    let (map, _) = normals::decode(raster, &DecodeOptions::default()).expect("normals");
    map
}

/// Relative L1 error.
pub fn error(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let pairs = found.iter().zip(expected);
    let off: f64 = pairs
        .map(|(found, expected)| (found - expected).abs())
        .sum();
    off / expected.iter().sum::<f64>()
}
