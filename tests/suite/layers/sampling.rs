//! Samples of materials against their density: χ² over the directions of light.

use super::{car_paint, exact_flakes, flakes, open};
use crate::masking::direction;
use glintbake_format::model::{Footprint, Wrap};
use glintbake_runtime::Material;
use glintbake_tests::fixtures::Stream;
use glintbake_tests::materials::{Layer, material};
use std::f64::consts::TAU;

/// Cells in the cosine and around it.
const CELLS: [usize; 2] = [16, 24];
const SAMPLES: usize = 60_000;
/// Midpoints per side of a cell.
const MIDPOINTS: usize = 14;

/// χ² of samples for `view`, as a standard normal deviate (Wilson and Hilferty 1931); the last cell is "no direction".
fn deviate(material: &Material<'_>, footprint: &Footprint, view: [f64; 3]) -> f64 {
    let [rows, columns] = CELLS;
    let mut counts = vec![0.0; rows * columns + 1];
    let mut stream = Stream::new(31);
    for _ in 0..SAMPLES {
        let uniform = std::array::from_fn(|_| stream.uniform());
        let cell = match material.sample(footprint, view, uniform).unwrap() {
            None => rows * columns,
            Some([x, y, z]) => {
                assert!((x * x + y * y + z * z - 1.0).abs() < 1e-9 && z > 0.0);
                let turn = (y.atan2(x) / TAU).rem_euclid(1.0);
                let place =
                    |share: f64, cells: usize| ((share * cells as f64) as usize).min(cells - 1);
                place(z, rows) * columns + place(turn, columns)
            }
        };
        counts[cell] += 1.0;
    }
    let mut masses = vec![0.0; rows * columns + 1];
    let (fine_rows, fine_columns) = (rows * MIDPOINTS, columns * MIDPOINTS);
    for row in 0..fine_rows {
        for column in 0..fine_columns {
            let light = direction(
                (row as f64 + 0.5) / fine_rows as f64,
                (column as f64 + 0.5) / fine_columns as f64,
            );
            masses[row / MIDPOINTS * columns + column / MIDPOINTS] +=
                material.pdf(footprint, light, view).unwrap() * TAU
                    / (fine_rows * fine_columns) as f64;
        }
    }
    masses[rows * columns] = 1.0 - masses.iter().sum::<f64>();
    let (mut statistic, mut cells) = (0.0, 0.0);
    for (count, mass) in counts.iter().zip(&masses) {
        let expected = mass * SAMPLES as f64;
        if expected >= 5.0 {
            statistic += (count - expected).powi(2) / expected;
            cells += 1.0;
        } else {
            assert!(
                *count <= 30.0,
                "{count} samples where {expected} are expected"
            );
        }
    }
    let degrees: f64 = cells - 1.0;
    assert!(degrees > 100.0, "too few cells to mean anything");
    let spread = 2.0 / (9.0 * degrees);
    ((statistic / degrees).cbrt() - (1.0 - spread)) / spread.sqrt()
}

#[test]
fn samples_follow_the_density_of_all_layers_together() {
    // Blunt enough that a cell's mass is the sum over its midpoints.
    let tilted = Layer::coat(1.6, 0.0).mapped(&flakes(), exact_flakes(0.35, false));
    let bare = vec![tilted, Layer::base([0.04; 3], [0.3; 3], 0.5)];
    let mut half = car_paint(0.3, 0.35);
    half[0].recipe.opacity = 0.5;
    let footprint = Stream::new(5).footprint(&flakes(), 7.0);
    for (name, layers) in [
        ("car paint", car_paint(0.3, 0.35)),
        ("worn", half),
        ("bare", bare),
    ] {
        let bytes = material(&layers);
        let material = open(&bytes);
        for cosine in [0.95, 0.4] {
            let deviate = deviate(&material, &footprint, direction(cosine, 0.15));
            // One in 30 000 for a right sampler; seeds are fixed, so a pass stays a pass.
            assert!(
                deviate < 4.0,
                "{name} {cosine}: {deviate:.1} standard deviations out"
            );
        }
    }
}

#[test]
fn the_test_rejects_a_density_that_forgets_a_layer() {
    let layers = car_paint(0.3, 0.35);
    let (whole, part) = (material(&layers), material(&layers[..2]));
    let footprint = Stream::new(5).footprint(&flakes(), 7.0);
    let view = direction(0.4, 0.15);
    let (whole, part) = (open(&whole), open(&part));
    let mut differ = 0.0;
    for index in 0..200 {
        let light = direction((f64::from(index) + 0.5) / 200.0, 0.37 * f64::from(index));
        let [one, other] = [whole, part].map(|it| it.pdf(&footprint, light, view).unwrap());
        differ += (one - other).abs() * TAU / 200.0;
    }
    assert!(differ > 0.1, "only {differ} of the density is the base's");
}

#[test]
fn a_covered_layer_gets_no_samples_and_a_layer_without_cover_none_either() {
    let base = Layer::base([0.04; 3], [0.5; 3], 0.4);
    let flat =
        glintbake_tests::fixtures::sample_map(glintbake_samples::Kind::Flat, 4, 4, 0, Wrap::Repeat);
    let mirror = Layer::glints(&flat, exact_flakes(0.01, true), [0.9; 3]);
    let mut gone = mirror.clone();
    gone.recipe.opacity = 0.0;
    let (covered, bare) = (material(&[mirror, base.clone()]), material(&[gone, base]));
    let patch = Footprint::square([0.5; 2], 1.0, 4, 4);
    let (light, view) = (direction(0.3, 0.1), direction(0.9, 0.7));
    assert_eq!(
        open(&covered).pdf(&patch, light, view),
        Ok(0.0),
        "far from the mirror"
    );
    assert_eq!(open(&covered).eval(&patch, light, view), Ok([0.0; 3]));
    let away = open(&bare).pdf(&patch, light, view).unwrap();
    assert!(away > 0.05, "{away}");
    let mut stream = Stream::new(3);
    for _ in 0..200 {
        let uniform = std::array::from_fn(|_| stream.uniform());
        if let Some(light) = open(&covered).sample(&patch, view, uniform).unwrap() {
            let mirrored = [-view[0], -view[1], view[2]];
            let cosine: f64 = (0..3).map(|axis| light[axis] * mirrored[axis]).sum();
            assert!(cosine > 0.98, "{light:?} is no mirror's");
        }
    }
}
