//! What opening a package touches, and what it promises.

use glintbake_bake::MethodRecipe;
use glintbake_format::model::{METHODS, Method, Wrap};
use glintbake_format::{Container, Fault, HEADER_LENGTH};
use glintbake_runtime::Package;
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{flake_package, package, sample_map};

/// A page, the unit a mapping is read in.
const PAGE: usize = 4096;

#[test]
fn opening_reads_the_first_page_and_nothing_else() {
    let map = sample_map(Kind::Flakes, 128, 128, 1, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.005, 0.01, 0.02]);
    let expected: Vec<_> = Package::open(&bytes).unwrap().instances().collect();
    assert_eq!(expected.len(), 3);
    for filler in [0x00, 0xFF, 0xA5] {
        let mut overwritten = bytes.clone();
        overwritten[PAGE..].fill(filler);
        let package = Package::open(&overwritten).expect("opening never looks at the data");
        assert_eq!(package.instances().collect::<Vec<_>>(), expected);
        for instance in &expected {
            package
                .ndf(instance.number)
                .expect("nor does choosing an instance");
        }
    }
}

#[test]
fn lobes_and_surfaces_are_opened_by_the_first_page_as_well() {
    let map = sample_map(Kind::Noise, 40, 40, 1, Wrap::Repeat);
    let recipe = |method| MethodRecipe::new(method, &[0.005, 0.02]);
    for bytes in [Method::Lobes, Method::Analytic].map(|method| package(&map, recipe(method))) {
        let expected: Vec<_> = Package::open(&bytes).unwrap().instances().collect();
        assert_eq!(expected.len(), 2);
        let mut overwritten = bytes.clone();
        overwritten[PAGE..].fill(0xFF);
        let package = Package::open(&overwritten).expect("opening never looks at the data");
        assert_eq!(package.instances().collect::<Vec<_>>(), expected);
    }
}

#[test]
fn sections_are_aligned_for_gpus_and_leave_no_hole() {
    let map = sample_map(Kind::Waves, 33, 17, 1, Wrap::Repeat);
    let example = sample_map(Kind::Waves, 8, 8, 1, Wrap::Repeat);
    for &method in METHODS {
        let roughness: &[f64] = match method {
            Method::SpecularBins => &[],
            _ => &[0.05],
        };
        let map = match method {
            Method::NdfMaps => &example,
            _ => &map,
        };
        let bytes = package(map, MethodRecipe::new(method, roughness));
        let container = Container::open(&bytes).unwrap();
        let mut end = (HEADER_LENGTH + size_of_val(container.entries())) as u64;
        for entry in container.entries() {
            assert_eq!(entry.offset.get() % 256, 0);
            assert!(entry.offset.get() - end < 256);
            end = entry.offset.get() + entry.length.get();
        }
        assert_eq!(end, bytes.len() as u64);
    }
}

#[test]
fn a_future_version_is_told_apart_from_damage() {
    let map = sample_map(Kind::Flat, 4, 4, 1, Wrap::Repeat);
    let mut bytes = flake_package(&map, &[0.5]);
    bytes[12] = 2;
    let finding = Container::open(&bytes).unwrap_err();
    assert_eq!(finding.fault, Fault::UnsupportedVersion);
    assert_eq!((finding.expected, finding.got), (Some(1), Some(2)));
    let text = Container::open(b"PNG").unwrap_err();
    assert_eq!(text.fault, Fault::NotAPackage);
    assert_eq!(Container::open(b"").unwrap_err().fault, Fault::TooShort);
}
