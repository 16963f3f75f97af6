//! Structural checks of surfaces.

use super::Limited;
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::records::Instance;
use crate::view::{BoxPyramid, GlobalNdf, Normals, PyramidBox};

/// Reports normals that are no points of the disk or not within the boxes that queries find them by, and global NDFs that
/// cannot be drawn from.
pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    if let Err(finding) = Normals::of_map(container, instance) {
        report(finding);
    }
    match Normals::open(container, instance) {
        Ok(Some(normals)) => {
            check_normals(&normals, report);
            if let Ok(Some(pyramid)) = BoxPyramid::open(container, instance) {
                check_boxes(&normals, &pyramid, report);
            }
        }
        // Those of another instance are checked with it.
        Ok(None) => {}
        Err(finding) => report(finding),
    }
    match GlobalNdf::open(container, instance) {
        Ok(global) => check_global(&global, report),
        Err(finding) => report(finding),
    }
}

fn check_normals(normals: &Normals<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    for (place, normal) in normals.normals.iter().enumerate() {
        let [s, t] = normal.point();
        // So that NaN is found.
        let is_on_disk = s * s + t * t <= 1.0;
        if !is_on_disk {
            let finding = Finding::new(Fault::SurfaceNormal).within(normals.id);
            limited.report(finding.at(place as u64));
        }
    }
}

/// Every normal is a vertex of the cell of its own column and row, and so in its box, but for rounding.
fn check_boxes(normals: &Normals<'_>, pyramid: &BoxPyramid<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let [width, height] = normals.size;
    for row in 0..height {
        let mut found: Option<PyramidBox> = None;
        for column in 0..width {
            if column % 4 == 0 {
                match pyramid.block_at(column, row) {
                    Ok(block) => found = block.map(|(_, _, bounds)| bounds),
                    Err(finding) => return limited.report(finding),
                }
            }
            let (Some(bounds), Some(normal)) = (found, normals.normal(column, row)) else {
                continue;
            };
            let extent = bounds.extent();
            let ends = bounds.low.iter().zip(&extent);
            let is_within = ends
                .zip(&normal)
                .all(|((low, extent), x)| (low - 1e-6..=low + extent + 1e-6).contains(x));
            if !is_within {
                let place = u64::from(row)
                    .wrapping_mul(u64::from(width))
                    .wrapping_add(u64::from(column));
                limited.report(Finding::new(Fault::SurfaceBox).within(normals.id).at(place));
            }
        }
    }
}

fn check_global(global: &GlobalNdf<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let mut before = 0;
    for (place, sum) in global.sums.iter().enumerate() {
        let is_last = place.saturating_add(1) == global.sums.len();
        if sum.get() < before || (is_last && sum.get() != u32::MAX) {
            limited.report(
                Finding::new(Fault::GlobalOrder)
                    .within(global.id)
                    .at(place as u64),
            );
        }
        before = sum.get();
    }
}
