//! Nanoseconds per query of `flake-bins` by footprint size, map and way to the weights, in one run.
//!
//! `cargo bench -p glintbake-tests --bench weights`. 2048² maps at α = 0.01, square footprints at random places
//! (cold: no two queries share a neighbourhood) turned by a random angle, half vectors drawn from the footprint.
//! The ratio of `scan` to `lists` says where a query should change its way.

use divan::counter::ItemsCount;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Footprint, HalfVector, Wrap};
use glintbake_runtime::ndf::Lookup;
use glintbake_runtime::{Ndf, Package, Queries, Setting, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, sample_map};
use std::sync::LazyLock;

const ALPHA: f64 = 0.01;
const SIDE: u32 = 2048;
/// Edges of the footprints in texels (2σ): 16 texels to a million.
const EDGES: [u32; 6] = [4, 16, 32, 64, 256, 1024];
const QUERIES: usize = 256;
const KINDS: [Kind; 4] = [Kind::Flakes, Kind::Brushed, Kind::Scratches, Kind::Noise];

struct Scene {
    map: NormalMap,
    bytes: Vec<u8>,
}

static SCENES: LazyLock<Vec<Scene>> = LazyLock::new(|| {
    KINDS
        .iter()
        .map(|&kind| {
            let map = sample_map(kind, SIDE, SIDE, 7, Wrap::Repeat);
            let bytes = flake_package(&map, &[ALPHA]);
            Scene { map, bytes }
        })
        .collect()
});

fn queries(map: &NormalMap, edge: f64) -> Vec<(Footprint, HalfVector)> {
    let mut stream = Stream::new(3);
    (0..QUERIES)
        .map(|_| stream.turned_square(map, edge, ALPHA))
        .collect()
}

fn run(bencher: divan::Bencher<'_, '_>, kind: usize, edge: u32, lookup: Option<Lookup>) {
    let scene = &SCENES[kind];
    let package = Package::open(&scene.bytes).expect("a fresh package opens");
    let SurfaceNdf::FlakeBins(ndf) = package.ndf(1).expect("it has one instance") else {
        unreachable!("baked for flake-bins");
    };
    let ndf = match lookup {
        Some(lookup) => ndf.with_lookup(lookup),
        None => ndf
            .with_setting(Setting::Exact)
            .expect("baked with exact normals"),
    };
    let queries = queries(&scene.map, f64::from(edge));
    bencher
        .counter(ItemsCount::new(queries.len()))
        .bench_local(|| {
            queries
                .iter()
                .map(|(footprint, half_vector)| {
                    ndf.eval(footprint, *half_vector).expect("in range")
                })
                .sum::<f64>()
        });
}

/// As `run` by the way the runtime chooses, all queries in one batch.
fn run_batch(bencher: divan::Bencher<'_, '_>, kind: usize, edge: u32) {
    let scene = &SCENES[kind];
    let package = Package::open(&scene.bytes).expect("a fresh package opens");
    let ndf = package.ndf(1).expect("it has one instance");
    let queries = queries(&scene.map, f64::from(edge));
    let coordinate = |pick: &dyn Fn(&(Footprint, HalfVector)) -> f64| -> Vec<f64> {
        queries.iter().map(pick).collect()
    };
    let arrays = [
        coordinate(&|(footprint, _)| footprint.centre[0]),
        coordinate(&|(footprint, _)| footprint.centre[1]),
        coordinate(&|(footprint, _)| footprint.edge_1[0]),
        coordinate(&|(footprint, _)| footprint.edge_1[1]),
        coordinate(&|(footprint, _)| footprint.edge_2[0]),
        coordinate(&|(footprint, _)| footprint.edge_2[1]),
        coordinate(&|(_, h)| h.s),
        coordinate(&|(_, h)| h.t),
    ];
    let [u, v, e1u, e1v, e2u, e2v, s, t] = &arrays;
    let batch = Queries {
        centre: [u, v],
        edge_1: [e1u, e1v],
        edge_2: [e2u, e2v],
        half_vector: [s, t],
    };
    let mut densities = vec![0.0; queries.len()];
    bencher
        .counter(ItemsCount::new(queries.len()))
        .bench_local(|| {
            ndf.eval_batch(&batch, &mut densities).expect("in range");
            densities.last().copied()
        });
}

macro_rules! benches {
    ($($map:ident = $kind:literal),+) => {
        $(mod $map {
            benches!(@ $kind, lists, Some(super::Lookup::Lists));
            benches!(@ $kind, scan, Some(super::Lookup::Scan));
            benches!(@ $kind, auto, Some(super::Lookup::Auto));
            benches!(@ $kind, exact, None);

            #[divan::bench(args = super::EDGES)]
            fn batch(bencher: divan::Bencher<'_, '_>, edge: u32) {
                super::run_batch(bencher, $kind, edge);
            }
        })+
    };
    (@ $kind:literal, $name:ident, $lookup:expr) => {
        #[divan::bench(args = super::EDGES)]
        fn $name(bencher: divan::Bencher<'_, '_>, edge: u32) {
            super::run(bencher, $kind, edge, $lookup);
        }
    };
}

benches!(flakes = 0, brushed = 1, scratches = 2, noise = 3);

fn main() {
    divan::main();
}
