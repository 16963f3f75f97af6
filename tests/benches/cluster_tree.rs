//! `cluster-tree` against the paper's own structure and a vectorised exact scan, in one run.
//!
//! `cargo bench -p glintbake-tests --bench cluster_tree`; after `--` any of: names of maps, `--sigmas 1,16` (sizes σ of
//! footprints in texels), `--rough 0.005,0.08` (σr), `--filter gaussian`, `--kernel disk`, `--queries N`, `--eps E`,
//! `--size 1024`, `--no-paper`, `--raster` (the tree also with a raster of normals beside it).
//!
//! Maps of 2048²; square footprints of edge 2σ at random angles and places, half vectors drawn from the footprint: the normal of
//! a texel, moved by the kernel. Errors are against the exact scan, whose own are of single precision: relative L1 over a cell's
//! queries and the worst as a share of the greatest D. A number of time is the median over rounds that everybody begins in turn.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_cli::measure::baselines::exact_scan::ExactScan;
use glintbake_cli::measure::baselines::paper_forest::{
    LEAF_SIZE, PaperForest, PaperLookup, Traversal,
};
use glintbake_format::model::{
    BinGrid, Binning, Filter, Footprint, HalfVector, Kernel, Method, Neighbourhood, Wrap,
    beckmann_from_intrinsic, disk_grid_resolution,
};
use glintbake_runtime::microfacet::beckmann;
use glintbake_runtime::{Accuracy, ClusterTree, Ndf, Package, SurfaceNdf};
use glintbake_samples::{Kind, Options, generate};
use glintbake_tests::fixtures::Stream;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Instant;

/// Name and kind of each map.
const MAPS: [(&str, Kind); 4] = [
    ("flakes", Kind::Flakes),
    ("smooth", Kind::Waves),
    ("scratches", Kind::Scratches),
    ("brushed", Kind::Brushed),
];
const ROUNDS: usize = 5;

type Query = (Footprint, HalfVector);

struct Choice {
    maps: Vec<String>,
    sigmas: Vec<f64>,
    rough: Vec<f64>,
    filter: Filter,
    kernel: Kernel,
    queries: usize,
    eps: f64,
    size: u32,
    paper: bool,
    raster: bool,
}

fn numbers(text: &str) -> Vec<f64> {
    text.split(',')
        .map(|number| number.parse().expect("numbers with commas between"))
        .collect()
}

fn choice() -> Choice {
    let mut choice = Choice {
        maps: Vec::new(),
        sigmas: vec![0.25, 1.0, 4.0, 16.0, 64.0, 256.0],
        rough: vec![0.0025, 0.005, 0.02, 0.08, 0.15],
        filter: Filter::Box,
        kernel: Kernel::Beckmann,
        queries: 2000,
        eps: Accuracy::DEFAULT,
        size: 2048,
        paper: true,
        raster: false,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().expect("the option has a value");
        match argument.as_str() {
            "--bench" => {}
            "--sigmas" => choice.sigmas = numbers(&value()),
            "--rough" => choice.rough = numbers(&value()),
            "--filter" => {
                choice.filter = if value() == "gaussian" {
                    Filter::Gaussian
                } else {
                    Filter::Box
                }
            }
            "--kernel" => {
                choice.kernel = if value() == "disk" {
                    Kernel::Disk
                } else {
                    Kernel::Beckmann
                }
            }
            "--queries" => choice.queries = value().parse().expect("a number"),
            "--eps" => choice.eps = value().parse().expect("a number"),
            "--size" => choice.size = value().parse().expect("a number"),
            "--no-paper" => choice.paper = false,
            "--raster" => choice.raster = true,
            name => choice.maps.push(name.to_owned()),
        }
    }
    choice
}

fn main() {
    let choice = choice();
    println!(
        "{:<10} {:>7} {:>7} {:>9} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "map",
        "σr",
        "σ",
        "tree µs",
        "raster µs",
        "paper µs",
        "scan µs",
        "paper/",
        "scan/",
        "L1 %",
        "worst %",
        "raster L1",
        "paper L1"
    );
    let mut ratios = Vec::new();
    for (name, kind) in MAPS {
        if choice.maps.is_empty() || choice.maps.iter().any(|map| map == name) {
            contest(name, kind, &choice, &mut ratios);
        }
    }
    ratios.sort_by(f64::total_cmp);
    if let Some(median) = ratios.get(ratios.len() / 2) {
        println!(
            "the paper's structure takes {median:.1} times as long in the median of {} cells, {:.1} to {:.1}",
            ratios.len(),
            ratios[0],
            ratios[ratios.len() - 1]
        );
    }
}

fn contest(name: &str, kind: Kind, choice: &Choice, ratios: &mut Vec<f64>) {
    let options = Options {
        seed: 7,
        ..Options::new(kind, choice.size)
    };
    let sample = generate(kind, &options).expect("the options are in range");
    let map = NormalMap::new(choice.size, choice.size, Wrap::Repeat, sample.normals);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = pool.build().expect("one thread can be had");
    let recipe = |raster_normals| {
        Recipe::new(vec![MethodRecipe {
            masking: false,
            raster_normals,
            ..MethodRecipe::new(Method::ClusterTree, &[0.01])
        }])
    };
    let start = Instant::now();
    let plan = pool
        .install(|| bake(&map, &recipe(false), None))
        .expect("in range");
    let seconds = start.elapsed().as_secs_f64();
    let bytes = plan.to_bytes();
    println!(
        "{name}: {:.2} bytes a texel, built in {seconds:.2} s on one thread",
        bytes.len() as f64 / map.texels().len() as f64
    );
    let with_raster = choice.raster.then(|| {
        let plan = bake(&map, &recipe(true), None).expect("in range");
        plan.to_bytes()
    });
    let ndf = open(&bytes);
    let beside = with_raster.as_deref().map(open);
    let scan = ExactScan::new(&map);
    for &sigma in &choice.rough {
        let alpha = beckmann_from_intrinsic(sigma);
        let grid = BinGrid::new(Binning::DiskGrid, disk_grid_resolution(alpha)).expect("in range");
        let forest = (choice.paper && choice.filter == Filter::Box)
            .then(|| PaperForest::new(&map, grid, LEAF_SIZE));
        let ndf = asked(ndf, choice, alpha);
        let beside = beside.map(|ndf| asked(ndf, choice, alpha));
        for &size in &choice.sigmas {
            cell(
                name,
                &map,
                sigma,
                size,
                choice,
                &ndf,
                beside.as_ref(),
                &scan,
                forest.as_ref(),
                grid,
                ratios,
            );
        }
    }
}

/// `ndf` as `choice` asks for it.
fn asked<'a>(ndf: ClusterTree<'a>, choice: &Choice, alpha: f64) -> ClusterTree<'a> {
    ndf.with_roughness(alpha)
        .and_then(|ndf| ndf.with_kernel(choice.kernel))
        .expect("in range")
        .with_filter(choice.filter)
        .with_accuracy(Accuracy::Fast(choice.eps))
}

/// The tree of `bytes`.
fn open(bytes: &[u8]) -> ClusterTree<'_> {
    let package = Package::open(bytes).expect("a fresh package opens");
    match package.ndf(1).expect("it has one instance") {
        SurfaceNdf::ClusterTree(ndf) => ndf,
        other => unreachable!("baked for cluster-tree: {other:?}"),
    }
}

#[expect(
    clippy::too_many_arguments,
    reason = "what makes up a cell of the table"
)]
fn cell(
    name: &str,
    map: &NormalMap,
    sigma: f64,
    size: f64,
    choice: &Choice,
    ndf: &ClusterTree<'_>,
    beside: Option<&ClusterTree<'_>>,
    scan: &ExactScan,
    forest: Option<&PaperForest>,
    grid: BinGrid,
    ratios: &mut Vec<f64>,
) {
    let alpha = beckmann_from_intrinsic(sigma);
    let mut stream = Stream::new(11);
    // Scans of large footprints take long.
    let count = choice
        .queries
        .min((4e7 / (size * size * 4.0)) as usize)
        .max(40);
    let queries: Vec<Query> = (0..count)
        .map(|_| query(map, 2.0 * size, sigma, &mut stream))
        .collect();
    let mut lookup = forest.map(|forest| PaperLookup::new(forest, Traversal::Together));
    let mut times = [const { Vec::new() }; 4];
    let mut answers = [const { Vec::new() }; 4];
    for round in 0..ROUNDS {
        for turn in 0..4 {
            let who = (turn + round) % 4;
            let start = Instant::now();
            let densities: Vec<f64> = match (who, &mut lookup) {
                (0, _) => queries
                    .iter()
                    .map(|(footprint, h)| black_box(ndf.eval(footprint, *h).expect("in range")))
                    .collect(),
                (1, Some(lookup)) => queries
                    .iter()
                    .map(|(footprint, h)| paper(lookup, footprint, *h, grid, alpha))
                    .collect(),
                (2, _) => queries
                    .iter()
                    .map(|(footprint, h)| {
                        black_box(scan.eval(footprint, *h, choice.filter, choice.kernel, alpha))
                    })
                    .collect(),
                (3, _) => beside.map_or(Vec::new(), |ndf| {
                    let all = queries.iter();
                    all.map(|(footprint, h)| black_box(ndf.eval(footprint, *h).expect("in range")))
                        .collect()
                }),
                _ => Vec::new(),
            };
            times[who].push(start.elapsed().as_secs_f64() * 1e6 / count as f64);
            answers[who] = densities;
        }
    }
    let [tree_us, paper_us, scan_us, raster_us] = times.map(|mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    let [tree, paper, truth, raster] = &answers;
    let greatest = truth.iter().copied().fold(0.0, f64::max);
    let l1 = |answers: &[f64]| {
        let off: f64 = answers.iter().zip(truth).map(|(a, b)| (a - b).abs()).sum();
        100.0 * off / truth.iter().sum::<f64>()
    };
    let l1_if_there = |answers: &[f64]| {
        if answers.is_empty() {
            f64::NAN
        } else {
            l1(answers)
        }
    };
    let worst = tree
        .iter()
        .zip(truth)
        .map(|(a, b)| 100.0 * (a - b).abs() / greatest)
        .fold(0.0, f64::max);
    if forest.is_some() {
        ratios.push(paper_us / tree_us);
    }
    println!(
        "{name:<10} {sigma:>7} {size:>7} {tree_us:>9.2} {raster_us:>9.2} {paper_us:>9.2} {scan_us:>9.2} {:>8.2} {:>8.2} {:>8.3} {worst:>8.3} {:>8.3} {:>8.1}",
        paper_us / tree_us,
        scan_us / tree_us,
        l1(tree),
        l1_if_there(raster),
        l1_if_there(paper)
    );
}

fn paper(
    lookup: &mut PaperLookup<'_>,
    footprint: &Footprint,
    h: HalfVector,
    grid: BinGrid,
    alpha: f64,
) -> f64 {
    let direction = h.direction();
    let mut density = 0.0;
    lookup.bin_weights(
        footprint,
        h,
        Neighbourhood::Bins21,
        &mut |column, row, weight| {
            density += weight * beckmann::density(direction, grid.centre(column, row), alpha);
        },
    );
    density
}

/// A square footprint, and a half vector drawn from it.
fn query(map: &NormalMap, edge: f64, sigma: f64, stream: &mut Stream) -> Query {
    let angle = stream.between(0.0, TAU);
    let length = edge / f64::from(map.width());
    let footprint = Footprint {
        centre: [stream.uniform(), stream.uniform()],
        edge_1: [length * angle.cos(), length * angle.sin()],
        edge_2: [-length * angle.sin(), length * angle.cos()],
    };
    loop {
        let near = stream.half_vector_near(map, &footprint, 0.0);
        let radius = sigma * (-2.0 * (1.0 - stream.uniform()).ln()).sqrt();
        let angle = stream.between(0.0, TAU);
        let h = HalfVector {
            s: near.s + radius * angle.cos(),
            t: near.t + radius * angle.sin(),
        };
        if h.is_on_disk() {
            return (footprint, h);
        }
    }
}
