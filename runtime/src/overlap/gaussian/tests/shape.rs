//! Which texels a Gaussian meets, blocks of texels, and samples.

use super::super::{GaussianFootprint, LOST, RADIUS};
use super::{Random, gaussian, std};
use core::f64::consts::PI;
use std::collections::BTreeMap;

/// Square of the Mahalanobis distance of a point from the centre, of Σ itself.
fn distance_squared(footprint: &GaussianFootprint, [x, y]: [f64; 2]) -> f64 {
    let [first, second] = footprint.half_edges;
    let x = x - footprint.cell[0] - footprint.centre[0];
    let y = y - footprint.cell[1] - footprint.centre[1];
    let determinant = first[0] * second[1] - first[1] * second[0];
    let a = (x * second[1] - y * second[0]) / determinant;
    let b = (y * first[0] - x * first[1]) / determinant;
    a * a + b * b
}

fn any(random: &mut Random, least: f64, greatest: f64) -> GaussianFootprint {
    let short = libm::exp(random.between(libm::log(least), libm::log(greatest)));
    let long = short * libm::exp(random.between(0.0, 3.5));
    let centre = [random.between(300.0, 310.0), random.between(300.0, 310.0)];
    gaussian(centre, long, short, random.between(-PI, PI))
}

/// The columns of row `row` that contain a point of the ellipse, by walking along its outline.
fn outlined(footprint: &GaussianFootprint) -> BTreeMap<i64, (i64, i64)> {
    let [first, second] = footprint.half_edges;
    let mut rows = BTreeMap::new();
    let mut add = |[x, y]: [f64; 2]| {
        let (column, row) = (libm::floor(x) as i64, libm::floor(y) as i64);
        let (start, end) = rows.entry(row).or_insert((column, column));
        *start = column.min(*start);
        *end = column.max(*end);
    };
    let middle = [0, 1].map(|axis| footprint.cell[axis] + footprint.centre[axis]);
    let steps = 400_000;
    for step in 0..steps {
        let (sine, cosine) = libm::sincos(2.0 * PI * f64::from(step) / f64::from(steps));
        add([0, 1].map(|axis| middle[axis] + RADIUS * (cosine * first[axis] + sine * second[axis])));
    }
    rows
}

#[test]
fn rows_and_columns_are_the_texels_that_the_ellipse_meets() {
    let mut random = Random(21);
    for _ in 0..40 {
        let footprint = any(&mut random, 0.02, 12.0);
        let outlined = outlined(&footprint);
        let rows = footprint.rows();
        let walked = outlined.keys().next().copied()..outlined.keys().last().map(|row| row + 1);
        assert_eq!(Some(rows.start)..Some(rows.end), walked);
        for (row, (start, end)) in outlined {
            // A step of the walk is at most 2e-3 texels, and may leave out a corner of a texel that is smaller.
            let columns = footprint.row_columns(row);
            assert!(columns.start <= start && end < columns.end, "{columns:?}");
            for (column, extra) in [
                (columns.start, columns.start < start),
                (columns.end - 1, columns.end - 1 > end),
            ] {
                if extra {
                    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
                    let nearest = corners
                        .map(|(x, y)| {
                            distance_squared(&footprint, [column as f64 + x, row as f64 + y])
                        })
                        .into_iter()
                        .fold(f64::INFINITY, f64::min);
                    assert!(nearest < RADIUS * RADIUS * 1.01, "{nearest}");
                }
            }
        }
        for row in [rows.start - 1, rows.end] {
            assert!(footprint.row_columns(row).is_empty());
        }
    }
}

#[test]
fn strips_are_their_rows_together() {
    let mut random = Random(22);
    for _ in 0..300 {
        let footprint = any(&mut random, 1e-3, 30.0);
        let size = [2, 4, 8, 64][random.whole(0, 4) as usize];
        let rows = footprint.rows();
        let first = random.whole(rows.start - size, rows.end);
        let strip = footprint.strip_columns(first, size);
        let together = (first..first + size)
            .map(|row| footprint.row_columns(row))
            .filter(|columns| !columns.is_empty())
            .reduce(|all, next| all.start.min(next.start)..all.end.max(next.end))
            .unwrap_or(0..0);
        assert_eq!(strip, together, "{size} rows from {first}");
    }
}

#[test]
fn bounds_hold_the_ellipse_and_touch_it() {
    let mut random = Random(23);
    for _ in 0..50 {
        let footprint = any(&mut random, 1e-3, 30.0);
        let bounds = footprint.bounds();
        let [first, second] = footprint.half_edges;
        for axis in [0, 1] {
            let reach = RADIUS * libm::hypot(first[axis], second[axis]);
            let centre = footprint.cell[axis] + footprint.centre[axis];
            for (bound, exact) in [
                (bounds.high[axis], centre + reach),
                (-bounds.low[axis], reach - centre),
            ] {
                let over = bound - exact;
                assert!((0.0..1e-8 * (1.0 + reach)).contains(&over), "{over}");
            }
        }
        let moved = footprint.relative_to(64.0, -128.0).bounds();
        assert!((bounds.low[0] - moved.low[0] - 64.0).abs() < 1e-12);
        assert!((bounds.high[1] - moved.high[1] + 128.0).abs() < 1e-12);
    }
}

#[test]
fn a_footprint_is_the_same_from_every_tile() {
    let mut random = Random(24);
    for _ in 0..100 {
        let footprint = any(&mut random, 1e-2, 10.0);
        let moved = footprint.relative_to(2048.0, -1024.0);
        let [column, row] = footprint.sample([random.unit(), random.unit()]);
        let there = [column - 2048, row + 1024];
        assert_eq!(
            footprint.texel_weight(column, row),
            moved.texel_weight(there[0], there[1])
        );
        let columns = footprint.row_columns(row);
        assert_eq!(
            moved.row_columns(there[1]),
            columns.start - 2048..columns.end - 2048
        );
    }
}

#[test]
fn samples_fall_on_texels_with_weight_by_their_weights() {
    let mut random = Random(26);
    let count = 200_000;
    for (long, short, angle) in [
        (3.0, 2.2, 0.4),
        (2.5, 0.8, 2.0),
        (4.0, 0.2, -0.7),
        (0.3, 0.25, 0.1),
    ] {
        let footprint = gaussian([77.3, 50.9], long, short, angle);
        let mut counts = BTreeMap::new();
        for _ in 0..count {
            let texel = footprint.sample([random.unit(), random.unit()]);
            *counts.entry((texel[0], texel[1])).or_insert(0.0) += 1.0;
        }
        let (mut chi_square, mut cells) = (0.0, 0.0);
        for row in footprint.rows() {
            for column in footprint.row_columns(row) {
                let expected = f64::from(count) * footprint.texel_weight(column, row);
                let counted = counts.remove(&(column, row)).unwrap_or(0.0);
                if expected > 20.0 {
                    chi_square += (counted - expected) * (counted - expected) / expected;
                    cells += 1.0;
                }
            }
        }
        assert!(counts.is_empty(), "sampled without weight: {counts:?}");
        // Five standard deviations of chi-square.
        assert!(
            chi_square < cells + 5.0 * libm::sqrt(2.0 * cells),
            "{chi_square} of {cells} texels"
        );
    }
}

#[test]
fn no_sample_lies_beyond_the_ellipse() {
    let last = 1.0 - f64::EPSILON / 2.0;
    let mut random = Random(27);
    for case in 0..2000 {
        let footprint = any(&mut random, 1e-6, 20.0);
        let radius = [last, 0.0, random.unit()][case % 3];
        let [column, row] = footprint.sample([radius, random.unit()]);
        assert!(footprint.row_columns(row).contains(&column), "case {case}");
        assert!(footprint.rows().contains(&row));
    }
    // The farthest sample is on the ellipse, and the median where half of the kept Gaussian is.
    let footprint = gaussian([0.0, 0.0], 1e4, 1e4, 0.0);
    let radius = |uniform: f64| footprint.sample([uniform, 0.0])[0] as f64 / 1e4;
    assert!((radius(last) - RADIUS).abs() < 2e-4);
    let median = libm::sqrt(-2.0 * libm::log(0.5 * (1.0 + LOST)));
    assert!((radius(0.5) - median).abs() < 2e-4);
}
