//! Two reports of the same plan: what became slower, larger or worse, and what better.

mod judge;
mod matching;
mod text;
mod threshold;

pub use threshold::{Kind, Threshold, ThresholdError, Thresholds, Violation};

use super::document::{Cell, Contestant, PackageReport, Report, Role, Row};
use super::panel;
use judge::{compare_packages, compare_rows};
use matching::pair_up;
use serde::Serialize;

/// The baseline whose times tell how much faster the machine was: it is the same plain loop in every version.
pub const CLOCK: &str = "exact-scan";

/// What the comparison of two reports found.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What makes the reports less comparable, in sentences.
    pub notes: Vec<String>,
    /// Median of new over old times of [`CLOCK`], by which new times are judged; `None`, which counts as 1, if it is not
    /// in both reports.
    pub drift: Option<f64>,
    /// Every number that both have, in the order of the new report.
    pub values: Vec<Compared>,
    /// What only one of them has.
    pub missing: Vec<Missing>,
}

/// A number of both reports.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Compared {
    /// What the number is.
    pub quantity: Quantity,
    /// The map.
    pub map: String,
    /// Whose number it is.
    pub contestant: Contestant,
    /// Kernel and cell of a row; `None` for what is of a package.
    pub row: Option<(String, Cell)>,
    /// Roughness that was baked for, if any.
    pub roughness: Option<f64>,
    /// The old number: a share, bytes, nanoseconds or seconds.
    pub old: f64,
    /// The new number.
    pub new: f64,
    /// New over old, times divided by the drift; `None` if the old number is 0 and the new one is not.
    pub ratio: Option<f64>,
    /// How far apart they are in units of their uncertainty: of the mean quartile spread for times, of the standard
    /// error for energy; `None` for what has none.
    pub spreads: Option<f64>,
    /// What to make of it.
    pub verdict: Verdict,
}

/// What a number of a report is. Less is better of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Relative L1 error against the truth.
    Error,
    /// Relative L1 error against the method's own model.
    ModelError,
    /// How far the sampler's share of the energy is from 1.
    Energy,
    /// Bytes of the package.
    Bytes,
    /// Seconds of the bake.
    Bake,
    /// Median time of `eval`.
    Eval,
    /// Median time of `eval` in coherent order.
    EvalCoherent,
    /// Median time of `sample`.
    Sample,
    /// Median time of `pdf`.
    Pdf,
}

/// What to make of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The new one is better.
    Better,
    /// No difference, or none that could not be chance.
    Same,
    /// The new one is worse.
    Worse,
}

/// What only one report has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Missing {
    /// What: a map, or a row or package of one.
    pub what: String,
    /// Whether the old report has it, and the new one lacks it.
    pub is_gone: bool,
}

/// What became of every number of `old` in `new`.
///
/// Maps match by name and BLAKE3, else by name; rows by contestant, kernel, surface and cell; packages by contestant and
/// roughness. Costs the square of the rows of a map in comparisons of names.
pub fn compare(old: &Report, new: &Report) -> Comparison {
    let mut comparison = Comparison {
        notes: notes(old, new),
        drift: None,
        values: Vec::new(),
        missing: Vec::new(),
    };
    let maps = matching::maps(old, new, &mut comparison);
    let rows: Vec<_> = maps
        .iter()
        .map(|(old, new)| {
            let same = |old: &&Row, new: &&Row| {
                old.contestant == new.contestant
                    && old.kernel == new.kernel
                    && old.surface == new.surface
                    && old.cell == new.cell
            };
            let name = |row: &&Row| format!("{}: {}", new.name, text::row_name(row));
            let (old, new): (Vec<&Row>, Vec<&Row>) =
                (old.rows.iter().collect(), new.rows.iter().collect());
            pair_up(&old, &new, same, name, &mut comparison.missing)
        })
        .collect();
    comparison.drift = drift(rows.iter().flatten());
    if comparison.drift.is_none() {
        let note = format!(
            "no {CLOCK} is in both reports: times are compared as if the machine was as fast both times"
        );
        comparison.notes.push(note);
    }
    let factor = comparison.drift.unwrap_or(1.0);
    for ((old, new), rows) in maps.iter().zip(rows) {
        let same = |old: &&PackageReport, new: &&PackageReport| {
            old.contestant == new.contestant && old.roughness == new.roughness
        };
        let name =
            |package: &&PackageReport| format!("{}: {}", new.name, text::package_name(package));
        let packages: (Vec<_>, Vec<_>) =
            (old.packages.iter().collect(), new.packages.iter().collect());
        for (old, new_package) in pair_up(
            &packages.0,
            &packages.1,
            same,
            name,
            &mut comparison.missing,
        ) {
            compare_packages(&new.name, old, new_package, factor, &mut comparison.values);
        }
        if rows.iter().any(|(old, new)| old.queries != new.queries) {
            let note = format!(
                "{}: rows have other numbers of queries: errors vary with them",
                new.name
            );
            comparison.notes.push(note);
        }
        for (old, new_row) in rows {
            compare_rows(&new.name, old, new_row, factor, &mut comparison.values);
        }
    }
    comparison
}

/// What makes numbers of two reports less comparable.
fn notes(old: &Report, new: &Report) -> Vec<String> {
    let mut notes = Vec::new();
    for (name, report) in [("old", old), ("new", new)] {
        if !report.complete {
            notes.push(format!("the {name} report is not complete"));
        }
        if !report.head.optimised {
            notes.push(format!(
                "the {name} report was made without optimisation: its times mean little"
            ));
        }
    }
    let (old, new) = (&old.head, &new.head);
    let different = [
        (
            "seeds",
            old.seed.to_string(),
            new.seed.to_string(),
            "errors are of other queries",
        ),
        (
            "processors",
            old.processor.clone(),
            new.processor.clone(),
            "times may not compare",
        ),
        (
            "targets",
            old.target.clone(),
            new.target.clone(),
            "times may not compare",
        ),
        (
            "instruction sets",
            old.target_features.clone(),
            new.target_features.clone(),
            "times may not compare",
        ),
        (
            "compilers",
            old.compiler.clone(),
            new.compiler.clone(),
            "times may differ by them",
        ),
        (
            "threads",
            old.threads.to_string(),
            new.threads.to_string(),
            "bakes do not compare",
        ),
    ];
    for (what, old, new, consequence) in different {
        if old != new {
            let [old, new] = [old, new].map(|text| super::table::printable(&text));
            notes.push(format!("other {what} ({old}, now {new}): {consequence}"));
        }
    }
    notes
}

/// Median of new over old times of [`CLOCK`].
fn drift<'r>(rows: impl Iterator<Item = &'r (&'r Row, &'r Row)>) -> Option<f64> {
    let is_clock =
        |row: &Row| row.contestant.role == Role::Baseline && row.contestant.method == CLOCK;
    let ratios = rows
        .filter(|(old, _)| is_clock(old))
        .flat_map(|(old, new)| {
            [
                new.times.eval.median_ns / old.times.eval.median_ns,
                new.times.eval_coherent.median_ns / old.times.eval_coherent.median_ns,
            ]
        });
    let mut ratios: Vec<f64> = ratios
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
        .collect();
    ratios.sort_by(f64::total_cmp);
    let middle = ratios.len() / 2;
    let upper = *ratios.get(middle)?;
    if ratios.len() % 2 == 1 {
        return Some(upper);
    }
    // Of an even number, the geometric mean of the two in the middle, so that swapping the reports inverts the drift.
    Some((ratios[middle - 1] * upper).sqrt())
}

impl Comparison {
    /// What became worse and what better: the rest is the same.
    pub fn changes(&self, verdict: Verdict) -> Vec<&Compared> {
        let mut changes: Vec<&Compared> = self
            .values
            .iter()
            .filter(|value| value.verdict == verdict)
            .collect();
        // The largest first; something from nothing before all.
        let size = |value: &Compared| {
            let ratio = value.ratio.unwrap_or(f64::INFINITY);
            if ratio > 0.0 {
                libm::log(ratio).abs()
            } else {
                f64::INFINITY
            }
        };
        changes.sort_by(|one, other| size(other).total_cmp(&size(one)));
        changes
    }
}

/// Whether an error is shown as none.
fn is_exact(error: f64) -> bool {
    panel::shown(error) == 0.0
}

#[cfg(test)]
mod tests;
