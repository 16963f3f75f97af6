//! `flake-bins` densities against the oracle of the same setting.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::flake_bins::{self as oracle, Prepared};
use glintbake_format::Container;
use glintbake_format::model::{HalfVector, Neighbourhood, Wrap};
use glintbake_format::records::EXACT_NORMALS;
use glintbake_runtime::{Ndf, Package, QueryError, Setting};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, package, sample_map};
use glintbake_tests::tolerances::{NDF, NDF_FLOOR};
use std::f64::consts::PI;

const SETTINGS: [(Setting, oracle::Setting); 2] = [
    (
        Setting::Binned(Neighbourhood::Bins45),
        oracle::Setting::Binned(Neighbourhood::Bins45),
    ),
    (
        Setting::Binned(Neighbourhood::Bins21),
        oracle::Setting::Binned(Neighbourhood::Bins21),
    ),
];

fn assert_close(got: f64, expected: f64, alpha: f64, what: &str) {
    let floor = NDF_FLOOR / (PI * alpha * alpha);
    let tolerance = NDF * expected.abs().max(floor);
    assert!(
        (got - expected).abs() <= tolerance,
        "{what}: {got:e} instead of {expected:e}"
    );
}

#[test]
fn densities_equal_the_oracles_for_both_neighbourhoods() {
    for (seed, kind) in (1..).zip([Kind::Flakes, Kind::Scratches, Kind::Waves, Kind::Noise]) {
        let map = sample_map(kind, 96, 64, seed, Wrap::Repeat);
        for alpha in [0.001, 0.01, 0.1, 1.0] {
            let bytes = flake_package(&map, &[alpha]);
            let package = Package::open(&bytes).expect("a fresh package opens");
            let mut stream = Stream::new(seed);
            for texels in [0.3, 4.0, 40.0, 200.0] {
                let footprint = stream.footprint(&map, texels);
                for (setting, oracle_setting) in SETTINGS {
                    let ndf = package.ndf(1).unwrap().with_setting(setting).unwrap();
                    let prepared = Prepared::new(&map, &footprint, alpha, oracle_setting);
                    for _ in 0..20 {
                        let h = stream.half_vector_near(&map, &footprint, 2.0 * alpha);
                        let what = format!("{} {alpha} {texels} {h:?}", kind.name());
                        let density = ndf.eval(&footprint, h).unwrap();
                        assert_close(density, prepared.ndf(h), alpha, &what);
                        let pdf = ndf.pdf(&footprint, h).unwrap();
                        assert_close(pdf, prepared.pdf(h), alpha, &what);
                    }
                }
            }
        }
    }
}

/// The map whose normals are exactly those the package stores, decoded here as FORMAT.md describes them.
fn stored_normals(map: &NormalMap, bytes: &[u8], alpha: f64) -> NormalMap {
    let container = Container::open(bytes).unwrap();
    let instance = container.instances().next().unwrap().unwrap();
    let entry = container.find(instance.section(EXACT_NORMALS)).unwrap();
    let steps = container.section_bytes(entry).unwrap();
    let resolution = f64::from(oracle::resolution(alpha));
    let texels = map
        .texels()
        .iter()
        .zip(steps.chunks_exact(4))
        .map(|(texel, step)| {
            let component = |coordinate: f32, step: [u8; 2]| {
                let cell = ((f64::from(coordinate) + 1.0) * 0.5 * resolution)
                    .floor()
                    .min(resolution - 1.0);
                let fraction = (f64::from(u16::from_le_bytes(step)) + 0.5) / 65536.0;
                (2.0 * (cell + fraction) / resolution - 1.0) as f32
            };
            [
                component(texel[0], [step[0], step[1]]),
                component(texel[1], [step[2], step[3]]),
            ]
        });
    NormalMap::new(map.width(), map.height(), map.wrap(), texels.collect())
}

#[test]
fn exact_densities_equal_the_oracles_of_the_true_normals() {
    for (seed, kind) in (1..).zip([Kind::Flakes, Kind::Brushed, Kind::Noise]) {
        let map = sample_map(kind, 48, 80, seed, Wrap::Repeat);
        // At 0.1 the stored normals' step is far below f32's own; at 0.01 both are 1e-5 of a standard deviation.
        for (alpha, tolerance) in [(0.1, 1e-4), (0.01, 2e-4)] {
            let bytes = flake_package(&map, &[alpha]);
            let stored = stored_normals(&map, &bytes, alpha);
            for (texel, true_texel) in stored.texels().iter().zip(map.texels()) {
                let step = 2.0 / (65536.0 * f64::from(oracle::resolution(alpha)));
                for (component, true_component) in texel.iter().zip(true_texel) {
                    let off = f64::from(*component) - f64::from(*true_component);
                    assert!(
                        off.abs() <= 0.5 * step + 1.2e-7,
                        "a normal is stored {off:e} off"
                    );
                }
            }
            let package = Package::open(&bytes).unwrap();
            let ndf = package
                .ndf(1)
                .unwrap()
                .with_setting(Setting::Exact)
                .unwrap();
            let mut stream = Stream::new(seed);
            for texels in [0.3, 6.0, 60.0] {
                let footprint = stream.footprint(&map, texels);
                let prepared = Prepared::new(&map, &footprint, alpha, oracle::Setting::Exact);
                let as_stored = Prepared::new(&stored, &footprint, alpha, oracle::Setting::Exact);
                for _ in 0..20 {
                    let h = stream.half_vector_near(&map, &footprint, 2.0 * alpha);
                    let expected = prepared.ndf(h);
                    let floor = NDF_FLOOR / (PI * alpha * alpha);
                    let got = ndf.eval(&footprint, h).unwrap();
                    // The map of stored normals is f32: too coarse to hold 1e-5 against at a roughness of 0.01.
                    if alpha >= 0.1 {
                        assert_close(got, as_stored.ndf(h), alpha, kind.name());
                    }
                    assert!(
                        (got - expected).abs() <= tolerance * expected.max(floor),
                        "{} {alpha} {texels}: {got:e} instead of {expected:e}",
                        kind.name()
                    );
                }
            }
        }
    }
}

#[test]
fn one_package_answers_for_several_roughnesses() {
    let map = sample_map(Kind::Flakes, 64, 64, 1, Wrap::Repeat);
    let alphas = [0.005, 0.02, 0.2];
    let bytes = flake_package(&map, &alphas);
    let package = Package::open(&bytes).unwrap();
    let mut stream = Stream::new(4);
    let footprint = stream.footprint(&map, 10.0);
    for alpha in alphas {
        let instance = package.find(None, Some(alpha)).expect("it was baked");
        let ndf = package.ndf(instance.number).unwrap();
        let h = stream.half_vector_near(&map, &footprint, alpha);
        let expected = oracle::ndf(
            &map,
            &footprint,
            h,
            alpha,
            oracle::Setting::Binned(Neighbourhood::Bins45),
        );
        assert_close(ndf.eval(&footprint, h).unwrap(), expected, alpha, "several");
    }
    assert_eq!(package.find(None, Some(0.01)), None);
}

#[test]
fn a_half_vector_outside_the_disk_has_no_density_and_nan_is_an_error() {
    let map = sample_map(Kind::Noise, 16, 16, 1, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.1]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let footprint = Stream::new(1).footprint(&map, 8.0);
    let outside = HalfVector { s: 0.8, t: 0.7 };
    assert_eq!(ndf.eval(&footprint, outside), Ok(0.0));
    assert_eq!(ndf.pdf(&footprint, outside), Ok(0.0));
    let nan = HalfVector {
        s: f64::NAN,
        t: 0.0,
    };
    assert_eq!(ndf.eval(&footprint, nan), Err(QueryError::NotFinite));
    let mut infinite = footprint;
    infinite.edge_1[0] = f64::INFINITY;
    let pole = HalfVector { s: 0.0, t: 0.0 };
    assert_eq!(ndf.eval(&infinite, pole), Err(QueryError::NotFinite));
    let mut vast = footprint;
    vast.edge_1[0] = 1e5;
    assert_eq!(ndf.eval(&vast, pole), Err(QueryError::FootprintTooLarge));
}

#[test]
fn the_exact_setting_needs_its_section_and_says_so() {
    let map = sample_map(Kind::Noise, 16, 16, 1, Wrap::Repeat);
    let recipe =
        glintbake_bake::MethodRecipe::new(glintbake_format::model::Method::FlakeBins, &[0.1]);
    let bytes = package(&map, recipe);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let error = ndf.with_setting(Setting::Exact).unwrap_err();
    assert!(matches!(error, QueryError::NotBaked { section, .. } if section == EXACT_NORMALS));
    assert!(error.to_string().contains("--exact-normals"));
}
