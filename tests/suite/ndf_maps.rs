//! `ndf-maps` against the lobes of the surface that copies of an example make up.

use glintbake_bake::noise::{NoiseCopy, NoiseMap, NoiseOptions, NoiseSource, Transform, generate};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::ndf_maps::{Prepared, Surface};
use glintbake_bake::{BakeError, MethodRecipe, NdfCopies, NdfMapRecipe, Recipe, bake};
use glintbake_cli::rebuild;
use glintbake_format::model::{
    Filter, Footprint, HalfVector, Method, Wrap, intrinsic_from_beckmann,
};
use glintbake_runtime::{Ndf, NdfMaps, Package, QueryError, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, ndf_maps_package, sample_map};
use std::sync::Arc;

fn open(bytes: &[u8]) -> NdfMaps<'_> {
    match Package::open(bytes).map(|package| package.ndf(1)) {
        Ok(Ok(SurfaceNdf::NdfMaps(ndf))) => ndf,
        other => panic!("baked for ndf-maps: {other:?}"),
    }
}

/// The surface of the first instance.
fn surface(bytes: &[u8]) -> Surface {
    let package = Package::open(bytes).expect("sound");
    let instance = package.instances().next().expect("one");
    rebuild::ndf_maps::surface(package.container(), &instance).expect("sound")
}

fn tiled(transform: Transform) -> NdfMapRecipe {
    NdfMapRecipe {
        copies: NdfCopies::Tiled(transform),
        ..NdfMapRecipe::default()
    }
}

fn scattered(options: &NoiseOptions, size: u32) -> NdfMapRecipe {
    NdfMapRecipe {
        size: Some(size),
        copies: NdfCopies::Scattered(Arc::new(generate(options).expect("in range"))),
        ..NdfMapRecipe::default()
    }
}

/// Relative L1 against the oracle under squares of `edge` texels, half vectors being drawn from it, and the greatest difference of the
/// greatest density.
fn errors(surface: &Surface, ndf: &NdfMaps<'_>, edge: f64, seed: u64, count: usize) -> [f64; 2] {
    let sigma = intrinsic_from_beckmann(ndf.instance().roughness.expect("rough"));
    let mut stream = Stream::new(seed);
    let (mut off, mut sum, mut worst, mut most) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    let size = f64::from(surface.size);
    for _ in 0..count {
        let turn = stream.uniform() * 6.3;
        let edge = edge / size;
        let footprint = Footprint {
            centre: [stream.uniform() * 2.0 - 0.5, stream.uniform()],
            edge_1: [edge * turn.cos(), edge * turn.sin()],
            edge_2: [-edge * turn.sin(), edge * turn.cos()],
        };
        let prepared = Prepared::new(surface.clone(), &footprint, sigma);
        for _ in 0..3 {
            let uniform = [0; 4].map(|_| stream.uniform());
            let Some(h) = prepared.draw(sigma, uniform) else {
                continue;
            };
            let truth = prepared.ndf(h, sigma);
            let found = ndf.eval(&footprint, h).expect("in range");
            assert!(found.is_finite() && found >= 0.0);
            off += (found - truth).abs();
            sum += truth;
            worst = worst.max((found - truth).abs());
            most = most.max(truth);
        }
    }
    [off / sum, worst / most.max(1e-300)]
}

const TURNED: Transform = Transform {
    rotation: 30.0,
    scale: [2.0, 1.5],
    shear: 0.2,
    is_mirrored: true,
};

/// Tiled as it is and transformed, scattered, and scattered with slopes scaled.
fn surfaces() -> [(&'static str, NdfMapRecipe); 4] {
    let noise = NoiseOptions {
        scale: [0.7, 1.5],
        ..NoiseOptions::new(64, 5)
    };
    let scaled = NdfMapRecipe {
        scales_slopes: true,
        ..scattered(&noise, 128)
    };
    [
        ("tiled", tiled(Transform::default())),
        ("transformed", tiled(TURNED)),
        ("scattered", scattered(&noise, 128)),
        ("slopes scaled", scaled),
    ]
}

#[test]
fn densities_are_those_of_the_lobes_of_all_copies() {
    for kind in [Kind::Scratches, Kind::Waves] {
        let map = sample_map(kind, 16, 16, 3, Wrap::Repeat);
        for (how, recipe) in surfaces() {
            let bytes = ndf_maps_package(&map, recipe, &[0.02]);
            let surface = surface(&bytes);
            let ndf = open(&bytes);
            let exact = ndf.with_tolerance(0.0).expect("a tolerance");
            for (edge, count) in [(0.01, 6), (0.7, 8), (5.0, 8), (20.0, 3)] {
                let what = format!("{} {how} {edge}", kind.name());
                let [l1, worst] = errors(&surface, &exact, edge, 7, count);
                assert!(l1 < 5e-3 && worst < 1e-2, "{what}, exact: {l1} {worst}");
                let [l1, worst] = errors(&surface, &ndf, edge, 7, count);
                assert!(l1 < 0.05 && worst < 0.1, "{what}: {l1} {worst}");
            }
        }
    }
}

#[test]
fn at_the_default_the_mean_error_over_sizes_is_within_two_percent() {
    let map = sample_map(Kind::Scratches, 16, 16, 4, Wrap::Repeat);
    let noise = NoiseOptions::new(64, 5);
    for recipe in [tiled(Transform::default()), scattered(&noise, 128)] {
        let bytes = ndf_maps_package(&map, recipe, &[0.01 * core::f64::consts::SQRT_2]);
        let (surface, ndf) = (surface(&bytes), open(&bytes));
        for edge in [1.0, 4.0, 12.0] {
            let [l1, _] = errors(&surface, &ndf, edge, 9, 16);
            assert!(l1 < 0.02, "{edge}: {l1}");
        }
    }
}

#[test]
fn the_wider_the_tolerance_the_rougher_the_answer() {
    let map = sample_map(Kind::Waves, 16, 16, 3, Wrap::Repeat);
    let bytes = ndf_maps_package(&map, tiled(Transform::default()), &[0.02]);
    let (surface, ndf) = (surface(&bytes), open(&bytes));
    let errors = [0.0, 0.05, 1e6].map(|tolerance| {
        let ndf = ndf.with_tolerance(tolerance).expect("in range");
        errors(&surface, &ndf, 6.0, 3, 16)[0]
    });
    assert!(
        errors.is_sorted() && errors[2] > 4.0 * errors[0],
        "{errors:?}"
    );
}

#[test]
fn examples_that_end_go_on_as_their_border() {
    let map = sample_map(Kind::Waves, 8, 8, 3, Wrap::Clamp);
    let bytes = ndf_maps_package(&map, scattered(&NoiseOptions::new(20, 1), 40), &[0.05]);
    let (surface, ndf) = (surface(&bytes), open(&bytes));
    let exact = ndf.with_tolerance(0.0).expect("a tolerance");
    for edge in [0.5, 6.0] {
        let [l1, worst] = errors(&surface, &exact, edge, 2, 10);
        assert!(l1 < 5e-3 && worst < 1e-2, "{edge}: {l1} {worst}");
    }
}

#[test]
fn footprints_of_no_width_are_the_limit_of_thin_ones() {
    let map = sample_map(Kind::Waves, 8, 8, 3, Wrap::Repeat);
    for recipe in [
        tiled(Transform::default()),
        scattered(&NoiseOptions::new(20, 1), 40),
    ] {
        let bytes = ndf_maps_package(&map, recipe, &[0.1]);
        let ndf = open(&bytes).with_tolerance(0.0).expect("a tolerance");
        let size = f64::from(ndf.layout().size);
        let h = HalfVector { s: 0.05, t: -0.02 };
        for (edge_1, edge_2) in [
            ([0.0; 2], [0.0; 2]),
            ([5.0 / size, 2.0 / size], [0.0; 2]),
            ([5.0 / size, 2.0 / size], [2.5 / size, 1.0 / size]),
        ] {
            let at = |grow: f64| {
                let footprint = Footprint {
                    centre: [0.31, 0.62],
                    edge_1: [edge_1[0] + grow, edge_1[1]],
                    edge_2: [edge_2[0], edge_2[1] + grow],
                };
                ndf.eval(&footprint, h).expect("in range")
            };
            let (none, thin) = (at(0.0), at(1e-5 / size));
            assert!(none > 0.0, "{edge_1:?} {edge_2:?}");
            assert!(
                (none - thin).abs() < 1e-3 * none,
                "{edge_1:?}: {none} {thin}"
            );
        }
    }
}

#[test]
fn centres_a_million_tiles_away_are_those_at_home() {
    let map = sample_map(Kind::Waves, 8, 8, 3, Wrap::Repeat);
    let bytes = ndf_maps_package(&map, scattered(&NoiseOptions::new(20, 1), 40), &[0.1]);
    let ndf = open(&bytes);
    let h = HalfVector { s: 0.05, t: -0.02 };
    let at = |tiles: f64| {
        let footprint = Footprint::square([0.25 + tiles, 0.5 - tiles], 3.0, 40, 40);
        ndf.eval(&footprint, h).expect("in range")
    };
    assert!((at(0.0) - at(1e6)).abs() < 1e-6 * at(0.0));
}

#[test]
fn all_of_the_surface_is_what_all_its_copies_show() {
    let map = sample_map(Kind::Waves, 8, 8, 3, Wrap::Repeat);
    let noise = NoiseOptions {
        rotation: [0.0, 90.0],
        mirrored: 0.0,
        ..NoiseOptions::new(600, 1)
    };
    let bytes = ndf_maps_package(&map, scattered(&noise, 200), &[0.1]);
    let ndf = open(&bytes).with_tolerance(0.0).expect("a tolerance");
    let mut stream = Stream::new(5);
    let (mut off, mut sum) = (0.0, 0.0);
    for _ in 0..40 {
        let whole = Footprint::square([0.5; 2], 200.0, 200, 200);
        let uniform = [0; 4].map(|_| stream.uniform());
        let Some(h) = ndf.sample(&whole, uniform).expect("in range") else {
            continue;
        };
        // Beyond so many copies the image of the surface answers, and under one tile the copies themselves.
        let many = Footprint::square([0.5; 2], 12000.0, 200, 200);
        let (one, all) = (ndf.eval(&whole, h), ndf.eval(&many, h));
        let (one, all) = (one.expect("in range"), all.expect("in range"));
        off += (one - all).abs();
        sum += one;
    }
    assert!(off < 0.02 * sum, "{}", off / sum);
}

#[test]
fn samples_follow_the_pdf_and_lose_what_it_leaves_over() {
    let map = sample_map(Kind::Waves, 8, 8, 3, Wrap::Repeat);
    for (what, recipe) in [
        ("tiled", tiled(TURNED)),
        ("scattered", scattered(&NoiseOptions::new(24, 1), 40)),
    ] {
        let bytes = ndf_maps_package(&map, recipe, &[0.3]);
        let ndf = open(&bytes).with_tolerance(0.0).expect("a tolerance");
        for edge in [0.4, 7.0] {
            let size = ndf.layout().size;
            let footprint = Footprint::square([0.41, 0.37], edge, size, size);
            chi_squared(what, &ndf, &footprint);
        }
    }
}

/// Counts of samples in squares of the disk against the integral of the pdf over them; one square more for no sample at all.
fn chi_squared(what: &str, ndf: &NdfMaps<'_>, footprint: &Footprint) {
    const SIDE: usize = 12;
    const NODES: usize = 6;
    const COUNT: usize = 20_000;
    let square = |h: HalfVector| {
        let along = |x: f64| ((x + 1.0) * 0.5 * SIDE as f64) as usize;
        along(h.t).min(SIDE - 1) * SIDE + along(h.s).min(SIDE - 1)
    };
    let mut counts = [0.0; SIDE * SIDE + 1];
    let mut stream = Stream::new(3);
    for _ in 0..COUNT {
        let uniform = [0; 4].map(|_| stream.uniform());
        match ndf.sample(footprint, uniform).expect("in range") {
            Some(h) => counts[square(h)] += 1.0,
            None => counts[SIDE * SIDE] += 1.0,
        }
    }
    let mut expected = [0.0; SIDE * SIDE + 1];
    let cells = SIDE * NODES;
    for row in 0..cells {
        for column in 0..cells {
            let at = |place: usize| (place as f64 + 0.5) / cells as f64 * 2.0 - 1.0;
            let h = HalfVector {
                s: at(column),
                t: at(row),
            };
            let area = 4.0 / (cells * cells) as f64;
            // Per area of the disk, of which a solid angle is 1 / cosine.
            let density = ndf.eval(footprint, h).expect("in range");
            expected[square(h)] += density * area * COUNT as f64;
        }
    }
    let total: f64 = expected.iter().sum();
    assert!(total < 1.005 * COUNT as f64, "{what}: {total}");
    expected[SIDE * SIDE] = (COUNT as f64 - total).max(0.0);
    let (mut statistic, mut freedom) = (0.0, 0.0);
    let (mut rest, mut rest_expected) = (0.0, 0.0);
    for (count, expected) in counts.iter().zip(expected) {
        if expected < 8.0 {
            rest += count;
            rest_expected += expected;
        } else {
            statistic += (count - expected) * (count - expected) / expected;
            freedom += 1.0;
        }
    }
    if rest_expected > 8.0 {
        statistic += (rest - rest_expected) * (rest - rest_expected) / rest_expected;
    }
    // Six deviations above the mean of the distribution.
    let bound = freedom + 6.0 * (2.0_f64 * freedom).sqrt();
    assert!(
        statistic < bound,
        "{what}: {statistic} of {freedom} squares"
    );
}

#[test]
fn what_no_copy_covers_is_the_ground() {
    let map = sample_map(Kind::Waves, 8, 8, 3, Wrap::Repeat);
    let noise = NoiseMap {
        copies: vec![NoiseCopy {
            centre: [0.25; 2],
            matrix: [[1.0, 0.0], [0.0, 1.0]],
        }],
        source: NoiseSource::Generated(NoiseOptions::new(1, 0)),
    };
    let asked = NdfMapRecipe {
        size: Some(64),
        copies: NdfCopies::Scattered(Arc::new(noise)),
        ground: [0.3, -0.1],
        ground_roughness: Some(0.2),
        ..NdfMapRecipe::default()
    };
    let bytes = ndf_maps_package(&map, asked, &[0.1]);
    let ndf = open(&bytes);
    assert!((ndf.covered() - 1.0 / 64.0).abs() < 1e-6);
    let footprint = Footprint::square([0.75; 2], 8.0, 64, 64);
    let h = HalfVector { s: 0.35, t: -0.05 };
    let variance = 0.5 * 0.2 * 0.2;
    let distance: f64 = 0.05 * 0.05 + 0.05 * 0.05;
    let expected = (-0.5 * distance / variance).exp() / (2.0 * core::f64::consts::PI * variance);
    let found = ndf.eval(&footprint, h).expect("in range");
    assert!(
        (found - expected).abs() < 1e-9 * expected,
        "{found} {expected}"
    );
}

#[test]
fn packages_do_not_depend_on_threads() {
    let map = sample_map(Kind::Scratches, 16, 16, 3, Wrap::Repeat);
    let baked = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
            .install(|| ndf_maps_package(&map, scattered(&NoiseOptions::new(200, 5), 256), &[0.05]))
    };
    assert_eq!(baked(1), baked(3));
}

#[test]
fn what_cannot_be_baked_is_refused_with_what_can() {
    let example = sample_map(Kind::Waves, 8, 8, 3, Wrap::Repeat);
    let refused = |map: &NormalMap, asked: NdfMapRecipe, roughness: f64| {
        let recipe = MethodRecipe {
            ndf_maps: Some(asked),
            ..MethodRecipe::new(Method::NdfMaps, &[roughness])
        };
        match bake(map, &Recipe::new(vec![recipe]), None) {
            Err(BakeError::Option { option, reason, .. }) => (option, reason),
            other => panic!("{:?}", other.map(|_| ())),
        }
    };
    let plain = NdfMapRecipe::default();
    let odd = sample_map(Kind::Waves, 12, 12, 3, Wrap::Repeat);
    let (option, reason) = refused(&odd, plain.clone(), 0.1);
    assert!(
        option == "--method" && reason.contains("12 x 12"),
        "{reason}"
    );
    let flat = Transform {
        scale: [1.0, 1e-9],
        ..Transform::default()
    };
    let (option, reason) = refused(&example, tiled(flat), 0.1);
    assert!(
        option == "--transform" && reason.contains("singular"),
        "{reason}"
    );
    let crowd = NoiseOptions::new(4000, 1);
    let (option, reason) = refused(&example, scattered(&crowd, 40), 0.1);
    assert!(
        option == "--size" && reason.contains("lie over one"),
        "{reason}"
    );
    let (option, reason) = refused(&example, scattered(&NoiseOptions::new(4, 1), 16), 0.1);
    assert!(
        option == "--size" && reason.contains("four times"),
        "{reason}"
    );
    let steep = sample_map(Kind::Noise, 32, 32, 3, Wrap::Repeat);
    let (option, reason) = refused(&steep, plain, 0.0003);
    assert!(option == "--roughness" && reason.contains("MB"), "{reason}");
    let unsized_one = NdfMapRecipe {
        size: None,
        ..scattered(&NoiseOptions::new(4, 1), 64)
    };
    let (option, reason) = refused(&example, unsized_one, 0.1);
    assert!(
        option == "--size" && reason.contains("--size 1024"),
        "{reason}"
    );
}

#[test]
fn gaussian_footprints_are_refused() {
    let map = sample_map(Kind::Waves, 8, 8, 3, Wrap::Repeat);
    let bytes = ndf_maps_package(&map, NdfMapRecipe::default(), &[0.1]);
    let ndf = open(&bytes).with_filter(Filter::Gaussian);
    let footprint = Footprint::square([0.5; 2], 3.0, 8, 8);
    let found = ndf.eval(&footprint, HalfVector { s: 0.0, t: 0.0 });
    assert_eq!(found, Err(QueryError::BoxesOnly(Method::NdfMaps)));
}
