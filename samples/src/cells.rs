//! A grid of cells with one feature each, that repeats with the tile.

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

    /// The column of cells that lies `x` texels from the left, not wrapped.
    pub fn column_of(&self, x: f64) -> i64 {
        (x / self.cell_size[0]).floor() as i64
    }

    /// The row of cells that lies `y` texels from the top, not wrapped.
    pub fn row_of(&self, y: f64) -> i64 {
        (y / self.cell_size[1]).floor() as i64
    }

    /// The features of the rows of cells `first_row..=last_row`, with `feature(column, row)` called on wrapped indices.
    pub fn block<T>(
        &self,
        first_row: i64,
        last_row: i64,
        feature: impl Fn(u64, u64) -> T,
    ) -> CellBlock<T> {
        let mut features = Vec::new();
        for row in first_row..=last_row {
            let wrapped = row.rem_euclid(self.row_count) as u64;
            features.extend((0..self.column_count as u64).map(|column| feature(column, wrapped)));
        }
        CellBlock {
            grid: *self,
            first_row,
            features,
        }
    }
}

/// The features of a few rows of cells.
pub struct CellBlock<T> {
    grid: CellGrid,
    first_row: i64,
    features: Vec<T>,
}

impl<T> CellBlock<T> {
    /// The nine features in and around the cell (column, row), each with the corner of its cell in texels.
    ///
    /// Corners are not wrapped: they are where this copy of the feature lies as seen from that cell. Rows from one
    /// above to one below must be in the block.
    pub fn around(&self, column: i64, row: i64) -> impl Iterator<Item = ([f64; 2], &T)> {
        (row - 1..=row + 1).flat_map(move |y| {
            let start = (y - self.first_row) * self.grid.column_count;
            (column - 1..=column + 1).map(move |x| {
                let index = start + x.rem_euclid(self.grid.column_count);
                let corner = [
                    x as f64 * self.grid.cell_size[0],
                    y as f64 * self.grid.cell_size[1],
                ];
                (corner, &self.features[index as usize])
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_fill_the_tile_and_neighbours_wrap() {
        let grid = CellGrid::new(13, 1, 4.0);
        assert_eq!((grid.column_count, grid.row_count), (3, 1));
        assert_eq!(grid.cell_size, [13.0 / 3.0, 1.0]);
        let block = grid.block(-1, 1, |column, row| (column, row));
        let around: Vec<_> = block.around(0, 0).collect();
        assert_eq!(around.len(), 9);
        assert_eq!(around[0], ([-13.0 / 3.0, -1.0], &(2, 0)));
        assert_eq!(around[8], ([13.0 / 3.0, 1.0], &(1, 0)));
        assert_eq!(grid.column_of(12.5), 2);
        assert_eq!(grid.row_of(-0.5), -1);
    }

    #[test]
    fn cells_are_never_finer_than_texels() {
        let grid = CellGrid::new(7, 5, 0.1);
        assert_eq!((grid.column_count, grid.row_count), (7, 5));
        assert_eq!(grid.cell_size, [1.0, 1.0]);
    }
}
