//! Damaged and lying packages: a typed finding, never a panic, a hang or a wrong number that looks right.

mod lies;
mod materials;

use glintbake_bake::noise::{NoiseOptions, generate};
use glintbake_bake::{MethodRecipe, NdfCopies, NdfMapRecipe, QuiltRecipe};
use glintbake_format::model::{
    Filter, Footprint, HalfVector, Interpolation, LobeLattice, Method, Neighbourhood, Wrap,
};
use glintbake_format::records::{FOREST, INSTANCES, INVERSE_BIN_MAP, LIST_BLOCKS, LISTS, PAGES};
use glintbake_format::{Container, ENTRY_LENGTH, Fault, FourCc, HEADER_LENGTH, check};
use glintbake_runtime::{Ndf, Package, Setting};
use glintbake_samples::Kind;
use glintbake_tests::exercise::interrogate;
use glintbake_tests::fixtures::{
    Stream, flake_package, forest_package, lean_package, lobes_package, mixed_map, package,
    sample_map, specular_package, surface_package, tree_package,
};
use glintbake_tests::lies::{reseal, section_range};
use glintbake_tests::{naive_lists, small_surfaces};
use proptest::prelude::*;
use std::sync::Arc;

/// A small package with every kind of section of a forest: dense and sparse index, exact normals, masking.
fn small_package() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 12, 10, 5, Wrap::Repeat);
    forest_package(&map, &[0.4, 0.002], 2)
}

/// A small package of block lists without keys and tiles, and with a bin map in blocks that reach beyond the map.
fn small_tiles() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 16, 13, 5, Wrap::Repeat);
    flake_package(&map, &[0.4, 0.002])
}

/// A small package of block lists with keys and tiles.
fn small_tiles_in_full() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 16, 13, 5, Wrap::Repeat);
    naive_lists::package(&map, 0.02)
}

/// A small package of two instances that share a pyramid, part of which halves evenly.
fn small_lean() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 12, 10, 5, Wrap::Repeat);
    lean_package(&map, &[0.4, 0.02])
}

/// A small package of two instances that share a tree, with tiles of two levels and leaves of every kind.
fn small_tree() -> Vec<u8> {
    let recipe = MethodRecipe {
        masking: false,
        ..MethodRecipe::new(Method::ClusterTree, &[0.4, 0.02])
    };
    package(&mixed_map(65, 3, 3, Wrap::Repeat), recipe)
}

/// A small package of two instances that share lobes of three nodes, with blocks of every kind, two of which reach beyond the map.
fn small_lobes() -> Vec<u8> {
    let recipe = MethodRecipe {
        masking: false,
        ..MethodRecipe::new(Method::Lobes, &[0.4, 0.06])
    };
    package(&mixed_map(17, 9, 3, Wrap::Repeat), recipe)
}

/// A small package of two instances that share a surface of three nodes.
fn small_surface() -> Vec<u8> {
    let map = mixed_map(17, 6, 3, Wrap::Clamp);
    small_surfaces::package(&map, Interpolation::CatmullRom, &[0.4, 0.02])
}

fn finds_something(bytes: &[u8]) -> bool {
    match Container::open(bytes) {
        Err(_) => true,
        Ok(container) => {
            let mut found = false;
            check::full(&container, &mut |_| found = true);
            found
        }
    }
}

fn lattice(curved: bool, per_side: u8) -> LobeLattice {
    LobeLattice { curved, per_side }
}

/// A small package of a quilted surface, with cells of the sample and of the surface.
fn small_quilt() -> Vec<u8> {
    let map = sample_map(Kind::Waves, 16, 24, 5, Wrap::Repeat);
    let quilt = QuiltRecipe {
        patch: Some(8),
        overlap: 1,
        ..QuiltRecipe::new([16, 8])
    };
    let recipe = MethodRecipe {
        clusters: Some(16),
        lattice: Some(lattice(true, 1)),
        quilt: Some(quilt),
        masking: false,
        ..MethodRecipe::new(Method::MipLobes, &[0.2, 0.1])
    };
    package(&map, recipe)
}

/// A small package of scattered copies of which some hide parts of others.
fn small_copies() -> Vec<u8> {
    let example = sample_map(Kind::Waves, 4, 4, 5, Wrap::Repeat);
    let noise = generate(&NoiseOptions::new(24, 3)).expect("in range");
    let asked = NdfMapRecipe {
        size: Some(16),
        copies: NdfCopies::Scattered(Arc::new(noise)),
        ..NdfMapRecipe::default()
    };
    let recipe = MethodRecipe {
        ndf_maps: Some(asked),
        masking: false,
        ..MethodRecipe::new(Method::NdfMaps, &[0.3])
    };
    package(&example, recipe)
}

#[test]
fn a_sound_package_has_no_findings() {
    let map = sample_map(Kind::Noise, 40, 33, 5, Wrap::Clamp);
    for bytes in [
        small_package(),
        small_tiles(),
        small_tiles_in_full(),
        small_lean(),
        small_tree(),
        small_lobes(),
        small_surface(),
        small_quilt(),
        small_copies(),
        lobes_package(&map, lattice(true, 2), &[1.0, 0.0001]),
        lobes_package(&map, lattice(false, 1), &[0.01]),
        surface_package(&map, Interpolation::Linear, &[1.0, 0.0001]),
        tree_package(&map, &[1.0, 0.0001]),
        lean_package(&map, &[0.9, 0.0001]),
        flake_package(&map, &[0.9, 0.01]),
        specular_package(&map, 40),
        forest_package(&map, &[0.01], 1),
        forest_package(&map, &[0.9], 1),
    ] {
        let container = Container::open(&bytes).unwrap();
        check::full(&container, &mut |finding| panic!("{finding}"));
    }
}

#[test]
fn every_flipped_bit_is_found() {
    for sound in [
        small_package(),
        small_tiles_in_full(),
        small_lean(),
        small_tree(),
        small_lobes(),
        small_surface(),
        small_quilt(),
    ] {
        every_flipped_bit_of_is_found(&sound);
    }
}

fn every_flipped_bit_of_is_found(sound: &[u8]) {
    let mut bytes = sound.to_vec();
    for place in 0..bytes.len() {
        // One bit each, another one at every byte; all eight in the header and the table.
        let head = place < HEADER_LENGTH + 16 * ENTRY_LENGTH;
        for bit in if head { 0..8 } else { place % 8..place % 8 + 1 } {
            bytes[place] ^= 1 << bit;
            assert!(finds_something(&bytes), "bit {bit} of byte {place}");
            bytes[place] ^= 1 << bit;
        }
    }
    assert_eq!(bytes, sound);
}

#[test]
fn every_truncation_is_an_error_at_opening() {
    for sound in [small_package(), small_lobes(), small_surface()] {
        for length in 0..sound.len() {
            let finding =
                Container::open(&sound[..length]).expect_err("a cut package does not open");
            if length >= HEADER_LENGTH {
                assert_eq!(finding.fault, Fault::FileLength, "{length}");
            }
        }
        let mut longer = sound;
        longer.push(0);
        assert_eq!(
            Container::open(&longer).unwrap_err().fault,
            Fault::FileLength
        );
    }
}

#[test]
fn a_stored_roughness_of_any_size_gives_no_wrong_number() {
    // The format lets 1e-9 to 1e9 through, far beyond what any query may ask for.
    for sound in [small_tree(), small_lobes(), small_surface()] {
        let roughness = section_range(&sound, INSTANCES, 0).start + 16;
        for lie in [1e-9_f64, 1e-6, 1e-4, 1.0, 30.0, 1e5, 1e9] {
            let mut bytes = sound.clone();
            bytes[roughness..roughness + 8].copy_from_slice(&lie.to_le_bytes());
            assert!(reseal(&mut bytes));
            interrogate(&bytes);
        }
    }
}

#[test]
fn a_level_in_a_record_of_bins_is_refused() {
    let mut bytes = small_package();
    let record = section_range(&bytes, INSTANCES, 0).start;
    bytes[record + 44] = 1;
    assert!(reseal(&mut bytes));
    let finding = Container::open(&bytes).expect_err("bins have no levels");
    assert_eq!(finding.fault, Fault::ReservedNotZero);
}

#[test]
fn lists_of_no_page_and_blocks_of_no_list_are_found() {
    // What the counts alone would not show: the texels still add up.
    let sound = small_tiles_in_full();
    let count = section_range(&sound, LIST_BLOCKS, 1).len() / 2;
    let lists = section_range(&sound, LISTS, 1);
    let pages = section_range(&sound, PAGES, 1);
    for (kind, place, value) in [
        (LISTS, lists.start, 1),
        (LISTS, lists.start + 4, 1),
        (LISTS, lists.end - 8, count as u32 - 1),
        (LISTS, lists.end - 4, 0),
        (PAGES, pages.start, 1),
        (PAGES, pages.start + 4, 1),
        (PAGES, pages.start + 4, lists.len() as u32 / 8 - 2),
    ] {
        let mut bytes = sound.clone();
        bytes[place..place + 4].copy_from_slice(&value.to_le_bytes());
        assert!(reseal(&mut bytes));
        let mut found = false;
        let container = Container::open(&bytes).unwrap();
        check::structure(&container, &mut |finding| {
            let section = finding.section.map(|id| id.kind);
            found |= finding.fault == Fault::ListOrder && section == Some(kind);
        });
        assert!(found, "{kind} at {place}: {value}");
        interrogate(&bytes);
    }
}

#[test]
fn swapped_positions_are_found() {
    let mut bytes = small_package();
    let range = section_range(&bytes, INVERSE_BIN_MAP, 1);
    let (first, second) = (range.start, range.end - 4);
    for byte in 0..4 {
        bytes.swap(first + byte, second + byte);
    }
    reseal(&mut bytes);
    let mut faults = Vec::new();
    let container = Container::open(&bytes).unwrap();
    check::structure(&container, &mut |finding| faults.push(finding.fault));
    assert!(faults.contains(&Fault::PositionKey), "{faults:?}");
}

#[test]
fn boxes_turned_inside_out_weigh_nothing() {
    // Under a segment, where a whole texel would weigh infinitely much.
    let mut bytes = small_package();
    let forest = section_range(&bytes, FOREST, 1);
    for corners in bytes[forest].chunks_exact_mut(8) {
        corners.copy_from_slice(&[11, 0, 9, 0, 0, 0, 0, 0]);
    }
    assert!(reseal(&mut bytes));
    interrogate(&bytes);
}

#[test]
fn a_roughness_without_a_finite_density_is_refused_at_opening() {
    let sound = small_package();
    let roughness = section_range(&sound, INSTANCES, 0).start + 16;
    for lie in [
        0.0,
        -0.4,
        1e-160,
        f64::MIN_POSITIVE,
        1e160,
        f64::NAN,
        f64::INFINITY,
    ] {
        let mut bytes = sound.clone();
        bytes[roughness..roughness + 8].copy_from_slice(&lie.to_le_bytes());
        assert!(reseal(&mut bytes));
        let finding = Container::open(&bytes).expect_err("no lobe has this roughness");
        assert_eq!(finding.fault, Fault::InstanceField, "{lie}: {finding}");
    }
}

#[test]
fn lies_in_the_table_are_refused_at_opening() {
    let sound = small_package();
    let at = |entry: usize, place: usize| HEADER_LENGTH + entry * ENTRY_LENGTH + place;
    let cases: [(usize, Vec<u8>, Fault); 9] = [
        (at(2, 0), b"QQQQ".to_vec(), Fault::TableOrder),
        (at(2, 6), vec![9, 0], Fault::TableOrder),
        (at(2, 12), vec![2], Fault::ReservedNotZero),
        (at(2, 16), vec![3], Fault::SectionSchema),
        (at(2, 20), vec![2], Fault::SectionSchema),
        (at(2, 24), vec![1], Fault::SectionOffset),
        (at(2, 32), vec![0xFF; 8], Fault::SectionLength),
        (at(2, 40), vec![0xFF; 8], Fault::SectionLength),
        (at(2, 60), vec![1], Fault::ReservedNotZero),
    ];
    for (place, lie, fault) in cases {
        let mut bytes = sound.clone();
        bytes[place..place + lie.len()].copy_from_slice(&lie);
        reseal(&mut bytes);
        let finding = Container::open(&bytes).expect_err("a lying table does not open");
        assert_eq!(finding.fault, fault, "byte {place}: {finding}");
    }
}

#[test]
fn unknown_sections_are_skipped_unless_critical() {
    let sound = small_package();
    // The metadata, renamed to a kind that sorts into the same place.
    let entry = HEADER_LENGTH + ENTRY_LENGTH;
    assert_eq!(&sound[entry..entry + 4], b"META");
    let mut bytes = sound;
    bytes[entry..entry + 4].copy_from_slice(b"ZZZZ");
    reseal(&mut bytes);
    let container = Container::open(&bytes).expect("an unknown kind is skipped");
    let mut faults = Vec::new();
    check::structure(&container, &mut |finding| faults.push(finding.fault));
    assert_eq!(faults, [Fault::SectionMissing], "the metadata is missed");
    bytes[entry + 12] = 1;
    reseal(&mut bytes);
    assert_eq!(
        Container::open(&bytes).unwrap_err().fault,
        Fault::UnknownSection
    );
}

#[test]
fn bytes_all_over_a_small_package_may_lie_without_harm() {
    let mut stream = Stream::new(1);
    for sound in [
        small_package(),
        small_tiles_in_full(),
        small_lean(),
        small_tree(),
        small_lobes(),
        small_surface(),
    ] {
        // One in seven: the other tests and the corpus lie elsewhere, and 7 divides no record's size.
        for place in (HEADER_LENGTH..sound.len()).step_by(7) {
            let mut bytes = sound.clone();
            bytes[place] = (stream.uniform() * 256.0) as u8;
            reseal(&mut bytes);
            interrogate(&bytes);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn any_bytes_open_or_give_a_finding(bytes in proptest::collection::vec(any::<u8>(), 0..2048)) {
        interrogate(&bytes);
    }

    #[test]
    fn any_few_lies_are_survived(
        lies in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..12),
        kind in 0..6,
    ) {
        let mut bytes = match kind {
            0 => small_tiles_in_full(),
            1 => small_lean(),
            2 => small_tree(),
            3 => small_lobes(),
            4 => small_surface(),
            _ => small_package(),
        };
        let data = bytes.len() - HEADER_LENGTH;
        for (place, lie) in lies {
            bytes[HEADER_LENGTH + place.index(data)] = lie;
        }
        reseal(&mut bytes);
        interrogate(&bytes);
    }

    #[test]
    fn any_query_has_an_answer_or_a_typed_error(
        centre in any::<[f64; 2]>(),
        edge_1 in any::<[f64; 2]>(),
        edge_2 in any::<[f64; 2]>(),
        s in -1.5..1.5,
        t in any::<f64>(),
        paper in any::<bool>(),
        kind in 0..5,
    ) {
        let bytes = match kind {
            0 => small_tiles(),
            1 => small_tree(),
            2 => small_lobes(),
            3 => small_surface(),
            _ => small_package(),
        };
        let package = Package::open(&bytes).unwrap();
        let footprint = Footprint { centre, edge_1, edge_2 };
        for instance in package.instances() {
            let mut ndf = package.ndf(instance.number).unwrap();
            if paper && instance.bins().is_some() {
                ndf = ndf.with_setting(Setting::Binned(Neighbourhood::Bins21)).unwrap();
            } else if paper {
                ndf = ndf.with_filter(Filter::Gaussian);
            }
            if let Ok(value) = ndf.eval(&footprint, HalfVector { s, t }) {
                prop_assert!(value.is_finite() && value >= 0.0);
            }
        }
    }
}
