//! What the suite and the benchmarks share: maps, packages and tolerances.

pub mod exercise;
mod exercise_material;
pub mod fixtures;
pub mod lies;
pub mod materials;
pub mod naive_lists;
pub mod queries;
pub mod seeds;
pub mod small_surfaces;
pub mod tolerances;

/// The README's snippets, compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
