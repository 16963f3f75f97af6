//! Pyramids: how a map is cut into cells, ever coarser.

/// Levels of cells over a map, the finest stored first.
///
/// Level l cuts the unit tile evenly into `max(1, ⌊W / 2^l⌋) × max(1, ⌊H / 2^l⌋)` cells; level 0 has the texels, the top
/// one cell. Where a side is not halved evenly, cells are a little larger than 2^l texels and their borders cross texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PyramidLayout {
    width: u32,
    height: u32,
    finest: u32,
}

impl PyramidLayout {
    /// The pyramid of a map of `width` × `height` texels from level `finest` up; `None` if the map is empty or a side above
    /// 65535, or has no such level.
    pub const fn new(width: u32, height: u32, finest: u32) -> Option<Self> {
        let fits = width > 0 && height > 0 && width <= 0xFFFF && height <= 0xFFFF;
        if !fits || finest > Self::top_of(width, height) {
            return None;
        }
        Some(Self {
            width,
            height,
            finest,
        })
    }

    /// The level of one cell over a map of `width` × `height` texels: ⌊log2 max(W, H)⌋.
    pub const fn top_of(width: u32, height: u32) -> u32 {
        let longer = if width > height { width } else { height };
        (longer | 1).ilog2()
    }

    /// Columns and rows of the map.
    pub const fn map_size(self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The finest level stored.
    pub const fn finest(self) -> u32 {
        self.finest
    }

    /// The level of one cell, at most 15.
    pub const fn top(self) -> u32 {
        Self::top_of(self.width, self.height)
    }

    /// Columns and rows of `level`; those of the top for levels above it.
    pub const fn size(self, level: u32) -> [u32; 2] {
        let level = if level > 15 { 15 } else { level };
        let columns = self.width >> level;
        let rows = self.height >> level;
        [
            if columns == 0 { 1 } else { columns },
            if rows == 0 { 1 } else { rows },
        ]
    }

    /// The place of the first mean of `level` among those of all levels stored.
    pub const fn first_mean(self, level: u32) -> u64 {
        self.cells_between(self.finest, level)
    }

    /// The place of the first spread of `level`: as that of its mean, but that level 0 has none.
    pub const fn first_spread(self, level: u32) -> u64 {
        self.cells_between(self.finest_spread(), level)
    }

    /// The finest level that has spreads; above the top if the map is one texel.
    pub const fn finest_spread(self) -> u32 {
        if self.finest == 0 { 1 } else { self.finest }
    }

    /// Number of means: the cells of all levels stored.
    pub const fn mean_count(self) -> u64 {
        self.first_mean(self.top() + 1)
    }

    /// Number of spreads.
    pub const fn spread_count(self) -> u64 {
        self.first_spread(self.top() + 1)
    }

    /// The cells of the levels from `from` up to, not including, `to`.
    const fn cells_between(self, from: u32, to: u32) -> u64 {
        let mut cells = 0;
        let mut level = from;
        while level < to && level <= self.top() {
            let [columns, rows] = self.size(level);
            cells += columns as u64 * rows as u64;
            level += 1;
        }
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_halve_down_to_one_cell() {
        let layout = PyramidLayout::new(11, 4, 0).unwrap();
        assert_eq!(layout.top(), 3);
        let sizes = [0, 1, 2, 3].map(|level| layout.size(level));
        assert_eq!(sizes, [[11, 4], [5, 2], [2, 1], [1, 1]]);
        assert_eq!((layout.mean_count(), layout.spread_count()), (57, 13));
        assert_eq!((layout.first_mean(2), layout.first_spread(2)), (54, 10));
        let coarse = PyramidLayout::new(11, 4, 2).unwrap();
        assert_eq!((coarse.mean_count(), coarse.spread_count()), (3, 3));
        assert_eq!((coarse.first_mean(2), coarse.first_mean(3)), (0, 2));
        let texel = PyramidLayout::new(1, 1, 0).unwrap();
        assert_eq!((texel.mean_count(), texel.spread_count()), (1, 0));
    }

    #[test]
    fn levels_beyond_the_top_and_sides_beyond_the_format_are_none() {
        assert_eq!(PyramidLayout::new(11, 4, 4), None);
        assert_eq!(PyramidLayout::new(1, 1, 1), None);
        assert_eq!(PyramidLayout::new(0, 4, 0), None);
        assert_eq!(PyramidLayout::new(65_536, 4, 0), None);
        let largest = PyramidLayout::new(65_535, 65_535, 0).unwrap();
        assert_eq!(largest.top(), 15);
        assert!(largest.mean_count() < 3 << 31);
        assert_eq!(largest.size(40), [1, 1]);
    }
}
