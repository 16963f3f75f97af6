//! Masking of the map's own normals: the table against the plain sum over texels, and the BRDF with it.

use glintbake_bake::build::masking as table;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, PackagePlan, Recipe, bake, oracle};
use glintbake_format::model::{Footprint, MaskingGrid, Method, Neighbourhood, Wrap};
use glintbake_format::records::{MASKING, MaskingValue};
use glintbake_format::{Container, Fault, check};
use glintbake_runtime::microfacet::Masking;
use glintbake_runtime::microfacet::brdf::{self, MaskingPlacement};
use glintbake_runtime::microfacet::fresnel::Fresnel;
use glintbake_runtime::{Ndf, Package, QueryError, Setting, SurfaceNdf};
use glintbake_samples::{KINDS, Kind};
use glintbake_tests::fixtures::{Stream, flake_package, package, sample_map, specular_package};
use std::f64::consts::TAU;

/// A direction whose cosine to the surface is `cosine`.
fn direction(cosine: f64, turn: f64) -> [f64; 3] {
    let sine = (1.0 - cosine * cosine).sqrt();
    [sine * (turn * TAU).cos(), sine * (turn * TAU).sin(), cosine]
}

/// Directions whose cosines fall by the same factors from 1 to 0.001.
fn directions(count: u32) -> impl Iterator<Item = [f64; 3]> {
    let mut stream = Stream::new(1);
    (0..count).map(move |_| direction(10_f64.powf(-3.0 * stream.uniform()), stream.uniform()))
}

/// `map` baked for `flake-bins` without masking, with exact normals.
fn unmasked_package(map: &NormalMap, alpha: f64) -> Vec<u8> {
    let recipe = MethodRecipe {
        masking: false,
        exact_normals: true,
        ..MethodRecipe::new(Method::FlakeBins, &[alpha])
    };
    package(map, recipe)
}

fn first_ndf(bytes: &[u8]) -> SurfaceNdf<'_> {
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
        let bytes = flake_package(&map, &[0.3], 32);
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
        // Brushes have all their slopes across one line: masking along it has a kink between stored directions.
        let (most_mean, most) = match kind {
            Kind::Flat => (0.0, 0.0),
            Kind::Brushed => (0.004, 0.12),
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
    for bytes in [flake_package(&map, &[0.2], 32), specular_package(&map, 9)] {
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

/// The share of light from `view` that leaves again in all directions, for facets that reflect all: Fibonacci-like
/// samples of `brdf::sample` over the whole tile.
fn albedo(ndf: &SurfaceNdf<'_>, view: [f64; 3]) -> f64 {
    /// Powers of the root of x⁵ = x + 1: the low-discrepancy sequence of Roberts (2018) in four dimensions.
    const STEPS: [f64; 4] = [
        0.856_674_883_854_502_9,
        0.733_891_856_627_126,
        0.628_706_721_037_808_7,
        0.538_597_257_223_612,
    ];
    let samples = 4000;
    let mut sum = 0.0;
    for index in 0..samples {
        let uniform = STEPS.map(|step| (0.5 + f64::from(index) * step).fract());
        if let Some(light) = brdf::sample(ndf, &WHOLE_TILE, view, uniform).unwrap() {
            let f = brdf::eval(ndf, &WHOLE_TILE, light, view, Fresnel::Perfect).unwrap();
            let pdf = brdf::pdf(ndf, &WHOLE_TILE, light, view).unwrap();
            assert!(pdf > 0.0, "a sampled direction has a density");
            sum += f * light[2] / pdf;
        }
    }
    sum / f64::from(samples)
}

const WHOLE_TILE: Footprint = Footprint {
    centre: [0.5; 2],
    edge_1: [1.0, 0.0],
    edge_2: [0.0, 1.0],
};

#[test]
fn no_more_light_leaves_a_map_than_arrives() {
    for kind in [Kind::Flakes, Kind::Noise, Kind::Scratches] {
        let map = sample_map(kind, 16, 16, 3, Wrap::Repeat);
        for alpha in [0.1, 0.4] {
            let (masked, unmasked) = (
                flake_package(&map, &[alpha], 32),
                unmasked_package(&map, alpha),
            );
            for cosine in [1.0, 0.6, 0.2, 0.05] {
                let view = direction(cosine, 0.0);
                let of =
                    |bytes, setting| albedo(&first_ndf(bytes).with_setting(setting).unwrap(), view);
                let what = format!("{} {alpha} {cosine}", kind.name());
                let exact = of(&masked, Setting::Exact);
                assert!(exact <= 1.0 + 0.005, "{what}: {exact}");
                assert!(exact > 0.6, "{what}: only {exact} leaves");
                if alpha < 0.2 {
                    // Bins move normals by up to a tenth here, which turns some of them towards the view.
                    let binned = of(&masked, Setting::default());
                    assert!(binned <= 1.0 + 0.02, "{what}, binned: {binned}");
                }
                if cosine < 0.1 && kind != Kind::Scratches {
                    let without = of(&unmasked, Setting::Exact);
                    assert!(
                        without > 1.3,
                        "{what}: masking has nothing to do: {without}"
                    );
                }
            }
        }
    }
}

#[test]
fn sampling_and_summing_agree_on_the_light_that_leaves() {
    let map = sample_map(Kind::Waves, 16, 16, 3, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.4], 32);
    let ndf = first_ndf(&bytes).with_setting(Setting::Exact).unwrap();
    for cosine in [1.0, 0.5, 0.15] {
        let view = direction(cosine, 0.1);
        let [rows, columns] = [80, 160];
        let mut sum = 0.0;
        for row in 0..rows {
            for column in 0..columns {
                let z = (f64::from(row) + 0.5) / f64::from(rows);
                let light = direction(z, (f64::from(column) + 0.5) / f64::from(columns));
                let f = brdf::eval(&ndf, &WHOLE_TILE, light, view, Fresnel::Perfect).unwrap();
                sum += f * z;
            }
        }
        let summed = sum * TAU / f64::from(rows * columns);
        let sampled = albedo(&ndf, view);
        assert!(
            (summed / sampled - 1.0).abs() < 0.01,
            "{cosine}: {summed} and {sampled}"
        );
    }
}

#[test]
fn light_and_view_may_be_exchanged() {
    let map = sample_map(Kind::Leather, 64, 64, 1, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.3], 32);
    let ndf = first_ndf(&bytes);
    let mut stream = Stream::new(2);
    let mut lit = 0;
    for _ in 0..300 {
        let footprint = stream.footprint(&map, 20.0);
        let mut direction = || direction(stream.between(0.01, 1.0), stream.uniform());
        let (light, view) = (direction(), direction());
        for placement in [MaskingPlacement::Inside, MaskingPlacement::Factored] {
            let eval = |light, view| {
                brdf::eval_with(&ndf, &footprint, light, view, Fresnel::Perfect, placement).unwrap()
            };
            let (f, exchanged) = (eval(light, view), eval(view, light));
            assert!((f - exchanged).abs() <= 1e-9 * f, "{f} and {exchanged}");
            lit += u32::from(f > 0.0);
        }
    }
    assert!(lit > 200, "only {lit} evaluations met a flake");
}

#[test]
fn the_brdf_is_the_unmasked_one_times_the_maps_masking() {
    // The table's value is the same for all facets, so eq. 15 with and without it differ by this factor alone.
    let map = sample_map(Kind::Flakes, 32, 32, 5, Wrap::Repeat);
    let (masked, unmasked) = (flake_package(&map, &[0.3], 32), unmasked_package(&map, 0.3));
    let (masked, unmasked) = (first_ndf(&masked), first_ndf(&unmasked));
    assert!(masked.masking().is_baked() && !unmasked.masking().is_baked());
    let mut stream = Stream::new(3);
    let mut lit = 0;
    for _ in 0..300 {
        let footprint = stream.footprint(&map, 8.0);
        let mut direction = || direction(stream.between(0.02, 1.0), stream.uniform());
        let (light, view) = (direction(), direction());
        let eval = |ndf| brdf::eval(ndf, &footprint, light, view, Fresnel::Perfect).unwrap();
        let factor = oracle::masking(&map, light) * oracle::masking(&map, view);
        let (got, expected) = (eval(&masked), eval(&unmasked) * factor);
        assert!(
            (got - expected).abs() <= 0.02 * expected,
            "{got} {expected}"
        );
        lit += u32::from(got > 0.0);
    }
    assert!(lit > 100, "only {lit} evaluations met a flake");
}

/// How much brighter the factored form is, over directions as they are drawn and above `least` cosine: in all, and the
/// sum of differences of either sign.
fn factored_error(ndf: &SurfaceNdf<'_>, map: &NormalMap, least: f64) -> (f64, f64) {
    let mut stream = Stream::new(4);
    let (mut inside, mut brighter, mut off) = (0.0, 0.0, 0.0);
    for _ in 0..1500 {
        let footprint = stream.footprint(map, 20.0);
        let view = direction(stream.between(least, 1.0), stream.uniform());
        let uniform = std::array::from_fn(|_| stream.uniform());
        let drawn = brdf::sample(ndf, &footprint, view, uniform).unwrap();
        if let Some(light) = drawn.filter(|light| light[2] >= least) {
            let weight = light[2] / brdf::pdf(ndf, &footprint, light, view).unwrap();
            let [a, b] = [MaskingPlacement::Inside, MaskingPlacement::Factored].map(|placement| {
                weight
                    * brdf::eval_with(ndf, &footprint, light, view, Fresnel::Perfect, placement)
                        .unwrap()
            });
            inside += a;
            brighter += b - a;
            off += (b - a).abs();
        }
    }
    (brighter / inside, off / inside)
}

#[test]
fn factored_masking_is_as_near_as_documented() {
    // Of cosines above 0.05 and above 0.3: the figures in the documentation of MaskingPlacement.
    let bounds = [(0.01, 1e-4, 1e-5), (0.1, 0.006, 1e-4), (0.4, 0.14, 0.025)];
    for kind in [Kind::Flakes, Kind::Noise, Kind::Scratches, Kind::Leather] {
        let map = sample_map(kind, 64, 64, 3, Wrap::Repeat);
        for (alpha, near_horizon, above) in bounds {
            let bytes = flake_package(&map, &[alpha], 32);
            let ndf = first_ndf(&bytes);
            for (least, bound) in [(0.05, near_horizon), (0.3, above)] {
                let (brighter, off) = factored_error(&ndf, &map, least);
                let what = format!("{} {alpha} {least}: {brighter} {off}", kind.name());
                assert!(off <= bound, "{what}");
                if alpha > 0.2 {
                    assert!(off > 0.005, "{what}: the two forms are the same");
                    assert!(brighter > 0.95 * off, "{what}: it errs to the bright side");
                }
            }
        }
    }
    // Mirror flakes have no normal but the half vector.
    let map = sample_map(Kind::Flakes, 64, 64, 3, Wrap::Repeat);
    let bytes = specular_package(&map, 15);
    let (_, off) = factored_error(&first_ndf(&bytes), &map, 0.05);
    assert!(off < 1e-12, "{off}");
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
            16 => plan.add(id, elements::<16>(section)),
            _ => plan.add_critical(id, elements::<64>(section)),
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
    assert_eq!(with_masking(&sound, &table), sound);
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
