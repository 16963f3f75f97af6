//! Outcomes as a table for people and as a document.

use super::outcome::{At, Outcome, Verdict};
use serde_json::{Value, json};

/// One line for each check, method and filter: the worst over maps, roughnesses and settings. At most 100 columns wide.
pub fn lines(outcomes: &[Outcome]) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<12}{:<14}{:<9}{:>9} {:>9} {:>9}  {:<17}{:>7}  {}",
        "check", "method", "filter", "answers", "error", "bound", "energy", "faults", "verdict"
    )];
    for outcome in merged(outcomes, false) {
        let numbers = if outcome.at.is_some() {
            [
                format!("{:.1e}", outcome.error),
                format!("{:.1e}", outcome.bound),
            ]
        } else {
            ["-".to_owned(), "-".to_owned()]
        };
        let energy = match outcome.energy {
            Some([least, most]) => format!("{least:.5} {most:.5}"),
            None => "-".to_owned(),
        };
        lines.push(format!(
            "{:<12}{:<14}{:<9}{:>9} {:>9} {:>9}  {:<17}{:>7}  {}",
            outcome.check,
            outcome.method,
            outcome.filter.map_or("-", |filter| filter.name()),
            outcome.tried,
            numbers[0],
            numbers[1],
            energy,
            outcome.faults.count(),
            outcome.verdict.name()
        ));
    }
    lines.push(String::new());
    lines.extend(largest_jumps(outcomes));
    lines
}

/// A sentence for each method: how much a step of a footprint changes its density at most.
fn largest_jumps(outcomes: &[Outcome]) -> impl Iterator<Item = String> {
    let slides = merged(outcomes, false).into_iter();
    slides
        // Of a material it is coverage that is looked at, not density: under no filter.
        .filter(|outcome| {
            outcome.check == "continuity" && outcome.at.is_some() && outcome.filter.is_some()
        })
        .map(|outcome| {
            format!(
                "largest jump of {} under {} footprints: {:.1e} of the peak",
                outcome.method,
                outcome.filter.map_or("-", |filter| filter.name()),
                outcome.largest
            )
        })
}

/// What failed and what was skipped, a sentence each: where, how far off, and the bound's reason.
pub fn remarks(outcomes: &[Outcome]) -> Vec<String> {
    let mut remarks = Vec::new();
    for outcome in merged(outcomes, true) {
        let place = format!(
            "{} {} {} {} on {}{}",
            outcome.check,
            outcome.method,
            outcome.variant,
            outcome.filter.map_or("-", |filter| filter.name()),
            outcome.map,
            outcome
                .roughness
                .map(|alpha| format!(", roughness {alpha}"))
                .unwrap_or_default()
        );
        match outcome.verdict {
            Verdict::Fail => {
                let mut remark = format!("FAIL: {place}:");
                if let Some(complaint) = &outcome.complaint {
                    remark += &format!(" {complaint};");
                }
                if outcome.error > outcome.bound
                    && let Some(at) = &outcome.at
                {
                    remark += &format!(
                        " {}: {:e} off, {:e} allowed ({}); {}",
                        at.what,
                        outcome.error,
                        outcome.bound,
                        outcome.reason,
                        query(at)
                    );
                }
                remarks.push(remark);
            }
            Verdict::Skipped => remarks.push(format!("skipped: {place}: {}", outcome.reason)),
            Verdict::Pass | Verdict::Refused => {}
        }
    }
    remarks
}

/// The numbers of `at` as a row of a table of queries.
fn query(at: &At) -> String {
    let Some(footprint) = &at.footprint else {
        return String::new();
    };
    let mut numbers: Vec<_> = [footprint.centre, footprint.edge_1, footprint.edge_2]
        .as_flattened()
        .iter()
        .map(f64::to_string)
        .collect();
    if let Some(h) = at.half_vector {
        numbers.extend([h.s, h.t].map(|x| x.to_string()));
    }
    format!("u,v,e1u,e1v,e2u,e2v,s,t = {}", numbers.join(","))
}

/// Outcomes of the same check, method and filter together, and apart by setting and map if `apart`; in order of the first.
fn merged(outcomes: &[Outcome], apart: bool) -> Vec<Outcome> {
    let mut merged: Vec<(Key<'_>, Outcome)> = Vec::new();
    let mut places = std::collections::BTreeMap::new();
    for outcome in outcomes {
        let filter = outcome.filter.map(|filter| filter.name());
        let mut key = (outcome.check, outcome.method.as_str(), filter, "", "");
        if apart {
            key = (
                key.0,
                key.1,
                key.2,
                outcome.variant.as_str(),
                outcome.map.as_str(),
            );
        }
        match places.get(&key) {
            None => {
                places.insert(key, merged.len());
                merged.push((key, outcome.clone()));
            }
            Some(&place) => {
                let (_, known): &mut (Key<'_>, Outcome) = &mut merged[place];
                *known = known.clone().with(outcome);
            }
        }
    }
    if !apart {
        let order = |check: &str| ORDER.iter().position(|name| *name == check);
        merged.sort_by_key(|(key, _)| (order(key.0), key.1.to_owned(), key.2));
    }
    merged.into_iter().map(|(_, outcome)| outcome).collect()
}

type Key<'o> = (
    &'static str,
    &'o str,
    Option<&'static str>,
    &'o str,
    &'o str,
);

/// Checks in the order of the table.
const ORDER: [&str; 8] = [
    "accuracy",
    "energy",
    "sampling",
    "reciprocity",
    "continuity",
    "precision",
    "convergence",
    "refusals",
];

/// The verdict on all of them: a refusal that is due is as good as a pass.
pub fn overall(outcomes: &[Outcome]) -> Verdict {
    if count(outcomes, Verdict::Fail) > 0 {
        Verdict::Fail
    } else {
        Verdict::Pass
    }
}

/// How many outcomes have `verdict`.
pub fn count(outcomes: &[Outcome], verdict: Verdict) -> usize {
    outcomes
        .iter()
        .filter(|outcome| outcome.verdict == verdict)
        .count()
}

/// Every outcome, roughnesses of a setting on a map together.
pub fn document(input: &str, outcomes: &[Outcome]) -> Value {
    let cases: Vec<_> = merged(outcomes, true).iter().map(case).collect();
    json!({
        "cases": cases,
        "counts": {
            "fail": count(outcomes, Verdict::Fail),
            "pass": count(outcomes, Verdict::Pass),
            "refused": count(outcomes, Verdict::Refused),
            "skipped": count(outcomes, Verdict::Skipped),
        },
        "input": input,
        "verdict": overall(outcomes).name(),
    })
}

fn case(outcome: &Outcome) -> Value {
    json!({
        "answers": outcome.tried,
        "bound": finite(outcome.bound),
        "check": outcome.check,
        "complaint": outcome.complaint,
        "energy": outcome.energy,
        "error": finite(outcome.error),
        "faults": {
            "errors": outcome.faults.errors,
            "negative": outcome.faults.negative,
            "not-finite": outcome.faults.not_finite,
            "panics": outcome.faults.panics,
        },
        "largest-error": finite(outcome.largest),
        "filter": outcome.filter.map(|filter| filter.name()),
        "map": outcome.map,
        "method": outcome.method,
        "reason": outcome.reason,
        "refused": outcome.refused,
        "roughness": outcome.roughness,
        "setting": outcome.variant,
        "verdict": outcome.verdict.name(),
        "worst-at": outcome.at.as_ref().map(place),
    })
}

/// JSON has no infinity: the largest number stands for it.
fn finite(number: f64) -> f64 {
    number.min(f64::MAX)
}

fn place(at: &At) -> Value {
    json!({
        "footprint": at.footprint.map(|footprint| json!({
            "centre": footprint.centre,
            "edge-1": footprint.edge_1,
            "edge-2": footprint.edge_2,
        })),
        "half-vector": at.half_vector.map(|h| [h.s, h.t]),
        "what": at.what,
    })
}
