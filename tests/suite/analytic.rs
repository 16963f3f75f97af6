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
                        accurate <= 1e-4,
                        "{kind:?} {wrap:?} {interpolation:?} σr {sigma} {shape:?}: {accurate:e}"
                    );
                    papers_worst = papers_worst.max(paper);
                    println!(
                        "{kind:?} {wrap:?} {interpolation:?} {sigma} {shape:?}: {accurate:.1e} {paper:.1e}"
                    );
                }
            }
        }
    }
    println!("the paper's form at worst: {papers_worst}");
    assert!(papers_worst > 1e-4 && papers_worst < 0.2, "{papers_worst}");
}
