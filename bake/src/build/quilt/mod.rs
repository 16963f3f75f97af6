//! Quilts: a surface of any size from blocks of a small sample, \[TZX22\] §5.1.1 after Efros and Freeman 2001.

mod cuts;
#[cfg(test)]
mod expand;
mod overlaps;
mod texels;

use super::numbers::Numbers;
use crate::normals::NormalMap;
use glintbake_format::model::QuiltLayout;
use overlaps::Overlaps;
use texels::Texels;

/// What a quilt is to be.
#[derive(Clone, Copy, Debug)]
pub struct QuiltOptions {
    /// What the blocks are, and how many.
    pub layout: QuiltLayout,
    /// How much more the normals of texels count than their slopes where blocks meet, α of \[TZX22\] eq. 7.
    pub alpha: f64,
    /// Most that blocks may differ where they meet, of the mean difference of two texels of the sample, for chance to choose among
    /// them.
    pub tolerance: f64,
    /// What chance begins with.
    pub seed: u64,
}

/// A quilt.
#[derive(Clone, Debug, PartialEq)]
pub struct Quilt {
    /// Where the block of each patch begins in the sample, row by row.
    pub origins: Vec<[u16; 2]>,
    /// [`QuiltLayout::cuts`] of each patch: columns of each of its rows that are of the patch to the left, then rows of each of its
    /// columns that are of the patch above.
    pub cuts: Vec<u8>,
    /// Patches whose block is one of the least bad, as none was within the tolerance.
    pub forced: usize,
    /// Mean difference of texels along the cuts, of that of two texels of the sample; 0 for a sample of one normal.
    pub mean_error: f64,
}

/// The quilt of `sample` that `options` ask for. O(origins² × overlap × block), for at most some thousand origins; twice that many
/// numbers of memory.
///
/// Patches are chosen row by row, and then each of them anew a few times, as the last ones of a row had no choice. Of each block that
/// could be there the difference from the blocks around it that are chosen, across the surface's border too, is that of \[TZX22\]
/// eq. 7 over all texels they share. Of the blocks within the tolerance one of those used least so far is drawn; if there is none,
/// of those that differ nearly as little as the best. Blocks that go on in the sample where a neighbour ends always differ
/// least, and are left out where there are others: else samples that repeat would be copied as they are.
///
/// # Panics
/// If the layout is not one of `sample`.
pub fn build(sample: &NormalMap, options: &QuiltOptions) -> Quilt {
    let layout = &options.layout;
    assert_eq!(
        layout.sample,
        [sample.width(), sample.height()],
        "the layout is of another sample"
    );
    let texels = Texels::new(sample, options.alpha);
    let origins = candidates(sample, layout);
    let overlaps = Overlaps::new(&texels, layout, &origins);
    let unit = texels.mean_difference(options.seed);
    let (chosen, forced) = choose(layout, &origins, &overlaps, options, unit);
    let origins: Vec<[u16; 2]> = chosen
        .iter()
        .map(|&number| origins[number].map(|x| x as u16))
        .collect();
    let (cuts, mean) = cuts::cut(&texels, layout, &origins);
    Quilt {
        origins,
        cuts,
        forced,
        mean_error: if unit > 0.0 { mean / unit } else { 0.0 },
    }
}

/// Where blocks may begin: everywhere on the grid if the sample goes on across its border there, else where they end on it.
fn candidates(sample: &NormalMap, layout: &QuiltLayout) -> Vec<[u32; 2]> {
    let grid = 1 << layout.grid_log;
    let block = layout.patch() + u32::from(layout.overlap);
    let along = |axis: usize| {
        let side = layout.sample[axis];
        let repeats = sample.wrap() == glintbake_format::model::Wrap::Repeat;
        let end = if repeats && side.is_multiple_of(grid) {
            side
        } else {
            side - block + 1
        };
        (0..end).step_by(grid as usize)
    };
    along(1)
        .flat_map(|y| along(0).map(move |x| [x, y]))
        .collect()
}

/// How often every patch is chosen anew once all are there.
const SWEEPS: usize = 3;

/// Blocks that differ by up to so much more than the least bad one are drawn among where none is within the tolerance: always the same
/// few would be seen to repeat.
const NEARLY_LEAST: f64 = 1.15;

/// The number of the origin of each patch, and how many are not within the tolerance.
fn choose(
    layout: &QuiltLayout,
    origins: &[[u32; 2]],
    overlaps: &Overlaps,
    options: &QuiltOptions,
    unit: f64,
) -> (Vec<usize>, usize) {
    let mut choice = Choice {
        layout,
        origins,
        overlaps,
        most: options.tolerance * unit,
        numbers: Numbers::new(options.seed),
        uses: vec![0; origins.len()],
        chosen: vec![None; layout.count()],
        is_forced: vec![false; layout.count()],
    };
    for _ in 0..=SWEEPS {
        for place in 0..layout.count() {
            choice.choose(place);
        }
    }
    let forced = choice.is_forced.iter().filter(|&&is_forced| is_forced);
    let forced = forced.count();
    (choice.chosen.into_iter().flatten().collect(), forced)
}

/// Blocks as they are chosen.
struct Choice<'c> {
    layout: &'c QuiltLayout,
    origins: &'c [[u32; 2]],
    overlaps: &'c Overlaps,
    /// Most that one may differ from its neighbours.
    most: f64,
    numbers: Numbers,
    /// How many patches have each origin.
    uses: Vec<u32>,
    chosen: Vec<Option<usize>>,
    is_forced: Vec<bool>,
}

impl Choice<'_> {
    /// The origin of the patch `offset` patches to the right and below of `place`, across the surface's border too, if it is chosen.
    fn near(&self, place: usize, offset: [i64; 2]) -> Option<usize> {
        let [columns, rows] = self.layout.patches.map(i64::from);
        let (column, row) = (place as i64 % columns, place as i64 / columns);
        let [x, y] = [
            (column + offset[0]).rem_euclid(columns),
            (row + offset[1]).rem_euclid(rows),
        ];
        self.chosen[(y * columns + x) as usize]
    }

    /// Chooses the block of the patch at `place`, by those that are chosen around it.
    fn choose(&mut self, place: usize) {
        if let Some(before) = self.chosen[place].take() {
            self.uses[before] -= 1;
        }
        let mut errors = vec![0.0_f64; self.origins.len()];
        let mut sides = 0.0_f64;
        for offset in [[-1, 0], [1, 0], [0, -1], [0, 1]] {
            let Some(other) = self.near(place, offset) else {
                continue;
            };
            sides += 1.0;
            for (own, sum) in errors.iter_mut().enumerate() {
                *sum += f64::from(match offset {
                    [-1, _] => self.overlaps.beside(other, own),
                    [1, _] => self.overlaps.beside(own, other),
                    [_, -1] => self.overlaps.below(other, own),
                    _ => self.overlaps.below(own, other),
                });
            }
        }
        let error = |candidate: usize| errors[candidate] / sides.max(1.0);
        let neighbours: Vec<(usize, [i64; 2])> = (0..9)
            .map(|k| [k % 3 - 1, k / 3 - 1])
            .filter_map(|offset| Some((self.near(place, offset)?, offset)))
            .collect();
        let is_fresh = |candidate: &usize| {
            let own = self.origins[*candidate];
            !neighbours
                .iter()
                .any(|&(other, offset)| is_copy(self.layout, self.origins[other], own, offset))
        };
        let mut fresh: Vec<usize> = (0..self.origins.len()).filter(is_fresh).collect();
        if fresh.is_empty() {
            fresh = (0..self.origins.len()).collect();
        }
        let least = fresh.iter().map(|&candidate| error(candidate));
        let least = least.fold(f64::INFINITY, f64::min);
        self.is_forced[place] = least > self.most;
        let most = self.most.max(NEARLY_LEAST * least);
        fresh.retain(|&candidate| error(candidate) <= most);
        let fewest = fresh.iter().map(|&candidate| self.uses[candidate]).min();
        fresh.retain(|&candidate| Some(self.uses[candidate]) == fewest);
        let number = fresh[self.numbers.below(fresh.len())];
        self.uses[number] += 1;
        self.chosen[place] = Some(number);
    }
}

/// Whether the block at `candidate` would be, or nearly be, the same as the one at `other`, or go on in the sample where that one ends,
/// which lies `offset` patches to the right and below.
fn is_copy(layout: &QuiltLayout, other: [u32; 2], candidate: [u32; 2], offset: [i64; 2]) -> bool {
    let patch = i64::from(layout.patch());
    let within = |axis: usize, expected: i64| {
        let side = i64::from(layout.sample[axis]);
        let apart =
            (i64::from(other[axis]) - i64::from(candidate[axis]) - expected).rem_euclid(side);
        apart.min(side - apart) < patch / 4
    };
    let is_same = within(0, 0) && within(1, 0);
    let goes_on = within(0, offset[0] * patch) && within(1, offset[1] * patch);
    is_same || goes_on
}

#[cfg(test)]
mod tests;
