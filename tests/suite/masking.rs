//! Masking of the map's own normals: the table against the plain sum over texels, sound, damaged and absent.

use glintbake_bake::build::masking as table;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, PackagePlan, Recipe, bake, oracle};
use glintbake_format::model::{Footprint, MaskingGrid, Method, Neighbourhood, Wrap};
use glintbake_format::records::{MASKING, MaskingValue};
use glintbake_format::{Container, Fault, check};
use glintbake_runtime::microfacet::Masking;
use glintbake_runtime::microfacet::brdf;
use glintbake_runtime::microfacet::fresnel::Fresnel;
use glintbake_runtime::{Ndf, Package, QueryError, Setting, SurfaceNdf};
use glintbake_samples::{KINDS, Kind};
use glintbake_tests::fixtures::{Stream, flake_package, package, sample_map, specular_package};
use std::f64::consts::TAU;

/// A footprint that weighs all texels of a map alike.
pub(crate) const WHOLE_TILE: Footprint = Footprint {
    centre: [0.5; 2],
    edge_1: [1.0, 0.0],
    edge_2: [0.0, 1.0],
};

/// A direction whose cosine to the surface is `cosine`.
pub(crate) fn direction(cosine: f64, turn: f64) -> [f64; 3] {
    let sine = (1.0 - cosine * cosine).sqrt();
    [sine * (turn * TAU).cos(), sine * (turn * TAU).sin(), cosine]
}

/// Directions whose cosines fall by the same factors from 1 to 0.001.
fn directions(count: u32) -> impl Iterator<Item = [f64; 3]> {
    let mut stream = Stream::new(1);
    (0..count).map(move |_| direction(10_f64.powf(-3.0 * stream.uniform()), stream.uniform()))
}

/// `map` baked for `flake-bins` without masking, with exact normals.
pub(crate) fn unmasked_package(map: &NormalMap, alpha: f64) -> Vec<u8> {
    let recipe = MethodRecipe {
        masking: false,
        exact_normals: true,
        ..MethodRecipe::new(Method::FlakeBins, &[alpha])
    };
    package(map, recipe)
}

pub(crate) fn first_ndf(bytes: &[u8]) -> SurfaceNdf<'_> {
    Package::open(bytes).unwrap().ndf(1).unwrap()
}

#[test]
fn stored_values_are_the_sum_over_texels() {
    for &kind in KINDS {
        let map = sample_map(kind, 128, 96, 3, Wrap::Repeat);
        let bytes = specular_package(&map, 16);
        let ndf = first_ndf(&bytes);
        for row in 1..MaskingGrid::ROWS {
            for column in (0..MaskingGrid::COLUMNS).step_by(3) {
                let height = MaskingGrid::height(row);
                let [x, y] = MaskingGrid::heading(column).map(|part| part * (1.0 - height));
                let length = (x * x + y * y + height * height).sqrt();
                let omega = [x, y, height].map(|part| part / length);
                let expected = oracle::masking(&map, omega);
                let got = ndf.masking().g1(omega);
                // 16 bits and cells of like slopes: at most 3.3e-4 on these maps.
                assert!(
                    (got - expected).abs() <= 6e-4 * expected,
                    "{} {row} {column}: {got} instead of {expected}",
                    kind.name()
                );
            }
        }
    }
}

#[test]
fn masking_between_stored_directions_is_near_the_sum_over_texels_down_to_grazing() {
    for &kind in KINDS {
        let map = sample_map(kind, 128, 96, 3, Wrap::Repeat);
        let bytes = flake_package(&map, &[0.3]);
        let ndf = first_ndf(&bytes);
        let (mut sum, mut worst) = (0.0, 0.0_f64);
        let count = 600;
        for omega in directions(count) {
            let expected = oracle::masking(&map, omega);
            let error = (ndf.masking().g1(omega) - expected).abs() / expected;
            sum += error;
            worst = worst.max(error);
        }
        let mean = sum / f64::from(count);
        // Brushes have all their slopes across one line: masking along it has a kink between stored directions. Dents in
        // between round it off.
        let (most_mean, most) = match kind {
            Kind::Flat => (0.0, 0.0),
            Kind::Brushed => (0.004, 0.12),
            Kind::Dents => (0.002, 0.05),
            _ => (0.002, 0.012),
        };
        assert!(mean <= most_mean, "{}: {mean} on average", kind.name());
        assert!(worst <= most, "{}: {worst} at worst", kind.name());
    }
}

#[test]
fn extreme_maps_are_masked_like_the_sum_over_texels() {
    let step = |width, texels: &[[f32; 2]]| NormalMap::new(width, 1, Wrap::Repeat, texels.to_vec());
    let maps = [
        ("a step", step(2, &[[0.99, 0.0], [-0.99, 0.0]])),
        (
            "the rim",
            step(4, &[[1.0, 0.0], [0.0, 0.0], [-0.6, 0.8], [0.0, 0.0]]),
        ),
        ("nothing but rim", step(1, &[[1.0, 0.0]])),
        ("a lean", step(1, &[[0.3, -0.2]])),
        ("hardly any slope", step(2, &[[1e-4, 0.0], [-1e-4, 2e-4]])),
        ("one axis", step(3, &[[0.0, 0.4], [0.0, -0.1], [0.0, -0.3]])),
    ];
    for (name, map) in &maps {
        let bytes = specular_package(map, 16);
        let ndf = first_ndf(&bytes);
        let mut sum = 0.0;
        let count = 400;
        for omega in directions(count) {
            let (got, expected) = (ndf.masking().g1(omega), oracle::masking(map, omega));
            assert!((0.0..=1.0).contains(&got), "{name} {omega:?}: {got}");
            sum += (got - expected).abs();
        }
        // A few facets have kinks anywhere, so only the average is near: within 0.008 for the rim.
        let mean = sum / f64::from(count);
        assert!(mean < 0.01, "{name}: {mean}");
    }
}

#[test]
fn a_flat_map_masks_nothing() {
    let map = sample_map(Kind::Flat, 8, 8, 0, Wrap::Repeat);
    for bytes in [flake_package(&map, &[0.2]), specular_package(&map, 9)] {
        let ndf = first_ndf(&bytes);
        assert!(ndf.masking().is_baked());
        for omega in directions(200).chain([[0.6, 0.8, 1e-300], [0.0, 0.0, 1.0]]) {
            assert_eq!(ndf.masking().g1(omega), 1.0, "{omega:?}");
        }
        for below in [[1.0, 0.0, 0.0], [0.6, 0.0, -0.8], [f64::NAN, 0.0, 1.0]] {
            assert_eq!(ndf.masking().g1(below), 0.0, "{below:?}");
        }
    }
}

#[test]
fn masking_fades_continuously_around_and_to_the_horizon() {
    let map = sample_map(Kind::Scratches, 128, 128, 2, Wrap::Repeat);
    let bytes = specular_package(&map, 16);
    let ndf = first_ndf(&bytes);
    let g1 = |omega| ndf.masking().g1(omega);
    for turn in 0..64 {
        let turn = f64::from(turn) / 64.0;
        let mut previous = 0.0;
        for step in 1..=1000 {
            let masking = g1(direction(f64::from(step) / 1000.0, turn));
            assert!(masking >= previous - 1e-12, "{turn} {step}: it falls");
            previous = masking;
        }
        for cosine in [0.001, 0.01, 0.1, 0.7] {
            let (here, there) = (direction(cosine, turn), direction(cosine, turn - 1e-9));
            assert!((g1(here) - g1(there)).abs() < 1e-6, "{turn} {cosine}");
        }
    }
}

#[test]
fn the_table_does_not_depend_on_the_number_of_threads() {
    // More texels than one chunk holds, and not a multiple of it.
    let map = sample_map(Kind::Noise, 1531, 1403, 11, Wrap::Repeat);
    let build = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool of a few threads starts")
            .install(|| table::build(&map))
    };
    let one = build(1);
    assert_eq!(one.len(), MaskingGrid::COUNT);
    for threads in [2, 3, 8] {
        assert!(one == build(threads), "{threads}");
    }
}

#[test]
fn one_table_serves_all_instances_of_a_map() {
    let map = sample_map(Kind::Flakes, 40, 30, 2, Wrap::Clamp);
    let recipe = |masking: [bool; 2]| {
        Recipe::new(vec![
            MethodRecipe {
                masking: masking[0],
                ..MethodRecipe::new(Method::FlakeBins, &[0.2, 0.05])
            },
            MethodRecipe {
                masking: masking[1],
                ..MethodRecipe::new(Method::SpecularBins, &[])
            },
        ])
    };
    for (asked, holder) in [
        ([true, true], Some(1)),
        ([false, true], Some(3)),
        ([true, false], Some(1)),
        ([false, false], None),
    ] {
        let bytes = bake(&map, &recipe(asked), None).unwrap().to_bytes();
        let package = Package::open(&bytes).unwrap();
        let holders: Vec<_> = package
            .container()
            .entries()
            .iter()
            .filter(|entry| entry.kind == MASKING)
            .map(|entry| entry.instance.get())
            .collect();
        assert_eq!(holders, Vec::from_iter(holder), "{asked:?}");
        let grazing = direction(0.05, 0.3);
        let seen: Vec<_> = (1..=3)
            .map(|number| package.ndf(number).unwrap().masking().g1(grazing))
            .collect();
        let expected = holder.map_or(1.0, |_| oracle::masking(&map, grazing));
        for g1 in seen {
            assert!((g1 - expected).abs() <= 0.01 * expected, "{asked:?}: {g1}");
        }
    }
}

#[test]
fn what_says_nothing_of_masking_has_none() {
    /// A distribution of one's own, which knows its instance alone.
    struct Plain<'a>(SurfaceNdf<'a>);
    impl Ndf for Plain<'_> {
        fn instance(&self) -> &glintbake_runtime::Instance {
            self.0.instance()
        }
        fn facets(
            &self,
            footprint: &Footprint,
            half_vector: glintbake_format::model::HalfVector,
            visit: &mut dyn FnMut(glintbake_runtime::Facet),
        ) -> Result<(), QueryError> {
            self.0.facets(footprint, half_vector, visit)
        }
        fn sample(
            &self,
            footprint: &Footprint,
            uniform: [f64; 4],
        ) -> Result<Option<glintbake_format::model::HalfVector>, QueryError> {
            self.0.sample(footprint, uniform)
        }
    }
    let map = sample_map(Kind::Noise, 8, 8, 1, Wrap::Repeat);
    let bytes = specular_package(&map, 9);
    let ndf = first_ndf(&bytes);
    let grazing = direction(0.03, 0.7);
    assert!(ndf.masking().g1(grazing) < 0.9);
    assert_eq!(Plain(ndf).masking().g1(grazing), 1.0);
    assert_eq!(Masking::NONE.g(grazing, grazing), 1.0);
    assert_eq!(Masking::default().g1([0.0, 0.6, -0.8]), 0.0);
}

/// The sections of `bytes` in a new package, those of masking replaced by `values`.
fn with_masking(bytes: &[u8], values: &[u16]) -> Vec<u8> {
    fn elements<const SIZE: usize>(bytes: &[u8]) -> Vec<[u8; SIZE]> {
        bytes
            .chunks_exact(SIZE)
            .map(|element| element.try_into().unwrap())
            .collect()
    }
    let container = Container::open(bytes).unwrap();
    let mut plan = PackagePlan::new(container.header().recipe_hash);
    for entry in container.entries() {
        let (id, section) = (entry.id(), container.section_bytes(entry).unwrap());
        if entry.kind == MASKING {
            let values = values.iter().map(|&value| MaskingValue(value.into()));
            plan.add(id, values.collect());
            continue;
        }
        match entry.element_size.get() {
            1 => plan.add(id, section.to_vec()),
            2 => plan.add(id, elements::<2>(section)),
            4 => plan.add(id, elements::<4>(section)),
            8 => plan.add(id, elements::<8>(section)),
            64 => plan.add_critical(id, elements::<64>(section)),
            size => panic!("no section of this package has elements of {size} bytes"),
        }
    }
    plan.to_bytes()
}

fn faults(bytes: &[u8]) -> Vec<(Fault, Option<u64>)> {
    let mut faults = Vec::new();
    check::full(&Container::open(bytes).unwrap(), &mut |finding| {
        faults.push((finding.fault, finding.element));
    });
    faults
}

#[test]
fn damaged_tables_are_found_and_survived() {
    let map = sample_map(Kind::Flakes, 12, 10, 5, Wrap::Repeat);
    let sound = specular_package(&map, 9);
    let table: Vec<u16> = table::build(&map)
        .iter()
        .map(|value| value.0.get())
        .collect();
    assert!(with_masking(&sound, &table) == sound);
    assert_eq!(faults(&sound), []);

    // A value that exceeds the one below it is named by its place.
    let mut risen = table.clone();
    risen[3 * 64 + 5] = risen[2 * 64 + 5] + 1;
    let risen = with_masking(&sound, &risen);
    assert_eq!(faults(&risen), [(Fault::MaskingOrder, Some(3 * 64 + 5))]);

    // A table of another size opens no query, as nothing says which directions it would be for.
    for count in [0, 1, 64, 2047, 2049] {
        let resized = with_masking(&sound, &vec![0x8000; count]);
        assert_eq!(faults(&resized), [(Fault::SectionCount, None)], "{count}");
        match Package::open(&resized).unwrap().ndf(1) {
            Err(QueryError::Damaged(finding)) => assert_eq!(finding.fault, Fault::SectionCount),
            other => panic!("{count}: {other:?}"),
        }
    }

    // Whatever the values, masking is a share and the BRDF finite.
    let mut stream = Stream::new(8);
    let tables = [
        vec![0; 2048],
        vec![u16::MAX; 2048],
        (0..2048)
            .map(|_| (stream.uniform() * 65536.0) as u16)
            .collect(),
    ];
    for values in tables {
        let bytes = with_masking(&sound, &values);
        let ndf = first_ndf(&bytes);
        for light in directions(300) {
            let g1 = ndf.masking().g1(light);
            assert!((0.0..=1.0).contains(&g1), "{light:?}: {g1}");
            let f = brdf::eval(&ndf, &WHOLE_TILE, light, light, Fresnel::Perfect).unwrap();
            assert!(f.is_finite() && f >= 0.0, "{light:?}: {f}");
        }
    }
}

#[test]
fn packages_from_before_masking_answer_without() {
    let golden = include_bytes!("../golden/v1/noise-32.glint");
    let package = Package::open(golden).unwrap();
    let (light, view) = (direction(0.9, 0.1), direction(0.95, 0.6));
    let mut lit = 0;
    for instance in package.instances() {
        let ndf = package.ndf(instance.number).unwrap();
        assert!(!ndf.masking().is_baked());
        let f = brdf::eval(&ndf, &WHOLE_TILE, light, view, Fresnel::Perfect).unwrap();
        assert!(f.is_finite() && f >= 0.0, "{}: {f}", instance.number);
        lit += u32::from(f > 0.0);
    }
    assert!(lit > 0, "the rough instance at least reflects something");
    // And so do all settings of a package baked without it today.
    let map = sample_map(Kind::Flakes, 32, 32, 5, Wrap::Repeat);
    let bytes = unmasked_package(&map, 0.3);
    for setting in [
        Setting::Exact,
        Setting::default(),
        Setting::Binned(Neighbourhood::Bins21),
    ] {
        let ndf = first_ndf(&bytes).with_setting(setting).unwrap();
        assert_eq!(ndf.masking().g1(direction(0.01, 0.2)), 1.0);
    }
}
