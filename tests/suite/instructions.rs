//! Wider vectors change the time a query takes, and no bit of its answer.

use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Footprint, Neighbourhood, Wrap};
use glintbake_runtime::ndf::Lookup;
use glintbake_runtime::{FlakeBins, Instructions, Ndf, Package, SurfaceNdf};
use glintbake_samples::KINDS;
use glintbake_tests::fixtures::{Stream, flake_package, forest_package, sample_map};

/// Bins with the bits of their weights, and the bits of the density.
type Answer = (Vec<(u32, u32, u64)>, u64);

fn answer(
    ndf: &FlakeBins<'_>,
    instructions: Instructions,
    footprint: &Footprint,
    map: &NormalMap,
    spread: f64,
    stream: &Stream,
) -> Answer {
    let ndf = ndf.with_instructions(instructions);
    let half_vector = stream.clone().half_vector_near(map, footprint, spread);
    let mut weights = Vec::new();
    ndf.bin_weights(
        footprint,
        half_vector,
        Neighbourhood::Bins45,
        &mut |x, y, weight| weights.push((x, y, weight.to_bits())),
    )
    .expect("in range");
    let density = ndf.eval(footprint, half_vector).expect("in range");
    (weights, density.to_bits())
}

#[test]
fn portable_and_widest_instructions_give_the_same_bits() {
    // Where they are the same this compares one thing with itself; the name tells, if the test is asked to print.
    println!("fastest is {}", Instructions::Fastest.name());
    for (seed, &kind) in (1..).zip(KINDS) {
        // In blocks with narrow and with wide keys, and a map in rows.
        for (width, height, alpha, wrap) in [
            (201, 150, 0.05, Wrap::Repeat),
            (310, 300, 0.0005, Wrap::Repeat),
            (3, 500, 0.3, Wrap::Clamp),
        ] {
            let map = sample_map(kind, width, height, seed, wrap);
            let mut stream = Stream::new(seed);
            let mut lit = 0;
            for bytes in [
                flake_package(&map, &[alpha]),
                forest_package(&map, &[alpha], 8),
            ] {
                let package = Package::open(&bytes).expect("a fresh package opens");
                let Ok(SurfaceNdf::FlakeBins(ndf)) = package.ndf(1) else {
                    panic!("the fixture was baked for flake-bins");
                };
                for lookup in [Lookup::Lists, Lookup::Scan] {
                    let ndf = ndf.with_lookup(lookup);
                    for number in 0..60 {
                        let texels = [0.2, 3.0, 17.0, 60.0, 200.0][number % 5];
                        let mut footprint = stream.footprint(&map, texels);
                        if number % 7 == 0 {
                            // A sliver, which is clipped in place of covered.
                            footprint.edge_2 = footprint.edge_1.map(|edge| edge * 1.000_01);
                        }
                        let [portable, fastest] = [Instructions::Portable, Instructions::Fastest]
                            .map(|instructions| {
                                answer(&ndf, instructions, &footprint, &map, alpha, &stream)
                            });
                        assert!(
                            portable == fastest,
                            "{} {width} x {height}, {lookup:?}, {footprint:?}: {portable:?} or {fastest:?}",
                            kind.name()
                        );
                        lit += usize::from(!portable.0.is_empty());
                        stream.uniform();
                    }
                }
            }
            assert!(lit > 100, "{} {width} x {height}: {lit}", kind.name());
        }
    }
}
