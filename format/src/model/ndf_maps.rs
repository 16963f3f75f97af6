//! NDF maps: a tiny example, the images of its tiles' NDFs, and how copies of it make up a surface.

/// How the pixels of NDF images are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum NdfPixels {
    /// Coefficients of cubic B-splines: never negative, and their sum is the integral.
    Splines = 1,
    /// Values of the density over the whole disk, read bilinearly \[XTXW24\].
    Points = 2,
}

impl NdfPixels {
    /// The way stored as `code`, if there is one.
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::Splines),
            2 => Some(Self::Points),
            _ => None,
        }
    }
}

/// An example of `2^example_log` texels a side, whose tiles have NDF images level by level, and what its copies cover.
///
/// Tiles of level l have `2^l` texels a side, from single texels up to the example itself; \[XTXW24\] §5.2 begins with two. Copies either lie close to each other, all
/// under one transformation, or where and as each of them says, over a surface that repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NdfMapLayout {
    /// Texels along each side of one tile of texture space.
    pub size: u32,
    /// Binary logarithm of the texels along a side of the example.
    pub example_log: u8,
    /// How pixels are read.
    pub pixels: NdfPixels,
    /// Whether copies have places of their own.
    pub is_scattered: bool,
    /// Whether scale and shear of a copy change the slopes of its normals.
    pub scales_slopes: bool,
}

impl NdfMapLayout {
    /// The least and the greatest binary logarithm of an example's side.
    pub const EXAMPLE_LOGS: core::ops::RangeInclusive<u8> = 1..=5;

    /// Texels along a side of the example.
    pub const fn example(&self) -> u32 {
        1 << (self.example_log & 31)
    }

    /// How many levels there are: one less is the level of the whole example.
    pub const fn levels(&self) -> u8 {
        self.example_log.wrapping_add(1)
    }

    /// Tiles along a side of the example, at `level`.
    pub const fn tiles(&self, level: u8) -> u32 {
        1 << (self.example_log.wrapping_sub(level) & 31)
    }

    /// How many tiles the levels below `level` have.
    pub fn tiles_before(&self, level: u8) -> usize {
        (0..level)
            .map(|level| {
                let side = self.tiles(level) as usize;
                side.wrapping_mul(side)
            })
            .fold(0, usize::wrapping_add)
    }

    /// How many images there are: one a tile, level by level and row by row, and one of the surface if copies are scattered.
    pub fn images(&self) -> usize {
        self.tiles_before(self.levels())
            .wrapping_add(usize::from(self.is_scattered))
    }

    /// Whether the numbers go together.
    pub fn is_sound(&self) -> bool {
        Self::EXAMPLE_LOGS.contains(&self.example_log)
            && (self.example()..=0xFFFF).contains(&self.size)
    }
}
