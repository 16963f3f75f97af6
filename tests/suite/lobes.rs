//! `lobes` against the plain sum over all lobes, and against what any sum of lobes must keep to.

use core::f64::consts::SQRT_2;
use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::lobes::Prepared;
use glintbake_format::check;
use glintbake_format::model::{Filter, Footprint, HalfVector, LobeLattice, Method, Wrap};
use glintbake_runtime::{Instructions, Lobes, Ndf, Package, QueryError, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, package, sample_map};

const CURVED: LobeLattice = LobeLattice {
    curved: true,
    per_side: 1,
};
const FLAT: LobeLattice = LobeLattice {
    curved: false,
    per_side: 1,
};
const LATTICES: [LobeLattice; 4] = [
    CURVED,
    FLAT,
    LobeLattice {
        per_side: 2,
        ..CURVED
    },
    LobeLattice {
        per_side: 2,
        ..FLAT
    },
];

fn baked(map: &NormalMap, lattice: LobeLattice, sigma: f64) -> Vec<u8> {
    let recipe = MethodRecipe {
        lattice: Some(lattice),
        ..MethodRecipe::new(Method::Lobes, &[sigma * SQRT_2])
    };
    package(map, recipe)
}

fn lobes(bytes: &[u8]) -> Lobes<'_> {
    match Package::open(bytes).expect("a fresh package opens").ndf(1) {
        Ok(SurfaceNdf::Lobes(ndf)) => ndf,
        other => panic!("baked for lobes: {other:?}"),
    }
}

/// Footprints of about `texels` texels whose second edge is `squeeze` times as long, with half vectors near a normal below.
fn queries(
    map: &NormalMap,
    alpha: f64,
    texels: f64,
    squeeze: f64,
    count: usize,
) -> Vec<(Footprint, HalfVector)> {
    let mut stream = Stream::new(5);
    let mut query = || {
        let footprint = stream.footprint(map, texels);
        let footprint = Footprint {
            edge_2: footprint.edge_2.map(|x| x * squeeze),
            ..footprint
        };
        (
            footprint,
            stream.half_vector_near(map, &footprint, 1.5 * alpha),
        )
    };
    (0..count).map(|_| query()).collect()
}

/// Relative L1 error over `queries`. Where they have less than 1e-5 of the kernel's peak, as little as lies beyond the reach of
/// lobes, relative to that.
fn error(map: &NormalMap, ndf: &Lobes<'_>, queries: &[(Footprint, HalfVector)]) -> f64 {
    let (mut off, mut sum) = (0.0, 0.0);
    for (footprint, h) in queries {
        let truth = Prepared::new(map, footprint, ndf.lattice(), !ndf.is_raw_sum());
        let exact = truth.ndf(*h, ndf.roughness());
        let found = ndf.eval(footprint, *h).expect("in range");
        assert!(found.is_finite() && found >= 0.0);
        off += (found - exact).abs();
        sum += exact;
    }
    let sigma = ndf.roughness() / SQRT_2;
    let peak = 1.0 / (core::f64::consts::TAU * sigma * sigma);
    off / sum.max(1e-5 * peak * queries.len() as f64)
}

/// The integral of the density over the disk, by its middle values on a lattice finer than the kernel.
fn energy(ndf: &Lobes<'_>, footprint: &Footprint, sigma: f64) -> f64 {
    let side = (4.0 / sigma).ceil() as i32;
    let pitch = 2.0 / f64::from(side);
    let mut sum = 0.0;
    for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
        let place = |number: i32| (f64::from(number) + 0.5) * pitch - 1.0;
        let h = HalfVector {
            s: place(column),
            t: place(row),
        };
        sum += ndf.eval(footprint, h).expect("in range") * pitch * pitch;
    }
    sum
}

#[test]
fn densities_are_those_of_the_plain_sum_of_lobes() {
    for (kind, width, height, wrap) in [
        (Kind::Waves, 100, 128, Wrap::Repeat),
        (Kind::Flakes, 130, 75, Wrap::Repeat),
        (Kind::Waves, 61, 120, Wrap::Clamp),
    ] {
        let map = sample_map(kind, width, height, 5, wrap);
        for lattice in LATTICES {
            for sigma in [0.002, 0.02, 0.15] {
                let bytes = baked(&map, lattice, sigma);
                let ndf = lobes(&bytes);
                for (texels, squeeze) in
                    [(0.0, 1.0), (0.5, 1.0), (3.0, 1.0), (20.0, 0.1), (60.0, 1.0)]
                {
                    let queries = queries(&map, ndf.roughness(), texels, squeeze, 6);
                    let l1 = error(&map, &ndf, &queries);
                    assert!(
                        l1 < 1e-4,
                        "{kind:?} {wrap:?} {lattice:?} σ {sigma}, {texels} texels: {l1}"
                    );
                }
            }
        }
    }
}

#[test]
fn one_package_serves_blunter_kernels() {
    let map = sample_map(Kind::Waves, 128, 128, 3, Wrap::Repeat);
    let bytes = baked(&map, CURVED, 0.003);
    for sigma in [0.003, 0.01, 0.05, 0.2] {
        let ndf = lobes(&bytes)
            .with_roughness(sigma * SQRT_2)
            .expect("in range");
        let l1 = error(&map, &ndf, &queries(&map, ndf.roughness(), 9.0, 1.0, 15));
        assert!(l1 < 1e-4, "σ {sigma}: {l1}");
    }
}

#[test]
fn the_papers_sum_ripples_and_the_quotient_does_not() {
    let map = NormalMap::new(32, 32, Wrap::Repeat, vec![[0.2, -0.1]; 1024]);
    let sigma = 0.01;
    let bytes = baked(&map, CURVED, sigma);
    let (ndf, raw) = (lobes(&bytes), lobes(&bytes).with_raw_sum(true));
    let peak = 1.0 / (core::f64::consts::TAU * sigma * sigma);
    let h = HalfVector { s: 0.2, t: -0.1 };
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for place in 0..40 {
        let centre = [
            (3.0 + 0.05 * f64::from(place)) / 32.0,
            (5.0 + 0.05 * f64::from(place)) / 32.0,
        ];
        let footprint = Footprint {
            centre,
            edge_1: [0.0; 2],
            edge_2: [0.0; 2],
        };
        let quotient = ndf.eval(&footprint, h).expect("in range") / peak;
        assert!((quotient - 1.0).abs() < 1e-4, "{quotient}");
        let plain = raw.eval(&footprint, h).expect("in range");
        let truth = Prepared::new(&map, &footprint, CURVED, false).ndf(h, ndf.roughness());
        assert!((plain / truth - 1.0).abs() < 1e-4);
        range = [range[0].min(plain / peak), range[1].max(plain / peak)];
    }
    assert!(range[0] < 0.92 && range[1] > 1.08, "{range:?}");
}

#[test]
fn no_lobe_is_lost_at_any_roughness() {
    for (kind, lattice) in [
        (Kind::Waves, CURVED),
        (Kind::Waves, FLAT),
        (Kind::Brushed, CURVED),
    ] {
        let map = sample_map(kind, 96, 96, 11, Wrap::Repeat);
        for sigma in [0.02, 0.08] {
            let bytes = baked(&map, lattice, sigma);
            let ndf = lobes(&bytes);
            let mut stream = Stream::new(2);
            for texels in [0.0, 2.0, 30.0] {
                let footprint = stream.footprint(&map, texels);
                let energy = energy(&ndf, &footprint, sigma);
                assert!(
                    (energy - 1.0).abs() < 1e-3,
                    "{kind:?} {lattice:?} σ {sigma}, {texels} texels: {energy}"
                );
            }
        }
    }
}

#[test]
fn stiff_maps_and_extreme_footprints_keep_to_the_plain_sum() {
    let mut stream = Stream::new(17);
    // Steps between the ends of the disk: |J| σh / σr of up to 6000.
    let steps: Vec<[f32; 2]> = (0..24 * 17)
        .map(|_| {
            let pick = |x: f64| if x < 0.5 { -0.69_f32 } else { 0.69 };
            [pick(stream.uniform()), pick(stream.uniform())]
        })
        .collect();
    let steps = NormalMap::new(24, 17, Wrap::Repeat, steps);
    let single = NormalMap::new(1, 1, Wrap::Repeat, vec![[0.3, 0.1]]);
    let line = sample_map(Kind::Waves, 1, 70, 3, Wrap::Repeat);
    let noise = sample_map(Kind::Noise, 33, 40, 3, Wrap::Clamp);
    for (name, map) in [
        ("steps", &steps),
        ("1 x 1", &single),
        ("1 x 70", &line),
        ("noise", &noise),
    ] {
        for sigma in [1e-4, 0.005, 0.25] {
            let bytes = baked(map, CURVED, sigma);
            let ndf = lobes(&bytes);
            let side = f64::from(map.width().min(map.height()));
            for (texels, squeeze) in [
                (1e-4, 1.0),
                (2.0, 1e-6),
                (5.0, 1.0),
                (0.9 * side, 1e-3),
                (3.0 * side, 1.0),
                (40.0 * side, 1e-6),
            ] {
                let mut queries = queries(map, ndf.roughness(), texels, squeeze, 6);
                for (footprint, _) in &mut queries {
                    footprint.centre = footprint.centre.map(|x| x + 1e6);
                }
                if map.wrap() == Wrap::Clamp {
                    // A million tiles beyond the border there is only the corner.
                    for (footprint, _) in &mut queries {
                        footprint.centre = footprint.centre.map(|x| x - 1e6);
                    }
                }
                let l1 = error(map, &ndf, &queries);
                assert!(
                    l1 < 1e-3,
                    "{name}, σ {sigma}, {texels} texels, squeezed {squeeze}: {l1}"
                );
            }
        }
    }
}

#[test]
fn half_vectors_beyond_the_disk_and_boxes_have_no_density() {
    let map = sample_map(Kind::Waves, 40, 40, 3, Wrap::Repeat);
    let bytes = baked(&map, CURVED, 0.01);
    let footprint = Footprint::square([0.5; 2], 3.0, 40, 40);
    let ndf = lobes(&bytes);
    let beyond = HalfVector { s: 0.9, t: 0.9 };
    assert_eq!(ndf.eval(&footprint, beyond), Ok(0.0));
    assert_eq!(ndf.pdf(&footprint, beyond), Ok(0.0));
    let nowhere = HalfVector {
        s: f64::NAN,
        t: 0.0,
    };
    assert_eq!(ndf.eval(&footprint, nowhere), Err(QueryError::NotFinite));
    let boxed = ndf.with_filter(Filter::Box);
    let refused = Err(QueryError::FilterUnsupported(Method::Lobes));
    assert_eq!(
        boxed.eval(&footprint, HalfVector { s: 0.0, t: 0.0 }),
        refused
    );
}

#[test]
fn flat_ground_costs_next_to_nothing() {
    let flat = NormalMap::new(256, 256, Wrap::Repeat, vec![[0.25, 0.125]; 65_536]);
    let bytes = baked(&flat, CURVED, 0.005);
    let texels = 65_536.0;
    assert!((bytes.len() as f64) < 2.0 * texels, "{} bytes", bytes.len());
    let ndf = lobes(&bytes);
    let l1 = error(&flat, &ndf, &queries(&flat, ndf.roughness(), 30.0, 1.0, 10));
    assert!(l1 < 1e-4, "{l1}");
    // A plane is as cheap as flat ground, but for the seam.
    let ramp: Vec<[f32; 2]> = (0..65_536)
        .map(|texel| [(texel % 256) as f32 / 2048.0, 0.0])
        .collect();
    let ramp = NormalMap::new(256, 256, Wrap::Clamp, ramp);
    let bytes = baked(&ramp, CURVED, 0.005);
    assert!((bytes.len() as f64) < 2.6 * texels, "{} bytes", bytes.len());
    let ndf = lobes(&bytes);
    let l1 = error(&ramp, &ndf, &queries(&ramp, ndf.roughness(), 30.0, 1.0, 10));
    assert!(l1 < 1e-4, "{l1}");
}

#[test]
fn merging_keeps_within_what_was_asked() {
    let map = sample_map(Kind::Waves, 128, 128, 9, Wrap::Repeat);
    let mut sizes = Vec::new();
    for merge_error in [0.0, 0.01, 0.1] {
        let recipe = MethodRecipe {
            lattice: Some(CURVED),
            merge_error: Some(merge_error),
            ..MethodRecipe::new(Method::Lobes, &[0.05 * SQRT_2])
        };
        let bytes = package(&map, recipe);
        let ndf = lobes(&bytes);
        let queries = queries(&map, ndf.roughness(), 4.0, 1.0, 20);
        let l1 = error(&map, &ndf, &queries);
        assert!(l1 <= merge_error + 1e-4, "{merge_error}: {l1}");
        sizes.push(bytes.len());
    }
    assert!(sizes[0] >= sizes[1] && sizes[1] > sizes[2], "{sizes:?}");
}

#[test]
fn facets_add_up_to_the_density_and_instructions_agree() {
    let map = sample_map(Kind::Waves, 90, 61, 3, Wrap::Clamp);
    for lattice in LATTICES {
        let bytes = baked(&map, lattice, 0.01);
        let ndf = lobes(&bytes);
        for (footprint, h) in queries(&map, ndf.roughness(), 12.0, 0.5, 10) {
            let density = ndf.eval(&footprint, h).expect("in range");
            let mut sum = 0.0;
            ndf.facets(&footprint, h, &mut |facet| {
                sum += facet.density * facet.weight
            })
            .expect("in range");
            assert!((sum - density).abs() <= 2e-4 * density, "{sum} {density}");
            let portable = ndf.with_instructions(Instructions::Portable);
            assert_eq!(portable.eval(&footprint, h), Ok(density));
        }
    }
}

#[test]
fn fresh_packages_have_no_faults() {
    for (kind, wrap) in [(Kind::Waves, Wrap::Repeat), (Kind::Noise, Wrap::Clamp)] {
        let map = sample_map(kind, 70, 45, 3, wrap);
        for lattice in LATTICES {
            let bytes = baked(&map, lattice, 0.004);
            let container = glintbake_format::Container::open(&bytes).expect("it opens");
            check::full(&container, &mut |finding| panic!("{finding}"));
        }
    }
}
