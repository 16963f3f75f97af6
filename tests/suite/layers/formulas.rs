//! The runtime's BRDF against the formulas of the papers, and against itself with one layer.

use super::{car_paint, directions, exact_flakes, flakes, open};
use glintbake_bake::MethodRecipe;
use glintbake_bake::oracle::layers::{Kind, Layer as OracleLayer, Normals, Passed, brdf};
use glintbake_format::model::{Footprint, Method, Wrap};
use glintbake_runtime::Ndf;
use glintbake_runtime::microfacet::brdf as plain;
use glintbake_runtime::microfacet::fresnel::Fresnel;
use glintbake_runtime::{
    Accuracy, Composition, Material, Package, QueryError, Setting, SurfaceNdf,
};
use glintbake_samples::Kind as Sample;
use glintbake_tests::fixtures::{Stream, package, sample_map};
use glintbake_tests::materials::{Layer, material};

/// `material` with every texel's own normal in place of its bin's.
fn exact(material: Material<'_>) -> Material<'_> {
    material
        .with_ndfs(|_, ndf| ndf.with_setting(Setting::Exact))
        .unwrap()
}

/// As the format rounds it.
fn stored<const N: usize>(numbers: [f64; N]) -> [f64; N] {
    numbers.map(|number| f64::from(number as f32))
}

#[test]
fn four_layers_are_what_the_formulas_say() {
    let (top, middle) = (
        sample_map(Sample::Scratches, 32, 32, 3, Wrap::Clamp),
        flakes(),
    );
    let (colour, f0, diffuse) = ([0.9, 0.5, 0.2], [0.9, 0.6, 0.3], [0.1, 0.4, 0.8]);
    for masked in [false, true] {
        let mut coat = Layer::coat(1.7, 0.0).mapped(&top, exact_flakes(0.3, masked));
        coat.recipe.colour = colour;
        coat.recipe.scale = [1.5, 0.75];
        let mut glints = Layer::glints(&middle, exact_flakes(0.4, masked), f0);
        glints.recipe.opacity = 0.6;
        glints.recipe.scale = [3.0, 2.0];
        let layers = [
            Layer::coat(1.3, 0.45),
            coat,
            glints,
            Layer::base([0.05, 0.04, 0.03], diffuse, 0.5),
        ];
        let bytes = material(&layers);
        let material = exact(open(&bytes));
        let of_map = |map, alpha| Normals::Map { map, alpha, masked };
        let lobe = |alpha: f64| Normals::Lobe {
            alpha: f64::from(alpha as f32),
        };
        let eta = |eta: f64| f64::from(eta as f32);
        let expected = [
            OracleLayer {
                kind: Kind::Coat {
                    eta: eta(1.3),
                    colour: [1.0; 3],
                },
                normals: lobe(0.45),
                scale: [1.0; 2],
                opacity: 1.0,
            },
            OracleLayer {
                kind: Kind::Coat {
                    eta: eta(1.7),
                    colour: stored(colour),
                },
                normals: of_map(&top, 0.3),
                scale: [1.5, 0.75],
                opacity: 1.0,
            },
            OracleLayer {
                kind: Kind::Glints { f0: stored(f0) },
                normals: of_map(&middle, 0.4),
                scale: [3.0, 2.0],
                opacity: f64::from(0.6_f32),
            },
            OracleLayer {
                kind: Kind::Base {
                    f0: stored([0.05, 0.04, 0.03]),
                    diffuse: stored(diffuse),
                },
                normals: lobe(0.5),
                scale: [1.0; 2],
                opacity: 1.0,
            },
        ];
        let mut stream = Stream::new(8);
        let mut worst: f64 = 0.0;
        for _ in 0..300 {
            let footprint = stream.footprint(&middle, 4.0);
            let [light, view] = directions(&mut stream, 0.03);
            for (composition, passed) in [
                (Composition::BothWays, Passed::BothWays),
                (Composition::HalfVector, Passed::HalfVector),
            ] {
                let got = material
                    .with_composition(composition)
                    .eval(&footprint, light, view)
                    .unwrap();
                let expected = brdf(&expected, &footprint, light, view, passed);
                for (got, expected) in got.into_iter().zip(expected) {
                    assert!(expected > 0.0);
                    worst = worst.max((got / expected - 1.0).abs());
                }
            }
        }
        // Exact normals are kept within 65536ths of bins; the map's masking comes from a table, see the tests of masking.
        let bound = if masked { 0.02 } else { 1e-4 };
        assert!(worst < bound, "masked {masked}: {worst:e}");
        assert!(!masked || worst > 3e-4, "the table is looked at: {worst:e}");
    }
}

#[test]
fn one_layer_of_glints_is_the_plain_brdf_to_the_bit() {
    let map = flakes();
    let footprints = Stream::new(4);
    for method in [
        exact_flakes(0.2, true),
        MethodRecipe {
            bins: Some(12),
            ..MethodRecipe::new(Method::SpecularBins, &[])
        },
        MethodRecipe::new(Method::Lean, &[0.2]),
        MethodRecipe::new(Method::ClusterTree, &[0.2]),
        MethodRecipe::new(Method::Lobes, &[0.2]),
        MethodRecipe::new(Method::Analytic, &[0.2]),
        MethodRecipe::new(Method::MipLobes, &[0.2]),
    ] {
        let name = method.method.name();
        let layered = material(&[Layer::glints(&map, method.clone(), [0.5, 0.25, 1.0])]);
        let layered = open(&layered);
        let alone = package(&map, method);
        let alone = Package::open(&alone).unwrap().ndf(1).unwrap();
        let mut stream = footprints.clone();
        let mut lit = 0;
        for _ in 0..200 {
            let footprint = stream.footprint(&map, 6.0);
            let [light, view] = directions(&mut stream, 0.1);
            let got = layered.eval(&footprint, light, view).unwrap();
            for (got, f0) in got.into_iter().zip([0.5, 0.25, 1.0]) {
                let fresnel = Fresnel::Schlick { f0 };
                let expected = plain::eval(&alone, &footprint, light, view, fresnel).unwrap();
                assert_eq!(got.to_bits(), expected.to_bits(), "{name}");
                lit += u32::from(got > 0.0);
            }
            let expected = plain::pdf(&alone, &footprint, light, view).unwrap();
            assert_eq!(layered.pdf(&footprint, light, view).unwrap(), expected);
            let uniform = std::array::from_fn(|_| stream.uniform());
            assert_eq!(
                layered.sample(&footprint, view, uniform).unwrap(),
                plain::sample(&alone, &footprint, view, uniform).unwrap(),
                "{name}"
            );
        }
        assert!(lit > 20, "{name}: only {lit} met a flake");
    }
}

#[test]
fn the_order_of_layers_matters_and_neither_layer_is_lost() {
    // Figure 5 of [XTXW24]: scratches over brushes, and brushes over scratches.
    let (scratches, brushes) = (
        sample_map(Sample::Scratches, 64, 64, 7, Wrap::Repeat),
        sample_map(Sample::Brushed, 64, 64, 7, Wrap::Repeat),
    );
    let tree = |alpha: f64| MethodRecipe::new(Method::ClusterTree, &[alpha]);
    let coat = |map, alpha| Layer::coat(1.8, 0.0).mapped(map, tree(alpha));
    let metal = |map, alpha| Layer::glints(map, tree(alpha), [0.6; 3]);
    let one = material(&[coat(&scratches, 0.05), metal(&brushes, 0.1)]);
    let other = material(&[coat(&brushes, 0.1), metal(&scratches, 0.05)]);
    let alone = material(&[coat(&scratches, 0.05)]);
    let (one, other, scratched) = (open(&one), open(&other), open(&alone));
    let mut stream = Stream::new(5);
    let (mut differ, mut counted) = (0, 0);
    for _ in 0..200 {
        let footprint = stream.footprint(&scratches, 8.0);
        let [light, view] = directions(&mut stream, 0.4);
        let [a, b] =
            [one, other].map(|material| material.eval(&footprint, light, view).unwrap()[0]);
        if a.max(b) > 1e-3 {
            counted += 1;
            differ += u32::from((a - b).abs() > 0.2 * a.max(b));
        }
        // What the coat alone sends out is part of the whole.
        let own = scratched.eval(&footprint, light, view).unwrap()[0];
        assert!(own <= a, "{own} of {a}");
    }
    assert!(
        counted > 40 && differ * 4 > counted * 3,
        "{differ} of {counted}"
    );
}

#[test]
fn light_and_view_may_be_exchanged() {
    let bytes = material(&car_paint(0.3, 0.2));
    let material = open(&bytes);
    let mut stream = Stream::new(2);
    for _ in 0..300 {
        let footprint = stream.footprint(&flakes(), 10.0);
        let [light, view] = directions(&mut stream, 0.01);
        for composition in [Composition::BothWays, Composition::HalfVector] {
            let material = material.with_composition(composition);
            let there = material.eval(&footprint, light, view).unwrap();
            let back = material.eval(&footprint, view, light).unwrap();
            for (there, back) in there.into_iter().zip(back) {
                assert!(there > 0.0);
                assert!((there - back).abs() <= 1e-9 * there, "{there} and {back}");
            }
        }
    }
}

#[test]
fn nothing_leaves_below_the_horizon_and_odd_questions_are_refused() {
    let bytes = material(&car_paint(0.3, 0.2));
    let material = open(&bytes);
    let up = [0.0, 0.0, 1.0];
    let patch = Footprint::square([0.3, 0.7], 4.0, 32, 24);
    for below in [
        [0.6, 0.0, -0.8],
        [1.0, 0.0, 0.0],
        [f64::NAN, 0.0, 1.0],
        [0.0; 3],
    ] {
        assert_eq!(material.eval(&patch, below, up), Ok([0.0; 3]));
        assert_eq!(material.eval(&patch, up, below), Ok([0.0; 3]));
        assert_eq!(material.pdf(&patch, below, up), Ok(0.0));
    }
    assert_eq!(
        material.sample(&patch, [0.6, 0.0, -0.8], [0.5; 4]),
        Ok(None)
    );
    let mut endless = patch;
    endless.edge_1[1] = f64::INFINITY;
    let wide = Footprint::square([0.5; 2], 300.0 * 32.0, 32, 24);
    for (footprint, error) in [
        (endless, QueryError::NotFinite),
        (wide, QueryError::FootprintTooLarge),
    ] {
        assert_eq!(material.eval(&footprint, up, up), Err(error));
        assert_eq!(material.pdf(&footprint, up, up), Err(error));
        assert_eq!(material.sample(&footprint, up, [0.5; 4]), Err(error));
    }
    // Without a map there is nothing to walk, but what is not a number is still refused.
    let bytes = glintbake_tests::materials::material(&[Layer::base([0.5; 3], [0.1; 3], 0.2)]);
    assert_eq!(
        open(&bytes).eval(&endless, up, up),
        Err(QueryError::NotFinite)
    );
}

#[test]
fn settings_reach_the_layers_they_are_meant_for() {
    let tree = MethodRecipe::new(Method::ClusterTree, &[0.1]);
    let layers = [
        Layer::coat(1.5, 0.0).mapped(&flakes(), tree.clone()),
        Layer::glints(&flakes(), tree, [0.9; 3]),
    ];
    let bytes = material(&layers);
    let material = open(&bytes);
    let changed = material
        .with_ndfs(|place, ndf| match (place, ndf) {
            (1, SurfaceNdf::ClusterTree(tree)) => Ok(SurfaceNdf::ClusterTree(
                tree.with_accuracy(Accuracy::Fast(1e-6))
                    .with_roughness(0.3)?,
            )),
            (_, ndf) => Ok(ndf),
        })
        .unwrap();
    let roughness: Vec<_> = changed
        .layers()
        .map(|layer| layer.ndf().unwrap().instance().roughness)
        .collect();
    assert_eq!(roughness, [Some(0.1), Some(0.3)]);
    let refused = material.with_ndfs(|_, ndf| ndf.with_setting(Setting::Exact));
    assert!(matches!(refused, Err(QueryError::SettingUnsupported(_))));
}
