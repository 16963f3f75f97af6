//! Where one block ends and the next begins: the cheapest way through what they share.

use super::texels::{Texels, difference};
use glintbake_format::model::QuiltLayout;
use rayon::prelude::*;

/// The cuts of every patch at `origins`, and the mean difference along them.
pub(super) fn cut(texels: &Texels, layout: &QuiltLayout, origins: &[[u16; 2]]) -> (Vec<u8>, f64) {
    let patch = layout.patch();
    let [columns, rows] = layout.patches;
    let all: Vec<(Vec<u8>, f64)> = (0..columns * rows)
        .into_par_iter()
        .map(|place| {
            let (column, row) = (place % columns, place / columns);
            let origin = |[x, y]: [u32; 2]| origins[layout.number([x, y])].map(u32::from);
            let own = origin([column, row]);
            let left = origin([(column + columns - 1) % columns, row]);
            let above = origin([column, (row + rows - 1) % rows]);
            let beside = |y: u32, x: u32| {
                difference(texels.at(left, [patch + x, y]), texels.at(own, [x, y]))
            };
            let below = |x: u32, y: u32| {
                difference(texels.at(above, [x, patch + y]), texels.at(own, [x, y]))
            };
            let overlap = u32::from(layout.overlap);
            let (mut cuts, first) = cheapest(patch, overlap, beside);
            let (more, second) = cheapest(patch, overlap, below);
            cuts.extend(more);
            (cuts, 0.5 * (first + second))
        })
        .collect();
    let mean = all.iter().map(|(_, mean)| mean).sum::<f64>() / all.len() as f64;
    (all.into_iter().flat_map(|(cuts, _)| cuts).collect(), mean)
}

/// For each of `length` lines how many of `overlap` places are the first block's, at the least sum of differences where it ends, and
/// their mean. From line to line a cut moves by at most one place.
///
/// `difference` is that of the two blocks' texels at a line and place. Texels of both blocks meet between the last place of the
/// first and the first of the second: the mean of the differences at these two places is what the seam costs, as each block
/// goes on smoothly by itself.
pub(super) fn cheapest(
    length: u32,
    overlap: u32,
    difference: impl Fn(u32, u32) -> f64,
) -> (Vec<u8>, f64) {
    let places = overlap as usize + 1;
    let mut best = vec![0.0; places];
    // Where the best way to each place of each line comes from.
    let mut from: Vec<Vec<u8>> = Vec::with_capacity(length as usize);
    for line in 0..length {
        let differences: Vec<f64> = (0..overlap).map(|place| difference(line, place)).collect();
        let cost = |cut: usize| {
            let before = cut.checked_sub(1).and_then(|place| differences.get(place));
            match (before, differences.get(cut)) {
                (Some(a), Some(b)) => 0.5 * (a + b),
                (Some(one), None) | (None, Some(one)) => *one,
                (None, None) => 0.0,
            }
        };
        let mut steps = Vec::with_capacity(places);
        let next = (0..places)
            .map(|cut| {
                let near = cut.saturating_sub(1)..=(cut + 1).min(places - 1);
                let step = near
                    .min_by(|&a, &b| f64::total_cmp(&best[a], &best[b]))
                    .unwrap_or(cut);
                steps.push(step as u8);
                best[step] + cost(cut)
            })
            .collect();
        best = next;
        from.push(steps);
    }
    let mut cut = (0..places)
        .min_by(|&a, &b| best[a].total_cmp(&best[b]))
        .unwrap_or(0);
    let mean = best[cut] / f64::from(length.max(1));
    let mut cuts = vec![0; length as usize];
    for (line, steps) in from.iter().enumerate().rev() {
        cuts[line] = cut as u8;
        cut = usize::from(steps[cut]);
    }
    (cuts, mean)
}
