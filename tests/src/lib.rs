//! What the suite and the benchmarks share: maps, packages and tolerances; and what the runtime is measured against.

pub mod exercise;
pub mod fixtures;
pub mod lies;
pub mod naive_lists;
pub mod paper_forest;
pub mod parallelogram;
pub mod plain_scan;
pub mod plot;
pub mod seeds;
pub mod tolerances;
pub mod window;

/// The README's snippets, compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
