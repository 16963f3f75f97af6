//! Measuring: what a method's answers are held against, how far they are off, and how long they take.
//!
//! A [`plan`] asks cells of footprint size, shape and filter; [`asked`] has the oracles answer each, [`entrants`] are who
//! answers in earnest, [`run`] brings them together into the rows of a report.

pub mod asked;
pub mod baselines;
pub mod clock;
pub mod entrants;
pub mod errors;
pub mod machine;
pub mod plan;
pub mod run;
pub mod sources;
pub mod stream;
pub mod subject;
pub mod visited;
