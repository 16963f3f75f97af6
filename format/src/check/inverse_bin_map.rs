//! Structural checks of an inverse bin map and its forest.

use super::Limited;
use crate::finding::{Fault, Finding};
use crate::model::{ForestShape, morton_index};
use crate::records::{BoxRecord, FOREST, ForestNode, INDEX, INVERSE_BIN_MAP, TexelPosition};
use crate::view::{BinTables, InverseBinMap};
use core::ops::Range;
use zerocopy::little_endian::U16;

/// Reports what it can; an error is a fault that makes the rest meaningless.
pub(super) fn check(
    tables: &BinTables<'_>,
    inverse: &InverseBinMap<'_>,
    report: &mut dyn FnMut(Finding),
) -> Result<(), Finding> {
    check_offsets(tables, inverse)?;
    check_lists(tables, inverse, report);
    let instance = &tables.instance;
    match inverse.forest {
        Some(nodes) => check_forest(tables, inverse, nodes, report),
        None if lists(tables, inverse)
            .any(|(_, list)| list.len() > tables.bins.leaf_size as usize) =>
        {
            return Err(Finding::new(Fault::SectionMissing).within(instance.section(FOREST)));
        }
        None => {}
    }
    Ok(())
}

fn check_offsets(tables: &BinTables<'_>, inverse: &InverseBinMap<'_>) -> Result<(), Finding> {
    let finding = Finding::new(Fault::IndexOrder).within(tables.instance.section(INDEX));
    let texels = u64::from(tables.instance.texel_count());
    let mut end = 0;
    for key in 0..tables.bins.key_count {
        let list = inverse.list(key)?;
        if u64::from(list.start) != end {
            return Err(finding
                .at(u64::from(key))
                .values(end, u64::from(list.start)));
        }
        end = u64::from(list.end);
    }
    if end != texels {
        return Err(finding.values(texels, end));
    }
    Ok(())
}

/// Key and places of every list.
fn lists(
    tables: &BinTables<'_>,
    inverse: &InverseBinMap<'_>,
) -> impl Iterator<Item = (u32, Range<usize>)> {
    let inverse = *inverse;
    (0..tables.bins.key_count).filter_map(move |key| {
        let list = inverse.list(key).ok()?;
        Some((key, list.start as usize..list.end as usize))
    })
}

/// Each position lies on the map, is listed under its own key, and comes once: strict order within a list and one
/// list per key make the inverse bin map a permutation of the texels.
fn check_lists(
    tables: &BinTables<'_>,
    inverse: &InverseBinMap<'_>,
    report: &mut dyn FnMut(Finding),
) {
    let mut limited = Limited::new(report);
    let instance = &tables.instance;
    let id = instance.section(INVERSE_BIN_MAP);
    for (key, list) in lists(tables, inverse) {
        let mut least = 0;
        let first = list.start as u64;
        let positions = inverse.positions.get(list).unwrap_or_default();
        for (place, position) in (first..).zip(positions) {
            let finding = |fault| Finding::new(fault).within(id).at(place);
            let (column, row) = (
                u32::from(position.column.get()),
                u32::from(position.row.get()),
            );
            if column >= instance.width || row >= instance.height {
                limited.report(finding(Fault::PositionRange));
                continue;
            }
            if tables.bin_map.key(column, row) != Some(key) {
                limited.report(finding(Fault::PositionKey));
            }
            let order = morton_index(column, row).saturating_add(1);
            if order <= least {
                limited.report(finding(Fault::PositionOrder));
            }
            least = order;
        }
    }
}

fn check_forest(
    tables: &BinTables<'_>,
    inverse: &InverseBinMap<'_>,
    nodes: &[ForestNode],
    report: &mut dyn FnMut(Finding),
) {
    let id = tables.instance.section(FOREST);
    let mut limited = Limited::new(report);
    let mut next_unused = 0;
    for (_, list) in lists(tables, inverse) {
        let (start, length) = (list.start as u32, list.len() as u32);
        let shape = ForestShape::new(start, length, tables.bins.leaf_size);
        if shape.depth() == 0 {
            continue;
        }
        check_unused(
            nodes,
            next_unused..shape.slots().start,
            tables,
            &mut limited,
        );
        next_unused = shape.slots().end;
        for level in 0..shape.depth() {
            for node in 0..1_u32.wrapping_shl(level) {
                let slot = shape.slot(level, node);
                let stored = nodes.get(slot as usize).copied();
                if stored != Some(true_node(inverse, &list, shape, level, node)) {
                    limited.report(Finding::new(Fault::ForestBox).within(id).at(slot));
                }
            }
        }
    }
    check_unused(nodes, next_unused..nodes.len() as u64, tables, &mut limited);
}

fn check_unused(
    nodes: &[ForestNode],
    slots: Range<u64>,
    tables: &BinTables<'_>,
    limited: &mut Limited<'_>,
) {
    let unused = nodes
        .get(slots.start as usize..slots.end as usize)
        .unwrap_or_default();
    for (slot, node) in (slots.start..).zip(unused) {
        if *node != ForestNode::default() {
            limited.report(
                Finding::new(Fault::ForestUnused)
                    .within(tables.instance.section(FOREST))
                    .at(slot),
            );
        }
    }
}

/// What the forest should store for node `node` at `level` of the tree over `list`.
fn true_node(
    inverse: &InverseBinMap<'_>,
    list: &Range<usize>,
    shape: ForestShape,
    level: u32,
    node: u32,
) -> ForestNode {
    let place = |child: u32| {
        list.start
            .saturating_add(shape.first_texel(level.saturating_add(1), child) as usize)
    };
    let first = node.wrapping_mul(2);
    let [start, middle, end] = [0, 1, 2].map(|step| place(first.wrapping_add(step)));
    ForestNode {
        children: [start..middle, middle..end]
            .map(|places| bounding_box(inverse.positions.get(places).unwrap_or_default())),
    }
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
