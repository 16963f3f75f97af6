//! Structural checks of box pyramids.

use super::Limited;
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::model::PYRAMID_SIDE;
use crate::records::Instance;
use crate::view::BoxPyramid;

/// Reports sections of the wrong size, roots that are no box, and boxes that are there where no cell is, or the other way round.
pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    // Looked up as queries do, so that an instance without a pyramid to share is found.
    if let Err(finding) = BoxPyramid::of_map(container, instance) {
        return report(finding);
    }
    match BoxPyramid::open(container, instance) {
        Ok(Some(pyramid)) => check_boxes(&pyramid, report),
        // That of another instance is checked with it.
        Ok(None) => {}
        Err(finding) => report(finding),
    }
}

fn check_boxes(pyramid: &BoxPyramid<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let layout = pyramid.layout;
    for level in 1..=layout.top() {
        let ([columns, rows], finer) = (layout.size(level), layout.size(level.wrapping_sub(1)));
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)))
        {
            let place = layout.place(level, column, row);
            let Some(node) = pyramid.nodes.get(place) else {
                continue;
            };
            for child in 0..PYRAMID_SIDE * PYRAMID_SIDE {
                let x = column
                    .wrapping_mul(PYRAMID_SIDE)
                    .wrapping_add(child % PYRAMID_SIDE);
                let y = row
                    .wrapping_mul(PYRAMID_SIDE)
                    .wrapping_add(child / PYRAMID_SIDE);
                let is_cell = x < finer[0] && y < finer[1];
                if pyramid.root.child(node, child).is_some() != is_cell {
                    limited.report(
                        Finding::new(Fault::PyramidBox)
                            .within(pyramid.id)
                            .at(place as u64),
                    );
                }
            }
        }
    }
}
