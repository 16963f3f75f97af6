//! Points, lines, needles, and footprints at the ends of what is accepted.

use super::super::GaussianFootprint;
use super::{Random, from_edges, gaussian};
use crate::error::QueryError;
use core::f64::consts::{FRAC_1_SQRT_2, PI};
use glintbake_format::model::{Footprint, MAX_EDGE_TILES, Wrap};

/// Φ.
fn below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

#[test]
fn a_point_is_the_texel_it_lies_in() {
    for (centre, texel) in [
        ([3.5, 2.25], [3, 2]),
        ([3.0, 2.0], [3, 2]),
        ([0.0, 1023.999], [0, 1023]),
    ] {
        for tiny in [0.0, 1e-200, 1e-110] {
            let footprint = from_edges(centre, [tiny, 0.0], [0.3 * tiny, 0.0]);
            assert_eq!(footprint.texel_weight(texel[0], texel[1]), 1.0);
            assert_eq!(footprint.row(texel[1]).weight(texel[0]), 1.0);
            assert_eq!(footprint.sample([0.9, 0.3]), texel);
            assert!(footprint.row_columns(texel[1]).contains(&texel[0]));
            for [x, y] in [[-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1]] {
                assert!(footprint.texel_weight(texel[0] + x, texel[1] + y) < 1e-15);
            }
        }
    }
}

#[test]
fn a_line_along_a_border_belongs_to_the_texels_that_it_begins() {
    for (edge, along) in [([5.0, 0.0], [1, 0]), ([0.0, -5.0], [0, 1])] {
        let footprint = from_edges([100.0, 200.0], edge, [0.0; 2]);
        for step in -12..12_i64 {
            let [x, y] = [100 + along[0] * step, 200 + along[1] * step];
            let exact = below((step + 1) as f64 / 2.5) - below(step as f64 / 2.5);
            assert!((footprint.texel_weight(x, y) - exact).abs() < 1e-10);
            assert_eq!(footprint.texel_weight(x - along[1], y - along[0]), 0.0);
        }
    }
}

#[test]
fn parallel_edges_are_a_line_of_their_squares_sum() {
    // Steps of 3 and 4 are as good as one of 5: σ = 2.5 in x; y = ±x / 2 crosses columns and rows in turn.
    for sign in [1, -1] {
        let slope = 0.5 * f64::from(sign);
        let line = from_edges([300.0, 400.0], [3.0, 3.0 * slope], [-4.0, -4.0 * slope]);
        let mut sum = 0.0;
        for step in -13..13_i64 {
            let row = 400 + libm::floor((step as f64 + 0.5) * slope) as i64;
            let exact = below((step + 1) as f64 / 2.5) - below(step as f64 / 2.5);
            let weight = line.texel_weight(300 + step, row);
            sum += weight;
            if step.abs() < 12 {
                assert!((weight - exact).abs() < 1e-10, "{weight} {exact} at {step}");
            }
        }
        assert!((sum - 1.0).abs() < 3e-6, "{sum}");
    }
}

#[test]
fn needles_run_into_their_line() {
    let mut random = Random(41);
    for _ in 0..200 {
        let (centre, angle) = (
            [random.between(0.0, 900.0), random.between(0.0, 900.0)],
            random.between(-PI, PI),
        );
        let line = gaussian(centre, 5.0, 0.0, angle);
        let [column, row] = line.sample([random.unit(), random.unit()]);
        let exact = line.texel_weight(column, row);
        for exponent in 3..18 {
            let short = libm::pow(10.0, -f64::from(exponent));
            let weight = gaussian(centre, 5.0, short, angle).texel_weight(column, row);
            assert!(
                (weight - exact).abs() < short + 2e-9,
                "{weight} instead of {exact} at {short}"
            );
        }
    }
}

#[test]
fn ways_to_a_weight_meet_where_they_change() {
    // Just below and above each change of σ the weights differ by the errors stated, not more.
    let mut random = Random(42);
    for (change, error) in [(0.5, 2e-5), (1.0, 4e-6), (2.0, 4e-6)] {
        for _ in 0..300 {
            let centre = [random.between(0.0, 900.0), random.between(0.0, 900.0)];
            let (long, angle) = (change * random.between(1.0, 30.0), random.between(-PI, PI));
            let [under, over] =
                [-1e-9, 1e-9].map(|off| gaussian(centre, long, change + off, angle));
            let [column, row] = over.sample([random.unit(), random.unit()]);
            let peak = 1.0 / (2.0 * PI * change * long);
            let step = (under.texel_weight(column, row) - over.texel_weight(column, row)).abs();
            assert!(step < error * peak, "{step:e} of {peak} at {change}");
        }
    }
}

#[test]
fn nothing_is_ever_not_a_number() {
    let lengths = [
        0.0,
        1e-310,
        1e-160,
        1e-99,
        1e-20,
        1e-4,
        0.3,
        1.0,
        MAX_EDGE_TILES,
    ];
    let centres = [0.0, 1.0 - f64::EPSILON, 0.5, -1e-300, 1e6 + 0.3, -1e300];
    let mut random = Random(43);
    for case in 0..60_000 {
        let edge = |random: &mut Random| {
            let mut component = || {
                let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
                sign * lengths[random.whole(0, lengths.len() as i64) as usize]
            };
            [component(), component()]
        };
        let footprint = Footprint {
            centre: [0, 1].map(|_| centres[random.whole(0, centres.len() as i64) as usize]),
            edge_1: edge(&mut random),
            edge_2: edge(&mut random),
        };
        let wrap = [Wrap::Repeat, Wrap::Clamp][case % 2];
        let (width, height) = ([1, 7, 65_535][case % 3], [65_535, 1, 20][case % 3]);
        let gaussian = GaussianFootprint::new(&footprint, width, height, wrap)
            .expect("finite and not too large");
        let [column, row] = gaussian.sample([random.unit(), random.unit()]);
        assert!(
            gaussian.row_columns(row).contains(&column) && gaussian.rows().contains(&row),
            "{footprint:?}"
        );
        for (column, row) in [(column, row), (column + 1, row), (column, row - 1), (0, 0)] {
            let weight = gaussian.texel_weight(column, row);
            assert!((0.0..=1.0).contains(&weight), "{weight} of {footprint:?}");
            assert_eq!(weight, gaussian.row(row).weight(column), "{footprint:?}");
        }
        assert!(gaussian.least_deviation().is_finite());
    }
}

#[test]
fn whole_tiles_away_nothing_changes() {
    let here = Footprint {
        centre: [0.312_5, 0.75],
        edge_1: [0.003, -0.001],
        edge_2: [0.000_5, 0.002],
    };
    let there = Footprint {
        centre: [1e6 + 0.312_5, -1e6 + 0.75],
        ..here
    };
    let [near, far] = [here, there].map(|footprint| {
        GaussianFootprint::new(&footprint, 1000, 600, Wrap::Repeat).expect("in range")
    });
    for row in near.rows() {
        assert_eq!(near.row_columns(row), far.row_columns(row));
        for column in near.row_columns(row) {
            assert_eq!(
                near.texel_weight(column, row),
                far.texel_weight(column, row)
            );
        }
    }
}

#[test]
fn bad_footprints_are_refused_as_boxes_are() {
    let good = Footprint {
        centre: [0.0; 2],
        edge_1: [0.1, 0.0],
        edge_2: [0.0, 0.1],
    };
    let refusal = |footprint: Footprint| {
        GaussianFootprint::new(&footprint, 8, 8, Wrap::Repeat).expect_err("to be refused")
    };
    assert_eq!(
        refusal(Footprint {
            centre: [f64::NAN, 0.0],
            ..good
        }),
        QueryError::NotFinite
    );
    assert_eq!(
        refusal(Footprint {
            edge_2: [0.0, -1.001 * MAX_EDGE_TILES],
            ..good
        }),
        QueryError::FootprintTooLarge
    );
}
