//! What came of a check: how far off, where, how much energy, what must never happen, and the verdict.

use crate::measure::subject::Subject;
use glintbake_format::model::{Filter, Footprint, HalfVector};
use glintbake_runtime::QueryError;
use std::panic::{self, AssertUnwindSafe};

/// How a check ended. Ordered from best to worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// It could not be tried; the reason says why.
    Skipped,
    /// Every answer is within its bound.
    Pass,
    /// What was tried is refused, with an error that names the cause.
    Refused,
    /// An answer is beyond its bound, or something happened that never may.
    Fail,
}

impl Verdict {
    /// The word in tables and documents.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Skipped => "skipped",
            Self::Pass => "pass",
            Self::Refused => "refused",
            Self::Fail => "FAIL",
        }
    }
}

/// What must never happen, and how often it did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Answers that are NaN or infinite.
    pub not_finite: u64,
    /// Answers below zero.
    pub negative: u64,
    /// Panics.
    pub panics: u64,
    /// Errors where an answer is due, or answers where an error is.
    pub errors: u64,
}

impl Faults {
    /// All of them.
    pub const fn count(self) -> u64 {
        self.not_finite + self.negative + self.panics + self.errors
    }
}

/// What was asked where, so that it can be asked again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct At {
    /// What kind of query.
    pub what: String,
    /// The footprint.
    pub footprint: Option<Footprint>,
    /// The half vector.
    pub half_vector: Option<HalfVector>,
}

/// What came of one check of one setting of a method on one map.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The check.
    pub check: &'static str,
    /// The method, or `-` where it does not matter.
    pub method: String,
    /// The setting.
    pub variant: String,
    /// How footprints weigh texels.
    pub filter: Option<Filter>,
    /// The map.
    pub map: String,
    /// Beckmann's α.
    pub roughness: Option<f64>,
    /// How many answers were looked at.
    pub tried: u64,
    /// How many queries were refused as documented.
    pub refused: u64,
    /// The error nearest to its bound, or furthest beyond.
    pub error: f64,
    /// Its bound.
    pub bound: f64,
    /// The largest error of all, whatever its bound.
    pub largest: f64,
    /// Where the error nearest to its bound was.
    pub at: Option<At>,
    /// The least and the greatest energy, where that was summed.
    pub energy: Option<[f64; 2]>,
    /// What never may happen.
    pub faults: Faults,
    /// The first of these in words.
    pub complaint: Option<String>,
    /// The verdict.
    pub verdict: Verdict,
    /// Why the bound is what it is, or why the check was skipped or what was refused.
    pub reason: String,
}

impl Outcome {
    /// Nothing of `check`, which could not be tried for `reason`.
    pub fn skipped(check: &'static str, reason: impl Into<String>) -> Self {
        Recorder::new(check, reason).outcome
    }

    /// What `check` was refused, as it must be, for `reason`.
    pub fn refused(check: &'static str, reason: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Refused,
            ..Self::skipped(check, reason)
        }
    }

    /// The failure of `check` as a whole, for `complaint`.
    pub fn failed(check: &'static str, complaint: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Fail,
            faults: Faults {
                errors: 1,
                ..Faults::default()
            },
            complaint: Some(complaint.into()),
            ..Self::skipped(check, "it must run to its end")
        }
    }

    /// The same of the method of `subject` at `roughness`.
    #[must_use]
    pub fn of(mut self, subject: &dyn Subject, roughness: Option<f64>) -> Self {
        subject.method().name().clone_into(&mut self.method);
        self.roughness = roughness;
        self
    }

    /// How near the worst error comes to its bound: above 1 is beyond.
    pub fn ratio(&self) -> f64 {
        ratio(self.error, self.bound)
    }

    /// What `self` and `other` say together: counts added, the worse error, the worse verdict.
    #[must_use]
    pub fn with(mut self, other: &Self) -> Self {
        self.tried += other.tried;
        self.refused += other.refused;
        self.largest = self.largest.max(other.largest);
        self.faults.not_finite += other.faults.not_finite;
        self.faults.negative += other.faults.negative;
        self.faults.panics += other.faults.panics;
        self.faults.errors += other.faults.errors;
        if self.complaint.is_none() {
            self.complaint.clone_from(&other.complaint);
        }
        self.energy = match (self.energy, other.energy) {
            (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
            (a, b) => a.or(b),
        };
        let is_worse = (other.verdict, other.ratio()) > (self.verdict, self.ratio());
        if is_worse || self.verdict == Verdict::Skipped && other.verdict != Verdict::Skipped {
            self.error = other.error;
            self.bound = other.bound;
            self.at.clone_from(&other.at);
            self.map.clone_from(&other.map);
            self.roughness = other.roughness;
            self.variant.clone_from(&other.variant);
            self.reason.clone_from(&other.reason);
        }
        self.verdict = self.verdict.max(other.verdict);
        self
    }
}

fn ratio(error: f64, bound: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / bound }
}

/// Writes an [`Outcome`] while a check runs.
#[derive(Debug)]
pub struct Recorder {
    outcome: Outcome,
}

impl Recorder {
    /// Nothing yet of `check`, whose bound is what it is for `reason`.
    pub fn new(check: &'static str, reason: impl Into<String>) -> Self {
        Self {
            outcome: Outcome {
                check,
                method: "-".to_owned(),
                variant: "-".to_owned(),
                filter: None,
                map: "-".to_owned(),
                roughness: None,
                tried: 0,
                refused: 0,
                error: 0.0,
                bound: 0.0,
                largest: 0.0,
                at: None,
                energy: None,
                faults: Faults::default(),
                complaint: None,
                verdict: Verdict::Skipped,
                reason: reason.into(),
            },
        }
    }

    /// What `ask` answers, if it is an answer: not a number, a negative one, a panic and an error other than the refusals
    /// that queries document are counted.
    pub fn ask(
        &mut self,
        at: impl Fn() -> At,
        ask: impl FnOnce() -> Result<f64, QueryError>,
    ) -> Option<f64> {
        let value = self.call(&at, ask)?;
        if !value.is_finite() {
            self.outcome.faults.not_finite += 1;
            self.complain(&at(), &format!("the answer is {value}"));
            return None;
        }
        if value < 0.0 {
            self.outcome.faults.negative += 1;
            self.complain(&at(), &format!("the answer is {value}"));
        }
        Some(value)
    }

    /// What `call` returns, unless it panics or fails.
    pub fn call<T>(
        &mut self,
        at: impl Fn() -> At,
        call: impl FnOnce() -> Result<T, QueryError>,
    ) -> Option<T> {
        self.outcome.tried += 1;
        match panic::catch_unwind(AssertUnwindSafe(call)) {
            Ok(Ok(value)) => Some(value),
            Ok(Err(QueryError::TooManyTexels { .. } | QueryError::FootprintTooLarge)) => {
                self.outcome.refused += 1;
                None
            }
            Ok(Err(error)) => {
                self.fault(&at(), &error.to_string());
                None
            }
            Err(_) => {
                self.outcome.faults.panics += 1;
                self.complain(&at(), "it panicked");
                None
            }
        }
    }

    /// Records an error where an answer is due, or the other way round.
    pub fn fault(&mut self, at: &At, complaint: &str) {
        self.outcome.faults.errors += 1;
        self.complain(at, complaint);
    }

    /// Records that the last call was refused, as was due.
    pub fn count_refusal(&mut self) {
        self.outcome.refused += 1;
    }

    fn complain(&mut self, at: &At, complaint: &str) {
        self.outcome
            .complaint
            .get_or_insert_with(|| format!("{}: {complaint}", at.what));
    }

    /// Records that what was asked at `at` is `error` off, of which `bound` is allowed.
    pub fn compare(&mut self, error: f64, bound: f64, at: impl FnOnce() -> At) {
        // NaN counts as beyond.
        let error = if error.is_nan() { f64::INFINITY } else { error };
        self.outcome.largest = self.outcome.largest.max(error);
        if self.outcome.at.is_none() || ratio(error, bound) > self.outcome.ratio() {
            self.outcome.error = error;
            self.outcome.bound = bound;
            self.outcome.at = Some(at());
        }
    }

    /// Records a sum of energy.
    pub fn energy(&mut self, energy: f64) {
        let [least, most] = self.outcome.energy.unwrap_or([energy; 2]);
        self.outcome.energy = Some([least.min(energy), most.max(energy)]);
    }

    /// The outcome, [`Verdict::Skipped`] if nothing was tried.
    pub fn finish(self) -> Outcome {
        let mut outcome = self.outcome;
        let is_within = outcome.error <= outcome.bound;
        outcome.verdict = if outcome.faults.count() > 0 || !is_within {
            Verdict::Fail
        } else if outcome.tried == 0 {
            "the map has no footprint for it that the oracle can weigh"
                .clone_into(&mut outcome.reason);
            Verdict::Skipped
        } else if outcome.refused > 0 && outcome.at.is_none() {
            Verdict::Refused
        } else {
            Verdict::Pass
        };
        outcome
    }
}
