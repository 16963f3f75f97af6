//! The white furnace: of light that arrives from everywhere no more than arrives leaves.

use super::{car_paint, open};
use crate::masking::{WHOLE_TILE, direction};
use glintbake_runtime::{Composition, Material};
use glintbake_tests::fixtures::Stream;
use glintbake_tests::materials::{Layer, material};

/// The share of light from `view` that leaves again, by colour, by samples of the material's own sampler.
fn albedo(material: &Material<'_>, view: [f64; 3], samples: u32) -> [f64; 3] {
    let mut stream = Stream::new(6);
    let mut sum = [0.0; 3];
    for index in 0..samples {
        let mut uniform: [f64; 4] = std::array::from_fn(|_| stream.uniform());
        // Lobes in proportion, exactly.
        uniform[0] = (f64::from(index) + uniform[0]) / f64::from(samples);
        if let Some(light) = material.sample(&WHOLE_TILE, view, uniform).unwrap() {
            let f = material.eval(&WHOLE_TILE, light, view).unwrap();
            let pdf = material.pdf(&WHOLE_TILE, light, view).unwrap();
            assert!(pdf > 0.0, "a sampled direction has a density");
            for (sum, f) in sum.iter_mut().zip(f) {
                *sum += f * light[2] / pdf;
            }
        }
    }
    sum.map(|sum| sum / f64::from(samples))
}

#[test]
fn car_paint_sends_out_no_more_than_arrives() {
    for (alpha, coat) in [(0.05, 0.002), (0.05, 0.1), (0.2, 0.3)] {
        let mut layers = car_paint(alpha, coat);
        // As bright as can be.
        layers[1].recipe.f0 = [1.0; 3];
        layers[2].recipe.colour = [1.0; 3];
        let bytes = material(&layers);
        let material = open(&bytes);
        let material = material
            .with_ndfs(|_, ndf| ndf.with_setting(glintbake_runtime::Setting::Exact))
            .unwrap();
        for cosine in [1.0, 0.7, 0.3, 0.1, 0.03] {
            let [red, _, blue] = albedo(&material, direction(cosine, 0.1), 3000);
            let what = format!("{alpha} {coat} {cosine}: {red} {blue}");
            assert!(red <= 1.0 + 0.01 && blue <= 1.0 + 0.01, "{what}");
            // Single scattering loses light of rough facets towards the horizon.
            assert!(cosine < 0.2 || red > 0.45, "{what}");
        }
    }
}

#[test]
fn glass_over_white_keeps_energy_unlike_equation_3_with_the_half_vector() {
    for roughness in [0.001, 0.1, 0.4] {
        let layers = [
            Layer::coat(1.5, roughness),
            Layer::base([0.04; 3], [1.0; 3], 0.1),
        ];
        let bytes = material(&layers);
        let material = open(&bytes);
        let mut brightest: f64 = 0.0;
        for cosine in [1.0, 0.5, 0.2, 0.1, 0.03] {
            let view = direction(cosine, 0.3);
            let [kept, ..] = albedo(&material, view, 6000);
            let what = format!("{roughness} {cosine}: {kept}");
            assert!(kept <= 1.0 + 0.01 && kept > 0.25, "{what}");
            let paper = material.with_composition(Composition::HalfVector);
            let [paper, ..] = albedo(&paper, view, 6000);
            assert!(paper > kept, "{what} {paper}");
            brightest = brightest.max(paper);
        }
        // The figure in the documentation of layers.
        if roughness == 0.001 {
            assert!(brightest > 1.15 && brightest < 1.25, "{brightest}");
        }
    }
}

#[test]
fn a_coat_of_no_index_and_no_colour_is_not_there() {
    let base = Layer::base([0.04; 3], [0.3, 0.5, 0.7], 0.4);
    let bare = material(std::slice::from_ref(&base));
    let coated = material(&[Layer::coat(1.0, 0.3), base]);
    let (bare, coated) = (open(&bare), open(&coated));
    for cosine in [1.0, 0.3, 0.01] {
        let (light, view) = (direction(cosine, 0.6), direction(0.4, 0.2));
        let [one, other] = [bare, coated].map(|it| it.eval(&WHOLE_TILE, light, view).unwrap());
        assert_eq!(one, other);
    }
}
