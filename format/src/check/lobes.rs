//! Structural checks of the sections behind `lobes`.

use super::{Limited, MAX_FINDINGS_PER_SECTION, box_pyramid};
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::model::PYRAMID_SIDE;
use crate::records::{
    Instance, LOBE_MOMENTS, LOBE_SPREADS, LobeBlock, LobeIndex, LobeSlopes, WideLobeBlock,
    WideLobeSlopes,
};
use crate::view::{LobeNormal, Lobes, LobesOfBlock, PyramidBox};
use zerocopy::IntoBytes;

/// Lobes of a block.
const LOBES: u32 = PYRAMID_SIDE * PYRAMID_SIDE;

/// Reports what [`box_pyramid::check`] does, blocks that are stored twice or not at all, numbers that are none, lobes that leave
/// their boxes and would be missed, and means of blocks that are not those of their lobes.
pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    if let Err(finding) = Lobes::of_map(container, instance) {
        return report(finding);
    }
    box_pyramid::check(container, instance, report);
    let lobes = match Lobes::open(container, instance) {
        Ok(Some(lobes)) => lobes,
        Ok(None) => return,
        Err(finding) => return report(finding),
    };
    check_index(&lobes, report);
    let mut left = Left {
        range: MAX_FINDINGS_PER_SECTION,
        unused: MAX_FINDINGS_PER_SECTION,
        outside: MAX_FINDINGS_PER_SECTION,
        moments: MAX_FINDINGS_PER_SECTION,
    };
    let layout = lobes.pyramid.layout;
    let [columns, rows] = layout.size(0);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let (x, y) = (
            column.wrapping_mul(PYRAMID_SIDE),
            row.wrapping_mul(PYRAMID_SIDE),
        );
        if let Ok(Some((place, child, bounds))) = lobes.pyramid.block_at(x, y) {
            let block = Block {
                place,
                child,
                bounds,
                first: [x, y],
            };
            check_block(&lobes, instance, &block, &mut left, report);
        }
    }
}

/// How many findings of each kind may still be reported.
struct Left {
    range: u32,
    unused: u32,
    outside: u32,
    moments: u32,
}

/// A block, its place, and the column and row of its first lobe.
struct Block {
    place: usize,
    child: u32,
    bounds: PyramidBox,
    first: [u32; 2],
}

fn check_block(
    lobes: &Lobes<'_>,
    instance: &Instance,
    block: &Block,
    left: &mut Left,
    report: &mut dyn FnMut(Finding),
) {
    let mut tell = |left: &mut u32, fault, id| {
        if *left > 0 {
            *left = left.saturating_sub(1);
            report(Finding::new(fault).within(id).at(block.place as u64));
        }
    };
    let moments = instance.section(LOBE_MOMENTS);
    if !lobes
        .moments
        .get(block.place)
        .is_some_and(|moments| is_unit(moments.slope_step.get()))
    {
        tell(&mut left.range, Fault::LobeRange, moments);
        return;
    }
    let spreads = lobes.spreads.get(block.place);
    if spreads.is_some_and(|spreads| !is_unit(spreads.step.get())) {
        tell(
            &mut left.range,
            Fault::LobeRange,
            instance.section(LOBE_SPREADS),
        );
        return;
    }
    let stored = match lobes.block(block.place, block.child) {
        Ok(LobesOfBlock::Merged) | Err(_) => return,
        Ok(LobesOfBlock::Narrow(narrow, _)) => {
            let units = [
                narrow.step[0].get(),
                narrow.step[1].get(),
                narrow.slope_step.get(),
            ];
            units.into_iter().all(is_unit)
        }
        Ok(LobesOfBlock::Wide(..)) => true,
    };
    let spread = lobes.spread(block.place, block.child);
    let [columns, rows] = lobes.pyramid.layout.cells();
    let (mut sum, mut count, mut is_sound, mut is_inside) = ([0.0; 2], 0.0, stored, true);
    for number in 0..LOBES {
        let Ok(lobe) = lobes.lobe(block.place, block.child, number, &block.bounds) else {
            continue;
        };
        let x = block.first[0].wrapping_add(number % PYRAMID_SIDE);
        let y = block.first[1].wrapping_add(number / PYRAMID_SIDE);
        if x >= columns || y >= rows {
            if !is_zero(lobes, block, number) {
                tell(&mut left.unused, Fault::LobeUnused, lobes.id);
            }
            continue;
        }
        let numbers = [
            lobe.normal[0],
            lobe.normal[1],
            lobe.slope[0],
            lobe.slope[1],
            lobe.slope[2],
            lobe.slope[3],
        ];
        is_sound = is_sound && numbers.iter().all(|x| x.abs() <= 8.0);
        is_inside =
            is_inside && is_within(&lobe, &block.bounds) && lobe.spread() <= 1.001 * spread + 1e-6;
        sum = [sum[0] + lobe.normal[0], sum[1] + lobe.normal[1]];
        count += 1.0;
    }
    if !is_sound {
        return tell(&mut left.range, Fault::LobeRange, lobes.id);
    }
    if !is_inside {
        tell(&mut left.outside, Fault::LobeBox, lobes.id);
    }
    if let Ok(cell) = lobes.cell(block.place, block.child, &block.bounds) {
        let extent = block.bounds.extent();
        let off = |axis: usize| {
            let mean = sum.get(axis).map_or(0.0, |sum| sum / count);
            let stored = cell.lobe.normal.get(axis).copied().unwrap_or(f64::NAN);
            let slack = extent.get(axis).copied().unwrap_or(0.0) / 30_000.0 + 2e-6;
            // Not a number is off as well.
            (mean - stored).abs().partial_cmp(&slack) != Some(core::cmp::Ordering::Less)
        };
        if off(0) || off(1) {
            tell(&mut left.moments, Fault::LobeMoments, moments);
        }
    }
}

fn is_unit(x: f32) -> bool {
    (0.0..=8.0).contains(&x)
}

/// Whether the lobe lies in the box, but for what nested roundings and those of the lobe add.
fn is_within(lobe: &LobeNormal, bounds: &PyramidBox) -> bool {
    /// More than 16 bits and f32 round by.
    const SLACK: f64 = 2e-5;
    let extent = bounds.extent();
    let [low_s, low_t] = bounds.low;
    let [s, t] = lobe.normal;
    s >= low_s - SLACK
        && s <= low_s + extent[0] + SLACK
        && t >= low_t - SLACK
        && t <= low_t + extent[1] + SLACK
}

/// Whether all numbers of lobe `number` of a block are zero.
fn is_zero(lobes: &Lobes<'_>, block: &Block, number: u32) -> bool {
    let at = number as usize;
    match lobes.block(block.place, block.child) {
        Ok(LobesOfBlock::Narrow(LobeBlock { s, t, .. }, slopes)) => {
            let normals = [s.get(at), t.get(at)];
            normals.iter().flatten().all(|n| n.get() == 0)
                && slopes.is_none_or(|LobeSlopes { s_x, s_y, t_x, t_y }| {
                    let lanes = [s_x.get(at), s_y.get(at), t_x.get(at), t_y.get(at)];
                    lanes.iter().flatten().all(|n| n.get() == 0)
                })
        }
        Ok(LobesOfBlock::Wide(WideLobeBlock { s, t }, slopes)) => {
            let normals = [s.get(at), t.get(at)];
            normals.iter().flatten().all(|x| x.as_bytes() == [0; 4])
                && slopes.is_none_or(|WideLobeSlopes { s_x, s_y, t_x, t_y }| {
                    let lanes = [s_x.get(at), s_y.get(at), t_x.get(at), t_y.get(at)];
                    lanes.iter().flatten().all(|x| x.as_bytes() == [0; 4])
                })
        }
        Ok(LobesOfBlock::Merged) | Err(_) => true,
    }
}

/// Reports nodes whose blocks are not stored one after another, in order of nodes, each once, and blocks of no node.
fn check_index(lobes: &Lobes<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let layout = lobes.pyramid.layout;
    let [across, down] = layout.size(0);
    let [columns, _] = layout.size(1);
    let (mut narrow, mut wide) = (0_u32, 0_u32);
    for (place, index) in (0_u32..).zip(lobes.index) {
        let LobeIndex {
            first,
            first_wide,
            narrow: mask,
            wide: wide_mask,
        } = *index;
        let (column, row) = (place % columns.max(1), place / columns.max(1));
        let mut there = 0_u16;
        for child in 0..LOBES {
            let x = column
                .wrapping_mul(PYRAMID_SIDE)
                .wrapping_add(child % PYRAMID_SIDE);
            let y = row
                .wrapping_mul(PYRAMID_SIDE)
                .wrapping_add(child / PYRAMID_SIDE);
            if x < across && y < down {
                there |= 1_u16.wrapping_shl(child);
            }
        }
        let (mask, wide_mask) = (mask.get(), wide_mask.get());
        let is_sound = first.get() == narrow
            && first_wide.get() == wide
            && mask & wide_mask == 0
            && (mask | wide_mask) & !there == 0;
        if !is_sound {
            limited.report(
                Finding::new(Fault::LobeIndex)
                    .within(lobes.id)
                    .at(u64::from(place)),
            );
        }
        narrow = narrow.wrapping_add(mask.count_ones());
        wide = wide.wrapping_add(wide_mask.count_ones());
    }
    if [narrow as usize, wide as usize] != lobes.block_counts() {
        limited.report(Finding::new(Fault::LobeIndex).within(lobes.id));
    }
}
