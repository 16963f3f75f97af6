//! Gaussian footprints: weights and densities against the oracle, the tolerance's promise, samples, instructions.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::{self, flake_bins as truth};
use glintbake_bake::{MethodRecipe, Recipe};
use glintbake_format::model::{Filter, Footprint, HalfVector, Method, Neighbourhood, Wrap};
use glintbake_format::records::InverseKind;
use glintbake_runtime::ndf::Lookup;
use glintbake_runtime::{FlakeBins, Instructions, Ndf, Package, Setting, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, package, sample_map, specular_package};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Exact weights against the oracle's: what is cut off at 4.8 standard deviations, all of which may be one texel's.
const WEIGHT: f64 = 2e-5;
/// Exact densities against the oracle's, relative to the greatest of their footprint.
const NDF: f64 = 1e-4;
/// What the default tolerance promises in relative L1.
const PROMISE: f64 = 5e-3;
const ALPHA: f64 = 0.15;

fn baked(map: &NormalMap, alpha: f64, inverse: InverseKind) -> Vec<u8> {
    let recipe = MethodRecipe {
        inverse: Some(inverse),
        leaf_size: 8,
        exact_normals: true,
        ..MethodRecipe::new(Method::FlakeBins, &[alpha])
    };
    package(map, recipe)
}

fn flake_bins<'a>(package: &Package<'a>) -> FlakeBins<'a> {
    let SurfaceNdf::FlakeBins(ndf) = package.ndf(1).expect("it has one instance") else {
        unreachable!("baked for flake-bins");
    };
    ndf.with_filter(Filter::Gaussian)
}

/// A Gaussian of standard deviations `sigma`, in texels of `map`, turned at random.
fn gaussian(stream: &mut Stream, map: &NormalMap, sigma: [f64; 2]) -> Footprint {
    let size = [f64::from(map.width()), f64::from(map.height())];
    let angle = stream.between(0.0, TAU);
    let (cosine, sine) = (angle.cos(), angle.sin());
    Footprint {
        centre: [stream.between(-2.0, 3.0), stream.between(-2.0, 3.0)],
        edge_1: [
            2.0 * sigma[0] * cosine / size[0],
            2.0 * sigma[0] * sine / size[1],
        ],
        edge_2: [
            -2.0 * sigma[1] * sine / size[0],
            2.0 * sigma[1] * cosine / size[1],
        ],
    }
}

/// Deviations from a hundredth of a texel to `most`, by anisotropy.
fn sweep(stream: &mut Stream, map: &NormalMap, most: f64) -> Vec<Footprint> {
    let mut footprints = Vec::new();
    for long in [0.01, 0.2, 0.7, 1.4, 2.1, 5.0, 14.0, 40.0, 110.0, 300.0] {
        for thinness in [1.0, 3.0, 40.0, 1e4] {
            if long <= most {
                footprints.push(gaussian(stream, map, [long, long / thinness]));
            }
        }
    }
    footprints
}

/// A half vector where `weights` have some weight.
fn near_weight(
    stream: &mut Stream,
    map: &NormalMap,
    weights: &[oracle::TexelWeight],
) -> HalfVector {
    let mut left = stream.uniform();
    let texel = weights
        .iter()
        .find(|texel| {
            left -= texel.weight;
            left <= 0.0
        })
        .unwrap_or(&weights[0]);
    let [s, t] = map.texels()[(texel.row * map.width() + texel.column) as usize];
    let mut moved = |value: f32| 0.98 * f64::from(value) + stream.between(-0.05, 0.05) * ALPHA;
    HalfVector {
        s: moved(s),
        t: moved(t),
    }
}

fn weights_of(
    ndf: &FlakeBins<'_>,
    footprint: &Footprint,
    h: HalfVector,
) -> BTreeMap<(u32, u32), f64> {
    let mut weights = BTreeMap::new();
    ndf.bin_weights(
        footprint,
        h,
        Neighbourhood::Bins45,
        &mut |column, row, weight| {
            weights.insert((column, row), weight);
        },
    )
    .expect("in range");
    weights
}

/// Exact weights and densities of `map` against the oracle's, for every index and way to look up.
fn compare_exactly(map: &NormalMap, seed: u64, most: f64) {
    let mut stream = Stream::new(seed);
    let footprints = sweep(&mut stream, map, most);
    let packages = [InverseKind::Tiles, InverseKind::Forest, InverseKind::None]
        .map(|inverse| (inverse, baked(map, ALPHA, inverse)));
    for footprint in &footprints {
        let texels = oracle::texel_weights(map, footprint, Filter::Gaussian);
        let bins = truth::bin_weights_of(map, &texels, ALPHA);
        let binned =
            |bins| truth::Prepared::from_weights(map, &texels, ALPHA, truth::Setting::Binned(bins));
        let settings = [
            (
                Setting::Binned(Neighbourhood::Bins45),
                binned(Neighbourhood::Bins45),
            ),
            (
                Setting::Binned(Neighbourhood::Bins21),
                binned(Neighbourhood::Bins21),
            ),
        ];
        let queries: Vec<_> = (0..2)
            .map(|_| near_weight(&mut stream, map, &texels))
            .collect();
        for (inverse, bytes) in &packages {
            let package = Package::open(bytes).expect("a fresh package opens");
            let ndf = flake_bins(&package).with_tolerance(0.0);
            let lookups: &[Lookup] = match inverse {
                InverseKind::None => &[Lookup::Auto],
                _ => &[Lookup::Auto, Lookup::Scan, Lookup::Lists],
            };
            for &lookup in lookups {
                let ndf = ndf.with_lookup(lookup);
                for &h in &queries {
                    for (bin, weight) in weights_of(&ndf, footprint, h) {
                        let expected = bins.get(&bin).copied().unwrap_or(0.0);
                        assert!(
                            (weight - expected).abs() <= WEIGHT,
                            "{inverse:?}, {lookup:?}, {footprint:?}, bin {bin:?}: {weight}, not {expected}"
                        );
                    }
                    for (setting, truth) in &settings {
                        let ndf = ndf.with_setting(*setting).expect("any package has bins");
                        let (got, expected) =
                            (ndf.eval(footprint, h).expect("in range"), truth.ndf(h));
                        assert!(
                            (got - expected).abs() <= NDF * expected.max(1e-2),
                            "{inverse:?}, {lookup:?}, {setting:?}, {footprint:?}, {h:?}: {got}, not {expected}"
                        );
                    }
                }
            }
        }
        let (_, bytes) = &packages[0];
        let exact = flake_bins(&Package::open(bytes).expect("a fresh package opens"))
            .with_setting(Setting::Exact)
            .expect("it was baked with exact normals");
        let truth = truth::Prepared::from_weights(map, &texels, ALPHA, truth::Setting::Exact);
        for &h in &queries {
            let (got, expected) = (exact.eval(footprint, h).expect("in range"), truth.ndf(h));
            // Exact normals are stored in 2^-16 of a bin.
            assert!(
                (got - expected).abs() <= 3e-4 * expected.max(1e-2),
                "exact, {footprint:?}, {h:?}: {got}, not {expected}"
            );
        }
    }
}

#[test]
fn exact_weights_and_densities_are_the_oracles_on_maps_that_repeat() {
    compare_exactly(&sample_map(Kind::Waves, 150, 90, 4, Wrap::Repeat), 1, 110.0);
    compare_exactly(
        &sample_map(Kind::Flakes, 300, 300, 5, Wrap::Repeat),
        2,
        50.0,
    );
}

#[test]
fn exact_weights_and_densities_are_the_oracles_on_maps_with_a_border() {
    compare_exactly(
        &sample_map(Kind::Scratches, 100, 70, 4, Wrap::Clamp),
        3,
        110.0,
    );
    compare_exactly(&sample_map(Kind::Noise, 1, 1, 4, Wrap::Clamp), 4, 5.0);
}

#[test]
fn exact_weights_and_densities_are_the_oracles_under_many_copies_of_a_small_map() {
    compare_exactly(&sample_map(Kind::Noise, 5, 3, 4, Wrap::Repeat), 5, 300.0);
    compare_exactly(&sample_map(Kind::Noise, 1, 1, 4, Wrap::Repeat), 6, 110.0);
    compare_exactly(&sample_map(Kind::Noise, 40, 2, 4, Wrap::Repeat), 7, 20.0);
}

#[test]
fn mirrors_are_weighed_by_gaussians_too() {
    let map = sample_map(Kind::Waves, 80, 64, 3, Wrap::Repeat);
    let bytes = specular_package(&map, 20);
    let package = Package::open(&bytes).expect("a fresh package opens");
    let ndf = package
        .ndf(1)
        .expect("it has one instance")
        .with_filter(Filter::Gaussian)
        .with_tolerance(0.0);
    let mut stream = Stream::new(5);
    let mut seen = 0;
    for sigma in [0.3, 1.2, 4.0, 12.0, 30.0, 200.0] {
        let footprint = gaussian(&mut stream, &map, [sigma, 0.6 * sigma]);
        let texels = oracle::texel_weights(&map, &footprint, Filter::Gaussian);
        let truth = oracle::specular_bins::Prepared::from_weights(&map, &texels, 20);
        for _ in 0..8 {
            let h = near_weight(&mut stream, &map, &texels);
            let (got, expected) = (ndf.eval(&footprint, h).expect("in range"), truth.ndf(h));
            assert!(
                (got - expected).abs() <= NDF * expected + 1e-3,
                "{footprint:?}, {h:?}: {got}, not {expected}"
            );
            seen += usize::from(expected > 0.1);
        }
    }
    assert!(seen > 20, "most half vectors must meet weight: {seen}");
}

#[test]
fn the_default_tolerance_keeps_its_promise_and_is_used() {
    for kind in [
        Kind::Flakes,
        Kind::Scratches,
        Kind::Brushed,
        Kind::Waves,
        Kind::Leather,
        Kind::Noise,
    ] {
        let map = sample_map(kind, 1024, 1024, 7, Wrap::Repeat);
        let bytes = baked(&map, 0.02, InverseKind::Tiles);
        let package = Package::open(&bytes).expect("a fresh package opens");
        let fast = flake_bins(&package);
        let exact = fast.with_tolerance(0.0);
        let mut stream = Stream::new(11);
        let mut any_differs = false;
        for edge in [32.0, 64.0, 128.0, 256.0, 512.0] {
            let (mut difference, mut total) = (0.0, 0.0);
            for _ in 0..40 {
                let footprint = gaussian(&mut stream, &map, [0.5 * edge, 0.4 * edge]);
                let h = stream.half_vector_near(&map, &footprint, 0.01);
                let exact = exact.eval(&footprint, h).expect("in range");
                difference += (fast.eval(&footprint, h).expect("in range") - exact).abs();
                total += exact;
            }
            assert!(
                difference <= PROMISE * total,
                "{kind:?}, edges of {edge}: {} of the density",
                difference / total
            );
            any_differs |= difference > 0.0;
        }
        assert!(any_differs, "{kind:?}: nothing was approximated");
    }
}

#[test]
fn weights_of_all_bins_add_up_to_one() {
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let map = sample_map(Kind::Waves, 320, 256, 2, wrap);
        let bytes = baked(&map, 0.3, InverseKind::Tiles);
        let package = Package::open(&bytes).expect("a fresh package opens");
        let ndf = flake_bins(&package).with_lookup(Lookup::Lists);
        let mut stream = Stream::new(21);
        for sigma in [1.0, 3.0, 9.0, 30.0, 70.0] {
            let footprint = gaussian(&mut stream, &map, [sigma, 0.7 * sigma]);
            for (tolerance, allowed) in [(0.0, 1.5e-5), (0.125, 5e-3)] {
                let ndf = ndf.with_tolerance(tolerance);
                let resolution = ndf.instance().bins().unwrap().grid.resolution();
                let mut all = BTreeMap::new();
                for row in 0..resolution {
                    for column in 0..resolution {
                        let place =
                            |x: u32| (2.0 * f64::from(x) + 1.0) / f64::from(resolution) - 1.0;
                        let h = HalfVector {
                            s: place(column),
                            t: place(row),
                        };
                        for (bin, weight) in weights_of(&ndf, &footprint, h) {
                            let same = all.insert(bin, weight).is_none_or(|old| old == weight);
                            assert!(same, "bin {bin:?} weighs the same in every window");
                        }
                    }
                }
                let sum: f64 = all.values().sum();
                assert!(
                    (sum - 1.0).abs() <= allowed,
                    "σ {sigma}, {wrap:?}, tolerance {tolerance}: {sum}"
                );
            }
        }
    }
}

#[test]
fn all_instructions_give_the_same_bits() {
    let map = sample_map(Kind::Flakes, 512, 384, 7, Wrap::Repeat);
    for inverse in [InverseKind::Tiles, InverseKind::Forest] {
        let bytes = baked(&map, 0.03, inverse);
        let package = Package::open(&bytes).expect("a fresh package opens");
        let ndf = flake_bins(&package);
        let mut stream = Stream::new(9);
        for edge in [3.0, 20.0, 100.0, 300.0] {
            for tolerance in [0.0, 0.125] {
                for lookup in [Lookup::Scan, Lookup::Lists] {
                    let footprint = stream.footprint(&map, edge);
                    let h = stream.half_vector_near(&map, &footprint, 0.01);
                    let ndf = ndf.with_tolerance(tolerance).with_lookup(lookup);
                    let by = |instructions| ndf.with_instructions(instructions).eval(&footprint, h);
                    assert_eq!(by(Instructions::Portable), by(Instructions::Fastest));
                }
            }
        }
    }
}

#[test]
fn an_instance_says_which_filter_weighs_footprints_unless_told_otherwise() {
    let map = sample_map(Kind::Waves, 32, 32, 3, Wrap::Repeat);
    let recipe = MethodRecipe {
        filter: Filter::Gaussian,
        ..MethodRecipe::new(Method::FlakeBins, &[ALPHA])
    };
    assert_ne!(
        Recipe::new(vec![recipe.clone()]).hash(&[]),
        Recipe::new(vec![MethodRecipe::new(Method::FlakeBins, &[ALPHA])]).hash(&[])
    );
    let bytes = package(&map, recipe);
    let package = Package::open(&bytes).expect("a fresh package opens");
    let ndf = package.ndf(1).expect("it has one instance");
    assert_eq!(ndf.filter(), Filter::Gaussian);
    let footprint = Footprint::square([0.4; 2], 5.0, 32, 32);
    let h = HalfVector { s: 0.0, t: 0.0 };
    assert_eq!(
        ndf.eval(&footprint, h),
        ndf.with_filter(Filter::Gaussian).eval(&footprint, h)
    );
    assert_ne!(
        ndf.eval(&footprint, h),
        ndf.with_filter(Filter::Box).eval(&footprint, h)
    );
}
