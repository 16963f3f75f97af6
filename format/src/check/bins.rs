//! Structural checks of the sections behind `flake-bins` and `specular-bins`.

use super::{Limited, block_lists, inverse_bin_map};
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::model::{BLOCK_SIDE, BLOCK_TEXELS};
use crate::records::{Instance, OCCUPIED_BINS};
use crate::view::{BinTables, ExactNormals, Inverse, KeyLayout};

pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    if let Err(finding) = try_check(container, instance, report) {
        report(finding);
    }
}

/// Reports what it can; an error is a fault that makes the rest of the instance meaningless.
fn try_check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) -> Result<(), Finding> {
    let tables = BinTables::open(container, instance)?;
    ExactNormals::open(container, instance)?;
    check_keys(&tables, report);
    check_occupied(&tables, report);
    match &tables.inverse {
        Inverse::Forest(inverse) => inverse_bin_map::check(&tables, inverse, report),
        Inverse::Tiles(lists) => block_lists::check(&tables, lists, report),
        Inverse::None => Ok(()),
    }
}

fn check_keys(tables: &BinTables<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let key_count = tables.bins.key_count;
    for place in 0..tables.bin_map.len() {
        let Some(key) = tables.bin_map.key_at(place) else {
            continue;
        };
        let finding = |fault| {
            Finding::new(fault)
                .within(tables.bin_map.id)
                .at(place as u64)
        };
        if is_on_map(tables, place) {
            if key >= key_count {
                limited
                    .report(finding(Fault::KeyRange).values(u64::from(key_count), u64::from(key)));
            }
        } else if key != 0 {
            limited.report(finding(Fault::KeyUnused).values(0, u64::from(key)));
        }
    }
}

/// Whether place `place` of the bin map is a texel's.
fn is_on_map(tables: &BinTables<'_>, place: usize) -> bool {
    let KeyLayout::Blocks(layout) = tables.bin_map.layout else {
        return true;
    };
    let (block, texel) = (place / BLOCK_TEXELS, (place % BLOCK_TEXELS) as u32);
    let columns = layout.columns as usize;
    let column = (block % columns) as u32 * BLOCK_SIDE + texel % BLOCK_SIDE;
    let row = (block / columns) as u32 * BLOCK_SIDE + texel / BLOCK_SIDE;
    column < tables.instance.width && row < tables.instance.height
}

fn check_occupied(tables: &BinTables<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let mut least = 0;
    for (place, bin) in (0..).zip(tables.index.occupied()) {
        let bin = bin.get();
        if bin < least || bin >= tables.bins.grid.count() {
            limited.report(
                Finding::new(Fault::OccupiedBins)
                    .within(tables.instance.section(OCCUPIED_BINS))
                    .at(place)
                    .values(u64::from(least), u64::from(bin)),
            );
        }
        least = bin.saturating_add(1);
    }
}
