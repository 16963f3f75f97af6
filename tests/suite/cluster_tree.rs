//! `cluster-tree` against the sums over texels that it answers, on maps of any size, for every roughness, kernel and filter.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::{TexelWeight, disk, flake_bins, texel_weights};
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_format::check;
use glintbake_format::model::{Filter, Footprint, HalfVector, Kernel, Method, Wrap};
use glintbake_runtime::{Accuracy, ClusterTree, Ndf, Package, QueryError, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, sample_map};

fn package(map: &NormalMap) -> Vec<u8> {
    let recipe = Recipe::new(vec![MethodRecipe::new(Method::ClusterTree, &[0.01])]);
    bake(map, &recipe, None).expect("in range").to_bytes()
}

fn tree<'a>(bytes: &'a [u8]) -> ClusterTree<'a> {
    let package = Package::open(bytes).expect("a fresh package opens");
    match package.ndf(1).expect("it has an instance") {
        SurfaceNdf::ClusterTree(ndf) => ndf,
        other => panic!("baked for cluster-tree: {other:?}"),
    }
}

/// The sum over texels.
fn truth(
    map: &NormalMap,
    weights: &[TexelWeight],
    kernel: Kernel,
    alpha: f64,
    h: HalfVector,
) -> f64 {
    match kernel {
        Kernel::Disk => disk::Prepared::from_weights(map, weights, alpha).ndf(h),
        _ => {
            let exact = flake_bins::Setting::Exact;
            flake_bins::Prepared::from_weights(map, weights, alpha, exact).ndf(h)
        }
    }
}

/// Relative L1 error, and the worst as a share of the greatest density, over `count` queries of footprints of about `texels`.
fn errors(
    map: &NormalMap,
    ndf: &ClusterTree<'_>,
    texels: f64,
    count: usize,
    seed: u64,
) -> (f64, f64) {
    let mut stream = Stream::new(seed);
    let (mut off, mut sum, mut worst, mut most) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for _ in 0..count {
        let footprint = stream.footprint(map, texels);
        let near = stream.half_vector_near(map, &footprint, 1.5 * ndf.roughness());
        let weights = texel_weights(map, &footprint, ndf.filter());
        let exact = truth(map, &weights, ndf.kernel(), ndf.roughness(), near);
        let found = ndf.eval(&footprint, near).expect("in range");
        assert!(found.is_finite() && found >= 0.0);
        off += (found - exact).abs();
        sum += exact;
        worst = worst.max((found - exact).abs());
        most = most.max(exact);
    }
    (off / sum.max(1e-300), worst / most.max(1e-300))
}

#[test]
fn densities_are_those_of_the_sum_over_texels_within_the_default_error() {
    for (kind, width, height, wrap) in [
        (Kind::Flakes, 300, 130, Wrap::Repeat),
        (Kind::Waves, 128, 192, Wrap::Repeat),
        (Kind::Scratches, 257, 65, Wrap::Clamp),
        (Kind::Brushed, 70, 300, Wrap::Clamp),
    ] {
        let map = sample_map(kind, width, height, 5, wrap);
        let bytes = package(&map);
        for filter in [Filter::Box, Filter::Gaussian] {
            for (kernel, alpha) in [
                (Kernel::Beckmann, 0.0035),
                (Kernel::Beckmann, 0.2),
                (Kernel::Disk, 0.03),
            ] {
                let ndf = tree(&bytes)
                    .with_filter(filter)
                    .with_kernel(kernel)
                    .and_then(|ndf| ndf.with_roughness(alpha))
                    .expect("in range");
                for texels in [0.5, 3.0, 20.0, 90.0] {
                    let (l1, worst) = errors(&map, &ndf, texels, 30, 3);
                    assert!(
                        l1 < 3e-3 && worst < 2e-2,
                        "{kind:?} {filter:?} {kernel:?} α {alpha}, {texels} texels: {l1} {worst}"
                    );
                }
            }
        }
    }
}

#[test]
fn smaller_errors_can_be_asked_for() {
    let map = sample_map(Kind::Waves, 256, 256, 2, Wrap::Repeat);
    let bytes = package(&map);
    for filter in [Filter::Box, Filter::Gaussian] {
        let with = |eps| {
            let ndf = tree(&bytes)
                .with_filter(filter)
                .with_accuracy(Accuracy::Fast(eps))
                .with_roughness(0.1)
                .expect("in range");
            errors(&map, &ndf, 40.0, 40, 9).0
        };
        let [loose, tight] = [with(2e-2), with(1e-6)];
        assert!(tight < 3e-4 && tight < loose, "{filter:?}: {loose} {tight}");
    }
}

#[test]
fn footprints_of_any_shape_have_the_weights_of_the_oracle() {
    let map = sample_map(Kind::Flakes, 90, 50, 1, Wrap::Repeat);
    let bytes = package(&map);
    let size = [90.0, 50.0];
    let texel = |x: f64, y: f64| [x / size[0], y / size[1]];
    for (edge_1, edge_2) in [
        (texel(1e-4, 0.0), texel(0.0, 1e-4)),
        ([0.0; 2], [0.0; 2]),
        (texel(30.0, 5.0), [0.0; 2]),
        (texel(30.0, 5.0), texel(12.0, 2.0)),
        (texel(200.0, 7.0), texel(-0.001, 0.03)),
        ([1.0, 0.0], [0.0, 1.0]),
        ([3.2, 1.0], [-0.7, 2.9]),
    ] {
        for filter in [Filter::Box, Filter::Gaussian] {
            let ndf = tree(&bytes)
                .with_filter(filter)
                .with_roughness(0.05)
                .expect("in range");
            for number in 0..12 {
                let place = f64::from(number);
                let footprint = Footprint {
                    centre: [0.37 + place * 1.31, 0.81 - place * 0.57],
                    edge_1,
                    edge_2,
                };
                let weights = texel_weights(&map, &footprint, filter);
                let first = &weights[weights.len() / 2];
                let [s, t] = map.texels()[(first.row * 90 + first.column) as usize];
                let h = HalfVector {
                    s: f64::from(s) + 0.01,
                    t: f64::from(t),
                };
                let exact = truth(&map, &weights, Kernel::Beckmann, 0.05, h);
                let found = ndf.eval(&footprint, h).expect("in range");
                assert!(
                    (found - exact).abs() <= 5e-3 * exact + 1e-3,
                    "{filter:?} {footprint:?}: {found} for {exact}"
                );
            }
        }
    }
}

#[test]
fn roughness_and_kernel_out_of_range_are_refused_in_words() {
    let map = sample_map(Kind::Waves, 20, 20, 2, Wrap::Repeat);
    let bytes = package(&map);
    for alpha in [0.0, 0.99e-4, 1.01, f64::NAN, f64::INFINITY, -0.1] {
        let refused = tree(&bytes).with_roughness(alpha).unwrap_err();
        assert!(
            matches!(refused, QueryError::RoughnessRange { .. }),
            "{alpha}"
        );
    }
    assert!(tree(&bytes).with_kernel(Kernel::BinAverage).is_err());
    let rough = tree(&bytes).with_roughness(0.3).expect("in range");
    assert_eq!(rough.instance().roughness, Some(0.3));
}

#[test]
fn fresh_packages_of_any_size_are_sound() {
    for (width, height) in [(1, 1), (1, 90), (64, 64), (65, 64), (300, 7), (520, 260)] {
        for kind in [Kind::Noise, Kind::Flakes] {
            let bytes = package(&sample_map(kind, width, height, 4, Wrap::Repeat));
            let package = Package::open(&bytes).expect("it opens");
            check::full(package.container(), &mut |finding| {
                panic!("{kind:?} {width} x {height}: {finding}")
            });
        }
    }
}

#[test]
fn every_damaged_byte_of_the_tree_is_found_or_means_nothing_to_safety() {
    let map = sample_map(Kind::Flakes, 70, 66, 4, Wrap::Repeat);
    let bytes = package(&map);
    let mut stream = Stream::new(6);
    let h = HalfVector { s: 0.05, t: 0.0 };
    for _ in 0..400 {
        let mut damaged = bytes.clone();
        for _ in 0..40 {
            let place = 1024 + (stream.uniform() * (bytes.len() - 1024) as f64) as usize;
            damaged[place] = (stream.uniform() * 256.0) as u8;
        }
        let Ok(package) = Package::open(&damaged) else {
            continue;
        };
        let Ok(SurfaceNdf::ClusterTree(ndf)) = package.ndf(1) else {
            continue;
        };
        check::structure(package.container(), &mut |_| {});
        for filter in [Filter::Box, Filter::Gaussian] {
            for texels in [0.7, 9.0, 200.0] {
                let footprint = stream.footprint(&map, texels);
                let ndf = ndf.with_filter(filter);
                if let Ok(density) = ndf.eval(&footprint, h) {
                    assert!(density.is_finite() && density >= 0.0, "{density}");
                }
                if let Ok(density) = ndf.pdf(&footprint, h) {
                    assert!(density.is_finite() && density >= 0.0, "{density}");
                }
                let _ = ndf.sample(&footprint, [0.3, 0.6, 0.2, 0.9]);
            }
        }
    }
}

#[test]
fn samples_are_drawn_by_the_pdf_and_energy_is_whole() {
    let map = sample_map(Kind::Waves, 96, 80, 8, Wrap::Repeat);
    let bytes = package(&map);
    let alpha = 0.15;
    for filter in [Filter::Box, Filter::Gaussian] {
        for kernel in [Kernel::Beckmann, Kernel::Disk] {
            let ndf = tree(&bytes)
                .with_filter(filter)
                .with_kernel(kernel)
                .and_then(|ndf| ndf.with_roughness(alpha))
                .expect("in range");
            let mut stream = Stream::new(12);
            let footprint = Footprint {
                centre: [0.4, 0.9],
                edge_1: [0.12, 0.03],
                edge_2: [-0.02, 0.2],
            };
            // Cells of the disk: what falls into each, and the pdf's integral over it, by the middles of 5 × 5 parts.
            const CELLS: usize = 16;
            const SAMPLES: usize = 200_000;
            let mut counts = vec![0_u32; CELLS * CELLS];
            let mut drawn = 0;
            for _ in 0..SAMPLES {
                let uniform = [(); 4].map(|()| stream.uniform());
                if let Some(h) = ndf.sample(&footprint, uniform).expect("in range") {
                    let cell = |x: f64| (((x + 1.0) * 0.5 * CELLS as f64) as usize).min(CELLS - 1);
                    counts[cell(h.t) * CELLS + cell(h.s)] += 1;
                    drawn += 1;
                }
            }
            let (mut chi_square, mut cells, mut whole) = (0.0, 0, 0.0);
            for (number, &count) in counts.iter().enumerate() {
                const PARTS: usize = 12;
                let side = 2.0 / (CELLS * PARTS) as f64;
                let mut expected = 0.0;
                for part in 0..PARTS * PARTS {
                    let at = |cell: usize, part: usize| {
                        ((cell * PARTS + part) as f64 + 0.5) * side - 1.0
                    };
                    let h = HalfVector {
                        s: at(number % CELLS, part % PARTS),
                        t: at(number / CELLS, part / PARTS),
                    };
                    let [.., cosine] = h.direction();
                    if h.is_on_disk() && cosine > 0.0 {
                        // ds dt = cos θ dω.
                        expected +=
                            ndf.pdf(&footprint, h).expect("in range") / cosine * side * side;
                    }
                }
                whole += expected;
                expected *= SAMPLES as f64;
                if expected > 20.0 {
                    chi_square += (f64::from(count) - expected).powi(2) / expected;
                    cells += 1;
                }
            }
            let bound = f64::from(cells) + 5.0 * (2.0 * f64::from(cells)).sqrt();
            println!("{filter:?} {kernel:?}: {chi_square} of {cells} cells, {whole}");
            assert!(cells > 20, "{cells} cells");
            assert!(
                chi_square < bound,
                "{filter:?} {kernel:?}: {chi_square} of {bound}"
            );
            let share = f64::from(drawn) / SAMPLES as f64;
            assert!(
                (whole - share).abs() < 4e-3,
                "{filter:?} {kernel:?}: {whole} {share}"
            );
            assert!((whole - 1.0).abs() < 2e-3, "{filter:?} {kernel:?}: {whole}");
        }
    }
}

#[test]
fn facets_add_up_to_the_density_and_to_their_weights() {
    let map = sample_map(Kind::Scratches, 200, 200, 8, Wrap::Repeat);
    let bytes = package(&map);
    let mut stream = Stream::new(2);
    for filter in [Filter::Box, Filter::Gaussian] {
        let ndf = tree(&bytes)
            .with_filter(filter)
            .with_roughness(0.1)
            .expect("in range");
        for texels in [1.0, 30.0, 400.0] {
            let footprint = stream.footprint(&map, texels);
            let h = HalfVector { s: 0.02, t: 0.03 };
            let (mut sum, mut weight) = (0.0, 0.0);
            ndf.facets(&footprint, h, &mut |facet| {
                sum += facet.density * facet.weight;
                weight += facet.weight;
            })
            .expect("in range");
            let density = ndf.eval(&footprint, h).expect("in range");
            assert!(
                (sum - density).abs() <= 1e-5 * density + 1e-9,
                "{sum} {density}"
            );
            assert!(weight <= 1.0 + 1e-3, "{weight}");
        }
    }
}

#[test]
fn strict_bounds_hold_and_are_as_small_as_was_asked() {
    // 1e5 queries are what `STRICT_QUERIES=1500` asks; each costs an oracle.
    let queries: usize = std::env::var("STRICT_QUERIES")
        .ok()
        .and_then(|count| count.parse().ok())
        .unwrap_or(12);
    let (mut asked, mut met) = (0, 0);
    for (kind, seed, wrap) in [
        (Kind::Flakes, 1, Wrap::Repeat),
        (Kind::Waves, 2, Wrap::Clamp),
        (Kind::Scratches, 3, Wrap::Repeat),
        (Kind::Brushed, 4, Wrap::Clamp),
    ] {
        let map = sample_map(kind, 150, 280, seed, wrap);
        let bytes = package(&map);
        for filter in [Filter::Box, Filter::Gaussian] {
            for alpha in [0.001, 0.01, 0.1] {
                let ndf = tree(&bytes)
                    .with_filter(filter)
                    .with_kernel(Kernel::Disk)
                    .and_then(|ndf| ndf.with_roughness(alpha))
                    .expect("in range");
                let mut stream = Stream::new(seed + 10);
                for number in 0..queries {
                    let footprint = stream.footprint(&map, [0.6, 6.0, 40.0, 200.0][number % 4]);
                    let spread = if number % 3 == 0 { 6.0 } else { 1.0 } * alpha;
                    let h = stream.half_vector_near(&map, &footprint, spread);
                    if !h.is_on_disk() {
                        continue;
                    }
                    let weights = texel_weights(&map, &footprint, filter);
                    let exact = truth(&map, &weights, Kernel::Disk, alpha, h);
                    for accuracy in [
                        Accuracy::Fast(0.02),
                        Accuracy::default(),
                        Accuracy::Strict(0.02),
                    ] {
                        let found = ndf
                            .with_accuracy(accuracy)
                            .eval_bounded(&footprint, h)
                            .expect("in range");
                        assert!(
                            (found.density - exact).abs() <= found.bound,
                            "{kind:?} {filter:?} α {alpha} {accuracy:?} {footprint:?} {h:?}: {found:?} for {exact}"
                        );
                        if accuracy == Accuracy::Strict(0.02) {
                            asked += 1;
                            met += usize::from(found.bound <= 0.02 * found.density);
                        }
                    }
                }
            }
        }
    }
    // Densities far below the kernel's peak are beyond what single precision can promise.
    assert!(4 * met > asked, "{met} of {asked}");
}
