//! How far a method may be off, and in which order its settings should come nearer to the truth.

use super::Variant;

/// How far an answer may be from the method's own model.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Error allowed, as a share of the density or of the floor, whichever is greater.
    pub relative: f64,
    /// The floor, as a share of the kernel's peak: below it errors are absolute.
    pub floor: f64,
    /// Why, in one sentence.
    pub reason: String,
}

impl Bound {
    /// What `got` is off `expected` as a share of it or of the floor under a kernel of height `peak`.
    pub fn error(&self, got: f64, expected: f64, peak: f64) -> f64 {
        (got - expected).abs() / expected.max(self.floor * peak)
    }

    /// Whether any density up to the kernel's peak is allowed: the model then says nothing of a single one.
    pub fn is_of_the_peak(&self) -> bool {
        self.relative * self.floor >= 1.0
    }

    /// The error allowed at `expected`, absolute.
    pub fn allowed(&self, expected: f64, peak: f64) -> f64 {
        self.relative * expected.max(self.floor * peak)
    }
}

/// What the rungs of a ladder come nearer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The truth of the method's kernel.
    Truth,
    /// The method's own model.
    Model,
}

/// Settings from coarse to exact, whose error must fall.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// What is tightened.
    pub name: &'static str,
    /// Settings, coarse first.
    pub rungs: Vec<Variant>,
    /// What errors are measured against.
    pub against: Against,
    /// Error of the last rung, in relative L1, that counts as none.
    pub exact: f64,
    /// How much greater an error may be than that of the rung before, for chance.
    pub slack: f64,
}
