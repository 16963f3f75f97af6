//! Energy: each flake's kernel integrates to 1 in its own frame, but for what the setting is known to lose.

use glintbake_format::model::{
    Footprint, HalfVector, Interpolation, LobeLattice, Neighbourhood, Wrap,
};
use glintbake_runtime::{Ndf, Package, Setting};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{
    Stream, flake_package, lobes_package, sample_map, specular_package, surface_package,
};
use glintbake_tests::tolerances::ENERGY;

/// ∫ pdf dω over the hemisphere by midpoints on the disk, `steps` a side within `reach` of (s, t).
fn energy(
    ndf: &impl Ndf,
    footprint: &Footprint,
    centre: HalfVector,
    reach: f64,
    steps: u32,
) -> f64 {
    let step = 2.0 * reach / f64::from(steps);
    let mut sum = 0.0;
    for row in 0..steps {
        for column in 0..steps {
            let h = HalfVector {
                s: centre.s - reach + (f64::from(column) + 0.5) * step,
                t: centre.t - reach + (f64::from(row) + 0.5) * step,
            };
            if h.is_on_disk() {
                sum += ndf.pdf(footprint, h).unwrap() / h.direction()[2] * step * step;
            }
        }
    }
    sum
}

const POLE: HalfVector = HalfVector { s: 0.0, t: 0.0 };

#[test]
fn a_flake_keeps_its_energy_at_every_roughness() {
    let map = sample_map(Kind::Flat, 2, 2, 0, Wrap::Repeat);
    let footprint = Footprint::square([0.5; 2], 1.0, 2, 2);
    for alpha in [1e-4, 1e-3, 0.01, 0.07, 0.2] {
        let bytes = flake_package(&map, &[alpha]);
        let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
        let energy_45 = energy(&ndf, &footprint, POLE, (5.0 * alpha).min(1.0), 400);
        assert!((energy_45 - 1.0).abs() < ENERGY, "{alpha}: {energy_45}");
        let paper = ndf
            .with_setting(Setting::Binned(Neighbourhood::Bins21))
            .unwrap();
        let energy_21 = energy(&paper, &footprint, POLE, (5.0 * alpha).min(1.0), 400);
        assert!(
            (0.97..0.995).contains(&energy_21),
            "the paper's 21 bins lose about 1 %, not to {energy_21}"
        );
    }
}

#[test]
fn a_surface_of_gentle_slopes_keeps_its_energy() {
    let map = sample_map(Kind::Waves, 64, 64, 2, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.1]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let mut stream = Stream::new(3);
    for texels in [0.5, 10.0, 100.0] {
        let footprint = stream.footprint(&map, texels);
        let sum = energy(&ndf, &footprint, POLE, 1.0, 600);
        assert!((sum - 1.0).abs() < ENERGY, "{texels}: {sum}");
        let exact = ndf.with_setting(Setting::Exact).unwrap();
        if texels < 50.0 {
            let sum = energy(&exact, &footprint, POLE, 1.0, 600);
            assert!((sum - 1.0).abs() < ENERGY, "exact, {texels}: {sum}");
        }
    }
}

#[test]
fn lobes_and_surfaces_keep_their_energy() {
    let map = sample_map(Kind::Waves, 48, 32, 2, Wrap::Clamp);
    let lattice = |curved, per_side| LobeLattice { curved, per_side };
    for bytes in [
        lobes_package(&map, lattice(true, 1), &[0.1]),
        lobes_package(&map, lattice(false, 1), &[0.1]),
        lobes_package(&map, lattice(true, 2), &[0.1]),
        surface_package(&map, Interpolation::None, &[0.1]),
        surface_package(&map, Interpolation::Linear, &[0.1]),
        surface_package(&map, Interpolation::CatmullRom, &[0.1]),
    ] {
        let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
        let mut stream = Stream::new(3);
        for texels in [0.0, 0.2, 1.0, 10.0, 100.0] {
            let footprint = stream.footprint(&map, texels);
            let sum = energy(&ndf, &footprint, POLE, 1.0, 100);
            assert!(
                (sum - 1.0).abs() < ENERGY,
                "{:?}, {texels}: {sum}",
                ndf.instance().structure
            );
        }
    }
}

#[test]
fn specular_bins_keep_all_energy() {
    let map = sample_map(Kind::Noise, 32, 32, 2, Wrap::Repeat);
    let bytes = specular_package(&map, 9);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let footprint = Stream::new(3).footprint(&map, 20.0);
    // Midpoints of the square are equal solid angles: the integral is exact up to rounding.
    let grid = ndf.instance().bins().unwrap().grid;
    let mut sum = 0.0;
    for row in 0..9 {
        for column in 0..9 {
            let h = grid.normal_in_bin(column, row, 0.5, 0.5);
            sum += ndf.eval(&footprint, h).unwrap() * grid.solid_angle();
        }
    }
    assert!((sum - 1.0).abs() < 1e-12, "{sum}");
}
