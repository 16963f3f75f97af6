use super::super::document::{Errors, Timing};
use super::super::fixtures;
use super::*;
use proptest::prelude::*;

fn thresholds(text: &str) -> Thresholds {
    text.parse().expect("thresholds")
}

/// Every time of a report, multiplied.
fn slow_down(report: &mut Report, is_slowed: impl Fn(&Row) -> bool, factor: f64) {
    let slow = |timing: &mut Timing| {
        timing.median_ns *= factor;
        timing.low_ns *= factor;
        timing.high_ns *= factor;
    };
    for row in report.maps.iter_mut().flat_map(|map| &mut map.rows) {
        if is_slowed(row) {
            let times = &mut row.times;
            slow(&mut times.eval);
            slow(&mut times.eval_coherent);
            times.sample.iter_mut().for_each(slow);
            times.pdf.iter_mut().for_each(slow);
        }
    }
}

#[test]
fn a_report_is_the_same_as_itself() {
    let report = fixtures::report();
    let comparison = compare(&report, &report);
    assert_eq!(comparison.drift, Some(1.0));
    assert!(comparison.notes.is_empty() && comparison.missing.is_empty());
    assert!(!comparison.values.is_empty());
    assert!(
        comparison
            .values
            .iter()
            .all(|value| value.verdict == Verdict::Same)
    );
    assert!(
        comparison
            .violations(&thresholds("error:0%,bytes:0%,time:0%,bake:0%"))
            .is_empty()
    );
}

#[test]
fn a_slower_machine_is_no_slower_program() {
    let old = fixtures::report();
    let mut new = old.clone();
    slow_down(&mut new, |_| true, 1.7);
    for package in &mut new.maps[0].packages {
        package.bake_seconds *= 1.7;
    }
    let comparison = compare(&old, &new);
    assert!(
        comparison
            .drift
            .is_some_and(|drift| (drift - 1.7).abs() < 1e-12)
    );
    assert!(
        comparison.changes(Verdict::Worse).is_empty(),
        "{comparison}"
    );
    assert!(
        comparison.changes(Verdict::Better).is_empty(),
        "{comparison}"
    );
    // Those without the baseline cannot tell.
    new.maps[0]
        .rows
        .retain(|row| row.contestant.method != CLOCK);
    let comparison = compare(&old, &new);
    assert_eq!(comparison.drift, None);
    assert!(comparison.notes.iter().any(|note| note.contains(CLOCK)));
    assert!(!comparison.changes(Verdict::Worse).is_empty());
}

#[test]
fn what_became_slower_beyond_its_spread_is_found_despite_the_drift() {
    let old = fixtures::report();
    let mut new = old.clone();
    slow_down(&mut new, |_| true, 0.8);
    slow_down(&mut new, |row| row.contestant.variant == "bins-45", 1.5);
    let comparison = compare(&old, &new);
    let worse = comparison.changes(Verdict::Worse);
    assert!(!worse.is_empty());
    for value in worse {
        assert_eq!(value.contestant.variant, "bins-45");
        assert!(value.ratio.is_some_and(|ratio| (ratio - 1.5).abs() < 1e-9));
        assert_eq!(value.quantity.kind(), Some(Kind::Time));
    }
    assert!(!comparison.violations(&thresholds("time:40%")).is_empty());
    assert!(
        comparison
            .violations(&thresholds("time:60%,error:0%,bytes:0%"))
            .is_empty()
    );
    // A quartile spread as wide as the difference explains it.
    for row in &mut new.maps[0].rows {
        let medians = [row.times.eval, row.times.eval_coherent].map(|timing| timing.median_ns);
        row.times.eval.high_ns = medians[0] * 2.0;
        row.times.eval_coherent.high_ns = medians[1] * 2.0;
        row.times.sample = None;
        row.times.pdf = None;
    }
    assert!(compare(&old, &new).changes(Verdict::Worse).is_empty());
}

#[test]
fn the_text_names_what_changed() {
    let old = fixtures::report();
    let mut new = old.clone();
    new.head.seed = 8;
    new.head.processor = "another".to_owned();
    new.complete = false;
    let map = &mut new.maps[0];
    map.blake3 = "0".repeat(64);
    map.packages[0].bytes += map.packages[0].bytes / 10;
    map.rows[0].truth.relative_l1 = Some(0.05);
    map.rows[1].truth.relative_l1 = Some(0.01);
    // Below what arithmetic leaves, and out of nothing.
    map.rows[2].model = map.rows[2].model.map(|model| Errors {
        relative_l1: Some(2.2e-6),
        ..model
    });
    let scan = map
        .rows
        .iter_mut()
        .find(|row| row.contestant.method == CLOCK)
        .expect("a scan");
    scan.truth.relative_l1 = Some(0.001);
    let mut renamed = map.rows.pop().expect("a row");
    renamed.cell.sigma = 1024.0;
    map.rows.push(renamed);
    map.packages.pop();
    new.maps.push(fixtures::map("new.png"));
    let comparison = compare(&old, &new);
    insta::assert_snapshot!("changes", comparison.to_string());
    let violations = comparison.violations(&thresholds("error:50%, bytes:2%"));
    let violations: Vec<String> = violations.iter().map(Violation::to_string).collect();
    insta::assert_snapshot!("violations", violations.join("\n"));
    let json = comparison.to_json();
    assert_eq!(json["worse"].as_array().map(Vec::len), Some(3));
    assert_eq!(json["better"][0]["quantity"], "error");
    assert_eq!(
        json["worse"][0]["ratio"],
        serde_json::Value::Null,
        "from nothing comes first"
    );
    assert_eq!(json["only-old"].as_array().map(Vec::len), Some(2));
}

#[test]
fn maps_match_by_content_before_name() {
    let mut old = fixtures::report();
    old.maps.push(fixtures::map("waves.png"));
    old.maps[1].blake3 = "1".repeat(64);
    let mut new = old.clone();
    new.maps.swap(0, 1);
    let comparison = compare(&old, &new);
    assert!(
        comparison.notes.is_empty() && comparison.missing.is_empty(),
        "{comparison}"
    );
    // One of two that changed still finds its own.
    new.maps[1].blake3 = "2".repeat(64);
    let comparison = compare(&old, &new);
    assert_eq!(comparison.notes.len(), 1, "{comparison}");
    assert!(comparison.missing.is_empty());
}

#[test]
fn thresholds_are_read_or_refused_with_a_reason() {
    let read = thresholds("error:5%, bytes:2%,time:50%");
    let expected = [(Kind::Error, 0.05), (Kind::Bytes, 0.02), (Kind::Time, 0.5)];
    assert_eq!(read.0.len(), 3);
    for (threshold, (kind, share)) in read.0.iter().zip(expected) {
        assert_eq!(threshold.kind, kind);
        assert!((threshold.share - share).abs() < 1e-15);
    }
    for (text, word) in [
        ("", "no threshold"),
        ("error", "no threshold"),
        ("speed:5%", "there are error, bytes, time and bake"),
        ("error:5", "such as 5%"),
        ("error:-5%", "from 0"),
        ("error:NaN%", "no share"),
        ("error:inf%", "no share"),
        ("error:1%,error:2%", "two thresholds"),
        ("error:1%,", "no threshold"),
    ] {
        let error = text.parse::<Thresholds>().expect_err(text);
        assert!(error.to_string().contains(word), "{text}: {error}");
    }
}

proptest! {
    /// Whatever changed, swapping the reports turns better into worse.
    #[test]
    fn swapping_reports_swaps_verdicts(factors in prop::collection::vec(0.2_f64..5.0, 30)) {
        let old = fixtures::report();
        let mut new = old.clone();
        for (row, factor) in new.maps[0].rows.iter_mut().zip(&factors) {
            row.truth.relative_l1 = row.truth.relative_l1.map(|error| error * factor);
            row.times.eval.median_ns *= factor;
            row.times.eval.low_ns *= factor;
            row.times.eval.high_ns *= factor;
        }
        let [there, back] = [compare(&old, &new), compare(&new, &old)];
        for (one, other) in there.values.iter().zip(&back.values) {
            // Spreads of times are relative to the new one, so borderline cases may fall on one side only.
            if one.quantity == Quantity::Error {
                let swapped = match one.verdict {
                    Verdict::Better => Verdict::Worse,
                    Verdict::Same => Verdict::Same,
                    Verdict::Worse => Verdict::Better,
                };
                prop_assert_eq!(other.verdict, swapped);
            } else {
                prop_assert!(one.verdict != other.verdict || one.verdict == Verdict::Same);
            }
        }
        let product = there.drift.unwrap_or(0.0) * back.drift.unwrap_or(0.0);
        prop_assert!((product - 1.0).abs() < 1e-9);
    }
}
