//! How far answers are off: the norms of a report.

use super::clock::quantile;
use crate::report::document::{Energy, Errors};

/// Least density per steradian of a query that counts as lit: a diffuse surface has 0.3, so less is nothing to see. Far
/// tails of needles, at 1e-100 and below, would make relative errors of noise otherwise.
pub const LIT: f64 = 1e-6;

/// The norms of `answers` against `truth`, query by query.
pub fn errors(answers: &[f64], truth: &[f64]) -> Errors {
    let mut differences: Vec<f64> = answers
        .iter()
        .zip(truth)
        .map(|(answer, truth)| (answer - truth).abs())
        .collect();
    let count = truth.len() as f64;
    let total: f64 = truth.iter().sum();
    let most = truth.iter().copied().fold(0.0, f64::max);
    let sum: f64 = differences.iter().sum();
    let squares: f64 = differences
        .iter()
        .map(|difference| difference * difference)
        .sum();
    differences.sort_by(f64::total_cmp);
    let lit = most >= LIT;
    Errors {
        relative_l1: lit.then(|| sum / total),
        rms: lit.then(|| (squares / count).sqrt() / (total / count)),
        percentile_99: lit.then(|| quantile(&differences, 0.99) / most),
        worst: lit.then(|| quantile(&differences, 1.0) / most),
        worst_unlit: answers
            .iter()
            .zip(truth)
            .filter(|&(_, &truth)| truth < LIT)
            .map(|(&answer, _)| answer)
            .fold(0.0, f64::max),
    }
}

/// The integral of a pdf over the hemisphere, from its `ratios` to the pdf of a model at half vectors that the model drew,
/// 0 where it drew none.
///
/// `E[p/q; drawn] = ∫ p` where q draws, and little varies where p is nearly q: what a method loses shows to a fraction of
/// what it takes to see it in D itself. `None` if there are fewer than two.
pub fn energy(ratios: &[f64]) -> Option<Energy> {
    let count = ratios.len() as f64;
    if count < 2.0 {
        return None;
    }
    let share = ratios.iter().sum::<f64>() / count;
    let squares: f64 = ratios.iter().map(|ratio| (ratio - share).powi(2)).sum();
    Some(Energy {
        share,
        standard_error: (squares / (count - 1.0) / count).sqrt(),
    })
}

/// The error that point sampling has when it may take `time`, from `(time, error)` of it with rising numbers of points.
///
/// Between two, along the line through them on logarithmic axes; below the first, that of the first, for there is nothing
/// cheaper; beyond the last, falling with the root of the time. `None` without points of an error above zero.
pub fn at_equal_time(points: &[(f64, f64)], time: f64) -> Option<f64> {
    let points: Vec<_> = points.iter().filter(|&&(_, error)| error > 0.0).collect();
    let (&&(first, most), &&(last, least)) = (points.first()?, points.last()?);
    if time <= first {
        return Some(most);
    }
    if time >= last {
        return Some(least * (last / time).sqrt());
    }
    points.windows(2).find_map(|pair| {
        let [&(start, from), &(end, to)] = *pair else {
            return None;
        };
        let part = libm::log(time / start) / libm::log(end / start);
        (start..end)
            .contains(&time)
            .then(|| from * libm::exp(part * libm::log(to / from)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_are_those_of_their_definitions() {
        let found = errors(&[1.0, 3.0, 0.5, 0.0], &[2.0, 2.0, 0.0, 0.0]);
        assert_eq!(found.relative_l1, Some(2.5 / 4.0));
        assert_eq!(found.rms, Some((2.25_f64 / 4.0).sqrt()));
        assert_eq!(found.worst, Some(0.5));
        assert_eq!(found.worst_unlit, 0.5);
        let dark = errors(&[0.25], &[0.0]);
        assert_eq!((dark.relative_l1, dark.worst_unlit), (None, 0.25));
    }

    #[test]
    fn energy_is_the_mean_ratio() {
        let found = energy(&[0.5, 1.5]).unwrap();
        assert_eq!(found.share, 1.0);
        assert!((found.standard_error - 0.5).abs() < 1e-12);
        assert!(energy(&[1.0]).is_none());
    }

    #[test]
    fn errors_at_equal_time_follow_the_points() {
        let points = [(10.0, 1.0), (1000.0, 0.1)];
        assert_eq!(at_equal_time(&points, 1.0), Some(1.0));
        let between = at_equal_time(&points, 100.0).unwrap();
        assert!((between - 0.1_f64.sqrt()).abs() < 1e-12);
        assert_eq!(at_equal_time(&points, 4000.0), Some(0.05));
        assert_eq!(at_equal_time(&[], 1.0), None);
    }
}
