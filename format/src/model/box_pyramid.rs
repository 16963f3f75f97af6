//! Box pyramids: how cells over a map nest, sixteen to one.

/// Cells along one side of a block, and blocks or nodes along one side of a node.
pub const PYRAMID_SIDE: u32 = 4;

/// Most levels of nodes: those of [`BoxPyramidLayout::MAX_SIDE`] cells a side.
pub const PYRAMID_LEVELS: usize = 9;

/// A grid of cells in blocks of 4 × 4, these in nodes of 4 × 4 blocks, these in nodes of 4 × 4 nodes, up to a single one.
///
/// Level 0 are blocks, level 1 the nodes whose children are blocks, and so on. Levels are in rows, blocks and nodes at the
/// right and lower border may have fewer cells. Nodes are stored level by level from level 1, each level row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoxPyramidLayout {
    /// Columns and rows of cells.
    cells: [u32; 2],
    /// The number of the level of one node, at least 1.
    top: u32,
    /// For each level of nodes, from level 1, the place of its first node.
    starts: [u32; PYRAMID_LEVELS],
    node_count: u32,
}

impl BoxPyramidLayout {
    /// Most cells along a side: two for each texel of the largest map.
    pub const MAX_SIDE: u32 = 0x1_FFFE;

    /// The layout over `columns` × `rows` cells; `None` if there are none, or more than [`MAX_SIDE`](Self::MAX_SIDE) a side.
    pub const fn new(columns: u32, rows: u32) -> Option<Self> {
        let fits = columns > 0 && rows > 0 && columns <= Self::MAX_SIDE && rows <= Self::MAX_SIDE;
        if !fits {
            return None;
        }
        let mut layout = Self {
            cells: [columns, rows],
            top: 0,
            starts: [0; PYRAMID_LEVELS],
            node_count: 0,
        };
        let mut rest: &mut [u32] = &mut layout.starts;
        while let Some((start, later)) = rest.split_first_mut() {
            *start = layout.node_count;
            layout.top = layout.top.wrapping_add(1);
            let [across, down] = Self::size_over(columns, rows, layout.top);
            // At most 8192² nodes on level 1, and a sixteenth of it on each further one.
            layout.node_count = layout.node_count.wrapping_add(across.wrapping_mul(down));
            if across == 1 && down == 1 {
                break;
            }
            rest = later;
        }
        Some(layout)
    }

    const fn size_over(columns: u32, rows: u32, level: u32) -> [u32; 2] {
        let shift = 2 * level.wrapping_add(1);
        let shift = if shift > 31 { 31 } else { shift };
        let less_one = (1_u32 << shift).wrapping_sub(1);
        [
            columns.wrapping_add(less_one) >> shift,
            rows.wrapping_add(less_one) >> shift,
        ]
    }

    /// Columns and rows of cells.
    pub const fn cells(&self) -> [u32; 2] {
        self.cells
    }

    /// The level of a single node, 1 to 8.
    pub const fn top(&self) -> u32 {
        self.top
    }

    /// Columns and rows of level `level`: of blocks for 0, of nodes for 1 and above.
    pub const fn size(&self, level: u32) -> [u32; 2] {
        Self::size_over(self.cells[0], self.cells[1], level)
    }

    /// Nodes of all levels.
    pub const fn node_count(&self) -> u32 {
        self.node_count
    }

    /// Nodes of level 1, which are the first.
    pub const fn lowest_count(&self) -> u32 {
        let [columns, rows] = self.size(1);
        columns.wrapping_mul(rows)
    }

    /// The place of the node in `column` and `row` of `level`, 1 to [`top`](Self::top).
    #[inline]
    pub fn place(&self, level: u32, column: u32, row: u32) -> usize {
        let start = self
            .starts
            .get(level.wrapping_sub(1) as usize)
            .copied()
            .unwrap_or(u32::MAX);
        let [columns, _] = self.size(level);
        (start as usize)
            .wrapping_add((row as usize).wrapping_mul(columns as usize))
            .wrapping_add(column as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_cover_every_cell_and_end_in_one_node() {
        for (columns, rows) in [
            (1, 1),
            (4, 4),
            (5, 1),
            (16, 17),
            (100, 3),
            (2048, 2048),
            (131_070, 131_070),
        ] {
            let layout = BoxPyramidLayout::new(columns, rows).expect("fits");
            assert_eq!(layout.size(layout.top()), [1, 1]);
            assert!(layout.top() as usize <= PYRAMID_LEVELS && layout.top() >= 1);
            let mut next = 0;
            for level in 1..=layout.top() {
                let ([across, down], [finer_across, finer_down]) =
                    (layout.size(level), layout.size(level - 1));
                assert_eq!(
                    [across, down],
                    [finer_across.div_ceil(4), finer_down.div_ceil(4)]
                );
                assert_eq!(layout.place(level, 0, 0), next);
                next = layout.place(level, across - 1, down - 1) + 1;
            }
            assert_eq!(next, layout.node_count() as usize);
            assert_eq!(layout.size(0), [columns.div_ceil(4), rows.div_ceil(4)]);
        }
        assert_eq!(BoxPyramidLayout::new(0, 1), None);
        assert_eq!(BoxPyramidLayout::new(1, 131_071), None);
    }
}
