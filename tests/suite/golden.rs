//! Packages of every released format version open and answer forever.
//!
//! `golden/v1/noise-32.glint` was baked once by the first release; it is never baked again. It holds `flake-bins` at
//! α = 0.9 (dense index) and 0.0005 (sparse index, exact normals), and `specular-bins` with 5 bins a side, of a
//! 32 × 32 map of noise.

use glintbake_format::model::{Footprint, HalfVector, Method};
use glintbake_format::records::IndexKind;
use glintbake_format::{Container, check};
use glintbake_runtime::{Ndf, Package, Setting};

const V1: &[u8] = include_bytes!("../golden/v1/noise-32.glint");

#[test]
fn version_1_is_sound_and_says_what_it_is() {
    let container = Container::open(V1).expect("a released version opens forever");
    check::full(&container, &mut |finding| panic!("{finding}"));
    let package = Package::open(V1).unwrap();
    let instances: Vec<_> = package.instances().collect();
    assert_eq!(
        instances
            .iter()
            .map(|instance| (instance.method, instance.roughness, instance.index))
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
    let package = Package::open(V1).unwrap();
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
    insta::assert_json_snapshot!(answers);
}
