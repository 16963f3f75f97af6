//! MIP lobes: how a small sample is quilted to a surface, and which cells of it have clustered lobes.

/// Lobes of a block, stored and summed together; cells have a multiple of them.
pub const MIP_LANES: usize = 16;

/// A surface of square patches of a smaller sample, which overlap.
///
/// Patch (i, j) of a surface is a block of `patch + overlap` texels a side, copied from the sample at the patch's origin, whose
/// first texel lies at (i, j) · `patch`. On the first `overlap` columns and rows of a patch the block before it still reaches; which
/// of both a texel is of, a cut says: for each row of the patch, how many columns are of the patch to the left, and for each column,
/// how many rows are of the patch above. Both the surface and the sample repeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QuiltLayout {
    /// Columns and rows of the sample.
    pub sample: [u32; 2],
    /// Binary logarithm of the texels from one patch to the next.
    pub patch_log: u8,
    /// Columns, or rows, that neighbouring blocks share.
    pub overlap: u8,
    /// Binary logarithm of what origins are multiples of.
    pub grid_log: u8,
    /// Columns and rows of patches.
    pub patches: [u32; 2],
}

impl QuiltLayout {
    /// The least and the greatest binary logarithm of a patch's side.
    pub const PATCH_LOGS: core::ops::RangeInclusive<u8> = 3..=12;

    /// The quilt of a surface of `size` texels, if there is one: patches of 8 to 4096 texels, fewer of them shared than half a patch
    /// has, blocks no larger than the sample, and a whole number of patches.
    pub fn new(
        size: [u32; 2],
        sample: [u32; 2],
        patch_log: u8,
        overlap: u8,
        grid_log: u8,
    ) -> Option<Self> {
        if !Self::PATCH_LOGS.contains(&patch_log) || grid_log > patch_log {
            return None;
        }
        let patch = 1_u32 << patch_log;
        let block = patch.wrapping_add(u32::from(overlap));
        let fits = |side: &u32| (block..=0xFFFF).contains(side);
        let is_whole = |side: &u32| (patch..=0xFFFF).contains(side) && side.is_multiple_of(patch);
        let is_sound = sample.iter().all(fits)
            && size.iter().all(is_whole)
            && u32::from(overlap).wrapping_mul(2) <= patch;
        is_sound.then(|| Self {
            sample,
            patch_log,
            overlap,
            grid_log,
            patches: size.map(|side| side >> patch_log),
        })
    }

    /// Texels from one patch to the next.
    pub const fn patch(&self) -> u32 {
        1 << (self.patch_log & 31)
    }

    /// How many patches there are.
    pub const fn count(&self) -> usize {
        (self.patches[0] as usize).wrapping_mul(self.patches[1] as usize)
    }

    /// How many cuts a patch has: those of its rows, then those of its columns.
    pub const fn cuts(&self) -> usize {
        2 << (self.patch_log & 31)
    }

    /// The patch that texel (`x`, `y`) of the surface is in by its place, and where in it.
    #[inline(always)]
    pub const fn place(&self, x: u32, y: u32) -> ([u32; 2], [u32; 2]) {
        let (log, mask) = (self.patch_log & 31, self.patch().wrapping_sub(1));
        ([x >> log, y >> log], [x & mask, y & mask])
    }

    /// The number of the patch in `column` and `row`.
    #[inline(always)]
    pub const fn number(&self, [column, row]: [u32; 2]) -> usize {
        (row as usize)
            .wrapping_mul(self.patches[0] as usize)
            .wrapping_add(column as usize)
    }

    /// The patch whose block has the texel, and where in the block, of a texel at `within` in the patch at `patch`, `left` of whose
    /// columns and `above` of whose rows are of the patches before it.
    #[inline(always)]
    pub const fn supplier(
        &self,
        patch: [u32; 2],
        within: [u32; 2],
        [left, above]: [u8; 2],
    ) -> ([u32; 2], [u32; 2]) {
        let [columns, rows] = self.patches;
        let (column, x) = self.along(patch[0], within[0], left, columns);
        let (row, y) = self.along(patch[1], within[1], above, rows);
        ([column, row], [x, y])
    }

    /// As [`supplier`](Self::supplier), along one axis of `count` patches.
    #[inline(always)]
    const fn along(&self, patch: u32, within: u32, cut: u8, count: u32) -> (u32, u32) {
        if within >= cut as u32 {
            return (patch, within);
        }
        let before = if patch == 0 { count } else { patch };
        (before.wrapping_sub(1), within.wrapping_add(self.patch()))
    }

    /// The texel of the sample at `within` in the block that begins at `origin`.
    #[inline(always)]
    pub const fn texel(&self, [x, y]: [u16; 2], within: [u32; 2]) -> [u32; 2] {
        let [columns, rows] = self.sample;
        let column = folded((x as u32).wrapping_add(within[0]), columns);
        let row = folded((y as u32).wrapping_add(within[1]), rows);
        [column, row]
    }
}

/// `place` of an axis that repeats after `side`, of which it is less than twice.
#[inline(always)]
const fn folded(place: u32, side: u32) -> u32 {
    if place >= side {
        place.wrapping_sub(side)
    } else {
        place
    }
}

/// Levels of cells of a surface, each cell with as many clustered lobes.
///
/// A cell of level l is `2^l` texels a side. Without a quilt, all are cells of the surface. With one, those up to the size of a
/// patch are cells of the sample, at every origin and every cell within the patches there; larger ones are of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MipLayout {
    /// Columns and rows of the surface.
    pub size: [u32; 2],
    /// Lobes along each side of a texel: 1 or 2.
    pub per_side: u8,
    /// The lowest level that has clustered lobes.
    pub first_level: u8,
    /// Blocks of [`MIP_LANES`] lobes of each cell.
    pub blocks: u8,
    /// The quilt, if the surface is one.
    pub quilt: Option<QuiltLayout>,
}

impl MipLayout {
    /// The level of which one cell holds a surface of `size`.
    pub const fn top_of(size: [u32; 2]) -> u8 {
        let side = if size[0] > size[1] { size[0] } else { size[1] };
        side.next_power_of_two().trailing_zeros() as u8
    }

    /// The level of which one cell holds the surface.
    pub const fn top(&self) -> u8 {
        Self::top_of(self.size)
    }

    /// The highest level whose cells are the sample's, or less than [`first_level`](Self::first_level) if there is none.
    pub const fn last_of_sample(&self) -> u8 {
        match self.quilt {
            Some(quilt) => quilt.patch_log,
            None => self.first_level.wrapping_sub(1),
        }
    }

    /// Whether the numbers go together.
    pub fn is_sound(&self) -> bool {
        let starts = match self.quilt {
            // The cuts of a patch lie in its first cells.
            Some(quilt) => {
                self.first_level <= quilt.patch_log
                    && u32::from(quilt.overlap) <= 1 << self.first_level
            }
            None => self.first_level <= self.top().wrapping_add(1),
        };
        starts
            && matches!(self.per_side, 1 | 2)
            && (1..=16).contains(&self.first_level)
            && (1..=16).contains(&self.blocks)
            && self.size.iter().all(|side| (1..=0xFFFF).contains(side))
    }

    /// Texels from one cell of the sample to the next, at `level`: cells begin at origins and whole cells from them.
    pub fn step(quilt: &QuiltLayout, level: u8) -> u32 {
        1 << quilt.grid_log.min(level)
    }

    /// Columns and rows of places for cells of the sample, at `level`.
    pub fn places(quilt: &QuiltLayout, level: u8) -> [u32; 2] {
        let step = Self::step(quilt, level);
        quilt.sample.map(|side| side.div_ceil(step))
    }

    /// How many places for cells of the sample there are before those of `level`.
    pub fn places_before(&self, level: u8) -> usize {
        let Some(quilt) = self.quilt else {
            return 0;
        };
        (self.first_level..level.min(quilt.patch_log.wrapping_add(1)))
            .map(|level| {
                let [columns, rows] = Self::places(&quilt, level);
                (columns as usize).wrapping_mul(rows as usize)
            })
            .fold(0, usize::wrapping_add)
    }

    /// The first level whose cells are the surface's.
    pub const fn first_of_surface(&self) -> u8 {
        self.last_of_sample().wrapping_add(1)
    }

    /// Columns and rows of cells of the surface, at `level`.
    pub fn cells(&self, level: u8) -> [u32; 2] {
        self.size.map(|side| side.div_ceil(1 << (level & 31)))
    }

    /// How many cells of the surface there are before those of `level`; with that of [`top`](Self::top) and one, all.
    pub fn cells_before(&self, level: u8) -> usize {
        (self.first_of_surface()..level)
            .map(|level| {
                let [columns, rows] = self.cells(level);
                (columns as usize).wrapping_mul(rows as usize)
            })
            .fold(0, usize::wrapping_add)
    }
}
