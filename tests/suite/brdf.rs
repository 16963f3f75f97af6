//! The BRDF glue: reciprocity, furnace, Fresnel, sampling.

use glintbake_format::model::{Footprint, Wrap};
use glintbake_runtime::microfacet::beckmann;
use glintbake_runtime::microfacet::brdf;
use glintbake_runtime::microfacet::fresnel::Fresnel;
use glintbake_runtime::{Package, Setting};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, sample_map, specular_package};
use std::f64::consts::PI;

const MATERIALS: [Fresnel; 4] = [
    Fresnel::Perfect,
    Fresnel::Dielectric { eta: 1.5 },
    Fresnel::Conductor {
        eta: 0.2,
        kappa: 3.9,
    },
    Fresnel::Schlick { f0: 0.04 },
];

fn direction(stream: &mut Stream) -> [f64; 3] {
    let z = stream.between(0.05, 1.0);
    let angle = stream.between(0.0, 2.0 * PI);
    let radius = (1.0 - z * z).sqrt();
    [radius * angle.cos(), radius * angle.sin(), z]
}

#[test]
fn light_and_view_may_be_exchanged() {
    let map = sample_map(Kind::Flakes, 64, 64, 1, Wrap::Repeat);
    let flakes = flake_package(&map, &[0.4]);
    let mirrors = specular_package(&map, 12);
    for (bytes, least_lit) in [(&flakes, 200), (&mirrors, 20)] {
        let ndf = Package::open(bytes).unwrap().ndf(1).unwrap();
        let mut stream = Stream::new(2);
        let mut lit = 0;
        for _ in 0..200 {
            let footprint = stream.footprint(&map, 20.0);
            let (light, view) = (direction(&mut stream), direction(&mut stream));
            for fresnel in MATERIALS {
                let f = brdf::eval(&ndf, &footprint, light, view, fresnel).unwrap();
                let exchanged = brdf::eval(&ndf, &footprint, view, light, fresnel).unwrap();
                assert!((f - exchanged).abs() <= 1e-9 * f, "{f} and {exchanged}");
                lit += u32::from(f > 0.0);
            }
        }
        assert!(lit > least_lit, "only {lit} evaluations met a flake");
    }
}

#[test]
fn no_more_light_leaves_than_arrives() {
    // Rough flakes about the normal: with the flakes' own masking inside the sum, the furnace may lose light (single
    // scattering) but not make any.
    let map = sample_map(Kind::Flat, 2, 2, 0, Wrap::Repeat);
    let footprint = Footprint::square([0.5; 2], 1.0, 2, 2);
    for alpha in [0.05, 0.3, 0.8] {
        let bytes = flake_package(&map, &[alpha]);
        // The flake's own normal, not its bin's centre: a tilted flake is seen from a larger side than the surface.
        let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
        let ndf = ndf.with_setting(Setting::Exact).unwrap();
        for view in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -0.8, 0.6]] {
            let mut stream = Stream::new(4);
            let samples = 20_000;
            let mut sum = 0.0;
            for _ in 0..samples {
                let uniform = std::array::from_fn(|_| stream.uniform());
                if let Some(light) = brdf::sample(&ndf, &footprint, view, uniform).unwrap() {
                    let f = brdf::eval(&ndf, &footprint, light, view, Fresnel::Perfect).unwrap();
                    let pdf = brdf::pdf(&ndf, &footprint, light, view).unwrap();
                    assert!(pdf > 0.0, "a sampled direction has a density");
                    sum += f * light[2] / pdf;
                }
            }
            let albedo = sum / f64::from(samples);
            assert!(albedo <= 1.0 + 0.005, "{alpha} {view:?}: {albedo}");
            if alpha < 0.1 {
                assert!(albedo > 0.97, "smooth flakes lose hardly any: {albedo}");
            }
        }
    }
}

#[test]
fn a_flat_map_is_the_plain_microfacet_brdf() {
    // D G F / (4 cos cos) of Walter et al. 2007, written out here for a surface of one normal. Two bins a side meet at
    // the pole for even resolutions, so the flake sits at a bin centre half a bin off: take that centre.
    let alpha = 0.3;
    let map = sample_map(Kind::Flat, 2, 2, 0, Wrap::Repeat);
    let bytes = flake_package(&map, &[alpha]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let footprint = Footprint::square([0.5; 2], 1.0, 2, 2);
    let b = (5.0_f64 / (3.0 * alpha / 2.0_f64.sqrt()).atan().sin()).ceil();
    let cell = (b * 0.5).floor();
    let offset = (2.0 * cell + 1.0) / b - 1.0;
    let n = [offset, offset, (1.0 - 2.0 * offset * offset).sqrt()];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let smith = |v: [f64; 3]| {
        let cosine = dot(v, n);
        let a = cosine / (alpha * (1.0 - cosine * cosine).sqrt());
        // Walter et al. eq. 27, the rational fit, within 0.35 % of the exact form.
        if a < 1.6 {
            (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)
        } else {
            1.0
        }
    };
    let mut stream = Stream::new(9);
    for _ in 0..100 {
        let (light, view) = (direction(&mut stream), direction(&mut stream));
        let sum = [light[0] + view[0], light[1] + view[1], light[2] + view[2]];
        let h = sum.map(|x| x / dot(sum, sum).sqrt());
        let cosine = dot(h, n);
        let tangent = (1.0 - cosine * cosine) / (cosine * cosine);
        if tangent > 4.0 * alpha * alpha {
            continue; // the bins' tail cut shows beyond
        }
        let d = (-tangent / (alpha * alpha)).exp() / (PI * alpha * alpha * cosine.powi(4));
        let expected = d * smith(light) * smith(view) / (4.0 * light[2] * view[2]);
        let got = brdf::eval(&ndf, &footprint, light, view, Fresnel::Perfect).unwrap();
        assert!(
            (got - expected).abs() <= 0.008 * expected,
            "{got} instead of {expected}"
        );
    }
}

#[test]
fn fresnel_reproduces_known_values() {
    // Glass at normal incidence ((1.5 - 1) / (1.5 + 1))² and at Brewster's angle, where parallel light is transmitted.
    let glass = Fresnel::Dielectric { eta: 1.5 };
    assert!((glass.reflectance(1.0) - 0.04).abs() < 1e-12);
    let brewster = (1.0 / (1.0 + 1.5_f64 * 1.5)).sqrt();
    let perpendicular: f64 = (1.0 - 1.5 * 1.5) / (1.0 + 1.5 * 1.5);
    assert!((glass.reflectance(brewster) - 0.5 * perpendicular.powi(2)).abs() < 1e-12);
    // From the dense side, beyond the critical angle.
    assert!((Fresnel::Dielectric { eta: 1.0 / 1.5 }.reflectance(0.3) - 1.0).abs() < 1e-12);
    // A conductor without extinction is a dielectric; with it, ((η-1)² + κ²) / ((η+1)² + κ²) at normal incidence.
    for cosine in [0.01, 0.3, 0.7, 1.0] {
        let metal = Fresnel::Conductor {
            eta: 1.5,
            kappa: 0.0,
        };
        assert!((metal.reflectance(cosine) - glass.reflectance(cosine)).abs() < 1e-9);
    }
    let silver = Fresnel::Conductor {
        eta: 0.155,
        kappa: 3.6,
    };
    let expected = (0.845_f64.powi(2) + 3.6 * 3.6) / (1.155_f64.powi(2) + 3.6 * 3.6);
    assert!((silver.reflectance(1.0) - expected).abs() < 1e-12);
    for fresnel in MATERIALS {
        assert!(
            (fresnel.reflectance(0.0) - 1.0).abs() < 1e-9,
            "all reflect at grazing"
        );
    }
}

#[test]
fn masking_is_exact_against_its_definition() {
    // G1 = 1 / (1 + Λ), Λ = (exp(-a²) / (a √π) - erfc(a)) / 2 (Heitz 2014, eq. 71), by quadrature of erfc.
    let normal = [0.0, 0.0, 1.0];
    for alpha in [0.05, 0.5, 1.0] {
        for cosine in [0.02, 0.2, 0.6, 0.95] {
            let sine = (1.0_f64 - cosine * cosine).sqrt();
            let a = cosine / (alpha * sine);
            let steps = 20_000;
            let width = 8.0 / f64::from(steps);
            let erfc: f64 = (0..steps)
                .map(|step| {
                    let x = a + (f64::from(step) + 0.5) * width;
                    (-x * x).exp() * width * 2.0 / PI.sqrt()
                })
                .sum();
            let lambda = 0.5 * ((-a * a).exp() / (a * PI.sqrt()) - erfc);
            let got = beckmann::masking([sine, 0.0, cosine], normal, normal, alpha);
            assert!(
                (got - 1.0 / (1.0 + lambda)).abs() < 1e-6,
                "{alpha} {cosine}"
            );
        }
    }
    assert_eq!(
        beckmann::masking([0.6, 0.0, -0.8], normal, normal, 0.1),
        0.0
    );
    assert_eq!(beckmann::masking(normal, normal, normal, 0.1), 1.0);
}
