//! `mip-lobes` against the plain sum of the lobes of the surface it stands for.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::lobes::Prepared;
use glintbake_bake::{BakeError, MethodRecipe, QuiltRecipe, Recipe, bake};
use glintbake_cli::rebuild;
use glintbake_format::model::{Filter, Footprint, HalfVector, LobeLattice, Method, Wrap};
use glintbake_runtime::{Instructions, MipLobes, Ndf, Package, QueryError, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, mip_package, sample_map};

const LATTICE: LobeLattice = LobeLattice {
    curved: true,
    per_side: 2,
};

fn quilt(target: [u32; 2], patch: u32, overlap: u32) -> QuiltRecipe {
    QuiltRecipe {
        patch: Some(patch),
        overlap,
        ..QuiltRecipe::new(target)
    }
}

fn open(bytes: &[u8]) -> MipLobes<'_> {
    match Package::open(bytes).map(|package| package.ndf(1)) {
        Ok(Ok(SurfaceNdf::MipLobes(ndf))) => ndf,
        other => panic!("baked for mip-lobes: {other:?}"),
    }
}

/// The surface of the first instance.
fn surface(bytes: &[u8]) -> NormalMap {
    let package = Package::open(bytes).expect("sound");
    let instance = package.instances().next().expect("one");
    rebuild::normal_map(package.container(), &instance)
        .expect("sound")
        .expect("kept")
}

/// Relative L1 against the plain sum under squares of `edge` texels, and the greatest difference of the greatest density.
fn errors(map: &NormalMap, ndf: &MipLobes<'_>, edge: f64, seed: u64, count: usize) -> [f64; 2] {
    let mut stream = Stream::new(seed);
    let (mut off, mut sum, mut worst, mut most) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for _ in 0..count {
        let footprint = stream.footprint(map, edge);
        let h = stream.half_vector_near(map, &footprint, ndf.roughness());
        let truth = Prepared::new(map, &footprint, LATTICE, true).ndf(h, ndf.roughness());
        let found = ndf.eval(&footprint, h).expect("in range");
        assert!(found.is_finite() && found >= 0.0);
        off += (found - truth).abs();
        sum += truth;
        worst = worst.max((found - truth).abs());
        most = most.max(truth);
    }
    [off / sum, worst / most.max(1e-300)]
}

#[test]
fn below_all_levels_it_is_the_sum_of_the_lobes_of_the_surface() {
    let sample = sample_map(Kind::Leather, 48, 40, 3, Wrap::Repeat);
    for recipe in [
        None,
        Some(quilt([96, 64], 16, 2)),
        Some(quilt([32, 64], 8, 0)),
    ] {
        let bytes = mip_package(&sample, 16, recipe, &[0.05]);
        let map = surface(&bytes);
        let ndf = open(&bytes);
        // Footprints of a texel or two, and any if asked for.
        for edge in [0.01, 0.7, 1.9] {
            let [l1, worst] = errors(&map, &ndf, edge, 5, 40);
            assert!(l1 < 2e-4 && worst < 1e-3, "{recipe:?} {edge}: {l1} {worst}");
        }
        let unclustered = ndf.with_level_bias(-64.0).expect("finite");
        for edge in [8.0, 30.0] {
            let [l1, worst] = errors(&map, &unclustered, edge, 6, 12);
            assert!(l1 < 1e-3 && worst < 1e-3, "{recipe:?} {edge}: {l1} {worst}");
        }
    }
}

#[test]
fn clusters_err_less_the_more_there_are_and_the_lower_the_level() {
    let sample = sample_map(Kind::Waves, 64, 64, 3, Wrap::Repeat);
    let mut of_clusters = Vec::new();
    for clusters in [16, 64] {
        let bytes = mip_package(&sample, clusters, Some(quilt([128, 128], 32, 2)), &[0.03]);
        let map = surface(&bytes);
        let ndf = open(&bytes);
        let error = |ndf: &MipLobes<'_>| {
            let [small, large] = [10.0, 30.0].map(|edge| errors(&map, ndf, edge, 7, 24)[0]);
            small + large
        };
        let below = ndf.with_level_bias(-1.5).expect("finite");
        let found = error(&ndf);
        assert!(error(&below) < 0.8 * found, "{clusters}: {found}");
        of_clusters.push(found);
    }
    assert!(of_clusters[1] < 0.7 * of_clusters[0], "{of_clusters:?}");
    assert!(of_clusters[1] < 0.2, "{of_clusters:?}");
}

#[test]
fn long_footprints_are_sharper_by_their_width_than_by_their_area() {
    let sample = sample_map(Kind::Waves, 64, 64, 3, Wrap::Repeat);
    let bytes = mip_package(&sample, 32, Some(quilt([128, 128], 32, 2)), &[0.03]);
    let map = surface(&bytes);
    let ndf = open(&bytes);
    let paper = ndf.with_levels_by_area(true);
    let (mut by_width, mut by_area, mut sum) = (0.0, 0.0, 0.0);
    let mut stream = Stream::new(9);
    for _ in 0..40 {
        let turn = stream.uniform() * core::f64::consts::TAU;
        let (s, c) = (turn.sin() / 128.0, turn.cos() / 128.0);
        let footprint = Footprint {
            centre: [stream.uniform(), stream.uniform()],
            edge_1: [48.0 * c, 48.0 * s],
            edge_2: [-6.0 * s, 6.0 * c],
        };
        let h = stream.half_vector_near(&map, &footprint, 0.03);
        let truth = Prepared::new(&map, &footprint, LATTICE, true).ndf(h, 0.03);
        by_width += (ndf.eval(&footprint, h).expect("in range") - truth).abs();
        by_area += (paper.eval(&footprint, h).expect("in range") - truth).abs();
        sum += truth;
    }
    assert!(by_width < 0.7 * by_area, "{by_width} {by_area} of {sum}");
}

#[test]
fn energy_is_one_at_every_size_and_facets_add_up() {
    let sample = sample_map(Kind::Waves, 64, 48, 3, Wrap::Repeat);
    let bytes = mip_package(&sample, 16, Some(quilt([128, 96], 16, 2)), &[0.3]);
    let map = surface(&bytes);
    let ndf = open(&bytes).with_roughness(0.1).expect("in range");
    let mut stream = Stream::new(4);
    for edge in [0.3, 3.0, 7.0, 20.0, 90.0, 700.0, 5000.0] {
        let footprint = stream.footprint(&map, edge);
        // A grid finer than the kernel, over all that slopes of this map and the kernel reach.
        let steps = 90;
        let pitch = 2.0 / f64::from(steps);
        let mut energy = 0.0;
        for place in 0..steps * steps {
            let at = |k: i32| (f64::from(k) + 0.5) * pitch - 1.0;
            let h = HalfVector {
                s: at(place % steps),
                t: at(place / steps),
            };
            energy += ndf.eval(&footprint, h).expect("in range") * pitch * pitch;
        }
        assert!((energy - 1.0).abs() < 1e-3, "{edge}: {energy}");
        let h = stream.half_vector_near(&map, &footprint, 0.1);
        let (mut weights, mut sum) = (0.0, 0.0);
        ndf.facets(&footprint, h, &mut |facet| {
            weights += facet.weight;
            sum += facet.weight * facet.density;
        })
        .expect("in range");
        let found = ndf.eval(&footprint, h).expect("in range");
        assert!(
            (sum - found).abs() < 1e-4 * found.max(1.0),
            "{edge}: {sum} {found}"
        );
        assert!((weights - 1.0).abs() < 1e-4, "{edge}: {weights}");
    }
}

#[test]
fn the_surface_repeats_without_a_seam() {
    let sample = sample_map(Kind::Scratches, 64, 64, 3, Wrap::Repeat);
    let bytes = mip_package(&sample, 16, Some(quilt([64, 128], 16, 2)), &[0.05]);
    let map = surface(&bytes);
    let ndf = open(&bytes);
    let mut stream = Stream::new(8);
    for edge in [1.0, 6.0, 25.0, 80.0] {
        let mut footprint = stream.footprint(&map, edge);
        footprint.centre = [0.0, 0.25];
        let h = stream.half_vector_near(&map, &footprint, 0.05);
        let at = |x: f64, y: f64| {
            let moved = Footprint {
                centre: [x, y],
                ..footprint
            };
            ndf.eval(&moved, h).expect("in range")
        };
        let here = at(0.0, 0.25);
        let near = |other: f64| (other - here).abs() < 1e-3 * here.max(1.0);
        assert!(near(at(1.0, -0.75)) && near(at(-1e-9, 0.25)), "{edge}");
    }
}

#[test]
fn bytes_do_not_depend_on_threads_and_answers_not_on_instructions() {
    let sample = sample_map(Kind::Leather, 64, 64, 3, Wrap::Repeat);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads can be had")
            .install(|| mip_package(&sample, 32, Some(quilt([192, 128], 32, 3)), &[0.02]))
    };
    let bytes = with(1);
    assert!(bytes == with(3));
    let map = surface(&bytes);
    let ndf = open(&bytes);
    let portable = ndf.with_instructions(Instructions::Portable);
    let mut stream = Stream::new(3);
    for edge in [1.0, 9.0, 60.0] {
        let footprint = stream.footprint(&map, edge);
        let h = stream.half_vector_near(&map, &footprint, 0.02);
        let answers = [ndf, portable].map(|ndf| ndf.eval(&footprint, h).expect("in range"));
        assert_eq!(answers[0].to_bits(), answers[1].to_bits());
    }
}

#[test]
fn a_larger_surface_costs_its_quilt_and_its_own_cells_alone() {
    let sample = sample_map(Kind::Leather, 64, 64, 3, Wrap::Repeat);
    let bytes = |side: u32| {
        let recipe = quilt([side; 2], 16, 2);
        mip_package(&sample, 16, Some(recipe), &[0.02]).len()
    };
    let (small, large) = (bytes(256), bytes(512));
    // 768 patches more: 4 + 32 bytes each, and a third as many cells, of 16 lobes.
    let most = 768 * (36 + 512 / 3 + 1) + 8192;
    assert!(large - small < most, "{small} {large} {most}");
}

#[test]
fn what_cannot_be_quilted_is_refused_with_what_can() {
    let refused = |sample: &NormalMap, recipe: MethodRecipe| -> (String, String) {
        match bake(sample, &Recipe::new(vec![recipe]), None) {
            Err(BakeError::Option { option, reason, .. }) => (option.to_owned(), reason),
            other => panic!("{:?}", other.map(|_| "baked")),
        }
    };
    let sample = sample_map(Kind::Waves, 32, 24, 1, Wrap::Repeat);
    let recipe = |quilt: Option<QuiltRecipe>| MethodRecipe {
        quilt,
        ..MethodRecipe::new(Method::MipLobes, &[0.1])
    };
    for (asked, option, says) in [
        (
            quilt([64, 64], 32, 2),
            "--patch",
            "larger than the sample, which has 32 x 24",
        ),
        (quilt([64, 64], 16, 16), "--overlap", "up to half as many"),
        (
            quilt([60, 64], 16, 2),
            "--target",
            "multiples of the patch, 16: give 64",
        ),
        (quilt([64, 64], 12, 2), "--patch", "a power of two"),
        (quilt([0, 64], 16, 2), "--target", "1 to 65535"),
        (
            quilt([64, 64], 8, 2),
            "--clusters",
            "fewer, or larger patches",
        ),
    ] {
        let mut recipe = recipe(Some(asked));
        recipe.clusters = Some(128);
        let (found, reason) = refused(&sample, recipe);
        assert_eq!(found, option, "{reason}");
        assert!(reason.contains(says), "{reason}");
    }
    let tiny = sample_map(Kind::Waves, 7, 32, 1, Wrap::Repeat);
    let (option, reason) = refused(&tiny, recipe(Some(QuiltRecipe::new([64, 64]))));
    assert_eq!(option, "--target");
    assert!(reason.contains("at least 8 a side"), "{reason}");
    let ending = sample_map(Kind::Waves, 32, 32, 1, Wrap::Clamp);
    let (option, _) = refused(&ending, recipe(None));
    assert_eq!(option, "--wrap");
    for (clusters, option) in [(20, "--clusters"), (0, "--clusters"), (144, "--clusters")] {
        let asked = MethodRecipe {
            clusters: Some(clusters),
            ..recipe(None)
        };
        assert_eq!(refused(&sample, asked).0, option);
    }
    // A sample that ends is quilted all the same.
    let bytes = mip_package(&ending, 16, Some(quilt([64, 64], 16, 2)), &[0.1]);
    assert_eq!(open(&bytes).instance().wrap, Wrap::Repeat);
}

#[test]
fn boxes_and_biases_that_are_no_numbers_are_refused() {
    let sample = sample_map(Kind::Waves, 16, 16, 1, Wrap::Repeat);
    let bytes = mip_package(&sample, 16, None, &[0.1]);
    let ndf = open(&bytes);
    let footprint = Footprint::square([0.5; 2], 3.0, 16, 16);
    let h = HalfVector { s: 0.0, t: 0.0 };
    let boxed = ndf.with_filter(Filter::Box).eval(&footprint, h);
    assert_eq!(boxed, Err(QueryError::FilterUnsupported(Method::MipLobes)));
    assert!(matches!(
        ndf.with_level_bias(f64::NAN),
        Err(QueryError::NotFinite)
    ));
}
