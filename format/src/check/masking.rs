//! Structural check of masking tables.

use super::Limited;
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::model::MaskingGrid;
use crate::records::{Instance, MASKING};
use crate::view::MaskingTable;

/// Reports a table of the wrong size, and values that rise towards the pole: the sum over facets that turn away from
/// a direction, which the table holds, can only shrink as the direction rises.
pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    let table = match MaskingTable::open(container, instance) {
        Ok(Some(table)) => table,
        Ok(None) => return,
        Err(finding) => return report(finding),
    };
    let mut limited = Limited::new(report);
    for row in 1..MaskingGrid::ROWS {
        for column in 0..MaskingGrid::COLUMNS {
            let place = row.wrapping_mul(MaskingGrid::COLUMNS).wrapping_add(column);
            if table.excess(column, row) > table.excess(column, row.saturating_sub(1)) {
                limited.report(
                    Finding::new(Fault::MaskingOrder)
                        .within(instance.section(MASKING))
                        .at(u64::from(place)),
                );
            }
        }
    }
}
