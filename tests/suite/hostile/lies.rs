//! Lies in the sections of each method, and in the records of its instances.

use super::*;
use glintbake_format::records::{
    BLOCKED_BIN_MAP, FINE_STARTS, GLOBAL_NDF, GLOBAL_ROOT, INDEX, LEAVES, LIST_BLOCKS, LIST_COUNTS,
    LIST_KEYS, LIST_TILES, LISTS, LOBE_INDEX, LOBE_MOMENTS, LOBE_SPREADS, LOBES, MASKING, MEANS,
    MIP_BLOCKS, MIP_INDEX, NDF_COPIES, NDF_GRID, NDF_IMAGES, NDF_NEIGHBOURS, NDF_PIXELS, NDF_ROOT,
    NODES, NORMALS, PAGES, PYRAMID_NODES, PYRAMID_ROOT, QUILT_CUTS, QUILT_ORIGINS, ROOTS, SPREADS,
    WIDE_LOBES,
};

/// Section, instance, what is written everywhere in it, and the fault at least one place must be found under.
type Lie = (FourCc, u16, Vec<u8>, Fault);

fn every_lie_is_found_and_survived(sound: &[u8], cases: &[Lie]) {
    for (kind, instance, lie, fault) in cases {
        let mut bytes = sound.to_vec();
        let range = section_range(&bytes, *kind, *instance);
        // Lie about everything that can hold the lie, in turn: at least one place must be found under this fault.
        let mut found = false;
        for place in range.step_by(lie.len()) {
            let end = (place + lie.len()).min(bytes.len());
            let saved = bytes[place..end].to_vec();
            bytes[place..end].copy_from_slice(&lie[..end - place]);
            reseal(&mut bytes);
            if let Ok(container) = Container::open(&bytes) {
                check::structure(&container, &mut |finding| found |= finding.fault == *fault);
            }
            interrogate(&bytes);
            bytes[place..end].copy_from_slice(&saved);
        }
        assert!(
            found,
            "no lie in {kind} of {instance} was found as {fault:?}"
        );
    }
}

/// `sound` with one byte of its instance records changed, by its place among them.
fn with_record(sound: &[u8], (place, lie): (usize, u8)) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    let records = section_range(sound, INSTANCES, 0).start;
    bytes[records + place] = lie;
    assert!(reseal(&mut bytes));
    bytes
}

/// Changes one byte of the instance records at a time; the package must not open, for the reason given.
fn every_lie_in_a_record_is_refused(sound: &[u8], cases: &[(usize, u8, Fault)]) {
    for &(place, lie, fault) in cases {
        let bytes = with_record(sound, (place, lie));
        let finding = Container::open(&bytes).expect_err("a lying record does not open");
        assert_eq!(finding.fault, fault, "byte {place}: {finding}");
    }
}

#[test]
fn lies_in_the_data_are_found_by_structure_alone_and_survived_by_queries() {
    let cases: [Lie; 8] = [
        (FourCc(*b"BMAP"), 1, vec![0xFF; 2], Fault::KeyRange),
        (FourCc(*b"BMAP"), 1, vec![0x00; 4], Fault::PositionKey),
        (INDEX, 1, vec![0xFF; 4], Fault::IndexOrder),
        (FourCc(*b"BINS"), 2, vec![0xFF; 4], Fault::OccupiedBins),
        (INVERSE_BIN_MAP, 1, vec![0xFF; 4], Fault::PositionRange),
        (FOREST, 1, vec![0xFF; 16], Fault::ForestBox),
        (FOREST, 1, vec![0x00; 16], Fault::ForestBox),
        (MASKING, 1, vec![0xFF; 2], Fault::MaskingOrder),
    ];
    every_lie_is_found_and_survived(&small_package(), &cases);
}

#[test]
fn lies_in_block_lists_are_found_by_structure_alone_and_survived_by_queries() {
    let in_both: [Lie; 10] = [
        (BLOCKED_BIN_MAP, 1, vec![0xFF; 2], Fault::KeyRange),
        (BLOCKED_BIN_MAP, 1, vec![0x01, 0x00], Fault::KeyUnused),
        (BLOCKED_BIN_MAP, 1, vec![0x00; 8], Fault::ListCount),
        (PAGES, 1, vec![0xFF; 4], Fault::ListOrder),
        (PAGES, 1, vec![0x00; 4], Fault::ListOrder),
        (LISTS, 1, vec![0xFF; 4], Fault::ListOrder),
        (LISTS, 1, vec![0x01, 0, 0, 0], Fault::ListOrder),
        (LIST_BLOCKS, 1, vec![0xFF; 2], Fault::ListBlock),
        (LIST_COUNTS, 1, vec![0xFF], Fault::ListCount),
        (LIST_COUNTS, 1, vec![0x00], Fault::ListTotal),
    ];
    every_lie_is_found_and_survived(&small_tiles(), &in_both);
    every_lie_is_found_and_survived(&small_tiles_in_full(), &in_both);
    let in_full: [Lie; 6] = [
        (LIST_KEYS, 1, vec![0xFF; 4], Fault::ListKey),
        (LIST_KEYS, 1, vec![0x00; 4], Fault::ListKey),
        (LIST_KEYS, 1, vec![0x00; 4], Fault::ListCount),
        (LIST_TILES, 1, vec![0xFF; 2], Fault::ListTile),
        (LIST_TILES, 1, vec![0x00; 6], Fault::ListTile),
        (LIST_TILES, 1, vec![0x01, 0x10], Fault::ListTile),
    ];
    every_lie_is_found_and_survived(&small_tiles_in_full(), &in_full);
}

#[test]
fn lies_in_pyramids_are_found_by_structure_alone_and_survived_by_queries() {
    let sound = small_lean();
    let cases: [Lie; 6] = [
        (MEANS, 1, vec![0x00, 0x80], Fault::MeanRange),
        (MEANS, 1, vec![0xFF, 0x7F, 0xFF, 0x7F], Fault::MeanRange),
        (MEANS, 1, vec![0x11; 4], Fault::MeanAverage),
        (SPREADS, 1, vec![0xFF; 4], Fault::SpreadRange),
        (SPREADS, 1, vec![0, 0, 0, 0, 0x00, 0x80], Fault::SpreadRange),
        (SPREADS, 1, vec![0xFF; 6], Fault::SpreadRange),
    ];
    every_lie_is_found_and_survived(&sound, &cases);
    every_lie_in_a_record_is_refused(
        &sound,
        &[
            (24, 7, Fault::ReservedNotZero),
            (28, 1, Fault::ReservedNotZero),
            (32, 1, Fault::ReservedNotZero),
            (36, 1, Fault::ReservedNotZero),
            (38, 2, Fault::ReservedNotZero),
            (40, 9, Fault::ReservedNotZero),
            (44, 4, Fault::InstanceField),
            (44, 255, Fault::InstanceField),
            (48, 1, Fault::ReservedNotZero),
            (4, 1, Fault::InstanceField),
        ],
    );
    // A level that the pyramid does not have stored: sizes no longer fit.
    let bytes = with_record(&sound, (44, 1));
    let mut faults = Vec::new();
    check::structure(&Container::open(&bytes).unwrap(), &mut |finding| {
        faults.push(finding.fault);
    });
    assert!(faults.contains(&Fault::SectionCount), "{faults:?}");
    interrogate(&bytes);
}

#[test]
fn lies_in_trees_are_found_by_structure_alone_and_survived_by_queries() {
    let sound = small_tree();
    let below_one = (-0.5_f32).to_le_bytes().to_vec();
    let cases: [Lie; 8] = [
        (
            ROOTS,
            1,
            f32::NAN.to_le_bytes().to_vec(),
            Fault::ClusterRoot,
        ),
        (ROOTS, 1, below_one, Fault::ClusterRoot),
        (NODES, 1, vec![0xFF; 16], Fault::ClusterBox),
        (NODES, 1, vec![0xC0; 16], Fault::ClusterLeafKind),
        (NODES, 1, vec![0x00; 16], Fault::ClusterMoments),
        (LEAVES, 1, vec![0x00; 32], Fault::ClusterTexels),
        (LEAVES, 1, vec![0xFF; 64], Fault::ClusterUnused),
        (FINE_STARTS, 1, vec![0xFF; 4], Fault::ClusterLeafKind),
    ];
    every_lie_is_found_and_survived(&sound, &cases);
    every_lie_in_a_record_is_refused(
        &sound,
        &[
            (24, 7, Fault::ReservedNotZero),
            (28, 1, Fault::ReservedNotZero),
            (32, 1, Fault::ReservedNotZero),
            (36, 1, Fault::ReservedNotZero),
            (38, 2, Fault::ReservedNotZero),
            (40, 9, Fault::ReservedNotZero),
            (44, 1, Fault::ReservedNotZero),
            (48, 0, Fault::InstanceField),
            (48, 2, Fault::InstanceField),
            (48, 4, Fault::InstanceField),
            (49, 1, Fault::InstanceField),
            (50, 1, Fault::ReservedNotZero),
        ],
    );
    // Another size: the tree is not that of such a map, and the instance beside it has none to share.
    for record in [(8, 66), (12, 4), (64 + 8, 66)] {
        let bytes = with_record(&sound, record);
        assert!(finds_something_in_structure(&bytes), "{record:?}");
        interrogate(&bytes);
    }
}

#[test]
fn lies_in_lobes_are_found_by_structure_alone_and_survived_by_queries() {
    let sound = small_lobes();
    let nan = || f32::NAN.to_le_bytes().to_vec();
    let cases: [Lie; 19] = [
        (PYRAMID_ROOT, 1, nan(), Fault::PyramidRoot),
        (
            PYRAMID_ROOT,
            1,
            (-1.0_f32).to_le_bytes().to_vec(),
            Fault::PyramidRoot,
        ),
        (
            PYRAMID_ROOT,
            1,
            1e30_f32.to_le_bytes().to_vec(),
            Fault::PyramidRoot,
        ),
        (PYRAMID_NODES, 1, vec![0xFF; 16], Fault::PyramidBox),
        (PYRAMID_NODES, 1, vec![0x00; 16], Fault::LobeBox),
        // Blocks that no cell has, that two nodes share, that are stored twice or far away.
        (LOBE_INDEX, 1, vec![0xFF; 12], Fault::LobeIndex),
        (LOBE_INDEX, 1, vec![0xFF; 4], Fault::LobeIndex),
        (LOBE_INDEX, 1, vec![0xFF; 2], Fault::LobeIndex),
        (LOBE_INDEX, 1, vec![0x00; 12], Fault::LobeIndex),
        (LOBE_INDEX, 1, vec![0x01, 0x00], Fault::LobeIndex),
        // Steps and slopes that are no numbers, or reach far.
        (LOBES, 1, nan(), Fault::LobeRange),
        (LOBES, 1, vec![0xFF; 64], Fault::LobeUnused),
        (LOBES, 1, vec![0x00; 64], Fault::LobeMoments),
        (WIDE_LOBES, 1, nan(), Fault::LobeRange),
        (
            WIDE_LOBES,
            1,
            3.0_f32.to_le_bytes().to_vec(),
            Fault::LobeBox,
        ),
        // Spreads that are no numbers, and less than what lobes spread.
        (LOBE_SPREADS, 1, nan(), Fault::LobeRange),
        (LOBE_SPREADS, 1, vec![0x00; 20], Fault::LobeBox),
        (LOBE_MOMENTS, 1, nan(), Fault::LobeRange),
        (LOBE_MOMENTS, 1, vec![0x00; 64], Fault::LobeMoments),
    ];
    every_lie_is_found_and_survived(&sound, &cases);
    every_lie_in_a_record_is_refused(
        &sound,
        &[
            (24, 7, Fault::ReservedNotZero),
            (32, 1, Fault::ReservedNotZero),
            (38, 2, Fault::ReservedNotZero),
            (44, 1, Fault::ReservedNotZero),
            (48, 1, Fault::ReservedNotZero),
            (50, 1, Fault::ReservedNotZero),
            (51, 0, Fault::InstanceField),
            (51, 3, Fault::InstanceField),
            (52, 2, Fault::InstanceField),
            (53, 1, Fault::ReservedNotZero),
        ],
    );
    // Another size, four lobes a texel, or flat ones: the lobes are not those of such a lattice, or of none to share.
    for (place, lie) in [
        (8, 30),
        (12, 30),
        (64 + 8, 66),
        (51, 2),
        (52, 0),
        (64 + 51, 2),
    ] {
        let bytes = with_record(&sound, (place, lie));
        interrogate(&bytes);
        // Flat lobes beside slopes that nobody reads are no fault.
        if place != 52 {
            assert!(finds_something_in_structure(&bytes), "byte {place}");
        }
    }
}

#[test]
fn lies_in_surfaces_are_found_by_structure_alone_and_survived_by_queries() {
    let sound = small_surface();
    let number = |x: f32| x.to_le_bytes().to_vec();
    let cases: [Lie; 11] = [
        (PYRAMID_ROOT, 1, number(f32::NAN), Fault::PyramidRoot),
        (PYRAMID_ROOT, 1, number(1e30), Fault::PyramidRoot),
        (PYRAMID_NODES, 1, vec![0xFF; 16], Fault::PyramidBox),
        (PYRAMID_NODES, 1, vec![0x00; 16], Fault::SurfaceBox),
        (NORMALS, 1, number(f32::NAN), Fault::SurfaceNormal),
        (NORMALS, 1, number(1.1), Fault::SurfaceNormal),
        (NORMALS, 1, number(-0.9), Fault::SurfaceBox),
        (GLOBAL_ROOT, 1, number(f32::NAN), Fault::GlobalRoot),
        (GLOBAL_ROOT, 2, number(-1.0), Fault::GlobalRoot),
        (GLOBAL_NDF, 1, vec![0x00; 4], Fault::GlobalOrder),
        (GLOBAL_NDF, 2, vec![0xFF; 4], Fault::GlobalOrder),
    ];
    every_lie_is_found_and_survived(&sound, &cases);
    every_lie_in_a_record_is_refused(
        &sound,
        &[
            (24, 7, Fault::ReservedNotZero),
            (44, 1, Fault::ReservedNotZero),
            (48, 1, Fault::ReservedNotZero),
            (50, 3, Fault::InstanceField),
            (51, 1, Fault::ReservedNotZero),
            (52, 1, Fault::ReservedNotZero),
        ],
    );
    for record in [(8, 30), (12, 30), (64 + 8, 66), (64 + 50, 1)] {
        let bytes = with_record(&sound, record);
        assert!(finds_something_in_structure(&bytes), "{record:?}");
        interrogate(&bytes);
    }
}

#[test]
fn every_mask_of_blocks_is_survived() {
    // Masks say where in the sections each block lies: of every bit of every node, one alone, and all but one.
    let sound = small_lobes();
    let index = section_range(&sound, LOBE_INDEX, 1);
    for place in index.step_by(2) {
        for bit in 0..16_u32 {
            for mask in [1_u16 << bit, !(1 << bit)] {
                let mut bytes = sound.clone();
                bytes[place..place + 2].copy_from_slice(&mask.to_le_bytes());
                assert!(reseal(&mut bytes));
                interrogate(&bytes);
            }
        }
    }
}

fn finds_something_in_structure(bytes: &[u8]) -> bool {
    let mut found = false;
    let container = Container::open(bytes).expect("its record is in order");
    check::structure(&container, &mut |_| found = true);
    found
}

#[test]
fn lies_in_quilts_are_found_by_structure_alone_and_survived_by_queries() {
    let sound = small_quilt();
    let number = |x: f32| x.to_le_bytes().to_vec();
    let cases: [Lie; 12] = [
        (NORMALS, 1, number(f32::NAN), Fault::SurfaceNormal),
        (NORMALS, 1, number(1.1), Fault::SurfaceNormal),
        (QUILT_ORIGINS, 1, vec![0xFF; 2], Fault::QuiltOrigin),
        (QUILT_ORIGINS, 1, vec![0x01, 0x00], Fault::QuiltOrigin),
        (QUILT_ORIGINS, 1, vec![0xFF; 2], Fault::MipIndex),
        (QUILT_CUTS, 1, vec![0x02], Fault::QuiltCut),
        (MIP_INDEX, 1, vec![0xFF; 4], Fault::MipIndex),
        (MIP_INDEX, 1, vec![0x00; 4], Fault::MipIndex),
        (MIP_BLOCKS, 1, number(f32::NAN), Fault::MipLobe),
        (MIP_BLOCKS, 1, vec![0xFF; 2], Fault::MipWeight),
        (MIP_BLOCKS, 1, vec![0x00; 2], Fault::MipLobe),
        (MIP_BLOCKS, 1, vec![0x00; 32], Fault::MipWeight),
    ];
    every_lie_is_found_and_survived(&sound, &cases);
    every_lie_in_a_record_is_refused(
        &sound,
        &[
            (6, 1, Fault::InstanceField),
            (8, 12, Fault::InstanceField),
            (51, 3, Fault::InstanceField),
            (52, 0, Fault::ReservedNotZero),
            (53, 2, Fault::InstanceField),
            (53, 13, Fault::InstanceField),
            (54, 5, Fault::InstanceField),
            (55, 4, Fault::InstanceField),
            (56, 0, Fault::InstanceField),
            (56, 4, Fault::InstanceField),
            (57, 0, Fault::InstanceField),
            (57, 17, Fault::InstanceField),
            (58, 1, Fault::ReservedNotZero),
            (60, 8, Fault::InstanceField),
            (24, 7, Fault::ReservedNotZero),
        ],
    );
}

#[test]
fn lies_in_copies_are_found_by_structure_alone_and_survived_by_queries() {
    let sound = small_copies();
    let number = |x: f64| x.to_le_bytes().to_vec();
    let cases: [Lie; 16] = [
        (
            NORMALS,
            1,
            1.1_f32.to_le_bytes().to_vec(),
            Fault::SurfaceNormal,
        ),
        (NDF_ROOT, 1, number(f64::NAN), Fault::NdfRoot),
        (NDF_ROOT, 1, number(0.0), Fault::NdfRoot),
        (NDF_ROOT, 1, number(1e9), Fault::NdfRoot),
        (NDF_IMAGES, 1, vec![0xFF; 4], Fault::NdfImage),
        (NDF_IMAGES, 1, vec![0x00, 0x00, 0x00, 0x7F], Fault::NdfImage),
        (NDF_IMAGES, 1, vec![0x00; 16], Fault::NdfImage),
        (NDF_PIXELS, 1, vec![0x01, 0x00], Fault::NdfPixel),
        (NDF_COPIES, 1, vec![0xFF; 4], Fault::NdfCopy),
        (NDF_COPIES, 1, vec![0x00; 24], Fault::NdfCopy),
        (NDF_COPIES, 1, vec![0xFF; 24], Fault::NdfCopy),
        (NDF_COPIES, 1, vec![0xFF; 24], Fault::NdfNeighbour),
        (NDF_NEIGHBOURS, 1, vec![0xFF; 4], Fault::NdfNeighbour),
        (NDF_GRID, 1, vec![0xFF; 4], Fault::NdfGrid),
        (NDF_GRID, 1, vec![0x01, 0x00, 0x00, 0x00], Fault::NdfGrid),
        (NDF_GRID, 1, vec![0x00; 4], Fault::NdfGrid),
    ];
    every_lie_is_found_and_survived(&sound, &cases);
    every_lie_in_a_record_is_refused(
        &sound,
        &[
            (8, 12, Fault::InstanceField),
            (12, 12, Fault::InstanceField),
            (24, 7, Fault::ReservedNotZero),
            (58, 0, Fault::InstanceField),
            (58, 3, Fault::InstanceField),
            (59, 4, Fault::ReservedNotZero),
            (60, 3, Fault::InstanceField),
            (60, 64, Fault::InstanceField),
            (62, 8, Fault::InstanceField),
        ],
    );
}
