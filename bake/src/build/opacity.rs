//! Opacity maps: MIP maps of one channel, by exact area.

use glintbake_format::model::PyramidLayout;
use rayon::prelude::*;

/// The cells of all levels of `levels` over `texels`, row by row and level by level, each the average of the texels under it by
/// area, rounded to the nearest number: never the average of averages. In whole numbers, so that it is the same everywhere.
/// O(texels × levels).
///
/// # Panics
/// If there are not as many texels as the map has.
pub fn build(levels: PyramidLayout, texels: &[u8]) -> Vec<u8> {
    let [width, height] = levels.map_size().map(|side| side as usize);
    assert_eq!(texels.len(), width * height, "one byte a texel");
    let mut cells = texels.to_vec();
    for level in 1..=levels.top() {
        let [columns, rows] = levels.size(level).map(|side| side as usize);
        let across: Vec<_> = (0..columns)
            .map(|cell| parts(cell, columns, width))
            .collect();
        let level: Vec<Vec<u8>> = (0..rows)
            .into_par_iter()
            .map(|row| {
                let down = parts(row, rows, height);
                across
                    .iter()
                    .map(|across| average(texels, width, across, &down))
                    .collect()
            })
            .collect();
        cells.extend(level.into_iter().flatten());
    }
    cells
}

/// The texels of an axis of `texels` that cell `cell` of `cells` covers, each with its length within: of 1 / `cells` texels, of
/// which a cell has as many as there are texels.
fn parts(cell: usize, cells: usize, texels: usize) -> Vec<(usize, u64)> {
    let (from, to) = (cell * texels, (cell + 1) * texels);
    (from / cells..to.div_ceil(cells))
        .map(|texel| {
            let start = from.max(texel * cells);
            let end = to.min((texel + 1) * cells);
            (texel, (end - start) as u64)
        })
        .collect()
}

fn average(texels: &[u8], width: usize, across: &[(usize, u64)], down: &[(usize, u64)]) -> u8 {
    let (mut sum, mut area) = (0, 0);
    for &(row, high) in down {
        for &(column, wide) in across {
            sum += high * wide * u64::from(texels[row * width + column]);
            area += high * wide;
        }
    }
    // At most 255, as every texel is.
    ((2 * sum + area) / (2 * area)) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_averages_of_four_and_odd_sides_are_cut_by_area() {
        let levels = PyramidLayout::new(4, 2, 0).unwrap();
        let texels = [0, 10, 20, 30, 40, 50, 60, 255];
        let cells = build(levels, &texels);
        assert_eq!(cells[..8], texels);
        assert_eq!(cells[8..10], [25, 91]);
        // (8 numbers that add up to 465) / 8 = 58.125
        assert_eq!(cells[10..], [58]);
        let levels = PyramidLayout::new(3, 1, 0).unwrap();
        // ⌊3/2⌋ = 1 cell: all of it.
        assert_eq!(build(levels, &[0, 0, 255]), [0, 0, 255, 85]);
        let levels = PyramidLayout::new(5, 1, 0).unwrap();
        // Two cells of two and a half texels.
        let cells = build(levels, &[100, 0, 50, 0, 200]);
        assert_eq!(cells[5..], [50, 90, 70]);
    }
}
