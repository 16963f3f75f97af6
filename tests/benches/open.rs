//! Microseconds and page faults to open a mapped package of 100 MB.
//!
//! `cargo bench -p glintbake-tests --bench open`. Each round maps the file anew, so that its first page is not yet
//! mapped when the package is opened. Faults are the process's minor faults as Linux counts them.

use glintbake_bake::package;
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_format::model::{Method, Wrap};
use glintbake_runtime::Package;
use glintbake_samples::Kind;
use glintbake_tests::fixtures::sample_map;
use std::time::Instant;

const ROUNDS: usize = 1000;

/// Minor faults of this process so far, if the system tells.
fn minor_faults() -> Option<u64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Fields after the command's closing parenthesis: state is 0, minor faults 7.
    stat.rsplit(')')
        .next()?
        .split_whitespace()
        .nth(7)?
        .parse()
        .ok()
}

fn main() {
    let map = sample_map(Kind::Flakes, 4096, 4096, 7, Wrap::Repeat);
    let recipe = Recipe::new(vec![MethodRecipe::new(Method::FlakeBins, &[0.01])]);
    let plan = bake(&map, &recipe, None).expect("in range");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("flakes.glint");
    let length = package::publish(&path, |file| plan.write(file)).expect("a writable folder");
    let mut times = Vec::new();
    let mut faults = Vec::new();
    for _ in 0..ROUNDS {
        let bytes = package::open(&path, true).expect("it was just written");
        // The first call warms the path that reads the counter itself.
        minor_faults();
        let before = minor_faults();
        let start = Instant::now();
        let instances = Package::open(&bytes).expect("sound").instances().count();
        times.push(start.elapsed().as_nanos());
        let after = minor_faults();
        assert_eq!(instances, 1);
        faults.extend(after.zip(before).map(|(after, before)| after - before));
    }
    times.sort_unstable();
    faults.sort_unstable();
    println!(
        "open of {:.1} MB: median {:.1} µs, 99th percentile {:.1} µs, worst {:.1} µs over {ROUNDS} fresh mappings",
        length as f64 / 1e6,
        times[ROUNDS / 2] as f64 / 1e3,
        times[ROUNDS * 99 / 100] as f64 / 1e3,
        times[ROUNDS - 1] as f64 / 1e3,
    );
    match (faults.first(), faults.last()) {
        (Some(least), Some(most)) => println!("page faults: {least} to {most}"),
        _ => println!("page faults: this system does not tell"),
    }
}
