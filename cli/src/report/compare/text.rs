//! A comparison for people and for programs.

use super::super::document::{Cell, HalfVectors, PackageReport, Row};
use super::super::table::printable;
use super::super::units;
use super::{Compared, Comparison, Missing, Quantity, Verdict, is_exact};
use crate::output::human_bytes;
use serde_json::{Value, json};
use std::fmt::{self, Write};

/// Lines of a list; the JSON form has them all.
const MOST: usize = 40;

impl Quantity {
    /// What it is, in a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::ModelError => "model error",
            Self::Energy => "energy off",
            Self::Bytes => "bytes",
            Self::Bake => "bake",
            Self::Eval => "eval",
            Self::EvalCoherent => "eval coherent",
            Self::Sample => "sample",
            Self::Pdf => "pdf",
        }
    }

    fn show(self, value: f64) -> String {
        match self {
            // A change that matters may be below what is shown of errors elsewhere.
            Self::Error | Self::ModelError | Self::Energy if is_exact(value) => {
                format!("{} %", units::significant(value * 100.0, 3))
            }
            Self::Error | Self::ModelError | Self::Energy => format!("{} %", units::percent(value)),
            Self::Bytes => human_bytes(value as u64),
            Self::Bake => units::seconds(value),
            Self::Eval | Self::EvalCoherent | Self::Sample | Self::Pdf => units::time(value),
        }
    }
}

/// A row in words.
pub fn row_name(row: &Row) -> String {
    format!(
        "{}, {}",
        row.contestant.name(),
        cell_name(&row.kernel, &row.cell)
    )
}

/// A package in words.
pub fn package_name(package: &PackageReport) -> String {
    match package.roughness {
        Some(roughness) => format!(
            "package of {}, α {}",
            package.contestant.name(),
            units::plain(roughness)
        ),
        None => format!("package of {}", package.contestant.name()),
    }
}

fn cell_name(kernel: &str, cell: &Cell) -> String {
    let mut name = format!("{kernel} {}", cell.filter);
    if let Some(roughness) = cell.roughness {
        name += &format!(" α {}", units::plain(roughness));
    }
    let half_vectors = match cell.half_vectors {
        HalfVectors::Found => "found",
        HalfVectors::Uniform => "uniform",
    };
    name + &format!(
        " σ {} {}:1 {half_vectors}",
        units::plain(cell.sigma),
        units::plain(cell.anisotropy)
    )
}

/// Whose number it is, and of what.
pub fn value_name(value: &Compared) -> String {
    let mut name = format!(
        "{} of {}, {}",
        value.quantity.name(),
        value.contestant.name(),
        value.map
    );
    if let Some((kernel, cell)) = &value.row {
        name += &format!(", {}", cell_name(kernel, cell));
    } else if let Some(roughness) = value.roughness {
        name += &format!(", α {}", units::plain(roughness));
    }
    name
}

/// Old and new, and how many times the old the new is.
pub fn values(value: &Compared) -> String {
    let [old, new] = [value.old, value.new].map(|number| value.quantity.show(number));
    match value.ratio {
        Some(ratio) => format!("{old} -> {new}, x {ratio:.3}"),
        None => format!("{old} -> {new}"),
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        self.write(&mut text)?;
        formatter.write_str(text.trim_end())
    }
}

impl Comparison {
    fn write(&self, text: &mut String) -> fmt::Result {
        for note in &self.notes {
            writeln!(text, "note: {}", printable(note))?;
        }
        if let Some(drift) = self.drift {
            writeln!(
                text,
                "the machine took {drift:.3} times as long as before ({}); ratios of times are without that",
                super::CLOCK
            )?;
        }
        for (title, verdict) in [("worse", Verdict::Worse), ("better", Verdict::Better)] {
            let changes = self.changes(verdict);
            writeln!(text, "{title}: {}", changes.len())?;
            for value in changes.iter().take(MOST) {
                writeln!(
                    text,
                    "  {}: {}",
                    printable(&value_name(value)),
                    values(value)
                )?;
            }
            write_rest(text, changes.len())?;
        }
        let same = self.changes(Verdict::Same).len();
        writeln!(text, "the same, or within what chance does: {same}")?;
        for (title, is_gone) in [
            ("only in the old report", true),
            ("only in the new report", false),
        ] {
            let missing: Vec<&Missing> = self
                .missing
                .iter()
                .filter(|missing| missing.is_gone == is_gone)
                .collect();
            if !missing.is_empty() {
                writeln!(text, "{title}: {}", missing.len())?;
                for missing in missing.iter().take(MOST) {
                    writeln!(text, "  {}", printable(&missing.what))?;
                }
                write_rest(text, missing.len())?;
            }
        }
        Ok(())
    }

    /// The comparison as a document: `notes`, `drift`, `worse`, `better`, `same` (a count), `only-old` and `only-new`.
    pub fn to_json(&self) -> Value {
        let only = |is_gone: bool| -> Vec<&str> {
            let missing = self
                .missing
                .iter()
                .filter(|missing| missing.is_gone == is_gone);
            missing.map(|missing| missing.what.as_str()).collect()
        };
        json!({
            "notes": self.notes,
            "drift": self.drift,
            "worse": self.changes(Verdict::Worse),
            "better": self.changes(Verdict::Better),
            "same": self.changes(Verdict::Same).len(),
            "only-old": only(true),
            "only-new": only(false),
        })
    }
}

fn write_rest(text: &mut String, count: usize) -> fmt::Result {
    if count > MOST {
        writeln!(text, "  and {} more", count - MOST)?;
    }
    Ok(())
}
