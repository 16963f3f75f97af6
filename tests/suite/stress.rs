//! Stiff and extreme cases: needles and blunt lobes, footprints from a ten-thousandth of a texel to 64 tiles,
//! slivers, far centres, awkward maps, half vectors at the rim. Each against the f64 oracle.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::flake_bins::{self as oracle, Prepared};
use glintbake_format::model::{Footprint, HalfVector, Neighbourhood, Wrap};
use glintbake_runtime::{Ndf, Package};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, sample_map};
use glintbake_tests::tolerances::{NDF, NDF_FLOOR};
use std::f64::consts::PI;

fn maps() -> Vec<(&'static str, NormalMap)> {
    let with = |width, height, wrap, normal: &dyn Fn(usize) -> [f32; 2]| {
        let texels = (0..width as usize * height as usize).map(normal).collect();
        NormalMap::new(width, height, wrap, texels)
    };
    vec![
        ("constant", with(16, 16, Wrap::Repeat, &|_| [0.1, -0.2])),
        ("one texel", with(1, 1, Wrap::Repeat, &|_| [0.3, 0.3])),
        (
            "one column",
            with(1, 50, Wrap::Clamp, &|k| [0.0, k as f32 / 60.0]),
        ),
        ("one row", sample_map(Kind::Noise, 67, 1, 2, Wrap::Repeat)),
        ("primes", sample_map(Kind::Flakes, 31, 17, 3, Wrap::Repeat)),
        (
            "white noise",
            sample_map(Kind::Noise, 32, 32, 4, Wrap::Clamp),
        ),
        (
            "steps",
            with(24, 24, Wrap::Repeat, &|k| {
                if k % 2 == 0 {
                    [0.99, 0.0]
                } else {
                    [-0.99, 0.0]
                }
            }),
        ),
        (
            "rim",
            with(8, 8, Wrap::Repeat, &|k| {
                if k % 3 == 0 { [1.0, 0.0] } else { [0.6, 0.8] }
            }),
        ),
        // Normals on an 8-bit lattice, coarser than a bin of any roughness below 0.01.
        (
            "lattice",
            with(32, 32, Wrap::Repeat, &|k| {
                [
                    ((k * 7) % 100) as f32 / 255.0 - 0.2,
                    ((k * 13) % 90) as f32 / 255.0 - 0.2,
                ]
            }),
        ),
    ]
}

fn footprints(map: &NormalMap, stream: &mut Stream) -> Vec<Footprint> {
    let size = [f64::from(map.width()), f64::from(map.height())];
    let mut footprints = Vec::new();
    for texels in [1e-4, 0.1, 3.0] {
        footprints.push(stream.footprint(map, texels));
    }
    for tiles in [1.0, 7.3, 64.0] {
        let angle = stream.between(0.0, PI);
        footprints.push(Footprint {
            centre: [stream.uniform(), stream.uniform()],
            edge_1: [tiles * angle.cos(), tiles * angle.sin()],
            edge_2: [-0.8 * tiles * angle.sin(), 0.8 * tiles * angle.cos()],
        });
    }
    for anisotropy in [8.0, 1e3, 1e6] {
        let angle = stream.between(0.0, PI);
        let long = 20.0;
        let short = long / anisotropy;
        footprints.push(Footprint {
            centre: [stream.uniform(), stream.uniform()],
            edge_1: [long * angle.cos() / size[0], long * angle.sin() / size[1]],
            edge_2: [
                -short * angle.sin() / size[0],
                short * angle.cos() / size[1],
            ],
        });
    }
    // No area; parallel edges; a million tiles away.
    footprints.push(Footprint::square([0.37, 0.61], 0.0, 1, 1));
    footprints.push(Footprint {
        centre: [0.123, 0.456],
        edge_1: [0.3, 0.2],
        edge_2: [0.15, 0.1],
    });
    let mut far = stream.footprint(map, 5.0);
    far.centre = far.centre.map(|x| x + 1e6);
    footprints.push(far);
    footprints
}

fn half_vectors(
    map: &NormalMap,
    footprint: &Footprint,
    alpha: f64,
    stream: &mut Stream,
) -> Vec<HalfVector> {
    let mut vectors = vec![
        HalfVector { s: 0.0, t: 0.0 },
        HalfVector { s: 1.0, t: 0.0 },
        HalfVector { s: -0.6, t: 0.8 },
        HalfVector { s: 0.9, t: 0.9 },
    ];
    for spread in [0.0, alpha, 4.0 * alpha] {
        vectors.push(stream.half_vector_near(map, footprint, spread));
    }
    vectors
}

#[test]
fn every_stiff_and_extreme_case_matches_the_oracle() {
    let mut lit = 0;
    for alpha in [1e-4, 1e-3, 0.03, 0.3, 1.0] {
        for (seed, (name, map)) in (1..).zip(maps()) {
            let mut stream = Stream::new(seed);
            let bytes = flake_package(&map, &[alpha]);
            let package = Package::open(&bytes).unwrap();
            let ndf = package.ndf(1).unwrap();
            for footprint in footprints(&map, &mut stream) {
                let setting = oracle::Setting::Binned(Neighbourhood::Bins45);
                let prepared = Prepared::new(&map, &footprint, alpha, setting);
                for h in half_vectors(&map, &footprint, alpha, &mut stream) {
                    let expected = prepared.ndf(h);
                    let got = ndf.eval(&footprint, h).unwrap();
                    let floor = NDF_FLOOR / (PI * alpha * alpha);
                    assert!(
                        (got - expected).abs() <= NDF * expected.max(floor),
                        "{name}, α = {alpha}, {footprint:?}, {h:?}: {got:e} instead of {expected:e}"
                    );
                    lit += u32::from(got > 0.0);
                }
            }
        }
    }
    assert!(lit > 500, "only {lit} queries met a flake");
}

#[test]
fn samples_of_extreme_cases_are_directions_with_density() {
    for alpha in [1e-4, 0.03, 1.0] {
        for (seed, (name, map)) in (1..).zip(maps()) {
            let mut stream = Stream::new(seed);
            let bytes = flake_package(&map, &[alpha]);
            let package = Package::open(&bytes).unwrap();
            let ndf = package.ndf(1).unwrap();
            let mut drawn = 0;
            for footprint in footprints(&map, &mut stream) {
                for _ in 0..20 {
                    let uniform = std::array::from_fn(|_| stream.uniform());
                    let Some(h) = ndf.sample(&footprint, uniform).unwrap() else {
                        continue;
                    };
                    assert!(h.is_on_disk(), "{name} {alpha} {h:?}");
                    let pdf = ndf.pdf(&footprint, h).unwrap();
                    assert!(
                        pdf > 0.0 && pdf.is_finite(),
                        "{name} {alpha} {footprint:?}: {pdf}"
                    );
                    drawn += 1;
                }
            }
            assert!(drawn > 0, "{name} {alpha}: no sample at all");
        }
    }
}
