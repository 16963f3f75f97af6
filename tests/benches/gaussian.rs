//! Gaussian footprints against boxes of the same edges, and what the default tolerance costs in accuracy, in one run.
//!
//! `cargo bench -p glintbake-tests --bench gaussian`. 2048² maps at α = 0.01; square footprints at random angles and
//! places, half vectors drawn from the footprint; D over 45 bins, both filters asked the same new queries in turn.
//! Times are medians over rounds; the error is Σ|D − D*| / ΣD* over all queries, D* being that of tolerance 0.

use glintbake_format::model::{Filter, Footprint, HalfVector, Wrap};
use glintbake_runtime::{FlakeBins, Instructions, Ndf, Package, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, sample_map};
use std::time::Instant;

const ALPHA: f64 = 0.01;
const SIDE: u32 = 2048;
const EDGES: [f64; 6] = [4.0, 16.0, 64.0, 128.0, 256.0, 1024.0];
const KINDS: [(&str, Kind); 4] = [
    ("flakes", Kind::Flakes),
    ("waves", Kind::Waves),
    ("scratches", Kind::Scratches),
    ("brushed", Kind::Brushed),
];
const ROUNDS: usize = 7;
const QUERIES: usize = 64;

fn main() {
    println!("simd: {}\n", Instructions::Fastest.name());
    println!(
        "{:<10} {:>6} {:>9} {:>9} {:>7} {:>9} {:>9} {:>9}",
        "map", "edge", "box µs", "gauss µs", "ratio", "simd µs", "exact µs", "rel. L1"
    );
    for (name, kind) in KINDS {
        let map = sample_map(kind, SIDE, SIDE, 7, Wrap::Repeat);
        let bytes = flake_package(&map, &[ALPHA]);
        let package = Package::open(&bytes).expect("a fresh package opens");
        let SurfaceNdf::FlakeBins(boxed) = package.ndf(1).expect("it has one instance") else {
            unreachable!("baked for flake-bins");
        };
        let gaussian = boxed.with_filter(Filter::Gaussian);
        let contestants = [
            boxed,
            gaussian.with_instructions(Instructions::Portable),
            gaussian,
            gaussian
                .with_tolerance(0.0)
                .with_instructions(Instructions::Portable),
        ];
        let mut stream = Stream::new(3);
        for edge in EDGES {
            let mut times = [const { Vec::new() }; 4];
            let (mut difference, mut total) = (0.0, 0.0);
            for round in 0..=ROUNDS {
                let queries: Vec<_> = (0..QUERIES)
                    .map(|_| stream.turned_square(&map, edge, ALPHA))
                    .collect();
                let mut answers = [const { Vec::new() }; 4];
                for turn in 0..contestants.len() {
                    let who = (turn + round) % contestants.len();
                    let start = Instant::now();
                    answers[who] = densities(&contestants[who], &queries);
                    // The first round only warms up.
                    if round > 0 {
                        times[who].push(start.elapsed().as_secs_f64() * 1e6 / QUERIES as f64);
                    }
                }
                let [_, fast, _, exact] = answers;
                for (fast, exact) in fast.iter().zip(&exact) {
                    difference += (fast - exact).abs();
                    total += exact;
                }
            }
            let [boxed, gaussian, simd, exact] = times.map(|mut times| {
                times.sort_by(f64::total_cmp);
                times[times.len() / 2]
            });
            println!(
                "{name:<10} {edge:>6} {boxed:>9.2} {gaussian:>9.2} {:>7.2} {simd:>9.2} {exact:>9.2} {:>8.3}%",
                gaussian / boxed,
                100.0 * difference / total
            );
        }
    }
}

fn densities(ndf: &FlakeBins<'_>, queries: &[(Footprint, HalfVector)]) -> Vec<f64> {
    queries
        .iter()
        .map(|(footprint, h)| ndf.eval(footprint, *h).expect("in range"))
        .collect()
}
