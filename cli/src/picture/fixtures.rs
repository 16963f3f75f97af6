//! Packages for the tests of pictures.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_format::model::{Method, Wrap};
use glintbake_runtime::{Package, SurfaceNdf};
use glintbake_samples::{Kind, Options, generate};

/// The bytes of a map of 8 × 8 texels that all have the normal (s, t), baked for `flake-bins` at `roughness`.
pub(super) fn constant(normal: [f32; 2], roughness: f64) -> Vec<u8> {
    package(
        &NormalMap::new(8, 8, Wrap::Repeat, vec![normal; 64]),
        MethodRecipe::new(Method::FlakeBins, &[roughness]),
    )
}

/// A map of 64 × 64 texels of flakes.
pub(super) fn flake_map() -> NormalMap {
    let options = Options {
        seed: 7,
        ..Options::new(Kind::Flakes, 64)
    };
    let sample = generate(Kind::Flakes, &options).expect("the options are in range");
    NormalMap::new(64, 64, Wrap::Repeat, sample.normals)
}

/// The bytes of [`flake_map`], baked for `method` (at `roughness`, if it has one).
pub(super) fn flakes(method: Method, roughness: &[f64]) -> Vec<u8> {
    package(&flake_map(), MethodRecipe::new(method, roughness))
}

/// The bytes of `map`, baked by `recipe`.
pub(super) fn package(map: &NormalMap, recipe: MethodRecipe) -> Vec<u8> {
    bake(map, &Recipe::new(vec![recipe]), None)
        .expect("the recipe is in range")
        .to_bytes()
}

/// The P-NDF in the package `bytes`.
pub(super) fn ndf(bytes: &[u8]) -> SurfaceNdf<'_> {
    let package = Package::open(bytes).expect("the package was just made");
    package.ndf(1).expect("its first instance is there")
}

/// What `work` returns on a pool of `threads` threads.
pub(super) fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads can be started")
        .install(work)
}
