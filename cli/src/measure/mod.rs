//! Measuring: what a method's answers are held against, how far they are off, and how long they take.

pub mod baselines;
pub mod subject;
