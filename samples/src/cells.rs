//! A grid of cells with one feature each, that repeats with the tile.

/// Most rings of cells around a point that can be asked for.
pub const MAX_RINGS: usize = 2;

/// A periodic grid over a `width` × `height` tile whose cells are nearly squares of a wanted size.
#[derive(Clone, Copy, Debug)]
pub struct CellGrid {
    /// Cells in a row of cells, 1 to the tile's width.
    pub column_count: i64,
    /// Cells in a column of cells, 1 to the tile's height.
    pub row_count: i64,
    /// Width and height of a cell in texels, at least 1.
    pub cell_size: [f64; 2],
}

impl CellGrid {
    /// The grid whose cells come closest to `side` × `side` texels: a whole number must fill the tile each way.
    pub fn new(width: u32, height: u32, side: f64) -> Self {
        let count = |extent: u32| {
            (f64::from(extent) / side + 0.5)
                .floor()
                .clamp(1.0, f64::from(extent))
        };
        let counts = [count(width), count(height)];
        Self {
            column_count: counts[0] as i64,
            row_count: counts[1] as i64,
            cell_size: [f64::from(width) / counts[0], f64::from(height) / counts[1]],
        }
    }

    /// The features of the cells around every point with y in `rows` (texels from the top), for points that were moved
    /// by at most `reach` texels each way; `feature(column, row)` is called on wrapped indices.
    pub fn block<T>(
        &self,
        rows: core::ops::Range<usize>,
        reach: f64,
        feature: impl Fn(u64, u64) -> T,
    ) -> CellBlock<T> {
        // One more cell for rounding.
        let margin = self
            .cell_size
            .map(|size| (reach / size) as i64 + MAX_RINGS as i64 + 1);
        let row_at = |y: usize| (y as f64 / self.cell_size[1]) as i64;
        let first = [-margin[0], row_at(rows.start) - margin[1]];
        let end = [
            self.column_count + margin[0],
            row_at(rows.end) + margin[1] + 1,
        ];
        let mut features = Vec::new();
        for row in first[1]..end[1] {
            let row = row.rem_euclid(self.row_count) as u64;
            features.extend((first[0]..end[0]).map(|column| {
                let column = column.rem_euclid(self.column_count) as u64;
                feature(column, row)
            }));
        }
        CellBlock {
            cell_size: self.cell_size,
            first: first.map(|cell| cell as f64),
            stride: (end[0] - first[0]) as usize,
            features,
        }
    }
}

/// The features of a few rows of cells, continued beyond the tile on both sides.
pub struct CellBlock<T> {
    cell_size: [f64; 2],
    /// (column, row) of the first feature, not wrapped.
    first: [f64; 2],
    stride: usize,
    features: Vec<T>,
}

impl<T> CellBlock<T> {
    /// Visits the feature in the cell of `point` and those of `rings` rings of cells around it (at most [`MAX_RINGS`]),
    /// row by row, each with the corner of its cell; all in texels.
    ///
    /// Corners are not wrapped: they are where this copy of the feature lies as seen from the point.
    ///
    /// # Panics
    /// If the point is not one that the block was made for.
    // Loops, not an iterator: flattened ones cost flakes a third more time.
    #[inline]
    pub fn visit_around(&self, point: [f64; 2], rings: usize, mut visit: impl FnMut([f64; 2], &T)) {
        // From the first cell on no index is negative: truncation is floor.
        let column = (point[0] / self.cell_size[0] - self.first[0]) as usize;
        let row = (point[1] / self.cell_size[1] - self.first[1]) as usize;
        for y in row - rings..=row + rings {
            let start = y * self.stride + column - rings;
            let corner_y = (y as f64 + self.first[1]) * self.cell_size[1];
            for (k, feature) in self.features[start..=start + 2 * rings].iter().enumerate() {
                let x = column - rings + k;
                let corner_x = (x as f64 + self.first[0]) * self.cell_size[0];
                visit([corner_x, corner_y], feature);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around<T: Copy>(block: &CellBlock<T>, point: [f64; 2]) -> Vec<([f64; 2], T)> {
        let mut seen = Vec::new();
        block.visit_around(point, 1, |corner, feature| seen.push((corner, *feature)));
        seen
    }

    #[test]
    fn cells_fill_the_tile_and_neighbours_wrap() {
        let grid = CellGrid::new(13, 1, 4.0);
        assert_eq!((grid.column_count, grid.row_count), (3, 1));
        assert_eq!(grid.cell_size, [13.0 / 3.0, 1.0]);
        let block = grid.block(0..1, 0.0, |column, row| (column, row));
        let around = around(&block, [0.5, 0.5]);
        assert_eq!(around.len(), 9);
        assert_eq!(around[0], ([-13.0 / 3.0, -1.0], (2, 0)));
        assert_eq!(around[8], ([13.0 / 3.0, 1.0], (1, 0)));
        let right = self::around(&block, [12.5, 0.5]);
        assert_eq!(right[5], ([13.0, 0.0], (0, 0)));
    }

    #[test]
    fn a_block_holds_the_cells_of_moved_points() {
        let grid = CellGrid::new(50, 40, 5.0);
        let block = grid.block(10..20, 12.0, |column, row| [column as i64, row as i64]);
        for (x, y) in [(-11.9, -1.9), (-11.9, 31.9), (61.9, -1.9), (61.9, 31.9)] {
            let (corner, cell) = around(&block, [x, y])[4];
            let own = [x, y].map(|z: f64| (z / 5.0).floor());
            assert_eq!(corner, own.map(|index| index * 5.0));
            assert_eq!(cell[0], (own[0] as i64).rem_euclid(10));
            assert_eq!(cell[1], (own[1] as i64).rem_euclid(8));
        }
    }

    #[test]
    fn cells_are_never_finer_than_texels() {
        let grid = CellGrid::new(7, 5, 0.1);
        assert_eq!((grid.column_count, grid.row_count), (7, 5));
        assert_eq!(grid.cell_size, [1.0, 1.0]);
    }
}
