//! Structural checks of the sections behind `lean`.

use super::{Limited, MAX_FINDINGS_PER_SECTION};
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::records::{Instance, NarrowMean, SPREADS, WideMean};
use crate::view::{Means, Pyramid};

/// Reports sections of the wrong size, and moments that no map of unit normals has: means off the disk, spreads too large
/// for their mean, and, where levels halve evenly, means that are not the average of those below.
pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    // Looked up as queries do, so that an instance without a pyramid to share is found.
    if let Err(finding) = Pyramid::of_map(container, instance) {
        return report(finding);
    }
    let pyramid = match Pyramid::open(container, instance) {
        Ok(Some(pyramid)) => pyramid,
        // That of another instance is checked with it.
        Ok(None) => return,
        Err(finding) => return report(finding),
    };
    check_ranges(&pyramid, instance, report);
    check_averages(&pyramid, report);
}

/// How far a stored component may be from what was baked.
fn error(pyramid: &Pyramid<'_>) -> f64 {
    match pyramid.means {
        Means::Narrow(_) => NarrowMean::ERROR,
        Means::Wide(_) => WideMean::ERROR,
    }
}

/// Whether the stored mean at `place` uses the one number below the range.
fn is_below_range(pyramid: &Pyramid<'_>, place: usize) -> bool {
    match pyramid.means {
        Means::Narrow(means) => means
            .get(place)
            .is_some_and(|mean| mean.0.iter().any(|value| value.get() == i16::MIN)),
        Means::Wide(means) => means
            .get(place)
            .is_some_and(|mean| mean.0.iter().any(|value| value.get() == i32::MIN)),
    }
}

fn check_ranges(pyramid: &Pyramid<'_>, instance: &Instance, report: &mut dyn FnMut(Finding)) {
    let layout = pyramid.layout;
    // Rounded outwards, a mean may lie beyond the rim by as much in each component.
    let slack = 4.0 * error(pyramid) + 1e-12;
    let (mut off_disk, mut too_wide) = (MAX_FINDINGS_PER_SECTION, MAX_FINDINGS_PER_SECTION);
    for number in layout.finest()..=layout.top() {
        let level = pyramid.level(number);
        for (column, row) in cells(level.size) {
            let (Ok(cell), Some([mean, spread])) =
                (level.cell(column, row), level.places(column, row))
            else {
                continue;
            };
            let [s, t] = cell.mean;
            let squared = s * s + t * t;
            if off_disk > 0 && (squared > 1.0 + slack || is_below_range(pyramid, mean)) {
                off_disk = off_disk.saturating_sub(1);
                report(
                    Finding::new(Fault::MeanRange)
                        .within(pyramid.id)
                        .at(mean as u64),
                );
            }
            let is_number = number == 0
                || pyramid
                    .spreads
                    .get(spread)
                    .is_some_and(|spread| spread.correlation.get() != i16::MIN);
            let [ss, _, tt] = cell.covariance;
            // Unit normals have s² + t² of at most 1, on average as well; deviations are kept within 1.6e-5.
            if too_wide > 0 && (squared + ss + tt > 1.0 + slack + 1e-4 || !is_number) {
                too_wide = too_wide.saturating_sub(1);
                let id = instance.section(SPREADS);
                report(
                    Finding::new(Fault::SpreadRange)
                        .within(id)
                        .at(spread as u64),
                );
            }
        }
    }
}

fn check_averages(pyramid: &Pyramid<'_>, report: &mut dyn FnMut(Finding)) {
    let layout = pyramid.layout;
    // Both the average and what it is of were rounded.
    let slack = 2.0 * error(pyramid) + 1e-12;
    let mut limited = Limited::new(report);
    for number in layout.finest().saturating_add(1)..=layout.top() {
        let (level, finer) = (pyramid.level(number), pyramid.level(number.wrapping_sub(1)));
        let ([columns, rows], [finer_columns, finer_rows]) = (level.size, finer.size);
        // Only cells that are unions of finer ones are an average of these.
        if finer_columns % columns != 0 || finer_rows % rows != 0 {
            continue;
        }
        let (across, down) = (finer_columns / columns, finer_rows / rows);
        for (column, row) in cells(level.size) {
            let (mut sum, mut count) = ([0.0; 2], 0.0);
            for (x, y) in cells([across, down]) {
                let place = [
                    column.wrapping_mul(across).wrapping_add(x),
                    row.wrapping_mul(down).wrapping_add(y),
                ];
                if let Ok(cell) = finer.cell(place[0], place[1]) {
                    sum = [sum[0] + cell.mean[0], sum[1] + cell.mean[1]];
                    count += 1.0;
                }
            }
            let (Ok(cell), Some([mean, _])) = (level.cell(column, row), level.places(column, row))
            else {
                continue;
            };
            let off = |mean: f64, sum: f64| (mean * count - sum).abs() > slack * count;
            if off(cell.mean[0], sum[0]) || off(cell.mean[1], sum[1]) {
                limited.report(
                    Finding::new(Fault::MeanAverage)
                        .within(pyramid.id)
                        .at(mean as u64),
                );
            }
        }
    }
}

/// Column and row of each cell of a grid, row by row.
fn cells([columns, rows]: [u32; 2]) -> impl Iterator<Item = (u32, u32)> {
    (0..rows).flat_map(move |row| (0..columns).map(move |column| (column, row)))
}
