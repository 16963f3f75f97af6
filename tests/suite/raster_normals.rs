//! `cluster-tree` with a raster of normals: the sums over texels that it scans, and what a raster of lies does.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::{TexelWeight, disk, flake_bins, texel_weights};
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_format::model::{Filter, Footprint, HalfVector, Kernel, Method, Wrap};
use glintbake_format::records::{HALF_RASTER, RASTER, RasterLattice};
use glintbake_format::view::Raster;
use glintbake_format::{Fault, FourCc, check};
use glintbake_runtime::{Accuracy, ClusterTree, Ndf, Package, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, sample_map};
use glintbake_tests::lies::{reseal, section_range};
use proptest::prelude::*;

const KINDS: [Kind; 4] = [Kind::Flakes, Kind::Waves, Kind::Scratches, Kind::Brushed];

fn package(map: &NormalMap, raster_normals: bool) -> Vec<u8> {
    let recipe = Recipe::new(vec![MethodRecipe {
        raster_normals,
        ..MethodRecipe::new(Method::ClusterTree, &[0.05, 0.01])
    }]);
    bake(map, &recipe, None).expect("in range").to_bytes()
}

fn tree<'a>(bytes: &'a [u8], alpha: f64, filter: Filter, kernel: Kernel) -> ClusterTree<'a> {
    let package = Package::open(bytes).expect("a fresh package opens");
    // The second instance has neither tree nor raster of its own.
    match package.ndf(2).expect("it has two instances") {
        SurfaceNdf::ClusterTree(ndf) => ndf
            .with_filter(filter)
            .with_kernel(kernel)
            .and_then(|ndf| ndf.with_roughness(alpha))
            .expect("in range"),
        other => panic!("baked for cluster-tree: {other:?}"),
    }
}

/// The map that the raster of `bytes` says, which rounds that of the bake.
fn stored(bytes: &[u8], wrap: Wrap) -> NormalMap {
    let package = Package::open(bytes).expect("a fresh package opens");
    let instance = package.instances().next().expect("it has instances");
    let raster = Raster::of_map(package.container(), &instance)
        .expect("it is sound")
        .expect("it was asked for");
    let [width, height] = raster.size;
    let texels = (0..width * height)
        .map(|texel| {
            let normal = raster.normal(texel % width, texel / width);
            normal.expect("it is on the map").map(|x| x as f32)
        })
        .collect();
    NormalMap::new(width, height, wrap, texels)
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

/// Whether no texel of a map that repeats is met twice: such footprints are left to the tree.
fn fits_the_map(footprint: &Footprint, filter: Filter) -> bool {
    [0, 1].iter().all(|&axis| {
        let (a, b) = (footprint.edge_1[axis], footprint.edge_2[axis]);
        match filter {
            Filter::Box => a.abs() + b.abs() < 1.0,
            // As far as 4.8 standard deviations, either way.
            Filter::Gaussian => 4.81 * a.hypot(b) < 1.0,
        }
    })
}

/// Checks `ndf`, by its raster, against the sum over `map`: what is skipped is e^-6.5 of the peak at most, rounding aside.
fn compare(
    map: &NormalMap,
    ndf: &ClusterTree<'_>,
    footprint: &Footprint,
    h: HalfVector,
) -> Result<(), TestCaseError> {
    let weights = texel_weights(map, footprint, ndf.filter());
    let alpha = ndf.roughness();
    let exact = truth(map, &weights, ndf.kernel(), alpha, h);
    let found = ndf.eval(footprint, h).expect("in range");
    let peak = 1.0 / (std::f64::consts::PI * alpha * alpha);
    let slack = match ndf.filter() {
        Filter::Box => 2e-5,
        Filter::Gaussian => 3e-4,
    };
    let skipped = peak * f64::exp(-6.5);
    prop_assert!(
        found <= exact * (1.0 + 1e-4) + peak * slack
            && found >= exact * (1.0 - 1e-4) - peak * slack - skipped,
        "{:?} {:?} α {alpha} {footprint:?} {h:?}: {found} for {exact}",
        ndf.filter(),
        ndf.kernel()
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn densities_are_those_of_the_sum_over_what_the_raster_holds(
        kind in 0_usize..4,
        width in 1_u32..70,
        height in 1_u32..70,
        is_clamped in any::<bool>(),
        seed in any::<u64>(),
        alpha in prop_oneof![Just(0.0075), Just(0.03), Just(0.2), Just(0.9)],
    ) {
        let wrap = if is_clamped { Wrap::Clamp } else { Wrap::Repeat };
        let map = sample_map(KINDS[kind], width, height, 5, wrap);
        let bytes = package(&map, true);
        let rounded = stored(&bytes, wrap);
        let mut stream = Stream::new(seed);
        for filter in [Filter::Box, Filter::Gaussian] {
            for kernel in [Kernel::Beckmann, Kernel::Disk] {
                let ndf = tree(&bytes, alpha, filter, kernel);
                // Larger ones are the tree's, of which the Gaussians reach further.
                let sizes: &[f64] = match filter {
                    Filter::Box => &[0.01, 0.4, 1.5, 4.0, 7.0],
                    Filter::Gaussian => &[0.01, 0.4, 1.0, 1.6],
                };
                for &texels in sizes {
                    let footprint = stream.footprint(&map, texels);
                    let h = stream.half_vector_near(&map, &footprint, 1.5 * alpha);
                    if h.is_on_disk() && (is_clamped || fits_the_map(&footprint, filter)) {
                        compare(&rounded, &ndf, &footprint, h)?;
                    }
                }
            }
        }
    }
}

#[test]
fn a_tree_with_a_raster_answers_as_one_without() {
    for (kind, wrap) in [(Kind::Flakes, Wrap::Repeat), (Kind::Scratches, Wrap::Clamp)] {
        let map = sample_map(kind, 130, 90, 5, wrap);
        let [with, without] = [true, false].map(|raster| package(&map, raster));
        let mut stream = Stream::new(4);
        for filter in [Filter::Box, Filter::Gaussian] {
            for kernel in [Kernel::Beckmann, Kernel::Disk] {
                for alpha in [0.0005, 0.0075, 0.1] {
                    let [scan, walk] =
                        [&with, &without].map(|bytes| tree(bytes, alpha, filter, kernel));
                    let (mut off, mut sum, mut differ) = (0.0, 0.0, 0);
                    for number in 0..60 {
                        let texels = [0.5, 3.0, 12.0][number % 3];
                        let footprint = stream.footprint(&map, texels);
                        let h = stream.half_vector_near(&map, &footprint, alpha);
                        let [a, b] =
                            [&scan, &walk].map(|ndf| ndf.eval(&footprint, h).expect("in range"));
                        off += (a - b).abs();
                        sum += b;
                        differ += usize::from(a != b);
                    }
                    assert!(
                        off <= 4e-3 * sum,
                        "{kind:?} {filter:?} {kernel:?} α {alpha}: {off} of {sum}"
                    );
                    // Below σr = 0.005 the raster rounds too much for the default error.
                    assert_eq!(differ > 0, alpha > 0.001, "{alpha}: {differ}");
                }
            }
        }
    }
}

#[test]
fn facets_of_a_scan_add_up_to_density_and_pdf() {
    let map = sample_map(Kind::Scratches, 60, 70, 8, Wrap::Repeat);
    let bytes = package(&map, true);
    let mut stream = Stream::new(2);
    for filter in [Filter::Box, Filter::Gaussian] {
        let ndf = tree(&bytes, 0.2, filter, Kernel::Beckmann);
        for texels in [0.3, 2.0, 9.0] {
            let footprint = stream.footprint(&map, texels);
            let h = stream.half_vector_near(&map, &footprint, 0.05);
            let direction = h.direction();
            let (mut sum, mut weight, mut pdf) = (0.0, 0.0, 0.0);
            ndf.facets(&footprint, h, &mut |facet| {
                sum += facet.density * facet.weight;
                weight += facet.weight;
                let cosine: f64 = (0..3)
                    .map(|axis| direction[axis] * facet.normal[axis])
                    .sum();
                pdf += facet.density * facet.weight * cosine;
            })
            .expect("in range");
            let density = ndf.eval(&footprint, h).expect("in range");
            assert!((sum - density).abs() <= 1e-5 * density, "{sum} {density}");
            assert!((weight - 1.0).abs() < 1e-2, "{weight}");
            let answer = ndf.pdf(&footprint, h).expect("in range");
            // It reaches further down than facets do.
            let range = pdf * (1.0 - 1e-6)..=pdf * 1.003;
            assert!(range.contains(&answer), "{answer} {pdf}");
        }
    }
}

#[test]
fn strict_bounds_count_what_the_raster_rounds() {
    let (mut asked, mut met) = (0, 0);
    for (kind, wrap) in [(Kind::Flakes, Wrap::Repeat), (Kind::Waves, Wrap::Clamp)] {
        let map = sample_map(kind, 50, 80, 3, wrap);
        let bytes = package(&map, true);
        for filter in [Filter::Box, Filter::Gaussian] {
            for alpha in [0.0005, 0.01, 0.1] {
                let ndf = tree(&bytes, alpha, filter, Kernel::Disk);
                let mut stream = Stream::new(10);
                for number in 0..40 {
                    let footprint = stream.footprint(&map, [0.6, 3.0, 12.0, 0.02][number % 4]);
                    let h = stream.half_vector_near(&map, &footprint, alpha);
                    if !h.is_on_disk() {
                        continue;
                    }
                    let weights = texel_weights(&map, &footprint, filter);
                    let exact = truth(&map, &weights, Kernel::Disk, alpha, h);
                    for accuracy in [Accuracy::default(), Accuracy::Strict(0.02)] {
                        let found = ndf
                            .with_accuracy(accuracy)
                            .eval_bounded(&footprint, h)
                            .expect("in range");
                        assert!(
                            (found.density - exact).abs() <= found.bound,
                            "{kind:?} {filter:?} α {alpha} {accuracy:?} {footprint:?} {h:?}: {found:?} for {exact}"
                        );
                        if accuracy != Accuracy::default() && alpha > 0.001 {
                            asked += 1;
                            met += usize::from(found.bound <= 0.02 * found.density);
                        }
                    }
                }
            }
        }
    }
    assert!(2 * met > asked, "{met} of {asked}");
}

#[test]
fn normals_of_16_bit_images_are_kept_exactly() {
    for (kind, lattice, decode) in [
        (
            HALF_RASTER,
            RasterLattice::Half,
            (|x| (2.0 * x - 65535.0) / 65535.0) as fn(f64) -> f64,
        ),
        (RASTER, RasterLattice::Whole, |x| (x - 32768.0) / 32767.0),
    ] {
        let texels = (0..33 * 21)
            .map(|texel| {
                [20_000 + 31 * texel, 47_000 - 23 * texel]
                    .map(|sample| decode(f64::from(sample)) as f32)
            })
            .collect();
        let map = NormalMap::new(33, 21, Wrap::Repeat, texels);
        let bytes = package(&map, true);
        assert!(!section_range(&bytes, kind, 1).is_empty(), "{lattice:?}");
        assert_eq!(stored(&bytes, Wrap::Repeat), map);
    }
}

#[test]
fn samples_are_drawn_about_the_normals_of_the_raster() {
    let map = sample_map(Kind::Flakes, 37, 41, 3, Wrap::Repeat);
    let bytes = package(&map, true);
    let rounded = stored(&bytes, Wrap::Repeat);
    let ndf = tree(&bytes, 0.01, Filter::Box, Kernel::Disk);
    for texel in 0..37 * 41_u32 {
        let (x, y) = (texel % 37, texel / 37);
        let footprint = Footprint {
            centre: [(f64::from(x) + 0.5) / 37.0, (f64::from(y) + 0.5) / 41.0],
            edge_1: [1e-3, 0.0],
            edge_2: [0.0, 1e-3],
        };
        // A radius of 0 is the normal itself.
        let h = ndf
            .sample(&footprint, [0.5, 0.5, 0.0, 0.0])
            .expect("in range");
        let h = h.expect("no flake is on the rim");
        let [s, t] = rounded.texels()[texel as usize].map(f64::from);
        assert!((h.s - s).abs() < 1e-7 && (h.t - t).abs() < 1e-7, "{texel}");
    }
}

fn findings(bytes: &[u8]) -> Vec<Fault> {
    let package = Package::open(bytes).expect("it opens");
    let mut faults = Vec::new();
    check::structure(package.container(), &mut |finding| {
        faults.push(finding.fault)
    });
    faults
}

#[test]
fn fresh_rasters_of_any_size_are_sound() {
    for (width, height) in [(1, 1), (1, 90), (4, 4), (65, 64), (70, 7)] {
        for kind in [Kind::Noise, Kind::Flakes, Kind::Flat] {
            let bytes = package(&sample_map(kind, width, height, 4, Wrap::Repeat), true);
            let found = findings(&bytes);
            assert!(found.is_empty(), "{kind:?} {width} x {height}: {found:?}");
        }
    }
}

#[test]
fn lies_in_a_raster_are_found_and_survived() {
    let map = sample_map(Kind::Flakes, 18, 13, 4, Wrap::Clamp);
    let sound = package(&map, true);
    let kind: FourCc = [RASTER, HALF_RASTER]
        .into_iter()
        .find(|kind| {
            let package = Package::open(&sound).expect("a fresh package opens");
            let mut entries = package.container().entries().iter();
            entries.any(|entry| entry.kind == *kind)
        })
        .expect("it has a raster");
    let range = section_range(&sound, kind, 1);
    assert_eq!(range.len(), 64 * 5 * 4);
    // Texel (0, 0) beyond the disk, one off by far, and a word beyond the right border.
    for (place, lie, fault) in [
        (0, [0xFF, 0x7F, 0xFF, 0x7F], Fault::RasterRange),
        (0, [0x34, 0x12, 0x01, 0x20], Fault::RasterNormal),
        (64 * 4 + 3 * 4, [1, 0, 0, 0], Fault::RasterUnused),
    ] {
        let mut bytes = sound.clone();
        bytes[range.start + place..range.start + place + 4].copy_from_slice(&lie);
        assert!(reseal(&mut bytes));
        assert!(findings(&bytes).contains(&fault), "{fault:?}");
    }
    let mut stream = Stream::new(6);
    for _ in 0..300 {
        let mut bytes = sound.clone();
        for _ in 0..30 {
            let place = stream.uniform() * range.len() as f64;
            bytes[range.start + place as usize] = (stream.uniform() * 256.0) as u8;
        }
        assert!(reseal(&mut bytes));
        for filter in [Filter::Box, Filter::Gaussian] {
            for kernel in [Kernel::Beckmann, Kernel::Disk] {
                let ndf = tree(&bytes, 0.1, filter, kernel);
                let footprint = stream.footprint(&map, 3.0);
                let h = HalfVector { s: 0.05, t: 0.0 };
                for answer in [ndf.eval(&footprint, h), ndf.pdf(&footprint, h)] {
                    let density = answer.expect("its blocks are there");
                    assert!(density.is_finite() && density >= 0.0, "{density}");
                }
                let drawn = ndf.sample(&footprint, [0.3, 0.6, 0.2, 0.9]);
                assert!(
                    drawn
                        .expect("its blocks are there")
                        .is_none_or(HalfVector::is_on_disk)
                );
            }
        }
    }
}
