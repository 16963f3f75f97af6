//! The weight of every texel against the reference, in each of the three ways it is found.

use super::super::{GaussianFootprint, LOST, RADIUS};
use super::reference::share;
use super::{Random, gaussian};
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// A texel that the ellipse meets, or one next to it.
fn texel_near(random: &mut Random, footprint: &GaussianFootprint) -> [i64; 2] {
    let rows = footprint.rows();
    if random.unit() < 0.5 {
        let row = random.whole(rows.start, rows.end);
        let columns = footprint.row_columns(row);
        [random.whole(columns.start - 1, columns.end + 1), row]
    } else {
        let [column, row] = footprint.sample([random.unit(), random.unit()]);
        [column + random.whole(-1, 2), row + random.whole(-1, 2)]
    }
}

fn angle(random: &mut Random, case: u32) -> f64 {
    match case % 8 {
        0 => 0.0,
        1 => FRAC_PI_2,
        2 => FRAC_PI_4,
        3 => -FRAC_PI_4,
        4 => random.between(-1e-6, 1e-6),
        _ => random.between(-PI, PI),
    }
}

/// On texel borders and corners, or anywhere.
fn centre(random: &mut Random, case: u32) -> [f64; 2] {
    match case % 3 {
        0 => [500.0, 500.0],
        1 => [500.0, random.between(0.0, 1000.0)],
        _ => [random.between(0.0, 1000.0), random.between(0.0, 1000.0)],
    }
}

/// The worst error for least deviations in `least`, in units of the peak's weight if `of_peak`, over texels that the
/// ellipse meets; and 0 must be given everywhere else.
fn worst(least: [f64; 2], anisotropy: f64, of_peak: bool) -> f64 {
    let mut random = Random(u64::from(least[0].to_bits() as u32) + 17);
    let mut worst: f64 = 0.0;
    for case in 0..600 {
        let short = libm::exp(random.between(libm::log(least[0]), libm::log(least[1])));
        let long = (short * libm::exp(random.between(0.0, libm::log(anisotropy)))).min(1e5);
        let angle = angle(&mut random, case);
        let footprint = gaussian(centre(&mut random, case / 8), long, short, angle);
        let (scale, kept) = if of_peak {
            (2.0 * PI * short * long, 1.0 - LOST)
        } else {
            (1.0, 1.0)
        };
        for _ in 0..20 {
            let [column, row] = texel_near(&mut random, &footprint);
            let weight = footprint.texel_weight(column, row);
            let exact = share(&footprint, column, row);
            if footprint.row_columns(row).contains(&column) {
                let error = (weight * kept - exact).abs() * scale;
                assert!(error.is_finite(), "{weight} {exact} {short} {long} {angle}");
                worst = worst.max(error);
            } else {
                assert_eq!(weight, 0.0, "beyond the ellipse");
                assert!(
                    exact <= LOST,
                    "{exact} is cut off at {short} {long} {angle}"
                );
            }
        }
    }
    worst
}

#[test]
fn whole_texels_err_as_stated() {
    for (from, to) in [(2.0, 2.2), (2.2, 4.0), (4.0, 8.0), (8.0, 300.0)] {
        let stated = 2.6e-6 * libm::pow(2.0 / from, 6.0) + 1e-9;
        let worst = worst([from, to], 1e4, true);
        assert!(worst < stated, "{worst:e} from {from}: stated {stated:e}");
    }
}

#[test]
fn texels_in_parts_err_as_stated() {
    for (from, to) in [(1.0, 2.0), (0.5, 1.0)] {
        let worst = worst([from, to], 1e3, true);
        assert!(worst < 2.6e-6, "{worst:e} from {from}");
    }
}

#[test]
fn thin_gaussians_are_right_to_1e_9() {
    for (from, to, anisotropy) in [
        (0.1, 0.5, 1.0 + 1e-9),
        (0.1, 0.5, 4.0),
        (0.1, 0.5, 1e3),
        (1e-2, 0.1, 1e5),
        (1e-4, 1e-2, 1e6),
        (1e-9, 1e-4, 1e6),
    ] {
        let worst = worst([from, to], anisotropy, false);
        assert!(worst < 1e-9, "{worst:e} from {from} by {anisotropy}");
    }
}

/// The sum of all weights, row by row, in one of the ways there are.
fn sum(footprint: &GaussianFootprint) -> f64 {
    let mut weights = [0.0; 64];
    footprint
        .rows()
        .map(|row| {
            let row = footprint.row(row);
            let columns = row.columns();
            let mut sum = 0.0;
            let mut first = columns.start;
            while first < columns.end {
                let count = (columns.end - first).min(64) as usize;
                let weights = &mut weights[..count];
                row.fill(first, weights);
                assert!(
                    weights.iter().all(|weight| (0.0..=1.0).contains(weight)),
                    "{weights:?}"
                );
                sum += weights.iter().sum::<f64>();
                first += 64;
            }
            sum
        })
        .sum()
}

#[test]
fn weights_add_up_to_one() {
    let mut random = Random(5);
    let mut worst = [0.0_f64; 3];
    for short in [
        1e-9_f64, 1e-4, 1e-3, 0.01, 0.1, 0.3, 0.499, 0.501, 0.7, 0.999, 1.001, 1.5, 1.999, 2.001,
        3.0, 10.0, 60.0,
    ] {
        for anisotropy in [1.0, 1.5, 3.0, 30.0, 1e3, 1e6] {
            let long = short * anisotropy;
            if long * short.max(1.0) > 4e3 {
                continue;
            }
            for case in 0..8 {
                let angle = angle(&mut random, case);
                let footprint = gaussian(centre(&mut random, case), long, short, angle);
                let error = (sum(&footprint) - 1.0).abs();
                assert!(error < 1e-5, "{error:e} for {short} {long} {angle}");
                let regime = usize::from(short > 0.5) + usize::from(short > 2.0);
                worst[regime] = worst[regime].max(error);
            }
        }
    }
    // Whole texels at the ends leave little of a thin Gaussian to lose.
    assert!(worst[0] < 3e-6, "{worst:?}");
    let large = gaussian([3.5, 900.1], 300.0, 300.0, 0.0);
    assert!((sum(&large) - 1.0).abs() < 1e-5);
}

#[test]
fn one_texel_rows_and_slices_give_the_same_weights() {
    let mut random = Random(6);
    for case in 0..400 {
        let short = libm::exp(random.between(-7.0, 3.0));
        let long = (short * libm::exp(random.between(0.0, 5.0))).min(200.0);
        let angle = angle(&mut random, case);
        let footprint = gaussian(centre(&mut random, case), long, short, angle);
        let rows = footprint.rows();
        let number = random.whole(rows.start, rows.end);
        let row = footprint.row(number);
        let columns = row.columns();
        assert_eq!(columns, footprint.row_columns(number));
        let mut weights = [0.0; 300];
        let count = (columns.end - columns.start).min(300) as usize;
        row.fill(columns.start, &mut weights[..count]);
        for (column, weight) in (columns.start..columns.end).zip(weights) {
            assert_eq!(row.weight(column), footprint.texel_weight(column, number));
            let error = (row.weight(column) - weight).abs();
            assert!(error <= 1e-15, "{weight} in slices, {error:e} off");
        }
        for beyond in [columns.start - 1, columns.end, columns.end + 1000] {
            assert_eq!(row.weight(beyond), 0.0);
            assert_eq!(footprint.texel_weight(beyond, number), 0.0);
        }
        for beyond in [rows.start - 2, rows.end + 1] {
            assert_eq!(footprint.texel_weight(columns.start, beyond), 0.0);
        }
    }
}

#[test]
fn what_is_lost_is_what_lies_beyond_the_radius() {
    assert!((libm::exp(-0.5 * RADIUS * RADIUS) / LOST - 1.0).abs() < 1e-14);
}
