//! Structural checks of layered materials.

use super::Limited;
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::records::OPACITY;
use crate::view::{MaterialLayers, Opacity};

/// Reports layers that are none, instances that are not theirs, opacity maps of the wrong size or of no layer, and cells that
/// are not the average of the texels under them. O(texels × levels) of each opacity map.
pub(super) fn check(container: &Container<'_>, report: &mut dyn FnMut(Finding)) {
    let layers = match MaterialLayers::open(container) {
        Ok(layers) => layers,
        Err(finding) => return report(finding),
    };
    let mut mapped: u16 = 0;
    for (place, layer) in (0_u16..).zip(layers.iter().flat_map(MaterialLayers::iter)) {
        let opacity = layer.and_then(|layer| Opacity::open(container, place, &layer));
        match opacity {
            Ok(Some(opacity)) => {
                mapped |= 1_u16.wrapping_shl(u32::from(place));
                check_averages(&opacity, report);
            }
            Ok(None) => {}
            // Its section has been named.
            Err(finding) => {
                mapped |= 1_u16.wrapping_shl(u32::from(place));
                report(finding);
            }
        }
    }
    let mut limited = Limited::new(report);
    for entry in container.entries() {
        let id = entry.id();
        let layer = id.layer;
        let is_mapped = layer < 16 && mapped & 1_u16.wrapping_shl(u32::from(layer)) != 0;
        if id.kind == OPACITY && (!is_mapped || id.instance != 0 || id.ordinal != 0) {
            limited.report(Finding::new(Fault::OpacityStray).within(id));
        }
        // A layer that no record tells of.
        let count = layers.as_ref().map_or(0, MaterialLayers::len);
        if layers.is_some() && id.instance != 0 && usize::from(layer) >= count {
            limited.report(
                Finding::new(Fault::MaterialInstance)
                    .within(id)
                    .values(count as u64, u64::from(layer)),
            );
        }
    }
}

/// How much of texel `texel` of `texels` lies in cell `cell` of `cells`, in units of which a cell has `texels` and a texel
/// `cells`: whole numbers, so that averages are exact.
fn overlap(texel: u64, texels: u64, cell: u64, cells: u64) -> u64 {
    let (from, to) = (texel.wrapping_mul(cells), cell.wrapping_mul(texels));
    let end = from.wrapping_add(cells).min(to.wrapping_add(texels));
    end.saturating_sub(from.max(to))
}

/// The first texel of cell `cell` and the one after its last.
fn texels_under(cell: u64, texels: u64, cells: u64) -> core::ops::Range<u64> {
    let first = cell.wrapping_mul(texels) / cells;
    let last = cell.wrapping_add(1).wrapping_mul(texels).div_ceil(cells);
    first..last
}

fn check_averages(opacity: &Opacity<'_>, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    let levels = opacity.levels();
    let size = levels.map_size().map(u64::from);
    let all = size[0].wrapping_mul(size[1]);
    for level in 1..=levels.top() {
        let [columns, rows] = levels.size(level);
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)))
        {
            let (x, y) = (u64::from(column), u64::from(row));
            let (across, down) = (u64::from(columns), u64::from(rows));
            let mut sum: u64 = 0;
            for j in texels_under(y, size[1], down) {
                let high = overlap(j, size[1], y, down);
                for i in texels_under(x, size[0], across) {
                    let area = high.wrapping_mul(overlap(i, size[0], x, across));
                    let number = opacity.number(0, i as u32, j as u32).unwrap_or(0);
                    // At most 255 · 65535², a cell's whole area.
                    sum = sum.wrapping_add(area.wrapping_mul(u64::from(number)));
                }
            }
            let number = opacity.number(level, column, row).unwrap_or(0);
            let off = sum.abs_diff(u64::from(number).wrapping_mul(all));
            if off.wrapping_mul(2) > all {
                limited.report(
                    Finding::new(Fault::OpacityAverage)
                        .within(opacity.id)
                        .at(opacity.place(level, column, row) as u64)
                        .values(sum / all.max(1), u64::from(number)),
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_texels_under_it_by_their_areas() {
        for (texels, cells) in [(5, 2), (7, 3), (8, 4), (9, 1), (1, 1), (65_535, 32_767)] {
            for cell in [0, cells / 2, cells - 1] {
                let range = texels_under(cell, texels, cells);
                let inside: u64 = range
                    .clone()
                    .map(|texel| overlap(texel, texels, cell, cells))
                    .sum();
                assert_eq!(inside, texels, "{texels} {cells} {cell}");
                assert_eq!(overlap(range.end, texels, cell, cells), 0);
                assert!(overlap(range.start, texels, cell, cells) > 0);
                assert!(overlap(range.end - 1, texels, cell, cells) > 0);
            }
        }
    }
}
