//! `specular-bins` against the oracle.

use glintbake_bake::oracle::specular_bins as oracle;
use glintbake_format::model::Wrap;
use glintbake_runtime::{Ndf, Package, QueryError, Setting};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, sample_map, specular_package};
use glintbake_tests::tolerances::WEIGHT_ROUNDING;

#[test]
fn densities_equal_the_oracles() {
    for (seed, kind) in (1..).zip([Kind::Flakes, Kind::Scratches, Kind::Noise]) {
        let map = sample_map(kind, 64, 48, seed, Wrap::Repeat);
        for bins in [1, 8, 63, 127] {
            let bytes = specular_package(&map, bins);
            let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
            let mut stream = Stream::new(seed);
            for texels in [0.5, 8.0, 100.0] {
                let footprint = stream.footprint(&map, texels);
                let prepared = oracle::Prepared::new(&map, &footprint, bins);
                for _ in 0..30 {
                    let h = stream.half_vector_near(&map, &footprint, 0.01);
                    // Two ways to compute a bin may differ within rounding of its border.
                    let near_border = oracle::square_of(h).iter().any(|x| {
                        let cell = x * f64::from(bins);
                        (cell - cell.round()).abs() < 1e-6
                    });
                    if near_border {
                        continue;
                    }
                    let expected = prepared.ndf(h);
                    let got = ndf.eval(&footprint, h).unwrap();
                    let tolerance = WEIGHT_ROUNDING / oracle::solid_angle(bins);
                    assert!(
                        (got - expected).abs() <= tolerance,
                        "{} {bins} {texels} {h:?}: {got} instead of {expected}",
                        kind.name()
                    );
                    let pdf = ndf.pdf(&footprint, h).unwrap();
                    assert!(
                        (pdf - got).abs() <= 1e-14 * got,
                        "mirror facets have h·n = 1"
                    );
                }
            }
        }
    }
}

#[test]
fn it_has_no_settings() {
    let map = sample_map(Kind::Noise, 8, 8, 1, Wrap::Repeat);
    let bytes = specular_package(&map, 16);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let error = ndf.with_setting(Setting::Exact).unwrap_err();
    assert!(matches!(error, QueryError::SettingUnsupported(_)));
}
