//! Structural checks of the sections behind `flake-bins` and `specular-bins`.

use super::Limited;
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::model::{ForestShape, morton_index};
use crate::records::{
    BIN_MAP, BoxRecord, EXACT_NORMALS, ExactNormal, FOREST, ForestNode, INDEX, INVERSE_BIN_MAP,
    IndexKind, Instance, OCCUPIED_BINS, TexelPosition,
};
use crate::section::{FourCc, SectionId};
use zerocopy::little_endian::{U16, U32};
use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

/// A bin map of either key width.
enum Keys<'a> {
    Narrow(&'a [U16]),
    Wide(&'a [U32]),
}

impl Keys<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Narrow(keys) => keys.len(),
            Self::Wide(keys) => keys.len(),
        }
    }

    fn get(&self, texel: u64) -> Option<u32> {
        let texel = usize::try_from(texel).ok()?;
        match self {
            Self::Narrow(keys) => keys.get(texel).map(|key| u32::from(key.get())),
            Self::Wide(keys) => keys.get(texel).map(|key| key.get()),
        }
    }
}

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
    let texels = instance.texel_count() as usize;
    let keys = bin_map(container, instance)?;
    expect_count(instance.section(BIN_MAP), texels, keys.len())?;
    check_keys(&keys, instance, report);

    if instance.index == IndexKind::Sparse {
        let bins: &[U32] = sized(
            container,
            instance,
            OCCUPIED_BINS,
            instance.key_count as usize,
        )?;
        check_occupied(bins, instance, report);
    }
    let optional = container.find(instance.section(EXACT_NORMALS));
    if optional.is_some() {
        sized::<ExactNormal>(container, instance, EXACT_NORMALS, texels)?;
    }
    let offsets: &[U32] = sized(
        container,
        instance,
        INDEX,
        (instance.key_count as usize).saturating_add(1),
    )?;
    let positions: &[TexelPosition] = sized(container, instance, INVERSE_BIN_MAP, texels)?;
    check_offsets(offsets, instance)?;
    check_lists(&keys, offsets, positions, instance, report);

    if container.find(instance.section(FOREST)).is_some() {
        let slots = ForestShape::slot_count(instance.texel_count(), instance.leaf_size) as usize;
        let nodes: &[ForestNode] = sized(container, instance, FOREST, slots)?;
        check_forest(nodes, offsets, positions, instance, report);
    } else if lists(offsets).any(|(_, start, end)| end.saturating_sub(start) > instance.leaf_size) {
        return Err(Finding::new(Fault::SectionMissing).within(instance.section(FOREST)));
    }
    Ok(())
}

fn bin_map<'a>(container: &Container<'a>, instance: &Instance) -> Result<Keys<'a>, Finding> {
    let id = instance.section(BIN_MAP);
    match container.find(id).map(|entry| entry.element_size.get()) {
        Some(4) => container.elements(id).map(Keys::Wide),
        _ => container.elements(id).map(Keys::Narrow),
    }
}

fn sized<'a, T>(
    container: &Container<'a>,
    instance: &Instance,
    kind: FourCc,
    count: usize,
) -> Result<&'a [T], Finding>
where
    T: FromBytes + Immutable + KnownLayout + Unaligned,
{
    let id = instance.section(kind);
    let elements: &[T] = container.elements(id)?;
    expect_count(id, count, elements.len())?;
    Ok(elements)
}

fn expect_count(id: SectionId, expected: usize, got: usize) -> Result<(), Finding> {
    if expected == got {
        Ok(())
    } else {
        Err(Finding::new(Fault::SectionCount)
            .within(id)
            .values(expected as u64, got as u64))
    }
}

fn check_keys(keys: &Keys<'_>, instance: &Instance, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    for texel in 0..keys.len() as u64 {
        if let Some(key) = keys.get(texel)
            && key >= instance.key_count
        {
            limited.report(
                Finding::new(Fault::KeyRange)
                    .within(instance.section(BIN_MAP))
                    .at(texel)
                    .values(u64::from(instance.key_count), u64::from(key)),
            );
        }
    }
}

fn check_occupied(bins: &[U32], instance: &Instance, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let mut least = 0;
    for (place, bin) in (0..).zip(bins) {
        let bin = bin.get();
        if bin < least || bin >= instance.grid.count() {
            limited.report(
                Finding::new(Fault::OccupiedBins)
                    .within(instance.section(OCCUPIED_BINS))
                    .at(place)
                    .values(u64::from(least), u64::from(bin)),
            );
        }
        least = bin.saturating_add(1);
    }
}

fn check_offsets(offsets: &[U32], instance: &Instance) -> Result<(), Finding> {
    let finding = Finding::new(Fault::IndexOrder).within(instance.section(INDEX));
    let mut least = 0;
    for (place, offset) in (0..).zip(offsets) {
        let offset = offset.get();
        if offset < least || (place == 0 && offset != 0) {
            return Err(finding
                .at(place)
                .values(u64::from(least), u64::from(offset)));
        }
        least = offset;
    }
    if least != instance.texel_count() {
        return Err(finding.values(u64::from(instance.texel_count()), u64::from(least)));
    }
    Ok(())
}

/// Key, start and end of every list.
fn lists(offsets: &[U32]) -> impl Iterator<Item = (u32, u32, u32)> {
    let ends = offsets.iter().skip(1);
    (0..)
        .zip(offsets.iter().zip(ends))
        .map(|(key, (start, end))| (key, start.get(), end.get()))
}

/// Each position lies on the map, is listed under its own key, and comes once: strict order within a list and one
/// list per key make the inverse bin map a permutation of the texels.
fn check_lists(
    keys: &Keys<'_>,
    offsets: &[U32],
    positions: &[TexelPosition],
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    let mut limited = Limited::new(report);
    let id = instance.section(INVERSE_BIN_MAP);
    for (key, start, end) in lists(offsets) {
        let mut least = 0;
        let list = positions
            .get(start as usize..end as usize)
            .unwrap_or_default();
        for (place, position) in (u64::from(start)..).zip(list) {
            let (column, row) = (position.column.get(), position.row.get());
            if u32::from(column) >= instance.width || u32::from(row) >= instance.height {
                limited.report(Finding::new(Fault::PositionRange).within(id).at(place));
                continue;
            }
            let texel = u64::from(row)
                .saturating_mul(u64::from(instance.width))
                .saturating_add(u64::from(column));
            if keys.get(texel) != Some(key) {
                limited.report(Finding::new(Fault::PositionKey).within(id).at(place));
            }
            let order = morton_index(u32::from(column), u32::from(row)).saturating_add(1);
            if order <= least {
                limited.report(Finding::new(Fault::PositionOrder).within(id).at(place));
            }
            least = order;
        }
    }
}

fn check_forest(
    nodes: &[ForestNode],
    offsets: &[U32],
    positions: &[TexelPosition],
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    let id = instance.section(FOREST);
    let mut limited = Limited::new(report);
    let mut next_unused = 0;
    let check_unused = |limited: &mut Limited<'_>, from: u64, to: u64| {
        let unused = nodes.get(from as usize..to as usize).unwrap_or_default();
        for (slot, node) in (from..).zip(unused) {
            if *node != ForestNode::default() {
                limited.report(Finding::new(Fault::ForestUnused).within(id).at(slot));
            }
        }
    };
    for (_, start, end) in lists(offsets) {
        let shape = ForestShape::new(start, end.saturating_sub(start), instance.leaf_size);
        if shape.depth() == 0 {
            continue;
        }
        check_unused(&mut limited, next_unused, shape.slots().start);
        next_unused = shape.slots().end;
        for level in 0..shape.depth() {
            for node in 0..1_u32.wrapping_shl(level) {
                let slot = shape.slot(level, node);
                let Some(record) = nodes.get(slot as usize) else {
                    limited.report(Finding::new(Fault::ForestDepth).within(id).at(slot));
                    continue;
                };
                for (child, stored) in (node.wrapping_mul(2)..).zip(record.children) {
                    let below = level.saturating_add(1);
                    let first = start.saturating_add(shape.first_texel(below, child));
                    let last =
                        start.saturating_add(shape.first_texel(below, child.saturating_add(1)));
                    let texels = positions
                        .get(first as usize..last as usize)
                        .unwrap_or_default();
                    if bounding_box(texels) != stored {
                        limited.report(Finding::new(Fault::ForestBox).within(id).at(slot));
                    }
                }
            }
        }
    }
    check_unused(&mut limited, next_unused, nodes.len() as u64);
}

fn bounding_box(texels: &[TexelPosition]) -> BoxRecord {
    let columns = || texels.iter().map(|texel| texel.column.get());
    let rows = || texels.iter().map(|texel| texel.row.get());
    let bound = |value: Option<u16>| U16::new(value.unwrap_or_default());
    BoxRecord {
        first_column: bound(columns().min()),
        first_row: bound(rows().min()),
        last_column: bound(columns().max()),
        last_row: bound(rows().max()),
    }
}
