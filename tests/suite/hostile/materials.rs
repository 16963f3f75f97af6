//! Lies about layers and opacity maps.

use super::*;
use glintbake_bake::PackagePlan;
use glintbake_format::SectionId;
use glintbake_format::records::{InstanceRecord, LayerRecord, MATERIAL, METADATA, OPACITY};
use glintbake_tests::materials::{Layer, material};

/// A small material of two maps, and an opacity map on each of two layers.
fn small_material() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 5, 3, 5, Wrap::Repeat);
    let recipe = MethodRecipe {
        masking: false,
        ..MethodRecipe::new(Method::Lean, &[0.4])
    };
    let texels = |count: u8| (0..count).map(|texel| texel.wrapping_mul(37)).collect();
    material(&[
        Layer::coat(1.5, 0.0).mapped(&map, recipe.clone()),
        Layer::glints(&map, recipe, [0.9; 3]).covering(5, 3, texels(15), Wrap::Clamp),
        Layer::base([0.04; 3], [0.5; 3], 0.3).covering(2, 2, texels(4), Wrap::Repeat),
    ])
}

/// The faults that structure finds in `bytes`, once they open.
fn faults(bytes: &[u8]) -> Vec<Fault> {
    let mut faults = Vec::new();
    match Container::open(bytes) {
        Ok(container) => check::structure(&container, &mut |finding| faults.push(finding.fault)),
        Err(finding) => faults.push(finding.fault),
    }
    faults
}

#[test]
fn a_sound_material_has_no_findings_and_every_flipped_bit_is_found() {
    let sound = small_material();
    check::full(&Container::open(&sound).unwrap(), &mut |finding| {
        panic!("{finding}")
    });
    interrogate(&sound);
    let mut bytes = sound.clone();
    for place in 0..bytes.len() {
        for bit in 0..8 {
            bytes[place] ^= 1 << bit;
            assert!(finds_something(&bytes), "bit {bit} of byte {place}");
            bytes[place] ^= 1 << bit;
        }
    }
}

#[test]
fn lies_in_layers_are_found_by_structure_alone_and_survived_by_queries() {
    let sound = small_material();
    let records = section_range(&sound, MATERIAL, 0).start;
    let float = |number: f32| number.to_le_bytes().to_vec();
    let cases: [(usize, usize, Vec<u8>, Fault); 22] = [
        // Kinds that are none, and kinds with numbers of others.
        (0, 0, vec![0], Fault::MaterialLayer),
        (0, 0, vec![4], Fault::MaterialLayer),
        (0, 0, vec![2], Fault::MaterialLayer),
        (1, 0, vec![3], Fault::MaterialLayer),
        // Instances that are not there, of another layer, or of none.
        (0, 2, vec![7], Fault::MaterialInstance),
        (0, 2, vec![2], Fault::MaterialInstance),
        (1, 2, vec![1], Fault::MaterialInstance),
        (1, 2, vec![0], Fault::MaterialLayer),
        (0, 4, float(0.0), Fault::MaterialLayer),
        (0, 8, float(f32::INFINITY), Fault::MaterialLayer),
        (1, 12, float(f32::NAN), Fault::MaterialLayer),
        (1, 20, float(1.5), Fault::MaterialLayer),
        (2, 24, float(-0.25), Fault::MaterialLayer),
        (2, 28, float(f32::NAN), Fault::MaterialLayer),
        (2, 36, float(0.0), Fault::MaterialLayer),
        (0, 36, float(0.5), Fault::ReservedNotZero),
        (2, 40, float(2.0), Fault::MaterialLayer),
        (0, 44, float(0.5), Fault::MaterialLayer),
        // Opacity maps of other sizes, of none, and where none is.
        (1, 48, vec![6], Fault::SectionCount),
        (2, 48, vec![0; 4], Fault::OpacityStray),
        (0, 48, vec![1, 0, 1, 0], Fault::SectionMissing),
        (0, 54, vec![1], Fault::ReservedNotZero),
    ];
    for (layer, offset, lie, fault) in cases {
        let mut bytes = sound.clone();
        let start = records + 64 * layer + offset;
        bytes[start..start + lie.len()].copy_from_slice(&lie);
        assert!(reseal(&mut bytes));
        let found = faults(&bytes);
        assert!(
            found.contains(&fault),
            "{layer} {offset} {lie:?}: {found:?}"
        );
        interrogate(&bytes);
    }
    // Half a size is none.
    let mut bytes = sound.clone();
    bytes[records + 64 + 50..records + 64 + 52].fill(0);
    assert!(reseal(&mut bytes));
    assert!(faults(&bytes).contains(&Fault::MaterialLayer));
    interrogate(&bytes);
}

#[test]
fn lies_in_opacity_maps_are_found_and_survived() {
    let sound = small_material();
    for place in section_range(&sound, OPACITY, 0) {
        let mut bytes = sound.clone();
        bytes[place] ^= 0xFF;
        assert!(reseal(&mut bytes));
        assert!(faults(&bytes).contains(&Fault::OpacityAverage), "{place}");
        interrogate(&bytes);
    }
}

#[test]
fn instances_of_no_layer_are_found() {
    let sound = small_material();
    let records = section_range(&sound, INSTANCES, 0).start;
    for layer in [0, 2, 9, 255] {
        let mut bytes = sound.clone();
        // The second instance, of layer 1.
        bytes[records + 64] = layer;
        assert!(reseal(&mut bytes));
        assert!(faults(&bytes).contains(&Fault::MaterialInstance), "{layer}");
        interrogate(&bytes);
    }
}

#[test]
fn a_material_has_one_to_eight_layers() {
    let base = Layer::base([0.04; 3], [0.5; 3], 0.3);
    let one = material(std::slice::from_ref(&base));
    let container = Container::open(&one).unwrap();
    let records: &[LayerRecord] = container.elements(SectionId::shared(MATERIAL)).unwrap();
    for count in [0, 1, 8, 9, 70_000] {
        let mut plan = PackagePlan::new([0; 32]);
        plan.add_critical(SectionId::shared(INSTANCES), Vec::<InstanceRecord>::new());
        plan.add(SectionId::shared(METADATA), b"{}".to_vec());
        plan.add(SectionId::shared(MATERIAL), vec![records[0]; count]);
        let bytes = plan.to_bytes();
        let expected: &[Fault] = if (1..=8).contains(&count) {
            &[]
        } else {
            &[Fault::MaterialCount]
        };
        assert_eq!(faults(&bytes), expected, "{count}");
        interrogate(&bytes);
    }
}
