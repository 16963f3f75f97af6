//! `lobes` against the plain sum over all lobes, and against what any sum of lobes must keep to.

use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::lobes::Prepared;
use glintbake_format::model::{Footprint, LobeLattice, Method, Wrap};
use glintbake_runtime::{Lobes, Ndf, Package, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, package, sample_map};

const CURVED: LobeLattice = LobeLattice {
    curved: true,
    per_side: 1,
};

fn baked(map: &NormalMap, lattice: LobeLattice, merge_error: f64, alpha: f64) -> Vec<u8> {
    let recipe = MethodRecipe {
        lattice: Some(lattice),
        merge_error: Some(merge_error),
        ..MethodRecipe::new(Method::Lobes, &[alpha])
    };
    package(map, recipe)
}

fn lobes(bytes: &[u8]) -> Lobes<'_> {
    match Package::open(bytes).expect("a fresh package opens").ndf(1) {
        Ok(SurfaceNdf::Lobes(ndf)) => ndf,
        other => panic!("baked for lobes: {other:?}"),
    }
}

/// Relative L1 error of `count` queries under footprints of about `texels` texels.
fn error(map: &NormalMap, ndf: &Lobes<'_>, texels: f64, squeeze: f64, count: usize) -> f64 {
    let mut stream = Stream::new(5);
    let (mut off, mut sum) = (0.0, 0.0);
    for _ in 0..count {
        let footprint = stream.footprint(map, texels);
        let footprint = Footprint {
            edge_2: footprint.edge_2.map(|x| x * squeeze),
            ..footprint
        };
        let near = stream.half_vector_near(map, &footprint, 1.5 * ndf.roughness());
        let truth = Prepared::new(map, &footprint, ndf.lattice(), !ndf.is_raw_sum());
        let exact = truth.ndf(near, ndf.roughness());
        let found = ndf.eval(&footprint, near).expect("in range");
        assert!(found.is_finite() && found >= 0.0);
        off += (found - exact).abs();
        sum += exact;
    }
    off / sum.max(1e-300)
}

#[test]
fn densities_are_those_of_the_plain_sum_of_lobes() {
    for (kind, width, height, wrap) in [
        (Kind::Waves, 256, 256, Wrap::Repeat),
        (Kind::Flakes, 130, 75, Wrap::Repeat),
        (Kind::Waves, 61, 120, Wrap::Clamp),
        (Kind::Brushed, 90, 33, Wrap::Clamp),
    ] {
        let map = sample_map(kind, width, height, 5, wrap);
        for (curved, per_side) in [(true, 1), (false, 1), (true, 2), (false, 2)] {
            let lattice = LobeLattice { curved, per_side };
            for sigma in [0.002, 0.005, 0.02, 0.15] {
                let alpha = sigma * core::f64::consts::SQRT_2;
                let bytes = baked(&map, lattice, 1e-3, alpha);
                let ndf = lobes(&bytes);
                for (texels, squeeze) in
                    [(0.0, 1.0), (0.5, 1.0), (3.0, 1.0), (20.0, 0.1), (60.0, 1.0)]
                {
                    let l1 = error(&map, &ndf, texels, squeeze, 12);
                    println!("{kind:?} {wrap:?} {lattice:?} σ {sigma}, {texels} texels: {l1:.2e}");
                }
            }
        }
    }
}
