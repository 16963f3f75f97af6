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
//! - `golden/v1/tree-260.glint`, version 1.3: `cluster-tree` with α = 0.05 and 0.004 for queries that name none, of a 260 × 17
//!   map of flakes, noise and waves (`mixed_map` of seed 7); one tree for both, of three levels of tiles and up to three
//!   of nodes, with leaves of every kind, masking.
//! - `golden/v1/lobes-60.glint`, version 1.4: `lobes`, curved and one a texel, at α = 0.05 and 0.004, and `analytic`, linear, at
//!   α = 0.05, of a 60 × 23 map of flakes, noise and waves (`mixed_map` of seed 7); blocks in 16 bits and wide ones, masking.
//! - `golden/v1/quilt-24.glint`, version 1.5: `mip-lobes`, 16 clusters, at α = 0.05, 64 × 32 texels quilted from 24 × 32 of waves by
//!   patches of 16.

use glintbake_format::model::{
    Filter, Footprint, HalfVector, Interpolation, Kernel, LobeLattice, Method, MipLayout,
    QuiltLayout,
};
use glintbake_format::records::ClusterNode;
use glintbake_format::records::{IndexKind, InverseKind, LeafKind, NODES, Structure};
use glintbake_format::{Container, check};
use glintbake_runtime::{Accuracy, Ndf, Package, Setting, SurfaceNdf};

const V1: &[u8] = include_bytes!("../golden/v1/noise-32.glint");
const V1_2: &[u8] = include_bytes!("../golden/v1/lean-24.glint");
const V1_3: &[u8] = include_bytes!("../golden/v1/tree-260.glint");
const V1_4: &[u8] = include_bytes!("../golden/v1/lobes-60.glint");
const V1_5: &[u8] = include_bytes!("../golden/v1/quilt-24.glint");
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

#[test]
fn version_1_3_is_sound_and_says_what_it_is() {
    let container = Container::open(V1_3).expect("a released version opens forever");
    check::full(&container, &mut |finding| panic!("{finding}"));
    assert_eq!(container.header().minor.get(), 3);
    let instances: Vec<_> = container.instances().map(Result::unwrap).collect();
    let structure = Structure::Clusters {
        kernel: Kernel::Beckmann,
    };
    assert_eq!(
        instances
            .iter()
            .map(|instance| (instance.method, instance.roughness, instance.structure))
            .collect::<Vec<_>>(),
        [
            (Method::ClusterTree, Some(0.05), structure),
            (Method::ClusterTree, Some(0.004), structure),
        ]
    );
    let kinds: Vec<_> = container
        .entries()
        .iter()
        .map(|entry| entry.kind.to_string())
        .collect();
    assert_eq!(
        kinds,
        [
            "INST", "META", "FINE", "FNDX", "LEAF", "MASK", "NODE", "ROOT"
        ]
    );
    let nodes: &[ClusterNode] = container.elements(instances[0].section(NODES)).unwrap();
    for kind in [LeafKind::Narrow, LeafKind::Palette, LeafKind::Wide] {
        let mut kinds = nodes.iter().flat_map(|node| node.deviation_xy);
        assert!(
            kinds.any(|byte| LeafKind::of(byte) == Some(kind)),
            "{kind:?}"
        );
    }
}

#[test]
fn version_1_3_answers_as_it_did() {
    let package = Package::open(V1_3).unwrap();
    let SurfaceNdf::ClusterTree(tree) = package.ndf(1).unwrap() else {
        panic!("baked for cluster-tree");
    };
    let mut answers = Vec::new();
    // The sum itself, whatever later releases skip: rounding is all they may differ by.
    let tree = tree.with_accuracy(Accuracy::Fast(1e-9));
    for (kernel, filter, alpha) in [
        (Kernel::Beckmann, Filter::Box, 0.05),
        (Kernel::Disk, Filter::Gaussian, 0.05),
        (Kernel::Disk, Filter::Box, 0.01),
        (Kernel::Beckmann, Filter::Gaussian, 0.3),
    ] {
        let ndf = tree.with_filter(filter).with_kernel(kernel);
        let ndf = ndf.and_then(|ndf| ndf.with_roughness(alpha)).unwrap();
        let asked = format!("{} {} {alpha}", kernel.name(), filter.name());
        answers.extend(answers_under_shapes(&ndf, &asked));
    }
    insta::assert_json_snapshot!(answers);
}

#[test]
fn version_1_4_is_sound_and_says_what_it_is() {
    let container = Container::open(V1_4).expect("a released version opens forever");
    check::full(&container, &mut |finding| panic!("{finding}"));
    assert_eq!(container.header().minor.get(), 4);
    let instances: Vec<_> = container.instances().map(Result::unwrap).collect();
    let lattice = Structure::Lobes(LobeLattice {
        curved: true,
        per_side: 1,
    });
    let surface = Structure::Surface {
        interpolation: Interpolation::Linear,
    };
    assert_eq!(
        instances
            .iter()
            .map(|instance| (instance.method, instance.roughness, instance.structure))
            .collect::<Vec<_>>(),
        [
            (Method::Lobes, Some(0.05), lattice),
            (Method::Lobes, Some(0.004), lattice),
            (Method::Analytic, Some(0.05), surface),
        ]
    );
    let kinds: Vec<_> = container
        .entries()
        .iter()
        .map(|entry| entry.kind.to_string())
        .collect();
    assert_eq!(
        kinds,
        [
            "INST", "META", "LOBE", "LOBW", "LOIX", "LOMO", "LOSD", "MASK", "PYRN", "PYRR", "GNDF",
            "GNDR", "NRML", "PYRN", "PYRR"
        ]
    );
}

#[test]
fn version_1_4_answers_as_it_did() {
    let package = Package::open(V1_4).unwrap();
    let mut answers = Vec::new();
    for number in 1..=3 {
        let ndf = package.ndf(number).unwrap();
        let method = ndf.instance().method.name();
        answers.extend(answers_under_shapes(&ndf, &format!("{method} {number}")));
    }
    insta::assert_json_snapshot!(answers);
}

#[test]
fn version_1_5_is_sound_and_says_what_it_is() {
    let container = Container::open(V1_5).expect("a released version opens forever");
    check::full(&container, &mut |finding| panic!("{finding}"));
    assert_eq!(container.header().minor.get(), 5);
    let instances: Vec<_> = container.instances().map(Result::unwrap).collect();
    let layout = MipLayout {
        size: [64, 32],
        per_side: 2,
        first_level: 2,
        blocks: 1,
        quilt: QuiltLayout::new([64, 32], [24, 32], 4, 2, 3),
    };
    assert!(layout.quilt.is_some());
    assert_eq!(
        instances
            .iter()
            .map(|instance| (instance.method, instance.roughness, instance.structure))
            .collect::<Vec<_>>(),
        [(Method::MipLobes, Some(0.05), Structure::MipLobes(layout))]
    );
    let kinds: Vec<_> = container
        .entries()
        .iter()
        .map(|entry| entry.kind.to_string())
        .collect();
    assert_eq!(
        kinds,
        [
            "INST", "META", "MASK", "MLIX", "MLOB", "NRML", "QCUT", "QORG"
        ]
    );
}

#[test]
fn version_1_5_answers_as_it_did() {
    let package = Package::open(V1_5).unwrap();
    let ndf = package.ndf(1).unwrap();
    insta::assert_json_snapshot!(answers_under_shapes(&ndf, "mip-lobes 1"));
}

/// Densities under footprints from less than a texel to tiles.
fn answers_under_shapes(ndf: &impl Ndf, asked: &str) -> Vec<String> {
    let mut answers = Vec::new();
    for (size, centre) in [
        (0.002, [0.3, 0.4]),
        (0.05, [0.45, 0.9]),
        (0.7, [0.6, 0.2]),
        (2.3, [0.1, 0.1]),
    ] {
        let footprint = Footprint {
            centre,
            edge_1: [size, 0.1 * size],
            edge_2: [-0.2 * size, size],
        };
        for (s, t) in [(-0.16, -0.07), (0.05, -0.05), (0.3, 0.2)] {
            let density = ndf.eval(&footprint, HalfVector { s, t }).unwrap();
            // Five digits: leaves and moments are summed in single precision. Less than a flank is none.
            let density = match density {
                ..1e-3 => "none".to_owned(),
                _ => format!("{density:.4e}"),
            };
            answers.push(format!("{asked} {size}: {s} {t} {density}"));
        }
    }
    answers
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
