//! Pictures: a P-NDF over the projected disk, a ball under small lights, and the PNG files they are written to.
//!
//! Pictures are drawn in f64 by rows, each pixel from its place alone, so that they are the same for any number of
//! threads and on every platform.

pub mod ball;
pub mod binning;
pub mod colour;
#[cfg(test)]
mod fixtures;
pub mod ndf;
pub mod png;

use glintbake_runtime::QueryError;

/// The values of `rows`, or the error of the first row that has one: which error is told never depends on threads.
fn first_error<T>(rows: Vec<Result<T, QueryError>>) -> Result<Vec<T>, QueryError> {
    rows.into_iter().collect()
}
