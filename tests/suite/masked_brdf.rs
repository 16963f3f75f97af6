//! The BRDF with the map's own masking: energy, sampling, reciprocity, and where the factor stands.

use crate::masking::{WHOLE_TILE, direction, first_ndf, unmasked_package};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle;
use glintbake_format::model::Wrap;
use glintbake_runtime::microfacet::brdf::{self, MaskingPlacement};
use glintbake_runtime::microfacet::fresnel::Fresnel;
use glintbake_runtime::{Ndf, Setting, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, sample_map, specular_package};
use std::f64::consts::TAU;

/// The share of light from `view` that leaves again in all directions, for facets that reflect all, by samples
/// of `brdf::sample` spread evenly over the whole tile.
fn albedo(ndf: &SurfaceNdf<'_>, view: [f64; 3]) -> f64 {
    /// Powers of the root of x⁵ = x + 1: the low-discrepancy sequence of Roberts (2018) in four dimensions.
    const STEPS: [f64; 4] = [
        0.856_674_883_854_502_9,
        0.733_891_856_627_126,
        0.628_706_721_037_808_7,
        0.538_597_257_223_612,
    ];
    let samples = 4000;
    let mut sum = 0.0;
    for index in 0..samples {
        let uniform = STEPS.map(|step| (0.5 + f64::from(index) * step).fract());
        if let Some(light) = brdf::sample(ndf, &WHOLE_TILE, view, uniform).unwrap() {
            let f = brdf::eval(ndf, &WHOLE_TILE, light, view, Fresnel::Perfect).unwrap();
            let pdf = brdf::pdf(ndf, &WHOLE_TILE, light, view).unwrap();
            assert!(pdf > 0.0, "a sampled direction has a density");
            sum += f * light[2] / pdf;
        }
    }
    sum / f64::from(samples)
}

#[test]
fn no_more_light_leaves_a_map_than_arrives() {
    for kind in [Kind::Flakes, Kind::Noise, Kind::Scratches] {
        let map = sample_map(kind, 16, 16, 3, Wrap::Repeat);
        for alpha in [0.1, 0.4] {
            let (masked, unmasked) = (flake_package(&map, &[alpha]), unmasked_package(&map, alpha));
            for cosine in [1.0, 0.6, 0.2, 0.05] {
                let view = direction(cosine, 0.0);
                let of =
                    |bytes, setting| albedo(&first_ndf(bytes).with_setting(setting).unwrap(), view);
                let what = format!("{} {alpha} {cosine}", kind.name());
                let exact = of(&masked, Setting::Exact);
                assert!(exact <= 1.0 + 0.005, "{what}: {exact}");
                assert!(exact > 0.6, "{what}: only {exact} leaves");
                if alpha < 0.2 {
                    // Bins move normals by up to a tenth here, which turns some of them towards the view.
                    let binned = of(&masked, Setting::default());
                    assert!(binned <= 1.0 + 0.02, "{what}, binned: {binned}");
                }
                if cosine < 0.1 && kind != Kind::Scratches {
                    let without = of(&unmasked, Setting::Exact);
                    assert!(
                        without > 1.3,
                        "{what}: masking has nothing to do: {without}"
                    );
                }
            }
        }
    }
}

#[test]
fn sampling_and_summing_agree_on_the_light_that_leaves() {
    let map = sample_map(Kind::Waves, 16, 16, 3, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.4]);
    let ndf = first_ndf(&bytes).with_setting(Setting::Exact).unwrap();
    for cosine in [1.0, 0.5, 0.15] {
        let view = direction(cosine, 0.1);
        let [rows, columns] = [80, 160];
        let mut sum = 0.0;
        for row in 0..rows {
            for column in 0..columns {
                let z = (f64::from(row) + 0.5) / f64::from(rows);
                let light = direction(z, (f64::from(column) + 0.5) / f64::from(columns));
                let f = brdf::eval(&ndf, &WHOLE_TILE, light, view, Fresnel::Perfect).unwrap();
                sum += f * z;
            }
        }
        let summed = sum * TAU / f64::from(rows * columns);
        let sampled = albedo(&ndf, view);
        assert!(
            (summed / sampled - 1.0).abs() < 0.01,
            "{cosine}: {summed} and {sampled}"
        );
    }
}

#[test]
fn light_and_view_may_be_exchanged() {
    let map = sample_map(Kind::Leather, 64, 64, 1, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.3]);
    let ndf = first_ndf(&bytes);
    let mut stream = Stream::new(2);
    let mut lit = 0;
    for _ in 0..300 {
        let footprint = stream.footprint(&map, 20.0);
        let mut direction = || direction(stream.between(0.01, 1.0), stream.uniform());
        let (light, view) = (direction(), direction());
        for placement in [MaskingPlacement::Inside, MaskingPlacement::Factored] {
            let eval = |light, view| {
                brdf::eval_with(&ndf, &footprint, light, view, Fresnel::Perfect, placement).unwrap()
            };
            let (f, exchanged) = (eval(light, view), eval(view, light));
            assert!((f - exchanged).abs() <= 1e-9 * f, "{f} and {exchanged}");
            lit += u32::from(f > 0.0);
        }
    }
    assert!(lit > 200, "only {lit} evaluations met a flake");
}

#[test]
fn the_brdf_is_the_unmasked_one_times_the_maps_masking() {
    // The table's value is the same for all facets, so eq. 15 with and without it differ by this factor alone.
    let map = sample_map(Kind::Flakes, 32, 32, 5, Wrap::Repeat);
    let (masked, unmasked) = (flake_package(&map, &[0.3]), unmasked_package(&map, 0.3));
    let (masked, unmasked) = (first_ndf(&masked), first_ndf(&unmasked));
    assert!(masked.masking().is_baked() && !unmasked.masking().is_baked());
    let mut stream = Stream::new(3);
    let mut lit = 0;
    for _ in 0..300 {
        let footprint = stream.footprint(&map, 8.0);
        let mut direction = || direction(stream.between(0.02, 1.0), stream.uniform());
        let (light, view) = (direction(), direction());
        let eval = |ndf| brdf::eval(ndf, &footprint, light, view, Fresnel::Perfect).unwrap();
        let factor = oracle::masking(&map, light) * oracle::masking(&map, view);
        let (got, expected) = (eval(&masked), eval(&unmasked) * factor);
        assert!(
            (got - expected).abs() <= 0.02 * expected,
            "{got} {expected}"
        );
        lit += u32::from(got > 0.0);
    }
    assert!(lit > 100, "only {lit} evaluations met a flake");
}

/// How much brighter the factored form is, over directions as they are drawn and above `least` cosine: in all, and the
/// sum of differences of either sign.
fn factored_error(ndf: &SurfaceNdf<'_>, map: &NormalMap, least: f64) -> (f64, f64) {
    let mut stream = Stream::new(4);
    let (mut inside, mut brighter, mut off) = (0.0, 0.0, 0.0);
    for _ in 0..1500 {
        let footprint = stream.footprint(map, 20.0);
        let view = direction(stream.between(least, 1.0), stream.uniform());
        let uniform = std::array::from_fn(|_| stream.uniform());
        let drawn = brdf::sample(ndf, &footprint, view, uniform).unwrap();
        if let Some(light) = drawn.filter(|light| light[2] >= least) {
            let weight = light[2] / brdf::pdf(ndf, &footprint, light, view).unwrap();
            let [a, b] = [MaskingPlacement::Inside, MaskingPlacement::Factored].map(|placement| {
                weight
                    * brdf::eval_with(ndf, &footprint, light, view, Fresnel::Perfect, placement)
                        .unwrap()
            });
            inside += a;
            brighter += b - a;
            off += (b - a).abs();
        }
    }
    (brighter / inside, off / inside)
}

#[test]
fn factored_masking_is_as_near_as_documented() {
    // Of cosines above 0.05 and above 0.3: the figures in the documentation of MaskingPlacement.
    let bounds = [(0.01, 1e-4, 1e-5), (0.1, 0.006, 1e-4), (0.4, 0.14, 0.025)];
    for kind in [Kind::Flakes, Kind::Noise, Kind::Scratches, Kind::Leather] {
        let map = sample_map(kind, 64, 64, 3, Wrap::Repeat);
        for (alpha, near_horizon, above) in bounds {
            let bytes = flake_package(&map, &[alpha]);
            let ndf = first_ndf(&bytes);
            for (least, bound) in [(0.05, near_horizon), (0.3, above)] {
                let (brighter, off) = factored_error(&ndf, &map, least);
                let what = format!("{} {alpha} {least}: {brighter} {off}", kind.name());
                assert!(off <= bound, "{what}");
                if alpha > 0.2 {
                    assert!(off > 0.005, "{what}: the two forms are the same");
                    assert!(brighter > 0.95 * off, "{what}: it errs to the bright side");
                }
            }
        }
    }
    // Mirror flakes have no normal but the half vector.
    let map = sample_map(Kind::Flakes, 64, 64, 3, Wrap::Repeat);
    let bytes = specular_package(&map, 15);
    let (_, off) = factored_error(&first_ndf(&bytes), &map, 0.05);
    assert!(off < 1e-12, "{off}");
}
