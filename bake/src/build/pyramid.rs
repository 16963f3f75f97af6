//! Pyramids of moments: mean and covariance of the normals in ever larger cells, \[OB10\].
//!
//! Every cell is an exact average over its area, also where a side is odd and cells cut texels. A level whose cells are
//! unions of a coarser one's is merged from that; the others are summed over the texels themselves, as there is no telling
//! where in a cell its normals lie.

use crate::normals::NormalMap;
use glintbake_format::model::PyramidLayout;
use glintbake_format::records::{NarrowMean, SpreadRecord, WideMean};
use rayon::prelude::*;

/// Texels, or cells where they are written down, that a unit of parallel work covers.
const CHUNK: usize = 1 << 12;

/// The finest level whose moments are kept in f64 for coarser ones: keeping finer ones would take more memory than the map.
const FINEST_KEPT: u32 = 2;

/// Means as the package stores them.
#[derive(Clone, Debug, PartialEq)]
pub enum Means {
    /// To 16 bits, 4 bytes each.
    Narrow(Vec<NarrowMean>),
    /// To 32 bits, 8 bytes each.
    Wide(Vec<WideMean>),
}

/// The stored moments of all levels, finest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    /// Means of all cells.
    pub means: Means,
    /// Spreads of the cells of all levels but level 0.
    pub spreads: Vec<SpreadRecord>,
}

/// Mean and covariance (ss, st, tt) of the normals in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moments {
    mean: [f64; 2],
    covariance: [f64; 3],
}

/// The pyramid of `map` over the levels of `layout`, its means to 32 bits if `wide`.
///
/// O(texels) where both sides halve evenly; else once more for each level whose cells are no unions of finer ones. Peak
/// memory beside the map: what is stored, 3.3 bytes a texel for moments on the way, and 8 for the level at hand. The same
/// for any number of threads.
///
/// # Panics
/// If `layout` is not of the map's size.
pub fn build(map: &NormalMap, layout: PyramidLayout, wide: bool) -> Pyramid {
    assert_eq!(
        layout.map_size(),
        [map.width(), map.height()],
        "a layout belongs to its map"
    );
    let mut pyramid = Pyramid {
        means: if wide {
            Means::Wide(Vec::with_capacity(layout.mean_count() as usize))
        } else {
            Means::Narrow(Vec::with_capacity(layout.mean_count() as usize))
        },
        spreads: Vec::with_capacity(layout.spread_count() as usize),
    };
    let mut kept: Vec<Level> = Vec::new();
    for number in layout.finest()..=layout.top() {
        let size = layout.size(number);
        if number == 0 {
            let texels = map.texels();
            pyramid
                .means
                .extend(texels.len(), |texel| texels[texel].map(f64::from));
            continue;
        }
        let [columns, rows] = [spans(size[0], map.width()), spans(size[1], map.height())];
        let cell = |cell: usize| {
            let finer = kept.iter().rev().find(|finer| finer.is_cut_from(size));
            match finer {
                Some(finer) => finer.union(cell, size),
                None => over_texels(
                    map,
                    columns[cell % columns.len()],
                    rows[cell / columns.len()],
                ),
            }
        };
        let count = size[0] as usize * size[1] as usize;
        // Few cells are many texels each.
        let run = (CHUNK * count / map.texels().len()).max(1);
        if number < FINEST_KEPT {
            // In pieces, so that no more than one of them is there in f64.
            for first in (0..count).step_by(PIECE) {
                let cells = collect(PIECE.min(count - first), run, |place| cell(first + place));
                pyramid.push(&cells);
            }
        } else {
            let cells = collect(count, run, cell);
            pyramid.push(&cells);
            kept.push(Level { size, cells });
        }
    }
    pyramid
}

/// Cells of a level that is not kept, at a time.
const PIECE: usize = 1 << 20;

/// `make` of every place below `count`, by all threads, with at least `run` of them to one.
fn collect<T: Send>(count: usize, run: usize, make: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    let places = (0..count).into_par_iter().with_min_len(run);
    places.map(make).collect()
}

impl Means {
    /// Adds `count` means, `mean` of each place.
    fn extend(&mut self, count: usize, mean: impl Fn(usize) -> [f64; 2] + Send + Sync) {
        let places = (0..count).into_par_iter().with_min_len(CHUNK);
        match self {
            Self::Narrow(means) => {
                means.par_extend(places.map(|place| NarrowMean::new(mean(place))))
            }
            Self::Wide(means) => means.par_extend(places.map(|place| WideMean::new(mean(place)))),
        }
    }
}

impl Pyramid {
    /// Adds the next cells.
    fn push(&mut self, cells: &[Moments]) {
        self.means.extend(cells.len(), |cell| cells[cell].mean);
        let spreads = cells.par_iter().with_min_len(CHUNK);
        self.spreads
            .par_extend(spreads.map(|cell| SpreadRecord::new(cell.covariance)));
    }
}

/// A finished level.
struct Level {
    size: [u32; 2],
    cells: Vec<Moments>,
}

impl Level {
    /// Whether each cell of a level of `size` is a union of cells of this one.
    fn is_cut_from(&self, size: [u32; 2]) -> bool {
        self.size[0].is_multiple_of(size[0]) && self.size[1].is_multiple_of(size[1])
    }

    /// The moments of cell number `cell` of a level of `size`: the law of total covariance over equal parts.
    fn union(&self, cell: usize, size: [u32; 2]) -> Moments {
        let [columns, rows] = [0, 1].map(|axis| (self.size[axis] / size[axis]) as usize);
        let (column, row) = (cell % size[0] as usize, cell / size[0] as usize);
        let width = self.size[0] as usize;
        let parts = || {
            (row * rows..(row + 1) * rows)
                .flat_map(move |row| &self.cells[row * width + column * columns..][..columns])
        };
        let share = 1.0 / (columns * rows) as f64;
        let mut mean = [0.0; 2];
        for part in parts() {
            mean = [mean[0] + part.mean[0], mean[1] + part.mean[1]];
        }
        let mean = mean.map(|sum| sum * share);
        let mut covariance = [0.0; 3];
        for part in parts() {
            let [s, t] = [part.mean[0] - mean[0], part.mean[1] - mean[1]];
            let [ss, st, tt] = part.covariance;
            covariance[0] += ss + s * s;
            covariance[1] += st + s * t;
            covariance[2] += tt + t * t;
        }
        Moments {
            mean,
            covariance: covariance.map(|sum| sum * share),
        }
    }
}

/// The texels that a cell meets on one axis.
#[derive(Clone, Copy, Debug)]
struct Span {
    first: usize,
    last: usize,
    /// The shares of the first and of the last that lie in the cell.
    shares: [f64; 2],
}

/// The span of each of `count` cells on an axis of `size` texels. Exact but for the last rounding of shares: borders are
/// multiples of 1 / `count`.
fn spans(count: u32, size: u32) -> Vec<Span> {
    let (count, size) = (u64::from(count), u64::from(size));
    let span = |cell: u64| {
        let (start, end) = (cell * size, (cell + 1) * size);
        let (first, last) = (start / count, (end - 1) / count);
        let share = |texel: u64| {
            let (low, high) = ((texel * count).max(start), ((texel + 1) * count).min(end));
            (high - low) as f64 / count as f64
        };
        Span {
            first: first as usize,
            last: last as usize,
            shares: [share(first), share(last)],
        }
    };
    (0..count).map(span).collect()
}

/// The moments of the texels of `map` in the columns and rows of a cell, by the share of each within it.
///
/// Sums are of differences to the texel in the middle, one of those averaged, so that what cancels between squares and the
/// square of the mean is of the order of the variance.
fn over_texels(map: &NormalMap, columns: Span, rows: Span) -> Moments {
    let width = map.width() as usize;
    let (left, right, column_shares) = (columns.first, columns.last, columns.shares);
    let (top, bottom, row_shares) = (rows.first, rows.last, rows.shares);
    let [s_0, t_0] = map.texels()[(top + bottom) / 2 * width + (left + right) / 2].map(f64::from);
    let mut weight = 0.0;
    // Of s, t, ss, st, tt.
    let mut sums = [0.0; 5];
    for row in top..=bottom {
        let line = &map.texels()[row * width + left..=row * width + right];
        let mut line_weight = 0.0;
        let mut line_sums = [0.0; 5];
        let mut add = |texels: &[[f32; 2]], share: f64| {
            for texel in texels {
                let [s, t] = [f64::from(texel[0]) - s_0, f64::from(texel[1]) - t_0];
                for (sum, term) in line_sums.iter_mut().zip([s, t, s * s, s * t, t * t]) {
                    *sum += share * term;
                }
            }
            line_weight += share * texels.len() as f64;
        };
        match line {
            [first, inner @ .., last] => {
                add(&[*first], column_shares[0]);
                add(inner, 1.0);
                add(&[*last], column_shares[1]);
            }
            texel => add(texel, column_shares[0]),
        }
        let share = if row == top {
            row_shares[0]
        } else if row == bottom {
            row_shares[1]
        } else {
            1.0
        };
        weight += share * line_weight;
        for (sum, line) in sums.iter_mut().zip(line_sums) {
            *sum += share * line;
        }
    }
    let [s, t, ss, st, tt] = sums.map(|sum| sum / weight);
    Moments {
        mean: [s_0 + s, t_0 + t],
        covariance: [(ss - s * s).max(0.0), st - s * t, (tt - t * t).max(0.0)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::model::Wrap;

    fn map(width: u32, height: u32, normal: impl Fn(u32) -> [f32; 2]) -> NormalMap {
        let texels = (0..width * height).map(normal).collect();
        NormalMap::new(width, height, Wrap::Repeat, texels)
    }

    #[test]
    fn shares_of_cut_texels_add_up_to_cells_of_one_size() {
        let cases = [
            (7, 3),
            (11, 5),
            (11, 2),
            (8, 4),
            (5, 5),
            (1, 1),
            (65_535, 32_767),
        ];
        for (size, count) in cases {
            let mut total = 0.0;
            for span in spans(count, size) {
                let [head, tail] = span.shares;
                let length = match span.last - span.first {
                    0 => head,
                    apart => head + tail + (apart - 1) as f64,
                };
                assert!((length - f64::from(size) / f64::from(count)).abs() < 1e-12);
                assert!(head > 0.0 && tail > 0.0 && head <= 1.0 && tail <= 1.0);
                total += length;
            }
            assert!(
                (total / f64::from(size) - 1.0).abs() < 1e-12,
                "{size} {count}"
            );
        }
    }

    /// The moments of cell number `cell` of a level of `size`, straight from the texels.
    fn summed(map: &NormalMap, cell: usize, size: [u32; 2]) -> Moments {
        let [columns, rows] = [spans(size[0], map.width()), spans(size[1], map.height())];
        over_texels(
            map,
            columns[cell % columns.len()],
            rows[cell / columns.len()],
        )
    }

    #[test]
    fn unions_equal_sums_over_texels() {
        let map = map(48, 32, |texel| {
            let x = texel.wrapping_mul(2_654_435_761) >> 8;
            [x as f32 / 16_777_216.0 - 0.5, (x % 4093) as f32 / 8186.0]
        });
        let fine = Level {
            size: [12, 8],
            cells: (0..96).map(|cell| summed(&map, cell, [12, 8])).collect(),
        };
        for size in [[12, 8], [6, 4], [3, 2], [3, 1], [1, 1]] {
            assert!(fine.is_cut_from(size));
            for cell in 0..(size[0] * size[1]) as usize {
                let (merged, direct) = (fine.union(cell, size), summed(&map, cell, size));
                for (a, b) in merged.mean.iter().zip(direct.mean) {
                    assert!((a - b).abs() < 1e-15);
                }
                for (a, b) in merged.covariance.iter().zip(direct.covariance) {
                    assert!((a - b).abs() < 1e-15);
                }
            }
        }
        assert!(!fine.is_cut_from([5, 4]));
    }

    #[test]
    fn what_is_constant_has_no_spread_and_one_outlier_has_its_own() {
        let layout = PyramidLayout::new(37, 20, 0).unwrap();
        let flat = build(&map(37, 20, |_| [0.3, -0.7]), layout, true);
        let none = SpreadRecord::new([0.0; 3]);
        assert!(flat.spreads.iter().all(|spread| *spread == none));
        let outlier = map(37, 20, |texel| {
            if texel == 390 {
                [0.9, 0.0]
            } else {
                [1e-4, 0.0]
            }
        });
        let top = summed(&outlier, 0, [1, 1]);
        let share = 1.0 / 740.0;
        let expected = (0.9_f64 - 1e-4).powi(2) * share * (1.0 - share);
        assert!((top.covariance[0] / expected - 1.0).abs() < 1e-6);
    }

    #[test]
    fn levels_below_the_finest_are_not_stored() {
        let map = map(20, 12, |texel| [texel as f32 / 500.0, 0.1]);
        let all = build(&map, PyramidLayout::new(20, 12, 0).unwrap(), false);
        for finest in 1..=4 {
            let layout = PyramidLayout::new(20, 12, finest).unwrap();
            let some = build(&map, layout, false);
            let (Means::Narrow(all_means), Means::Narrow(means)) = (&all.means, &some.means) else {
                panic!("both are narrow");
            };
            assert_eq!(means[..], all_means[all_means.len() - means.len()..]);
            assert_eq!(means.len() as u64, layout.mean_count());
            let skipped = all.spreads.len() - some.spreads.len();
            assert_eq!(some.spreads, all.spreads[skipped..]);
        }
    }
}
