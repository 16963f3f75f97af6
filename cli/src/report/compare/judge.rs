//! Which differences matter.

use super::super::document::{PackageReport, Row, Timing};
use super::{Compared, Quantity, Verdict};

/// Errors that differ by less are those of one arithmetic.
const SAME_ERROR: f64 = 1e-6;
/// Times within so many spreads of each other may differ by chance, as may those within [`SAME_TIME`].
const SAME_SPREADS: f64 = 2.0;
const SAME_TIME: f64 = 1.03;
/// Bakes are timed a few times only.
const SAME_BAKE: f64 = 1.25;
/// Standard errors within which two energies may be one.
const SAME_ENERGY: f64 = 4.0;

/// Adds bytes and bake of the packages of one contestant to `values`.
pub fn compare_packages(
    map: &str,
    old: &PackageReport,
    new: &PackageReport,
    drift: f64,
    values: &mut Vec<Compared>,
) {
    let mut add = |quantity, [old_value, new_value]: [f64; 2], ratio: Option<f64>, same: f64| {
        values.push(Compared {
            quantity,
            map: map.to_owned(),
            contestant: new.contestant.clone(),
            row: None,
            roughness: new.roughness,
            old: old_value,
            new: new_value,
            ratio,
            spreads: None,
            verdict: verdict(ratio, same),
        });
    };
    let bytes = [old.bytes as f64, new.bytes as f64];
    add(Quantity::Bytes, bytes, ratio(bytes), 1.0);
    let seconds = [old.bake_seconds, new.bake_seconds];
    add(
        Quantity::Bake,
        seconds,
        time_ratio(seconds, drift),
        SAME_BAKE,
    );
}

/// Adds errors, energy and times of one cell to `values`.
pub fn compare_rows(map: &str, old: &Row, new: &Row, drift: f64, values: &mut Vec<Compared>) {
    let mut add = |quantity, [old, value]: [f64; 2], ratio, spreads, verdict| {
        values.push(Compared {
            quantity,
            map: map.to_owned(),
            contestant: new.contestant.clone(),
            row: Some((new.kernel.clone(), new.cell.clone())),
            roughness: new.cell.roughness,
            old,
            new: value,
            ratio,
            spreads,
            verdict,
        });
    };
    let truth = [old.truth.relative_l1, new.truth.relative_l1];
    let model = [old.model, new.model].map(|model| model?.relative_l1);
    for (quantity, errors) in [(Quantity::Error, truth), (Quantity::ModelError, model)] {
        if let [Some(before), Some(after)] = errors {
            let ratio = ratio([before, after]);
            let verdict = if (after - before).abs() < SAME_ERROR {
                Verdict::Same
            } else {
                verdict(ratio, 1.0)
            };
            add(quantity, [before, after], ratio, None, verdict);
        }
    }
    if let (Some(before), Some(after)) = (old.energy, new.energy) {
        let lost = [before, after].map(|energy| (energy.share - 1.0).abs());
        let [one, other] = [before, after].map(|energy| energy.standard_error.powi(2));
        // Two estimates without any spread are still rounded.
        let spreads = (lost[1] - lost[0]) / (one + other).sqrt().max(1e-9);
        add(
            Quantity::Energy,
            lost,
            ratio(lost),
            Some(spreads),
            verdict_of_spreads(spreads, SAME_ENERGY),
        );
    }
    let (before, after) = (&old.times, &new.times);
    for (quantity, timings) in [
        (Quantity::Eval, [Some(before.eval), Some(after.eval)]),
        (
            Quantity::EvalCoherent,
            [Some(before.eval_coherent), Some(after.eval_coherent)],
        ),
        (Quantity::Sample, [before.sample, after.sample]),
        (Quantity::Pdf, [before.pdf, after.pdf]),
    ] {
        if let [Some(before), Some(after)] = timings {
            let medians = [before.median_ns, after.median_ns];
            let ratio = time_ratio(medians, drift);
            let spreads = spreads(&before, &after, drift);
            // A tight spread makes no matter of a difference of a few per cent, nor a wide one of twice the time.
            let verdict = match (
                verdict(ratio, SAME_TIME),
                verdict_of_spreads(spreads, SAME_SPREADS),
            ) {
                (one, other) if one == other => one,
                _ => Verdict::Same,
            };
            add(quantity, medians, ratio, Some(spreads), verdict);
        }
    }
}

/// New over old; 1 if both are 0, `None` if only the old is.
fn ratio([old, new]: [f64; 2]) -> Option<f64> {
    if old == new {
        Some(1.0)
    } else {
        (old > 0.0).then(|| new / old)
    }
}

/// The same for times, without the drift; what takes no time on any machine has none.
fn time_ratio([old, new]: [f64; 2], drift: f64) -> Option<f64> {
    ratio([old * drift, new])
}

/// How far the new median is from the old one times `drift`, in units of the mean of both quartile spreads.
fn spreads(old: &Timing, new: &Timing, drift: f64) -> f64 {
    let wide = |timing: &Timing, factor: f64| (timing.high_ns - timing.low_ns) * factor;
    let difference = new.median_ns - old.median_ns * drift;
    // Repetitions that agree to the last tick of the clock would make any difference matter.
    let least = new.median_ns * 0.01;
    let mean = (wide(old, drift) + wide(new, 1.0)) / 2.0;
    difference / mean.max(least).max(f64::MIN_POSITIVE)
}

/// Better or worse by more than `same` as a ratio; something from nothing is worse.
fn verdict(ratio: Option<f64>, same: f64) -> Verdict {
    match ratio {
        None => Verdict::Worse,
        Some(ratio) if ratio > same => Verdict::Worse,
        Some(ratio) if ratio < 1.0 / same => Verdict::Better,
        Some(_) => Verdict::Same,
    }
}

fn verdict_of_spreads(spreads: f64, same: f64) -> Verdict {
    if spreads > same {
        Verdict::Worse
    } else if spreads < -same {
        Verdict::Better
    } else {
        Verdict::Same
    }
}
