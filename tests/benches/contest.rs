//! The look-up of `flake-bins` against the paper's own structure and a plain vectorised scan, in one run.
//!
//! `cargo bench -p glintbake-tests --bench contest`, with names of maps and `--edges 4,16` after `--` for less of it.
//!
//! 2048² maps at α = 0.01; square footprints at random angles and places, half vectors drawn from the footprint. What
//! is timed is D over 45 bins: each contestant hands (column, row, weight) to one and the same density, so only the
//! look-up differs. A round asks every contestant the same new queries, so that nothing is in a cache from the last
//! time and noise of the machine meets all alike; a number is the median over rounds. The contest ends with a panic
//! if the contestants' D ever differ by more than rounding.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_cli::measure::baselines::paper_forest::{
    LEAF_SIZE, PaperForest, PaperLookup, Traversal,
};
use glintbake_cli::measure::baselines::plain_scan::PlainScan;
use glintbake_cli::measure::machine;
use glintbake_format::model::{
    BinGrid, Binning, Footprint, HalfVector, Method, Neighbourhood, Wrap, disk_grid_resolution,
};
use glintbake_runtime::microfacet::beckmann;
use glintbake_runtime::{FlakeBins, Package, SurfaceNdf};
use glintbake_samples::{Kind, Options, generate};
use glintbake_tests::fixtures::Stream;
use std::f64::consts::{PI, SQRT_2};
use std::time::Instant;

const ALPHA: f64 = 0.01;
const SIDE: u32 = 2048;
/// Edges of the footprints in texels: 16 texels to a million.
const EDGES: [u32; 8] = [4, 16, 32, 64, 128, 256, 512, 1024];
const ROUNDS: usize = 9;
/// Agreement of densities, as a share of the peak of the flakes' own distribution.
const AGREEMENT: f64 = 1e-9;

/// Name, kind and scale of each map. Flakes show 32 · scale² texels on average: 8 and 64 here.
const MAPS: [(&str, Kind, f64); 6] = [
    ("flakes-8", Kind::Flakes, 0.5),
    ("flakes-64", Kind::Flakes, SQRT_2),
    ("smooth", Kind::Waves, 1.0),
    ("scratches", Kind::Scratches, 1.0),
    ("brushed", Kind::Brushed, 1.0),
    ("noise", Kind::Noise, 1.0),
];

const CONTESTANTS: [&str; 4] = ["paper", "one by one", "scan", "ours"];
const PAPER: usize = 0;
const SCAN: usize = 2;
const OURS: usize = 3;

type Query = (Footprint, HalfVector);

fn main() {
    let choice = match Choice::from_arguments(std::env::args().skip(1)) {
        Ok(choice) => choice,
        Err(message) => {
            eprintln!("error: {message}");
            std::process::exit(2);
        }
    };
    describe_machine();
    println!(
        "\nµs per query; paper: §5.4 with leaves of {LEAF_SIZE}, trees traversed together as it says, or one by one\n"
    );
    print!("{:<10} {:>8}", "map", "texels");
    for name in CONTESTANTS {
        print!(" {name:>10}");
    }
    println!(" {:>11} {:>10}", "paper/ours", "ours/scan");
    let mut difference = 0.0_f64;
    for (name, kind, scale) in MAPS {
        if choice.wants(name) {
            difference = difference.max(contest(name, &sample_map(kind, scale), &choice.edges));
        }
    }
    println!(
        "largest difference between any two contestants' D: {difference:.1e} of the peak 1 / πα² = {:.0}",
        peak()
    );
}

/// What the command line asks for.
struct Choice {
    /// Maps by name; all if empty. `flakes` stands for both sizes.
    maps: Vec<String>,
    edges: Vec<u32>,
}

impl Choice {
    fn from_arguments(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut choice = Self {
            maps: Vec::new(),
            edges: EDGES.to_vec(),
        };
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                // Cargo adds it.
                "--bench" => {}
                "--edges" => {
                    let list = arguments
                        .next()
                        .ok_or("--edges needs a list, such as 4,16")?;
                    choice.edges = list
                        .split(',')
                        .map(|edge| match edge.parse() {
                            Ok(edge @ 1..=SIDE) => Ok(edge),
                            _ => Err(format!("--edges: {edge} is no number from 1 to {SIDE}")),
                        })
                        .collect::<Result<_, _>>()?;
                }
                name => choice.maps.push(name.to_owned()),
            }
        }
        for name in &choice.maps {
            if !MAPS.iter().any(|(map, ..)| stands_for(name, map)) {
                let names = MAPS.map(|(map, ..)| map).join(", ");
                return Err(format!(
                    "there is no map {name}; choose from {names}, flakes"
                ));
            }
        }
        Ok(choice)
    }

    fn wants(&self, map: &str) -> bool {
        self.maps.is_empty() || self.maps.iter().any(|name| stands_for(name, map))
    }
}

fn stands_for(name: &str, map: &str) -> bool {
    map == name || map.split('-').next() == Some(name)
}

/// Prints processor, target features and what they say about flags.
fn describe_machine() {
    println!("processor: {}", machine::processor());
    let features = machine::target_features();
    let flags = if matches!(&*features, "" | "sse2" | "neon") {
        "no more than every such machine has: built without target-cpu flags"
    } else {
        "more than every such machine has: built with target-cpu or target-feature flags"
    };
    println!("target: {} with {features}; {flags}", machine::target());
}

fn sample_map(kind: Kind, scale: f64) -> NormalMap {
    let options = Options {
        seed: 7,
        scale,
        ..Options::new(kind, SIDE)
    };
    let sample = generate(kind, &options).expect("the options are in range");
    NormalMap::new(SIDE, SIDE, Wrap::Repeat, sample.normals)
}

/// Prints the rows of one map, and returns the largest difference in D as a share of the peak.
fn contest(name: &str, map: &NormalMap, edges: &[u32]) -> f64 {
    let grid = BinGrid::new(Binning::DiskGrid, disk_grid_resolution(ALPHA)).expect("in range");
    let forest = PaperForest::new(map, grid, LEAF_SIZE);
    let scan = PlainScan::new(map, grid);
    let recipe = Recipe::new(vec![MethodRecipe::new(Method::FlakeBins, &[ALPHA])]);
    let bytes = bake(map, &recipe, None).expect("in range").to_bytes();
    let package = Package::open(&bytes).expect("a fresh package opens");
    let SurfaceNdf::FlakeBins(ours) = package.ndf(1).expect("it has one instance") else {
        unreachable!("baked for flake-bins");
    };
    let mut contestants = Contestants {
        grid,
        together: PaperLookup::new(&forest, Traversal::Together),
        one_by_one: PaperLookup::new(&forest, Traversal::OneByOne),
        scan: &scan,
        ours,
    };
    let mut stream = Stream::new(3);
    let mut difference = 0.0_f64;
    for &edge in edges {
        let mut times = [const { Vec::new() }; CONTESTANTS.len()];
        for round in 0..=ROUNDS {
            let queries = queries(map, f64::from(edge), &mut stream);
            let mut densities = [const { Vec::new() }; CONTESTANTS.len()];
            for turn in 0..CONTESTANTS.len() {
                // Everyone begins a round in turn.
                let who = (turn + round) % CONTESTANTS.len();
                let start = Instant::now();
                densities[who] = contestants.densities(who, &queries);
                let elapsed = start.elapsed().as_secs_f64();
                // The first round only warms up.
                if round > 0 {
                    times[who].push(elapsed * 1e6 / queries.len() as f64);
                }
            }
            for others in &densities[1..] {
                for (one, other) in densities[0].iter().zip(others) {
                    difference = difference.max((one - other).abs() / peak());
                }
            }
        }
        let medians = times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        });
        print!("{name:<10} {:>8}", u64::from(edge) * u64::from(edge));
        for median in medians {
            print!(" {median:>10.2}");
        }
        println!(
            " {:>11.2} {:>10.2}",
            medians[PAPER] / medians[OURS],
            medians[OURS] / medians[SCAN]
        );
    }
    // Evaluation and sampling: the paper stores the bin map, an integer a texel, besides.
    let texels = f64::from(SIDE) * f64::from(SIDE);
    let paper = forest.bytes_per_texel() + 4.0;
    let ours = bytes.len() as f64 / texels;
    println!(
        "{name:<10} {:>8} {paper:>10.2} {paper:>10.2} {:>10.2} {ours:>10.2}  bytes a texel, bin map included\n",
        "",
        scan.bytes_per_texel()
    );
    assert!(
        difference <= AGREEMENT,
        "{name}: the contestants' D differ by {difference:e} of the peak"
    );
    difference
}

/// Few enough that a round is short, many enough that it means something.
fn query_count(edge: f64) -> usize {
    (1 << 15 >> (edge.log2() as u32)).clamp(64, 2048)
}

fn queries(map: &NormalMap, edge: f64, stream: &mut Stream) -> Vec<Query> {
    (0..query_count(edge))
        .map(|_| stream.turned_square(map, edge, ALPHA))
        .collect()
}

/// The density of one flake at its middle.
fn peak() -> f64 {
    1.0 / (PI * ALPHA * ALPHA)
}

struct Contestants<'a> {
    grid: BinGrid,
    together: PaperLookup<'a>,
    one_by_one: PaperLookup<'a>,
    scan: &'a PlainScan,
    ours: FlakeBins<'a>,
}

impl Contestants<'_> {
    /// D of each query by contestant number `who`.
    fn densities(&mut self, who: usize, queries: &[Query]) -> Vec<f64> {
        let grid = self.grid;
        let bins = Neighbourhood::Bins45;
        queries
            .iter()
            .map(|(footprint, h)| {
                let direction = h.direction();
                let mut density = 0.0;
                let mut add = |column, row, weight: f64| {
                    let centre = grid.centre(column, row);
                    density += weight * beckmann::density(direction, centre, ALPHA);
                };
                match who {
                    PAPER => self.together.bin_weights(footprint, *h, bins, &mut add),
                    SCAN => self.scan.bin_weights(footprint, *h, bins, &mut add),
                    OURS => self
                        .ours
                        .bin_weights(footprint, *h, bins, &mut add)
                        .expect("in range"),
                    _ => self.one_by_one.bin_weights(footprint, *h, bins, &mut add),
                }
                density
            })
            .collect()
    }
}
