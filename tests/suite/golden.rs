//! Packages of every released format version open and answer forever.
//!
//! They were baked once by the first release that wrote such packages, and are never baked again:
//!
//! - `golden/v1/noise-32.glint`, version 1.0: `flake-bins` at α = 0.9 (dense index) and 0.0005 (sparse index, exact
//!   normals), and `specular-bins` with 5 bins a side, of a 32 × 32 map of noise; forests of positions.
//! - `golden/v1/scratches-96.glint`, version 1.1: `flake-bins` at α = 0.9 of a 96 × 93 map of scratches; a bin map in
//!   blocks, block lists with keys and tiles, masking.
//! - `golden/v1/lean-24.glint`, version 1.2: `lean` at α = 0.05 and 0.004 (means to 32 bits) of a 24 × 21 map of scratches;
//!   one pyramid for both, masking.

use glintbake_format::model::{Footprint, HalfVector, Method};
use glintbake_format::records::{IndexKind, InverseKind, Structure};
use glintbake_format::{Container, check};
use glintbake_runtime::{Ndf, Package, Setting};

const V1: &[u8] = include_bytes!("../golden/v1/noise-32.glint");
const V1_2: &[u8] = include_bytes!("../golden/v1/lean-24.glint");
const V1_1: &[u8] = include_bytes!("../golden/v1/scratches-96.glint");

#[test]
fn version_1_is_sound_and_says_what_it_is() {
    let container = Container::open(V1).expect("a released version opens forever");
    check::full(&container, &mut |finding| panic!("{finding}"));
    let package = Package::open(V1).unwrap();
    let instances: Vec<_> = package.instances().collect();
    assert_eq!(
        instances
            .iter()
            .map(|instance| (
                instance.method,
                instance.roughness,
                instance.bins().unwrap().index
            ))
            .collect::<Vec<_>>(),
        [
            (Method::FlakeBins, Some(0.9), IndexKind::Dense),
            (Method::FlakeBins, Some(0.0005), IndexKind::Sparse),
            (Method::SpecularBins, None, IndexKind::Dense),
        ]
    );
}

#[test]
fn version_1_answers_as_it_did() {
    insta::assert_json_snapshot!(answers(V1));
}

#[test]
fn version_1_1_is_sound_and_says_what_it_is() {
    let container = Container::open(V1_1).expect("a released version opens forever");
    check::full(&container, &mut |finding| panic!("{finding}"));
    let instance = container.instances().next().unwrap().unwrap();
    assert_eq!(
        (
            instance.method,
            instance.roughness,
            instance.bins().unwrap().inverse
        ),
        (Method::FlakeBins, Some(0.9), InverseKind::Tiles)
    );
    let kinds: Vec<_> = container
        .entries()
        .iter()
        .map(|entry| entry.kind.to_string())
        .collect();
    assert_eq!(
        kinds,
        [
            "INST", "META", "LBLK", "LCNT", "LIST", "LKEY", "LTIL", "MASK", "PAGE", "TMAP"
        ]
    );
}

#[test]
fn version_1_1_answers_as_it_did() {
    let mut answers = answers(V1_1);
    let ndf = Package::open(V1_1).unwrap().ndf(1).unwrap();
    for [s, t] in [[0.0, 0.0], [0.6, 0.3], [-0.99, 0.1]] {
        let direction = HalfVector { s, t }.direction();
        let g1 = ndf.masking().g1(direction);
        answers.push(format!("masking {s} {t}: {g1:.8e}"));
    }
    insta::assert_json_snapshot!(answers);
}

#[test]
fn version_1_2_is_sound_and_says_what_it_is() {
    let container = Container::open(V1_2).expect("a released version opens forever");
    check::full(&container, &mut |finding| panic!("{finding}"));
    assert_eq!(container.header().minor.get(), 2);
    let instances: Vec<_> = container.instances().map(Result::unwrap).collect();
    let structure = Structure::Pyramid { finest_level: 0 };
    assert_eq!(
        instances
            .iter()
            .map(|instance| (instance.method, instance.roughness, instance.structure))
            .collect::<Vec<_>>(),
        [
            (Method::Lean, Some(0.05), structure),
            (Method::Lean, Some(0.004), structure),
        ]
    );
    let kinds: Vec<_> = container
        .entries()
        .iter()
        .map(|entry| entry.kind.to_string())
        .collect();
    assert_eq!(kinds, ["INST", "META", "MASK", "MEAN", "SPRD"]);
}

#[test]
fn version_1_2_answers_as_it_did() {
    insta::assert_json_snapshot!(answers(V1_2));
}

/// Densities and samples of every instance and setting of the package `bytes`.
fn answers(bytes: &[u8]) -> Vec<String> {
    let package = Package::open(bytes).unwrap();
    let footprint = Footprint {
        centre: [0.4, 0.7],
        edge_1: [0.31, 0.05],
        edge_2: [-0.11, 0.42],
    };
    let mut answers = Vec::new();
    for instance in package.instances() {
        let mut ndf = package.ndf(instance.number).unwrap();
        for exact in [false, true] {
            if exact {
                match ndf.with_setting(Setting::Exact) {
                    Ok(exact) => ndf = exact,
                    Err(_) => continue,
                }
            }
            for (s, t) in [(0.0, 0.0), (0.05, -0.03), (-0.1, 0.12), (0.3, 0.2)] {
                let h = HalfVector { s, t };
                let density = ndf.eval(&footprint, h).unwrap();
                // Nine digits: later releases may round differently in the last few.
                answers.push(format!(
                    "{} {} {s} {t}: {density:.8e}",
                    instance.number,
                    ndf.setting_name()
                ));
            }
            let uniform = [0.3, 0.6, 0.2, 0.9];
            let sample = ndf.sample(&footprint, uniform).unwrap();
            answers.push(match sample {
                Some(h) => format!("{} sample {:.8} {:.8}", instance.number, h.s, h.t),
                None => format!("{} no sample", instance.number),
            });
        }
    }
    answers
}
