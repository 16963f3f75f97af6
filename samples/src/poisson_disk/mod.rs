//! Points that keep their distance and leave no room for another: maximal Poisson-disk sampling of a tile.
//!
//! Darts are thrown at ever finer squares, one at each that is not yet within the radius of a centre, and stay where no
//! centre is too near; of darts that are too near each other the one with precedence stays. That is Ebeida et al. 2012,
//! "A Simple Algorithm for Maximal Poisson-Disk Sampling in High Dimensions", without its order of throws: a dart's
//! position and precedence are hashed from its square, so the centres are the same however the work is shared out.
//!
//! The first squares are cells with a diagonal of at most the radius, which hold one centre each at most. After each
//! throw, squares that a centre covers are given up and the others cut into four.

#[cfg(test)]
mod tests;

use core::ops::Range;

use rayon::prelude::*;

use crate::random::{Random, Stream, key};

/// How often cells are cut into four.
///
/// When all darts of a depth are thrown, each square that is left has a point, its dart, within the radius of a centre:
/// no point of the tile is farther from a centre than the radius and the diagonal of such a square.
const DEPTHS: u32 = 10;

/// Upper bound of the distance from any point to its nearest centre, in radii: 1 + 2^−[`DEPTHS`].
pub const REACH: f64 = 1.0 + 1.0 / 1024.0;

/// Position within a cell, both in [0, 1].
type Place = [f32; 2];

/// What a cell holds.
#[derive(Clone, Copy)]
enum Cell {
    Empty,
    /// A dart that has not yet been compared with those around.
    Dart(Dart),
    Centre(Place),
}

#[derive(Clone, Copy)]
struct Dart {
    place: Place,
    /// The smallest goes first; then the smallest cell.
    precedence: u32,
}

/// A square of a cell that no centre covers: the one at (column, row) of 2^depth × 2^depth.
#[derive(Clone, Copy)]
struct Square {
    cell: u32,
    column: u16,
    row: u16,
}

/// A centre, and the cell that names it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centre {
    /// (column, row) of the cell, not wrapped: that of the copy asked for.
    pub cell: [i64; 2],
    /// (x, y) of the copy, in texels.
    pub position: [f64; 2],
}

/// A maximal set of centres of a tile, no two nearer than the radius around the tile's seams either.
pub struct PoissonDisk {
    /// Width and height of the tile, in texels.
    size: [f64; 2],
    counts: [usize; 2],
    cell_size: [f64; 2],
    /// Cells to each side that can hold a point within the radius.
    rings: [usize; 2],
    squared_radius: f64,
    cells: Vec<Cell>,
}

impl PoissonDisk {
    /// The centres of `seed` at least `radius` texels apart on a `width` × `height` tile, its copies included.
    ///
    /// A centre's own copies do not count: a tile smaller than the radius has one centre. Takes about 50 bytes for each
    /// radius²/2 texels, and time in proportion.
    pub fn new(seed: u64, [width, height]: [u32; 2], radius: f64) -> Self {
        let size = [f64::from(width), f64::from(height)];
        let count = |side: f64| (side * core::f64::consts::SQRT_2 / radius).ceil().max(1.0);
        let cell_size = size.map(|side| side / count(side));
        let counts = size.map(|side| count(side) as usize);
        let mut disk = Self {
            size,
            counts,
            cell_size,
            rings: cell_size.map(|side| (radius / side).ceil() as usize),
            squared_radius: radius * radius,
            cells: vec![Cell::Empty; counts[0] * counts[1]],
        };
        let mut squares: Vec<_> = (0..disk.cells.len() as u32)
            .map(|cell| Square {
                cell,
                column: 0,
                row: 0,
            })
            .collect();
        for depth in 0..=DEPTHS {
            disk.throw_all(key(seed, Stream::Centre, u64::from(depth)), depth, &squares);
            squares = squares
                .par_iter()
                .filter(|square| !disk.is_covered(square, depth))
                .flat_map_iter(|square| square.quarters())
                .collect();
        }
        disk
    }

    /// The (column, row) on the tile of the cell at (column, row) of any copy of it.
    pub fn wrapped(&self, cell: [i64; 2]) -> [usize; 2] {
        [0, 1].map(|axis| cell[axis].rem_euclid(self.counts[axis] as i64) as usize)
    }

    /// The centres with y in `rows` (texels), those of copies above and below the tile too, by rows of cells.
    pub fn visit_rows(&self, rows: Range<f64>, mut visit: impl FnMut(Centre)) {
        let row_at = |y: f64| (y / self.cell_size[1]).floor() as i64;
        for row in row_at(rows.start)..=row_at(rows.end) {
            let [_, wrapped] = self.wrapped([0, row]);
            let start = wrapped * self.counts[0];
            let cells = &self.cells[start..start + self.counts[0]];
            for (column, cell) in (0..).zip(cells) {
                if let &Cell::Centre(place) = cell {
                    let cell = [column, row];
                    let position = self.position([column as f64, row as f64], place);
                    if rows.contains(&position[1]) {
                        visit(Centre { cell, position });
                    }
                }
            }
        }
    }

    /// Throws one dart at each of `squares`, in the order of precedence, as far as that matters.
    fn throw_all(&mut self, key: u64, depth: u32, squares: &[Square]) {
        let mut squares: Vec<_> = squares.to_vec();
        loop {
            squares = squares
                .into_par_iter()
                .filter(|square| !self.is_forbidden(square.cell, self.dart(key, depth, square)))
                .collect();
            // Squares of a cell follow each other. All its darts are too near each other: the first alone can stay.
            let first: Vec<_> = squares
                .par_chunk_by(|a, b| a.cell == b.cell)
                .filter_map(|squares| {
                    let darts = squares.iter().map(|square| self.dart(key, depth, square));
                    let first = darts.min_by_key(|dart| dart.precedence)?;
                    Some((squares[0].cell, first))
                })
                .collect();
            if first.is_empty() {
                return;
            }
            for &(cell, dart) in &first {
                self.cells[cell as usize] = Cell::Dart(dart);
            }
            let stays: Vec<bool> = first
                .par_iter()
                .map(|&(cell, dart)| self.goes_first(cell, dart))
                .collect();
            for (&(cell, dart), stays) in first.iter().zip(stays) {
                self.cells[cell as usize] = match stays {
                    true => Cell::Centre(dart.place),
                    false => Cell::Empty,
                };
            }
        }
    }

    /// The dart that is thrown at `square`.
    fn dart(&self, key: u64, depth: u32, square: &Square) -> Dart {
        let [column, row] = self.cell(square.cell).map(|index| (index as u64) << depth);
        let mut random = Random::at(
            key,
            column + u64::from(square.column),
            row + u64::from(square.row),
        );
        let side = square_side(depth);
        Dart {
            place: [square.column, square.row]
                .map(|index| ((f64::from(index) + random.unit()) * side) as f32),
            precedence: (random.unit() * 4_294_967_296.0) as u32,
        }
    }

    /// Whether the cell has a centre, or one lies nearer to the dart than the radius.
    fn is_forbidden(&self, cell: u32, dart: Dart) -> bool {
        let position = self.position_in(cell as usize, dart.place);
        self.any_around(cell, |index| match self.cells[index] {
            Cell::Centre(place) => {
                index == cell as usize || self.are_near(position, self.position_in(index, place))
            }
            _ => false,
        })
    }

    /// Whether no dart with precedence lies nearer to the dart than the radius.
    fn goes_first(&self, cell: u32, dart: Dart) -> bool {
        let position = self.position_in(cell as usize, dart.place);
        !self.any_around(cell, |index| match self.cells[index] {
            Cell::Dart(other) => {
                (other.precedence, index) < (dart.precedence, cell as usize)
                    && self.are_near(position, self.position_in(index, other.place))
            }
            _ => false,
        })
    }

    /// Whether a centre is within the radius of all of `square`.
    fn is_covered(&self, square: &Square, depth: u32) -> bool {
        let side = square_side(depth);
        let middle = [square.column, square.row].map(|index| (f64::from(index) + 0.5) * side);
        let cell = self.cell(square.cell);
        let position = [0, 1].map(|axis| (cell[axis] as f64 + middle[axis]) * self.cell_size[axis]);
        let half = self.cell_size.map(|size| 0.5 * side * size);
        self.any_around(square.cell, |index| match self.cells[index] {
            Cell::Centre(place) => {
                let offset = self.offset(position, self.position_in(index, place));
                let farthest = [0, 1].map(|axis| offset[axis].abs() + half[axis]);
                squared(farthest) <= self.squared_radius
            }
            _ => false,
        })
    }

    /// Whether `test` holds for a cell that may have points within the radius of one in `cell`, itself included.
    #[inline]
    fn any_around(&self, cell: u32, test: impl Fn(usize) -> bool) -> bool {
        let at = self.cell(cell);
        // Each cell once, also where the tile is narrower than the rings are wide.
        let [columns, rows] = [0, 1].map(|axis| {
            let (count, rings) = (self.counts[axis], self.rings[axis]);
            match 2 * rings + 1 {
                some if some < count => ((at[axis] + count - rings) % count, some),
                _ => (0, count),
            }
        });
        let mut row = rows.0;
        for _ in 0..rows.1 {
            let mut column = columns.0;
            for _ in 0..columns.1 {
                if test(row * self.counts[0] + column) {
                    return true;
                }
                column += 1;
                if column == self.counts[0] {
                    column = 0;
                }
            }
            row += 1;
            if row == self.counts[1] {
                row = 0;
            }
        }
        false
    }

    /// (column, row) of a cell.
    fn cell(&self, cell: u32) -> [usize; 2] {
        [
            cell as usize % self.counts[0],
            cell as usize / self.counts[0],
        ]
    }

    fn position_in(&self, cell: usize, place: Place) -> [f64; 2] {
        self.position(self.cell(cell as u32).map(|index| index as f64), place)
    }

    fn position(&self, cell: [f64; 2], place: Place) -> [f64; 2] {
        [0, 1].map(|axis| (cell[axis] + f64::from(place[axis])) * self.cell_size[axis])
    }

    fn are_near(&self, a: [f64; 2], b: [f64; 2]) -> bool {
        squared(self.offset(a, b)) < self.squared_radius
    }

    /// a − b for the nearest of their copies.
    fn offset(&self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let (offset, size) = (a[axis] - b[axis], self.size[axis]);
            if offset > 0.5 * size {
                offset - size
            } else if offset < -0.5 * size {
                offset + size
            } else {
                offset
            }
        })
    }
}

impl Square {
    fn quarters(self) -> [Self; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[column, row]| Self {
            cell: self.cell,
            column: 2 * self.column + column,
            row: 2 * self.row + row,
        })
    }
}

/// Side of a square, in cell sides.
fn square_side(depth: u32) -> f64 {
    1.0 / f64::from(1u32 << depth)
}

fn squared([x, y]: [f64; 2]) -> f64 {
    x * x + y * y
}
