//! Samples against the pdf: χ² over a partition of the hemisphere, with "no vector" as a cell of its own.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle;
use glintbake_format::model::{
    Filter, Footprint, HalfVector, Interpolation, LobeLattice, Neighbourhood, Wrap,
};
use glintbake_runtime::{Ndf, Package, Setting, SurfaceNdf};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{
    Stream, flake_package, lean_package, lobes_package, sample_map, specular_package,
    surface_package,
};
use std::f64::consts::TAU;

/// A cut of the hemisphere into cells of equal solid angle: a product of two intervals in each of which a fraction
/// names a direction.
struct Partition {
    cells: [usize; 2],
    /// Fractions in [0, 1) of a direction.
    fractions: fn(HalfVector) -> [f64; 2],
    /// The direction of fractions.
    direction: fn([f64; 2]) -> HalfVector,
}

impl Partition {
    /// The cell of "no vector".
    fn nothing(&self) -> usize {
        self.cells[0] * self.cells[1]
    }
}

/// Cells in the cosine to the surface, and around it: no singular rim to integrate over.
const RINGS: Partition = Partition {
    cells: [30, 48],
    fractions: |h| [h.direction()[2], (h.t.atan2(h.s) / TAU).rem_euclid(1.0)],
    direction: |[z, turn]| {
        let radius = (1.0 - z * z).sqrt();
        HalfVector {
            s: radius * (turn * TAU).cos(),
            t: radius * (turn * TAU).sin(),
        }
    },
};

/// Three by three cells in each of 12 × 12 bins of equal solid angle, by the oracle's map: a density that is constant
/// in bins is constant in cells.
const BINS: Partition = Partition {
    cells: [36, 36],
    fractions: oracle::specular_bins::square_of,
    direction: oracle::specular_bins::normal_at,
};

/// Samples drawn.
const SAMPLES: usize = 200_000;
/// Midpoints per side of a cell, for integrating the pdf; kernels used here span several cells.
const MIDPOINTS: usize = 16;
/// Cells that expect fewer samples are pooled: the χ² law needs about five.
const LEAST_EXPECTED: f64 = 5.0;

/// Samples and the pdf's integral over each cell; the last cell is "no vector".
fn counts_and_masses(
    ndf: &SurfaceNdf<'_>,
    footprint: &Footprint,
    partition: &Partition,
) -> (Vec<f64>, Vec<f64>) {
    let [rows, columns] = partition.cells;
    let mut counts = vec![0.0; partition.nothing() + 1];
    let mut stream = Stream::new(77);
    for _ in 0..SAMPLES {
        let uniform = std::array::from_fn(|_| stream.uniform());
        let drawn = ndf.sample(footprint, uniform).unwrap();
        let cell = drawn.map_or(partition.nothing(), |h| {
            let [x, y] = (partition.fractions)(h);
            let row = (x * rows as f64) as usize;
            let column = (y * columns as f64) as usize;
            row.min(rows - 1) * columns + column.min(columns - 1)
        });
        counts[cell] += 1.0;
    }
    let mut masses = vec![0.0; partition.nothing() + 1];
    let (fine_rows, fine_columns) = (rows * MIDPOINTS, columns * MIDPOINTS);
    let solid_angle = TAU / (fine_rows * fine_columns) as f64;
    for row in 0..fine_rows {
        for column in 0..fine_columns {
            let h = (partition.direction)([
                (row as f64 + 0.5) / fine_rows as f64,
                (column as f64 + 0.5) / fine_columns as f64,
            ]);
            let mass = ndf.pdf(footprint, h).unwrap() * solid_angle;
            masses[row / MIDPOINTS * columns + column / MIDPOINTS] += mass;
        }
    }
    let total: f64 = masses.iter().sum();
    masses[partition.nothing()] = 1.0 - total;
    (counts, masses)
}

/// The standard normal deviate of the χ² statistic (Wilson and Hilferty 1931), and the degrees of freedom.
fn chi_square_deviate(counts: &[f64], masses: &[f64]) -> (f64, f64) {
    let mut statistic = 0.0;
    let mut cells = 0.0;
    let (mut pooled_count, mut pooled_mass) = (0.0, 0.0);
    let mut add = |count: f64, mass: f64| {
        let expected = mass * SAMPLES as f64;
        statistic += (count - expected).powi(2) / expected;
        cells += 1.0;
    };
    for (&count, &mass) in counts.iter().zip(masses) {
        if mass * SAMPLES as f64 >= LEAST_EXPECTED {
            add(count, mass);
        } else {
            pooled_count += count;
            pooled_mass += mass;
        }
    }
    if pooled_mass * SAMPLES as f64 >= LEAST_EXPECTED {
        add(pooled_count, pooled_mass);
    } else {
        assert!(
            pooled_count <= 30.0,
            "{pooled_count} samples fell where the pdf leaves {pooled_mass:e}"
        );
    }
    let degrees: f64 = cells - 1.0;
    let spread = 2.0 / (9.0 * degrees);
    (
        ((statistic / degrees).cbrt() - (1.0 - spread)) / spread.sqrt(),
        degrees,
    )
}

fn check(ndf: &SurfaceNdf<'_>, footprint: &Footprint, partition: &Partition, what: &str) {
    let (counts, masses) = counts_and_masses(ndf, footprint, partition);
    let (deviate, degrees) = chi_square_deviate(&counts, &masses);
    // One in 30 000 for a right sampler; seeds are fixed, so a pass stays a pass.
    assert!(
        deviate < 4.0,
        "{what}: χ² with {degrees} degrees of freedom lies {deviate:.1} standard deviations out"
    );
    assert!(degrees > 10.0, "{what}: too few cells to mean anything");
}

#[test]
fn flake_bins_samples_follow_the_pdf_for_every_setting() {
    let map = sample_map(Kind::Waves, 48, 32, 3, Wrap::Repeat);
    let footprint = Stream::new(5).footprint(&map, 9.0);
    let bytes = flake_package(&map, &[0.15, 0.4]);
    let package = Package::open(&bytes).unwrap();
    for number in [1, 2] {
        for setting in [
            Setting::Binned(Neighbourhood::Bins45),
            Setting::Binned(Neighbourhood::Bins21),
            Setting::Exact,
        ] {
            let ndf = package.ndf(number).unwrap().with_setting(setting).unwrap();
            check(
                &ndf,
                &footprint,
                &RINGS,
                &format!("instance {number}, {setting:?}"),
            );
        }
    }
}

#[test]
fn flake_bins_samples_follow_the_pdf_where_flakes_lean_to_the_rim() {
    // Noise of wide spread puts bin centres beyond the disk and lobes across the horizon.
    let map = sample_map(Kind::Noise, 24, 24, 8, Wrap::Clamp);
    let tilted = NormalMap::new(
        24,
        24,
        Wrap::Clamp,
        map.texels()
            .iter()
            .map(|[s, t]| [0.9 + 0.05 * s, 0.2 + 0.3 * t])
            .collect(),
    );
    let footprint = Stream::new(6).footprint(&tilted, 12.0);
    let bytes = flake_package(&tilted, &[0.3]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    check(&ndf, &footprint, &RINGS, "rim");
}

#[test]
fn samples_follow_the_pdf_under_gaussian_footprints() {
    for (wrap, setting) in [
        (Wrap::Repeat, Setting::default()),
        (Wrap::Clamp, Setting::Exact),
    ] {
        let map = sample_map(Kind::Waves, 24, 16, 3, wrap);
        let mut footprint = Stream::new(5).footprint(&map, 2.5);
        // Across the border.
        footprint.centre = [0.1, 0.97];
        let bytes = flake_package(&map, &[0.2]);
        let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
        let ndf = ndf
            .with_filter(Filter::Gaussian)
            .with_setting(setting)
            .unwrap();
        check(
            &ndf,
            &footprint,
            &RINGS,
            &format!("Gaussian, {wrap:?}, {setting:?}"),
        );
    }
}

#[test]
fn specular_bins_samples_follow_the_pdf() {
    let map = sample_map(Kind::Waves, 48, 32, 3, Wrap::Repeat);
    let footprint = Stream::new(5).footprint(&map, 9.0);
    let bytes = specular_package(&map, 12);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    check(&ndf, &footprint, &BINS, "specular-bins");
}

#[test]
fn lean_samples_follow_the_pdf() {
    let map = sample_map(Kind::Waves, 48, 32, 3, Wrap::Repeat);
    let bytes = lean_package(&map, &[0.15]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let mut stream = Stream::new(5);
    for texels in [0.3, 9.0] {
        let footprint = stream.footprint(&map, texels);
        for filter in [Filter::Box, Filter::Gaussian] {
            let what = format!("lean, {texels} texels, {filter:?}");
            check(&ndf.with_filter(filter), &footprint, &RINGS, &what);
        }
    }
    // A lobe of which the rim cuts off a third: no vector is a cell of its own.
    let tilted = NormalMap::new(2, 1, Wrap::Clamp, vec![[0.95, 0.2], [0.8, 0.3]]);
    let bytes = lean_package(&tilted, &[0.3]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    let footprint = Footprint::square([0.4, 0.5], 1.5, 2, 1);
    check(&ndf, &footprint, &RINGS, "lean at the rim");
}

#[test]
fn samples_of_lobes_and_surfaces_follow_the_pdf() {
    let lattice = |curved, per_side| LobeLattice { curved, per_side };
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let map = sample_map(Kind::Waves, 24, 16, 3, wrap);
        let mut stream = Stream::new(5);
        let mut across_border = stream.footprint(&map, 2.5);
        across_border.centre = [0.1, 0.97];
        let small = stream.footprint(&map, 0.4);
        let mut cases = vec![
            (lobes_package(&map, lattice(true, 1), &[0.2]), small),
            (lobes_package(&map, lattice(true, 1), &[0.2]), across_border),
            (
                lobes_package(&map, lattice(false, 2), &[0.2]),
                across_border,
            ),
            (
                surface_package(&map, Interpolation::Linear, &[0.2]),
                across_border,
            ),
        ];
        if wrap == Wrap::Repeat {
            // 32 triangles a texel.
            let bytes = surface_package(&map, Interpolation::CatmullRom, &[0.2]);
            cases.push((bytes, small));
        }
        for (bytes, footprint) in cases {
            let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
            let what = format!("{:?}, {wrap:?}, {footprint:?}", ndf.instance().structure);
            check(&ndf, &footprint, &RINGS, &what);
        }
    }
    // Of lobes that the rim cuts, no vector is a cell of its own; raw sums are sampled as normalised ones.
    let tilted = NormalMap::new(2, 1, Wrap::Clamp, vec![[0.95, 0.2], [0.8, 0.3]]);
    let footprint = Footprint::square([0.4, 0.5], 1.5, 2, 1);
    let bytes = lobes_package(&tilted, lattice(true, 1), &[0.3]);
    let Ok(SurfaceNdf::Lobes(ndf)) = Package::open(&bytes).unwrap().ndf(1) else {
        panic!("baked for lobes");
    };
    let raw = SurfaceNdf::Lobes(ndf.with_raw_sum(true));
    check(&raw, &footprint, &RINGS, "raw lobes at the rim");
    let bytes = surface_package(&tilted, Interpolation::Linear, &[0.3]);
    let ndf = Package::open(&bytes).unwrap().ndf(1).unwrap();
    check(&ndf, &footprint, &RINGS, "a surface at the rim");
}

#[test]
fn the_test_itself_rejects_the_paper_neighbourhood_if_its_loss_is_ignored() {
    // 21 bins lose 1 %: a sampler that never returned "no vector" would be caught by this very test.
    let map = sample_map(Kind::Flat, 4, 4, 0, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.15]);
    let ndf = Package::open(&bytes)
        .unwrap()
        .ndf(1)
        .unwrap()
        .with_setting(Setting::Binned(Neighbourhood::Bins21))
        .unwrap();
    let footprint = Footprint::square([0.5; 2], 1.0, 4, 4);
    let (mut counts, masses) = counts_and_masses(&ndf, &footprint, &RINGS);
    let lost = counts.pop().unwrap();
    assert!(lost > 0.005 * SAMPLES as f64, "the paper's loss is seen");
    let kept: f64 = counts.iter().sum();
    for count in &mut counts {
        *count *= SAMPLES as f64 / kept;
    }
    counts.push(0.0);
    let (deviate, _) = chi_square_deviate(&counts, &masses);
    assert!(deviate > 10.0, "{deviate}");
}
