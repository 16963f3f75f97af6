//! Which way to the weights is the cheaper one.

use super::map_shape;
use super::window::KeyRuns;
use crate::error::QueryError;
use crate::overlap::Parallelogram;
use glintbake_format::view::{BinTables, Inverse};

/// Whether lists are cheaper than a scan.
pub(super) fn lists_are_cheaper(
    tables: &BinTables<'_>,
    footprint: &Parallelogram,
    _runs: &KeyRuns,
) -> Result<bool, QueryError> {
    if matches!(tables.inverse, Inverse::None) {
        return Ok(false);
    }
    let _ = map_shape(tables);
    Ok(footprint.area() > 4000.0)
}
