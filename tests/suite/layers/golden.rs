//! A material of the version that brought them opens and answers forever; see the tests of golden packages.
//!
//! `golden/v1/material-20.glint`, version 1.6: a coat of roughness 0.1, `lean` glints at α = 0.2 of a 20 × 13 map of flakes, repeated
//! 2 × 1.5 times under an opacity map of 5 × 3 texels, and a base; baked once by the first release that wrote such packages.

use super::open;
use crate::masking::direction;
use glintbake_format::model::Footprint;
use glintbake_format::{Container, check};
use glintbake_runtime::Composition;

const V1_6: &[u8] = include_bytes!("../../golden/v1/material-20.glint");

#[test]
fn version_1_6_is_sound_and_says_what_it_is() {
    let container = Container::open(V1_6).expect("a released version opens forever");
    check::full(&container, &mut |finding| panic!("{finding}"));
    assert_eq!(container.header().minor.get(), 6);
    let entries = container.entries().iter();
    let sections: Vec<_> = entries
        .map(|entry| format!("{} {}", entry.layer.get(), entry.kind))
        .collect();
    assert_eq!(
        sections,
        ["0 INST", "0 MATL", "0 META", "1 OPAC", "1 MEAN", "1 SPRD"]
    );
}

#[test]
fn version_1_6_answers_as_it_did() {
    let material = open(V1_6);
    let mut answers = Vec::new();
    for (edge, cosine) in [(0.0, 0.9), (0.05, 0.5), (0.7, 0.1)] {
        let patch = Footprint {
            centre: [0.31, 0.77],
            edge_1: [edge, 0.2 * edge],
            edge_2: [-0.1 * edge, 0.5 * edge],
        };
        let (light, view) = (direction(cosine, 0.1), direction(0.8, 0.55));
        for composition in [Composition::BothWays, Composition::HalfVector] {
            let material = material.with_composition(composition);
            let rgb = material.eval(&patch, light, view).unwrap();
            answers.push(format!("{edge} {cosine} {composition:?}: {}", digits(&rgb)));
        }
        let pdf = material.pdf(&patch, light, view).unwrap();
        let drawn = material
            .sample(&patch, view, [0.4, 0.3, 0.6, 0.7])
            .unwrap()
            .expect("drawn above the horizon");
        answers.push(format!("{edge} {cosine}: {pdf:.8e}, {}", digits(&drawn)));
    }
    insta::assert_json_snapshot!(answers);
}

/// Numbers to eight digits.
fn digits(numbers: &[f64]) -> String {
    let words: Vec<_> = numbers
        .iter()
        .map(|number| format!("{number:.8e}"))
        .collect();
    words.join(" ")
}
