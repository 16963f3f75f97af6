//! How much worse is too much.

use super::super::table::printable;
use super::text::{value_name, values};
use super::{Compared, Comparison, Quantity, Verdict};
use serde::Serialize;
use std::str::FromStr;

/// What a threshold is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Relative L1 errors, against the truth and the model.
    Error,
    /// Bytes of packages.
    Bytes,
    /// Times of queries: of all kinds that are measured.
    Time,
    /// Seconds of bakes.
    Bake,
}

const KINDS: [(&str, Kind); 4] = [
    ("error", Kind::Error),
    ("bytes", Kind::Bytes),
    ("time", Kind::Time),
    ("bake", Kind::Bake),
];

impl Quantity {
    /// The kind of thresholds that it is held against; energy has none.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::Error | Self::ModelError => Some(Kind::Error),
            Self::Bytes => Some(Kind::Bytes),
            Self::Bake => Some(Kind::Bake),
            Self::Eval | Self::EvalCoherent | Self::Sample | Self::Pdf => Some(Kind::Time),
            Self::Energy => None,
        }
    }
}

/// How much worse a kind of numbers may become.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Threshold {
    /// Which.
    pub kind: Kind,
    /// By what share of the old number: 0.05 is 5 %.
    pub share: f64,
}

/// Thresholds, at most one of a kind, as written `error:5%,bytes:2%,time:50%`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Thresholds(pub Vec<Threshold>);

/// Why a text is no list of thresholds.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ThresholdError {
    /// A part is not of the form `kind:percent`.
    #[error("\"{0}\" is no threshold; write, for instance, error:5%,bytes:2%,time:50%")]
    Form(String),
    /// A kind is unknown.
    #[error("\"{0}\" has no threshold; there are error, bytes, time and bake")]
    Kind(String),
    /// A share is not a number from 0 with a per cent sign.
    #[error("\"{0}\" is no share; write a number from 0 to 100000 and %, such as 5%")]
    Share(String),
    /// A kind has two thresholds.
    #[error("{0} has two thresholds; give one")]
    Twice(&'static str),
}

impl FromStr for Thresholds {
    type Err = ThresholdError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut thresholds: Vec<Threshold> = Vec::new();
        for part in text.split(',').map(str::trim) {
            let (name, share) = part
                .split_once(':')
                .ok_or_else(|| ThresholdError::Form(part.to_owned()))?;
            let &(name, kind) = KINDS
                .iter()
                .find(|(known, _)| *known == name.trim())
                .ok_or_else(|| ThresholdError::Kind(name.trim().to_owned()))?;
            let share = share.trim();
            let percent = share
                .strip_suffix('%')
                .and_then(|number| number.trim().parse::<f64>().ok())
                .filter(|percent| (0.0..=100_000.0).contains(percent))
                .ok_or_else(|| ThresholdError::Share(share.to_owned()))?;
            if thresholds.iter().any(|threshold| threshold.kind == kind) {
                return Err(ThresholdError::Twice(name));
            }
            thresholds.push(Threshold {
                kind,
                share: percent / 100.0,
            });
        }
        Ok(Self(thresholds))
    }
}

/// A number that is worse than its threshold allows.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Violation {
    /// The threshold.
    pub threshold: Threshold,
    /// The number.
    pub value: Compared,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            formatter,
            "{}: {} (allowed: {} %)",
            printable(&value_name(&self.value)),
            values(&self.value),
            super::super::units::plain(self.threshold.share * 100.0)
        )
    }
}

impl Comparison {
    /// Every number that is worse than its threshold allows, in the order of the report.
    ///
    /// Of times, only those that chance does not explain: more than the threshold, the drift taken off, and more than
    /// two quartile spreads. Errors that differ by less than 1e-6 are the same.
    pub fn violations(&self, thresholds: &Thresholds) -> Vec<Violation> {
        let violates = |value: &Compared, threshold: &Threshold| {
            value.verdict == Verdict::Worse
                && value.quantity.kind() == Some(threshold.kind)
                && value
                    .ratio
                    .is_none_or(|ratio| ratio > 1.0 + threshold.share)
        };
        let violation = |value: &Compared| {
            let threshold = thresholds
                .0
                .iter()
                .find(|threshold| violates(value, threshold))?;
            Some(Violation {
                threshold: *threshold,
                value: value.clone(),
            })
        };
        self.values.iter().filter_map(violation).collect()
    }
}
