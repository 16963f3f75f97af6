//! What the suite and the benchmarks share: maps, packages and tolerances.

pub mod fixtures;
pub mod tolerances;

/// The README's snippets, compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
