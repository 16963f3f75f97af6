//! `lean` against the oracle of its own model, and what any lobe must keep to.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::{disk, lean as oracle};
use glintbake_bake::{MethodRecipe, Recipe};
use glintbake_format::model::{Filter, Footprint, HalfVector, Method, Wrap};
use glintbake_runtime::microfacet::{brdf, fresnel::Fresnel};
use glintbake_runtime::{Lean, Ndf, Package, QueryError, Setting, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, lean_package, package, sample_map};
use glintbake_tests::tolerances::ENERGY;
use proptest::prelude::*;

const FILTERS: [Filter; 2] = [Filter::Box, Filter::Gaussian];

fn lean<'a>(package: &Package<'a>, number: u16) -> Lean<'a> {
    match package.ndf(number).expect("the fixture has an instance") {
        SurfaceNdf::Lean(ndf) => ndf,
        _ => {
            panic!("the fixture was baked for lean")
        }
    }
}

/// Shapes of about `texels` texels: turned squares, needles, a segment.
fn shapes(stream: &mut Stream, map: &NormalMap, texels: f64) -> Vec<Footprint> {
    let mut shapes = Vec::new();
    for ratio in [1.0, 0.2, 0.03, 1e-6, 0.0] {
        let footprint = stream.footprint(map, texels);
        let edge_2 = footprint.edge_2.map(|x| x * ratio);
        shapes.push(Footprint {
            edge_2,
            ..footprint
        });
    }
    // On the other side of the world.
    let far = stream.footprint(map, texels);
    let centre = [far.centre[0] - 1e6, far.centre[1] + 1e6];
    shapes.push(Footprint { centre, ..far });
    shapes
}

/// Compares lobes and densities on `map`; returns the relative L1 error of the densities.
fn compare(map: &NormalMap, alpha: f64, finest_level: u32) -> f64 {
    let recipe = MethodRecipe {
        finest_level: Some(finest_level),
        ..MethodRecipe::new(Method::Lean, &[alpha])
    };
    let bytes = package(map, recipe);
    let package = Package::open(&bytes).unwrap();
    let mut stream = Stream::new(3);
    let (mut error, mut total) = (0.0, 0.0);
    for texels in [0.0, 1e-4, 0.7, 3.0, 17.0, 90.0, 3000.0] {
        for footprint in shapes(&mut stream, map, texels) {
            if footprint
                .edge_1
                .iter()
                .chain(&footprint.edge_2)
                .any(|x| x.abs() > 250.0)
            {
                continue;
            }
            for filter in FILTERS {
                let ndf = lean(&package, 1).with_filter(filter);
                let expected = oracle::Prepared::new(map, &footprint, filter, alpha, finest_level);
                let lobe = ndf.lobe(&footprint).unwrap();
                let what = || format!("α {alpha}, level {finest_level}, {filter:?}, {footprint:?}");
                let wide = alpha < 0.01;
                let [ss, _, tt] = expected.covariance();
                // Means are stored to 16 or 32 bits; the shares of probes are the same to 1e-6.
                let step = if wide { 1e-9 } else { 1.6e-5 };
                for (got, expected) in lobe.mean().iter().zip(expected.mean()) {
                    let off = (got - expected).abs();
                    assert!(
                        off <= step + 3e-6 * (ss + tt).sqrt(),
                        "{}: mean off by {off:e}",
                        what()
                    );
                }
                for (got, expected) in lobe.covariance().iter().zip(expected.covariance()) {
                    let off = (got - expected).abs();
                    // A deviation d is kept within 1.6e-5 √d, its square within twice d times that.
                    let room = 6e-5 * (ss + tt).powf(0.75)
                        + 1e-5 * (ss + tt)
                        + 2.0 * step * (ss + tt).sqrt();
                    assert!(
                        off <= room,
                        "{}: covariance off by {off:e} of {expected:e}",
                        what()
                    );
                }
                for _ in 0..4 {
                    let uniform = std::array::from_fn(|_| stream.uniform());
                    let Some(h) = ndf.sample(&footprint, uniform).unwrap() else {
                        continue;
                    };
                    let (got, wanted) = (ndf.eval(&footprint, h).unwrap(), expected.ndf(h));
                    // Weighed by the peak, so that wide lobes count as much as narrow ones.
                    let peak = 1.0 / (ss * tt).sqrt();
                    error += (got - wanted).abs() / peak;
                    total += wanted / peak;
                    let pdf = ndf.pdf(&footprint, h).unwrap();
                    assert!((pdf - got * h.direction()[2]).abs() <= 1e-14 * got);
                }
            }
        }
    }
    error / total
}

#[test]
fn lobes_are_those_of_the_model_for_every_roughness() {
    for (seed, kind) in (1..).zip([Kind::Flakes, Kind::Scratches, Kind::Noise]) {
        let map = sample_map(kind, 32, 32, seed, Wrap::Repeat);
        for (alpha, most) in [
            (1e-4, 0.01),
            (1e-3, 5e-3),
            (0.01, 5e-3),
            (0.1, 1e-3),
            (1.0, 1e-3),
        ] {
            let error = compare(&map, alpha, 0);
            assert!(error < most, "{} at {alpha}: {error}", kind.name());
        }
    }
}

#[test]
fn lobes_are_those_of_the_model_on_maps_of_any_size() {
    for [width, height] in [[1, 1], [1, 23], [37, 1], [31, 18], [45, 16], [16, 64]] {
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            let map = sample_map(Kind::Noise, width, height, 4, wrap);
            let top = width.max(height).ilog2();
            for finest in [0, 1, top] {
                if finest <= top {
                    let error = compare(&map, 0.02, finest);
                    assert!(
                        error < 5e-3,
                        "{width} x {height}, {wrap:?}, {finest}: {error}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_texel_and_the_whole_map_are_what_the_kernel_says() {
    let map = sample_map(Kind::Waves, 32, 32, 2, Wrap::Repeat);
    let bytes = lean_package(&map, &[0.2]);
    let package = Package::open(&bytes).unwrap();
    let ndf = lean(&package, 1);
    let texel = Footprint::square([4.5 / 32.0, 20.5 / 32.0], 1.0, 32, 32);
    let truth = disk::Prepared::new(&map, &texel, Filter::Box, 0.2);
    for (s, t) in [(0.0, 0.0), (0.2, -0.1), (-0.3, 0.4)] {
        let h = HalfVector { s, t };
        let (got, expected) = (ndf.eval(&texel, h).unwrap(), truth.ndf(h));
        assert!((got / expected - 1.0).abs() < 1e-3, "{got} {expected}");
    }
    let tile = Footprint::square([0.3, -7.1], 32.0, 32, 32);
    let texels = map.texels().iter().map(|texel| texel.map(f64::from));
    let mean = texels.fold([0.0; 2], |[s, t], [x, y]| [s + x / 1024.0, t + y / 1024.0]);
    for (got, expected) in ndf.lobe(&tile).unwrap().mean().iter().zip(mean) {
        assert!((got - expected).abs() < 1.6e-5);
    }
}

#[test]
fn the_lobe_does_not_jump_as_the_footprint_changes() {
    let map = sample_map(Kind::Noise, 48, 31, 6, Wrap::Repeat);
    let bytes = lean_package(&map, &[0.05]);
    let package = Package::open(&bytes).unwrap();
    for filter in FILTERS {
        let ndf = lean(&package, 1).with_filter(filter);
        // Along a path from a tenth of a texel to four tiles, turning, from round to needles and back.
        let largest_step = |steps: u32| {
            let lobe = |step: u32| {
                let x = f64::from(step) / f64::from(steps);
                let long = 0.002 * (7.6 * x).exp();
                let short = long * (-6.0 * (3.1 * x).sin().abs()).exp();
                let (cos, sin) = ((9.0 * x).cos(), (9.0 * x).sin());
                let footprint = Footprint {
                    centre: [0.3 + 0.5 * x, 0.9 - 2.0 * x],
                    edge_1: [long * cos, long * sin],
                    edge_2: [-short * sin, short * cos],
                };
                ndf.lobe(&footprint).unwrap()
            };
            let mut largest: f64 = 0.0;
            let mut before = lobe(0);
            for step in 1..=steps {
                let after = lobe(step);
                let means = before.mean().into_iter().zip(after.mean());
                let spreads = before.covariance().into_iter().zip(after.covariance());
                for (a, b) in means.chain(spreads) {
                    largest = largest.max((a - b).abs());
                }
                before = after;
            }
            largest
        };
        // A jump would stay as large however small the steps.
        let (coarse, fine) = (largest_step(4000), largest_step(160_000));
        assert!(fine < 0.06 * coarse, "{filter:?}: {coarse} becomes {fine}");
    }
}

#[test]
fn energy_is_kept_but_for_what_lies_beyond_the_rim() {
    let map = sample_map(Kind::Waves, 64, 48, 2, Wrap::Repeat);
    for alpha in [1e-4, 0.01, 0.1, 0.2] {
        let bytes = lean_package(&map, &[alpha]);
        let package = Package::open(&bytes).unwrap();
        let ndf = lean(&package, 1);
        let mut stream = Stream::new(3);
        for texels in [0.0, 0.5, 6.0, 200.0] {
            let footprint = stream.footprint(&map, texels);
            let lobe = ndf.lobe(&footprint).unwrap();
            let [ss, st, tt] = lobe.covariance();
            // Midpoints over six deviations along the lobe's own directions: s, and t given s.
            let (a, c) = (ss.sqrt(), (tt - st * st / ss).sqrt());
            let steps = 120;
            let step = 12.0 / f64::from(steps);
            let mut sum = 0.0;
            for x in 0..steps {
                for y in 0..steps {
                    let at = |place: i32| (f64::from(place) + 0.5) * step - 6.0;
                    let s = a * at(x);
                    let h = HalfVector {
                        s: lobe.mean()[0] + s,
                        t: lobe.mean()[1] + st / ss * s + c * at(y),
                    };
                    if h.is_on_disk() {
                        let pdf = ndf.pdf(&footprint, h).unwrap();
                        sum += pdf / h.direction()[2] * a * c * step * step;
                    }
                }
            }
            assert!((sum - 1.0).abs() < ENERGY, "{alpha} {texels}: {sum}");
        }
    }
}

#[test]
fn roughnesses_share_one_pyramid_and_differ_by_their_kernels() {
    let map = sample_map(Kind::Flakes, 24, 24, 5, Wrap::Repeat);
    let bytes = lean_package(&map, &[0.3, 0.02]);
    let package = Package::open(&bytes).unwrap();
    let kinds = package.container().entries().iter();
    assert_eq!(kinds.filter(|entry| &entry.kind.0 == b"MEAN").count(), 1);
    let footprint = Stream::new(2).footprint(&map, 6.0);
    let [rough, smooth] = [1, 2].map(|number| lean(&package, number).lobe(&footprint).unwrap());
    assert_eq!(rough.mean(), smooth.mean());
    let kernels = 0.5 * (0.3 * 0.3 - 0.02 * 0.02);
    let difference = rough.covariance()[0] - smooth.covariance()[0];
    assert!((difference - kernels).abs() < 1e-12, "{difference}");
}

#[test]
fn it_has_no_settings_and_says_so() {
    let map = sample_map(Kind::Noise, 8, 8, 1, Wrap::Repeat);
    let bytes = lean_package(&map, &[0.1]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let error = ndf.with_setting(Setting::Exact).unwrap_err();
    assert_eq!(error, QueryError::SettingUnsupported(Method::Lean));
    assert_eq!(ndf.with_filter(Filter::Gaussian).filter(), Filter::Gaussian);
}

#[test]
fn the_brdf_is_reciprocal_and_samples_have_a_density() {
    let map = sample_map(Kind::Waves, 32, 32, 3, Wrap::Repeat);
    let bytes = lean_package(&map, &[0.2]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let mut stream = Stream::new(8);
    let mut lit = 0;
    for _ in 0..200 {
        let footprint = stream.footprint(&map, 5.0);
        let view = [0.48, -0.36, 0.8];
        let uniform = std::array::from_fn(|_| stream.uniform());
        let Some(light) = brdf::sample(&ndf, &footprint, view, uniform).unwrap() else {
            continue;
        };
        let f = brdf::eval(&ndf, &footprint, light, view, Fresnel::Perfect).unwrap();
        let back = brdf::eval(&ndf, &footprint, view, light, Fresnel::Perfect).unwrap();
        assert!((f - back).abs() <= 1e-9 * f, "{f} and {back}");
        assert!(brdf::pdf(&ndf, &footprint, light, view).unwrap() > 0.0);
        lit += u32::from(f > 0.0);
    }
    assert!(lit > 150, "only {lit} samples were lit");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn any_query_has_an_answer_or_a_typed_error(
        centre in any::<[f64; 2]>(),
        edge_1 in proptest::array::uniform2(-1e3..1e3),
        edge_2 in any::<[f64; 2]>(),
        scale in -20.0..1.0,
        h in proptest::array::uniform2(-1.2..1.2),
        gaussian in any::<bool>(),
        clamp in any::<bool>(),
    ) {
        let wrap = if clamp { Wrap::Clamp } else { Wrap::Repeat };
        let map = sample_map(Kind::Noise, 13, 6, 1, wrap);
        let bytes = lean_package(&map, &[0.003]);
        let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
        let ndf = if gaussian { ndf.with_filter(Filter::Gaussian) } else { ndf };
        let edge_1 = edge_1.map(|x: f64| x * 10_f64.powf(scale));
        let footprint = Footprint { centre, edge_1, edge_2 };
        let [s, t] = h;
        match ndf.eval(&footprint, HalfVector { s, t }) {
            Ok(density) => prop_assert!(density.is_finite() && density >= 0.0),
            Err(error) => prop_assert!(matches!(error, QueryError::NotFinite | QueryError::FootprintTooLarge)),
        }
        let needle = Footprint { edge_2: edge_1.map(|x| x * 1e-6), ..footprint };
        if let Ok(Some(h)) = ndf.sample(&needle, [0.5, 0.5, 0.7, 0.2]) {
            prop_assert!(ndf.pdf(&needle, h).unwrap() > 0.0);
        }
    }
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    // One side that halves evenly and one that does not.
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool of a few threads starts").install(|| {
            let map = sample_map(Kind::Scratches, 512, 301, 11, Wrap::Repeat);
            let recipe = MethodRecipe::new(Method::Lean, &[0.004]);
            let plan = glintbake_bake::bake(&map, &Recipe::new(vec![recipe]), None);
            plan.expect("in range").to_bytes()
        })
    };
    let one = bytes(1);
    assert!([2, 3, 8].into_iter().all(|threads| bytes(threads) == one));
}
