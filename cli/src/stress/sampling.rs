//! Samples against the pdf: χ² over cells of a window about the densest lobe, and directions with density everywhere.

use super::footprints::{COUNTED, POINT};
use super::numbers::Numbers;
use super::outcome::{At, Outcome, Recorder};
use super::target::{Answered, Place, Target, at};
use super::window::Window;

/// Draws under each extreme footprint.
const FEW: usize = 12;
/// Draws that are counted by cells.
const MANY: usize = 16_384;
/// Cells on a side of the window, and its half side in units of the chart.
const CELLS: u32 = 14;
const REACH: f64 = 3.5;
/// Cells that expect fewer draws are counted together: the χ² law needs about five.
const LEAST_EXPECTED: f64 = 5.0;
/// The standard normal deviate that a χ² may reach: a right sampler exceeds it once in two million checks.
const DEVIATE: f64 = 4.9;

const REASON: &str = "a right sampler's chi-square exceeds 4.9 standard deviations once in two million checks; seeds are fixed, \
                      so a pass stays a pass";

/// Draws under every footprint, and counts draws under two.
pub(super) fn check(target: &Target<'_>) -> Outcome {
    let mut recorder = Recorder::new("sampling", REASON);
    let mut numbers = target.numbers("sampling");
    for place in target.places() {
        directions(target, place, &mut numbers, &mut recorder);
    }
    for name in [POINT, COUNTED] {
        if let Some(place) = target.place(name) {
            count(target, place, &mut numbers, &mut recorder);
        }
    }
    recorder.finish()
}

/// Every half vector drawn is a direction that the pdf knows of.
fn directions(
    target: &Target<'_>,
    place: &Place<'_>,
    numbers: &mut Numbers,
    recorder: &mut Recorder,
) {
    let footprint = &place.patch.footprint;
    for _ in 0..FEW {
        let uniform = numbers.four();
        let here = |h| at(format!("sample, {}, {uniform:?}", place.name), footprint, h);
        let drawn = recorder.call(|| here(None), || target.answers.sample(footprint, uniform));
        let Some(Some(h)) = drawn else {
            continue;
        };
        if !h.is_on_disk() {
            recorder.fault(&here(Some(h)), "no direction of the hemisphere is drawn");
            continue;
        }
        let pdf = recorder.ask(|| here(Some(h)), || target.answers.pdf(footprint, h));
        if pdf.is_some_and(|pdf| pdf <= 0.0) {
            recorder.fault(&here(Some(h)), "what is drawn has no density");
        }
    }
}

/// Counts draws by cells and compares with the integrals of the model's pdf, or of the pdf that is put to the test if the model
/// takes long, or is not what is answered.
fn count(target: &Target<'_>, place: &Place<'_>, numbers: &mut Numbers, recorder: &mut Recorder) {
    let footprint = &place.patch.footprint;
    let is_answered = !target.bound().is_of_the_peak();
    let is_drawn = target.subject.draws_by_model(target.variant);
    let model = if is_drawn || is_answered && target.is_quick(place) {
        target
            .subject
            .model(target.variant, &place.patch, target.alpha())
    } else {
        Box::new(Answered {
            answers: target.answers,
            footprint: *footprint,
        })
    };
    let Some(window) = Window::of(target, &place.patch, &*model, REACH, numbers) else {
        return;
    };
    let cells = (CELLS * CELLS) as usize;
    // The last is for what lies elsewhere, and for no vector at all.
    let mut counts = vec![0.0; cells + 1];
    for _ in 0..MANY {
        let uniform = numbers.four();
        let drawn = recorder.call(
            || {
                at(
                    format!("sample, {}, {uniform:?}", place.name),
                    footprint,
                    None,
                )
            },
            || target.answers.sample(footprint, uniform),
        );
        let Some(drawn) = drawn else { return };
        let cell = drawn
            .and_then(|h| window.cell(h, CELLS))
            .map_or(cells, |[column, row]| (row * CELLS + column) as usize);
        counts[cell] += 1.0;
    }
    let mut masses: Vec<f64> = (0..CELLS * CELLS)
        .map(|cell| window.mass([cell % CELLS, cell / CELLS], CELLS, &*model, MANY as f64))
        .collect();
    masses.push((1.0 - masses.iter().sum::<f64>()).max(0.0));
    let deviate = chi_square_deviate(&counts, &masses);
    recorder.compare(deviate.max(0.0), DEVIATE, || At {
        what: format!("chi-square of {MANY} draws, {}", place.name),
        footprint: Some(*footprint),
        half_vector: None,
    });
}

/// The standard normal deviate of the χ² of `counts` against the expected shares `masses` (Wilson and Hilferty 1931), or
/// infinity if draws fell where there is no mass. 0 for fewer than two cells.
fn chi_square_deviate(counts: &[f64], masses: &[f64]) -> f64 {
    let total: f64 = counts.iter().sum();
    let mut statistic = 0.0;
    let mut cells = 0.0;
    let mut add = |count: f64, expected: f64| {
        statistic += (count - expected) * (count - expected) / expected;
        cells += 1.0;
    };
    let (mut pooled_count, mut pooled) = (0.0, 0.0);
    for (&count, &mass) in counts.iter().zip(masses) {
        let expected = mass * total;
        if expected >= LEAST_EXPECTED {
            add(count, expected);
        } else {
            pooled_count += count;
            pooled += expected;
        }
    }
    if pooled >= LEAST_EXPECTED {
        add(pooled_count, pooled);
    } else if pooled_count > 30.0 {
        // Five are expected at most: a Poisson count above 30 is rarer than once in 10¹³.
        return f64::INFINITY;
    }
    let degrees: f64 = cells - 1.0;
    if degrees < 1.0 {
        return 0.0;
    }
    let spread = 2.0 / (9.0 * degrees);
    (libm::cbrt(statistic / degrees) - (1.0 - spread)) / spread.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviate_is_small_for_what_was_expected_and_large_for_what_was_not() {
        let masses = vec![0.01; 100];
        let mut numbers = Numbers::new(1);
        let mut even = vec![0.0; 100];
        let mut uneven = vec![0.0; 100];
        for _ in 0..10_000 {
            let x = numbers.uniform();
            even[(100.0 * x) as usize] += 1.0;
            uneven[(100.0 * x * (0.6 + 0.4 * x)) as usize] += 1.0;
        }
        assert!(chi_square_deviate(&even, &masses).abs() < 3.0);
        assert!(chi_square_deviate(&uneven, &masses) > DEVIATE);
        assert_eq!(
            chi_square_deviate(&[10.0, 31.0], &[1.0, 0.0]),
            f64::INFINITY
        );
        assert_eq!(chi_square_deviate(&[10.0, 0.0], &[1.0, 0.0]), 0.0);
    }
}
