//! `analytic` against the integral over the surface, in both forms, on maps of any size, interpolation and wrap.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::analytic::Prepared;
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_format::check;
use glintbake_format::model::{
    Filter, Footprint, HalfVector, Interpolation, Method, Wrap, beckmann_from_intrinsic,
};
use glintbake_runtime::{Analytic, Ndf, Package, QueryError, SurfaceNdf, TriangleForm};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, sample_map};

fn package(map: &NormalMap, interpolation: Interpolation, roughness: &[f64]) -> Vec<u8> {
    let recipe = MethodRecipe {
        interpolation: Some(interpolation),
        ..MethodRecipe::new(Method::Analytic, roughness)
    };
    let plan = bake(map, &Recipe::new(vec![recipe]), None);
    plan.expect("in range").to_bytes()
}

fn analytic<'a>(bytes: &'a [u8]) -> Analytic<'a> {
    let package = Package::open(bytes).expect("a fresh package opens");
    match package.ndf(1).expect("it has an instance") {
        SurfaceNdf::Analytic(ndf) => ndf,
        other => panic!("baked for analytic: {other:?}"),
    }
}

/// A footprint of standard deviations of about `texels` texels, `ratio` times as long as wide.
fn footprint(stream: &mut Stream, map: &NormalMap, texels: f64, ratio: f64) -> Footprint {
    let size = [f64::from(map.width()), f64::from(map.height())];
    let angle = stream.between(0.0, core::f64::consts::TAU);
    let edge = |length: f64, angle: f64| {
        [
            2.0 * length * angle.cos() / size[0],
            2.0 * length * angle.sin() / size[1],
        ]
    };
    let narrow = texels * stream.between(0.7, 1.4);
    Footprint {
        centre: [stream.between(-0.1, 1.1), stream.between(-0.1, 1.1)],
        edge_1: edge(narrow * ratio, angle),
        edge_2: edge(narrow, angle + stream.between(1.2, 1.9)),
    }
}

/// Relative L1 error of both forms over queries near normals that the footprint sees.
fn errors(
    map: &NormalMap,
    ndf: &Analytic<'_>,
    [texels, ratio]: [f64; 2],
    count: usize,
    seed: u64,
) -> [f64; 2] {
    let mut stream = Stream::new(seed);
    let (mut off, mut sum) = ([0.0; 2], 0.0);
    for _ in 0..count {
        let footprint = footprint(&mut stream, map, texels, ratio);
        let drawn = std::array::from_fn(|_| stream.uniform());
        let Some(h) = ndf.sample(&footprint, drawn).expect("in range") else {
            continue;
        };
        let exact = Prepared::new(map, &footprint, ndf.interpolation()).ndf(h, ndf.roughness());
        sum += exact;
        for (form, off) in [TriangleForm::Accurate, TriangleForm::Paper]
            .into_iter()
            .zip(&mut off)
        {
            let found = ndf.with_form(form).eval(&footprint, h).expect("in range");
            assert!(found.is_finite() && found >= 0.0, "{found}");
            *off += (found - exact).abs();
        }
    }
    off.map(|off| off / sum)
}

#[test]
fn densities_are_the_integral_over_the_surface() {
    let mut papers_worst = 0.0_f64;
    for (kind, width, height, wrap) in [
        (Kind::Waves, 40, 24, Wrap::Repeat),
        (Kind::Flakes, 33, 21, Wrap::Clamp),
        (Kind::Noise, 16, 20, Wrap::Repeat),
        (Kind::Noise, 9, 12, Wrap::Clamp),
    ] {
        let map = sample_map(kind, width, height, 3, wrap);
        for &interpolation in Interpolation::ALL {
            let bytes = package(&map, interpolation, &[0.01]);
            for sigma in [1e-4, 5e-3, 0.05, 0.25] {
                let ndf = analytic(&bytes)
                    .with_roughness(beckmann_from_intrinsic(sigma))
                    .expect("in range");
                for shape in [
                    [1e-4, 1.0],
                    [0.2, 10.0],
                    [1.0, 1.0],
                    [3.0, 2.0],
                    [1e-3, 1e3],
                ] {
                    let [accurate, paper] = errors(&map, &ndf, shape, 6, 5);
                    assert!(
                        accurate <= 1e-5,
                        "{kind:?} {wrap:?} {interpolation:?} σr {sigma} {shape:?}: {accurate:e}"
                    );
                    papers_worst = papers_worst.max(paper);
                }
            }
        }
    }
    println!("the paper's form at worst: {papers_worst}");
    assert!(papers_worst > 1e-4 && papers_worst < 0.2, "{papers_worst}");
}

#[test]
fn footprints_of_many_tiles_see_the_whole_map() {
    for (wrap, interpolation) in [
        (Wrap::Repeat, Interpolation::None),
        (Wrap::Repeat, Interpolation::Linear),
        (Wrap::Repeat, Interpolation::CatmullRom),
        (Wrap::Clamp, Interpolation::Linear),
        (Wrap::Clamp, Interpolation::CatmullRom),
    ] {
        let map = sample_map(Kind::Waves, 7, 5, 2, wrap);
        let bytes = package(&map, interpolation, &[0.05]);
        // In tiles: just short of even weights, just beyond them, long, and 64 tiles.
        for [texels, ratio] in [
            [4.0, 1.0],
            [5.0, 1.1],
            [12.0, 1.0],
            [1.0, 60.0],
            [300.0, 1.0],
        ] {
            let ndf = analytic(&bytes);
            let [accurate, _] = errors(&map, &ndf, [texels, ratio], 4, 8);
            assert!(
                accurate <= 1e-4,
                "{wrap:?} {interpolation:?} {texels} {ratio}: {accurate:e}"
            );
        }
    }
}

#[test]
fn maps_of_a_texel_or_a_row_and_constant_maps_are_answered() {
    for (width, height) in [(1, 1), (1, 6), (6, 1), (2, 2)] {
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            let map = sample_map(Kind::Noise, width, height, 4, wrap);
            for &interpolation in Interpolation::ALL {
                let bytes = package(&map, interpolation, &[0.1]);
                for texels in [0.01, 0.6, 3.0] {
                    let [accurate, _] = errors(&map, &analytic(&bytes), [texels, 1.5], 3, 6);
                    assert!(
                        accurate <= 1e-4,
                        "{width} {height} {wrap:?} {interpolation:?} {texels}: {accurate:e}"
                    );
                }
            }
        }
    }
    // A constant map is its kernel, under any footprint; so are points and lines.
    let map = NormalMap::new(16, 16, Wrap::Repeat, vec![[0.2, -0.1]; 256]);
    for &interpolation in Interpolation::ALL {
        let bytes = package(&map, interpolation, &[0.02]);
        let ndf = analytic(&bytes);
        let [s, t] = [0.2_f32, -0.1].map(f64::from);
        let peak = 1.0 / (core::f64::consts::PI * 0.02 * 0.02);
        for edges in [
            [[0.0; 2], [0.0; 2]],
            [[0.3, 0.1], [0.0; 2]],
            [[0.01, 0.0], [0.0, 0.02]],
            [[64.0, 3.0], [1.0, 64.0]],
            [[200.0, 130.0], [-1e-4, 1e-4]],
        ] {
            let footprint = Footprint {
                centre: [0.3, 1e6 + 0.7],
                edge_1: edges[0],
                edge_2: edges[1],
            };
            let found = ndf.eval(&footprint, HalfVector { s, t }).expect("in range");
            assert!(
                (found / peak - 1.0).abs() < 1e-5,
                "{interpolation:?} {edges:?}: {found} for {peak}"
            );
        }
    }
}

/// The integral of the density over the disk, and a check of facets against it on the way.
fn energy(ndf: &Analytic<'_>, footprint: &Footprint, steps: usize) -> f64 {
    let step = 2.0 / steps as f64;
    let mut sum = 0.0;
    for place in 0..steps * steps {
        let at = |number: usize| (number as f64 + 0.5) * step - 1.0;
        let h = HalfVector {
            s: at(place % steps),
            t: at(place / steps),
        };
        sum += ndf.eval(footprint, h).expect("in range");
    }
    sum * step * step
}

#[test]
fn energy_is_one_and_facets_add_up() {
    for &interpolation in Interpolation::ALL {
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            let map = sample_map(Kind::Waves, 20, 14, 7, wrap);
            let bytes = package(&map, interpolation, &[0.05]);
            let ndf = analytic(&bytes);
            let mut stream = Stream::new(4);
            for shape in [[1e-4, 1.0], [0.7, 3.0], [4.0, 1.0], [40.0, 1.0]] {
                let footprint = footprint(&mut stream, &map, shape[0], shape[1]);
                // Steps of 0.7 deviations: sums of Gaussians are then integrals.
                let energy = energy(&ndf, &footprint, 80);
                assert!(
                    (energy - 1.0).abs() < 1e-3,
                    "{interpolation:?} {wrap:?} {shape:?}: {energy}"
                );
                let h = stream.half_vector_near(&map, &footprint, 0.05);
                let (mut sum, mut weight) = (0.0, 0.0);
                ndf.facets(&footprint, h, &mut |facet| {
                    sum += facet.density * facet.weight;
                    weight += facet.weight;
                    let [x, y, z] = facet.normal;
                    assert!((x * x + y * y + z * z - 1.0).abs() < 1e-12);
                })
                .expect("in range");
                let whole = ndf.eval(&footprint, h).expect("in range");
                assert!(
                    (sum - whole).abs() <= 1e-9 * whole && weight < 1.0 + 1e-6,
                    "{weight}"
                );
            }
        }
    }
}

/// χ² of `count` draws over a grid of the disk against the integral of a density, as a standard normal deviate (Wilson and Hilferty).
fn deviate(
    count: usize,
    mut draw: impl FnMut([f64; 4]) -> Option<HalfVector>,
    density: impl Fn(HalfVector) -> f64,
    fine_steps: usize,
) -> f64 {
    const CELLS: usize = 24;
    let (low, high) = (-1.0, 1.0);
    let mut counts = vec![0.0; CELLS * CELLS + 1];
    let mut stream = Stream::new(12);
    let size = (high - low) / CELLS as f64;
    for _ in 0..count {
        let cell = draw(std::array::from_fn(|_| stream.uniform())).and_then(|h| {
            let place = |x: f64| ((x - low) / size).floor();
            let (i, j) = (place(h.s), place(h.t));
            let range = 0.0..CELLS as f64;
            (range.contains(&i) && range.contains(&j)).then(|| j as usize * CELLS + i as usize)
        });
        counts[cell.unwrap_or(CELLS * CELLS)] += 1.0;
    }
    let fine = size / fine_steps as f64;
    let mut masses = vec![0.0; CELLS * CELLS + 1];
    for place in 0..(CELLS * fine_steps).pow(2) {
        let (i, j) = (place % (CELLS * fine_steps), place / (CELLS * fine_steps));
        let h = HalfVector {
            s: low + (i as f64 + 0.5) * fine,
            t: low + (j as f64 + 0.5) * fine,
        };
        masses[j / fine_steps * CELLS + i / fine_steps] += density(h) * fine * fine;
    }
    masses[CELLS * CELLS] = 1.0 - masses.iter().sum::<f64>();
    let (mut statistic, mut freedom, mut rest) = (0.0, -1.0, [0.0; 2]);
    for (&counted, &mass) in counts.iter().zip(&masses) {
        let expected = mass * count as f64;
        if expected >= 5.0 {
            statistic += (counted - expected).powi(2) / expected;
            freedom += 1.0;
        } else {
            rest = [rest[0] + counted, rest[1] + expected.max(0.0)];
        }
    }
    if rest[1] >= 5.0 {
        statistic += (rest[0] - rest[1]).powi(2) / rest[1];
        freedom += 1.0;
    } else {
        assert!(rest[0] <= 30.0, "{rest:?}");
    }
    let spread = 2.0 / (9.0 * freedom);
    ((statistic / freedom).cbrt() - 1.0 + spread) / f64::sqrt(spread)
}

#[test]
fn samples_are_drawn_by_the_density() {
    let mut stream = Stream::new(3);
    for &interpolation in Interpolation::ALL {
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            let map = sample_map(Kind::Waves, 12, 10, 7, wrap);
            let bytes = package(&map, interpolation, &[0.12]);
            let ndf = analytic(&bytes);
            for shape in [[0.01, 1.0], [1.5, 2.0], [30.0, 1.0]] {
                let footprint = footprint(&mut stream, &map, shape[0], shape[1]);
                let found = deviate(
                    60_000,
                    |uniform| ndf.sample(&footprint, uniform).expect("in range"),
                    |h| ndf.eval(&footprint, h).expect("in range"),
                    4,
                );
                assert!(
                    found.abs() < 4.5,
                    "{interpolation:?} {wrap:?} {shape:?}: {found}"
                );
            }
            let h = HalfVector { s: 0.3, t: -0.2 };
            let [.., cosine] = h.direction();
            let footprint = footprint(&mut stream, &map, 3.0, 1.0);
            let ratio = ndf.pdf(&footprint, h).expect("in range")
                / ndf.eval(&footprint, h).expect("in range");
            assert!((ratio - cosine).abs() < 1e-12);
        }
    }
}

#[test]
fn the_global_ndf_is_that_of_the_whole_map_and_is_drawn_exactly() {
    for (kind, &interpolation) in [Kind::Waves, Kind::Flakes, Kind::Waves]
        .into_iter()
        .zip(Interpolation::ALL)
    {
        let map = sample_map(kind, 64, 48, 7, Wrap::Repeat);
        let bytes = package(&map, interpolation, &[0.15]);
        let ndf = analytic(&bytes);
        let global = ndf.global();
        let found = deviate(
            200_000,
            |uniform| global.sample(uniform),
            |h| global.eval(h),
            8,
        );
        assert!(found.abs() < 4.5, "{found}");
        let everything = Footprint {
            centre: [0.5; 2],
            edge_1: [2.0, 0.0],
            edge_2: [0.0, 2.0],
        };
        let (mut off, mut sum) = (0.0, 0.0);
        for place in 0..900 {
            let h = HalfVector {
                s: f64::from(place % 30) / 15.0 - 1.0,
                t: f64::from(place / 30) / 15.0 - 1.0,
            };
            let exact = ndf.eval(&everything, h).expect("in range");
            off += (global.eval(h) - exact).abs();
            sum += exact;
        }
        assert!(off < 0.02 * sum, "{interpolation:?}: {}", off / sum);
        assert_eq!(global.eval(HalfVector { s: 1.0, t: 0.1 }), 0.0);
    }
}

#[test]
fn what_is_not_made_for_it_is_refused_in_words() {
    let map = sample_map(Kind::Waves, 20, 20, 2, Wrap::Repeat);
    let bytes = package(&map, Interpolation::Linear, &[0.01, 0.1]);
    let ndf = analytic(&bytes);
    let footprint = Footprint::square([0.5; 2], 2.0, 20, 20);
    let h = HalfVector { s: 0.0, t: 0.0 };
    let refused = ndf
        .with_filter(Filter::Box)
        .eval(&footprint, h)
        .unwrap_err();
    assert_eq!(refused, QueryError::FilterUnsupported(Method::Analytic));
    for alpha in [0.0, 1e-7, 11.0, f64::NAN, f64::INFINITY] {
        assert!(ndf.with_roughness(alpha).is_err(), "{alpha}");
    }
    assert_eq!(ndf.with_reach(f64::NAN).reach(), 1.0);
    let beyond = HalfVector { s: 0.9, t: 0.9 };
    assert_eq!(ndf.eval(&footprint, beyond).expect("in range"), 0.0);
    let nan = HalfVector {
        s: f64::NAN,
        t: 0.0,
    };
    assert_eq!(
        ndf.eval(&footprint, nan).unwrap_err(),
        QueryError::NotFinite
    );
    let boxes = MethodRecipe {
        filter: Filter::Box,
        ..MethodRecipe::new(Method::Analytic, &[0.01])
    };
    let error = bake(&map, &Recipe::new(vec![boxes]), None)
        .err()
        .expect("refused");
    assert!(error.to_string().contains("Gaussian"), "{error}");
    let binned = MethodRecipe {
        bins: Some(9),
        ..MethodRecipe::new(Method::Analytic, &[0.01])
    };
    assert!(bake(&map, &Recipe::new(vec![binned]), None).is_err());
}

#[test]
fn packages_are_sound_shared_between_roughnesses_and_safe_when_damaged() {
    let map = sample_map(Kind::Noise, 37, 70, 2, Wrap::Repeat);
    for &interpolation in Interpolation::ALL {
        let bytes = package(&map, interpolation, &[0.01, 0.1]);
        let opened = Package::open(&bytes).expect("it opens");
        check::full(opened.container(), &mut |finding| {
            panic!("{interpolation:?}: {finding}")
        });
        let footprint = Footprint::square([0.4; 2], 6.0, 37, 70);
        let h = HalfVector { s: 0.1, t: 0.0 };
        let second = opened.ndf(2).expect("it has two");
        let first = analytic(&bytes).with_roughness(0.1).expect("in range");
        assert_eq!(second.eval(&footprint, h), first.eval(&footprint, h));
        let mut stream = Stream::new(6);
        for _ in 0..200 {
            let mut damaged = bytes.clone();
            for _ in 0..40 {
                let place = 1024 + (stream.uniform() * (bytes.len() - 1024) as f64) as usize;
                damaged[place] = (stream.uniform() * 256.0) as u8;
            }
            let Ok(package) = Package::open(&damaged) else {
                continue;
            };
            let Ok(SurfaceNdf::Analytic(ndf)) = package.ndf(1) else {
                continue;
            };
            for form in [TriangleForm::Accurate, TriangleForm::Paper] {
                let found = ndf.with_form(form).eval(&footprint, h);
                assert!(found.is_err() || found.is_ok_and(|d| d >= 0.0 && d.is_finite()));
            }
            let _ = ndf
                .global()
                .sample(std::array::from_fn(|_| stream.uniform()));
        }
    }
}
