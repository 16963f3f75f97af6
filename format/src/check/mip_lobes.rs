//! Structural checks of the sections behind `mip-lobes`.

use super::Limited;
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::model::{MIP_LANES, QuiltLayout};
use crate::records::{Instance, MIP_INDEX, MipBlock, NORMALS, QUILT_CUTS, QUILT_ORIGINS};
use crate::view::{MipLobes, NO_CELL};
use zerocopy::little_endian::{F32, U16};

/// Shares of the lobes of a cell add up to it.
const WHOLE: u32 = 65535;

/// Reports normals that are no points of the disk, patches whose block is not on the sample or whose cells are not there, cells that
/// no patch has, and lobes that are none or do not add up.
pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    if let Err(finding) = MipLobes::of_map(container, instance) {
        return report(finding);
    }
    let lobes = match MipLobes::open(container, instance) {
        Ok(Some(lobes)) => lobes,
        // Those of another instance are checked with it.
        Ok(None) => return,
        Err(finding) => return report(finding),
    };
    check_normals(&lobes, instance, report);
    if let Some(quilt) = lobes.layout.quilt {
        check_quilt(&lobes, &quilt, instance, report);
        check_index(&lobes, &quilt, instance, report);
    }
    check_blocks(&lobes, report);
}

fn check_normals(lobes: &MipLobes<'_>, instance: &Instance, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    for (place, normal) in (0..).zip(lobes.normals) {
        let [s, t] = normal.point();
        // So that NaN is found.
        let is_on_disk = s * s + t * t <= 1.0;
        if !is_on_disk {
            let id = instance.section(NORMALS);
            limited.report(Finding::new(Fault::SurfaceNormal).within(id).at(place));
        }
    }
}

fn check_quilt(
    lobes: &MipLobes<'_>,
    quilt: &QuiltLayout,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    let step = 1_u16 << (quilt.grid_log & 15);
    let mut limited = Limited::new(report);
    for (place, origin) in (0..).zip(lobes.origins) {
        let is_sound = origin
            .iter()
            .zip(quilt.sample)
            .all(|(at, side)| u32::from(at.get()) < side && at.get().is_multiple_of(step));
        if !is_sound {
            let id = instance.section(QUILT_ORIGINS);
            limited.report(Finding::new(Fault::QuiltOrigin).within(id).at(place));
        }
    }
    let mut limited = Limited::new(report);
    for (place, &cut) in (0..).zip(lobes.cuts) {
        if cut > quilt.overlap {
            let id = instance.section(QUILT_CUTS);
            let finding = Finding::new(Fault::QuiltCut).within(id).at(place);
            limited.report(finding.values(u64::from(quilt.overlap), u64::from(cut)));
        }
    }
}

/// Cells are numbered in order of their places, and those that patches have are there.
fn check_index(
    lobes: &MipLobes<'_>,
    quilt: &QuiltLayout,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    let id = instance.section(MIP_INDEX);
    let mut next = 0;
    let mut limited = Limited::new(report);
    for (place, number) in (0..).zip(lobes.index) {
        let number = number.get();
        if number == next {
            next = next.wrapping_add(1);
        } else if number != NO_CELL {
            let finding = Finding::new(Fault::MipIndex).within(id).at(place);
            limited.report(finding.values(u64::from(next), u64::from(number)));
            return;
        }
    }
    if next as usize != lobes.sample_cells {
        let finding = Finding::new(Fault::MipIndex).within(id);
        limited.report(finding.values(u64::from(next), lobes.sample_cells as u64));
        return;
    }
    for level in lobes.layout.first_level..=quilt.patch_log {
        let shift = quilt.patch_log.wrapping_sub(level) & 31;
        let [columns, rows] = quilt.patches.map(|count| count << shift);
        for row in 0..rows {
            for column in 0..columns {
                if lobes.cell(level, column, row).is_none() {
                    let place = u64::from(row)
                        .wrapping_mul(u64::from(columns))
                        .wrapping_add(u64::from(column));
                    limited.report(Finding::new(Fault::MipIndex).within(id).at(place));
                }
            }
        }
    }
}

fn check_blocks(lobes: &MipLobes<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let of_cell = usize::from(lobes.layout.blocks.max(1));
    for (cell, blocks) in lobes.blocks.chunks(of_cell).enumerate() {
        let mut sum = 0_u32;
        for (number, block) in blocks.iter().enumerate() {
            sum = block
                .weight
                .iter()
                .fold(sum, |sum, weight| sum.wrapping_add(u32::from(weight.get())));
            if !is_sound(block) {
                let place = cell.wrapping_mul(of_cell).wrapping_add(number);
                let finding = Finding::new(Fault::MipLobe).within(lobes.id);
                limited.report(finding.at(place as u64));
            }
        }
        if sum != WHOLE {
            let finding = Finding::new(Fault::MipWeight).within(lobes.id);
            let place = cell.wrapping_mul(of_cell) as u64;
            limited.report(finding.at(place).values(u64::from(WHOLE), u64::from(sum)));
        }
    }
}

/// Whether every number is one, and lobes that weigh something have a position factor that can be divided by, and normals near the
/// disk.
fn is_sound(block: &MipBlock) -> bool {
    let within = |x: F32, most: f32| (0.0..=most).contains(&x.get());
    let is_there = |lane: usize| {
        let is_zero = |lanes: &[U16; MIP_LANES]| lanes.get(lane).is_none_or(|x| x.get() == 0);
        is_zero(&block.weight) || !(is_zero(&block.l_11) || is_zero(&block.l_22))
    };
    block.low.iter().all(|x| (-1.01..=1.01).contains(&x.get()))
        && block.step.iter().all(|&x| within(x, 2.01 / 65535.0))
        && within(block.slope_step, 1e6)
        && within(block.residual_step, 1.0)
        && within(block.spread, 1e6)
        && block.reserved == [0; 4]
        && (0..MIP_LANES).all(is_there)
}
