//! Milliseconds to build the structures of `flake-bins` on one thread, 2048² maps.
//!
//! `cargo bench -p glintbake-tests --bench build`

use glintbake_bake::build::{bin_map, block_lists, forest, inverse_bin_map, masking};
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{BinGrid, Binning, Wrap, disk_grid_resolution};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::sample_map;
use std::sync::LazyLock;

const SIDE: u32 = 2048;
const KINDS: [&str; 4] = ["flakes", "scratches", "brushed", "noise"];

static MAPS: LazyLock<Vec<NormalMap>> = LazyLock::new(|| {
    KINDS
        .iter()
        .map(|name| {
            let kind = Kind::from_name(name).expect("a kind of sample");
            sample_map(kind, SIDE, SIDE, 7, Wrap::Repeat)
        })
        .collect()
});

fn map(name: &str) -> &'static NormalMap {
    let place = KINDS.iter().position(|kind| *kind == name);
    &MAPS[place.expect("one of the kinds")]
}

fn grid() -> BinGrid {
    BinGrid::new(Binning::DiskGrid, disk_grid_resolution(0.01)).expect("in range")
}

#[divan::bench(args = KINDS)]
fn a_bin_map(bencher: divan::Bencher<'_, '_>, name: &str) {
    let map = map(name);
    bencher.bench_local(|| bin_map::build(map, grid()));
}

#[divan::bench(args = KINDS)]
fn b_block_lists(bencher: divan::Bencher<'_, '_>, name: &str) {
    let bin_map = bin_map::build(map(name), grid());
    bencher.bench_local(|| block_lists::build(&bin_map, SIDE, SIDE));
}

#[divan::bench(args = KINDS)]
fn c_inverse_bin_map(bencher: divan::Bencher<'_, '_>, name: &str) {
    let bin_map = bin_map::build(map(name), grid());
    bencher.bench_local(|| inverse_bin_map::build(&bin_map, SIDE, SIDE));
}

#[divan::bench(args = [("flakes", 32), ("scratches", 32), ("brushed", 32), ("noise", 32), ("flakes", 10)])]
fn d_forest(bencher: divan::Bencher<'_, '_>, (name, leaf_size): (&str, u32)) {
    let bin_map = bin_map::build(map(name), grid());
    let inverse = inverse_bin_map::build(&bin_map, SIDE, SIDE);
    bencher.bench_local(|| forest::build(&inverse, leaf_size));
}

#[divan::bench(args = KINDS)]
fn e_masking(bencher: divan::Bencher<'_, '_>, name: &str) {
    let map = map(name);
    bencher.bench_local(|| masking::build(map));
}

fn main() {
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()
        .expect("the pool is built once");
    divan::main();
}
