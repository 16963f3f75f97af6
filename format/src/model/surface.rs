//! How a surface continues between the middles of texels, and the lobes that stand for it.

/// How normals are interpolated between texels.
///
/// Texel (i, j) has its normal at its middle, (i + ½, j + ½). Triangles are right-angled with sides along the axes, cut from
/// squares along the diagonal from the upper right to the lower left corner, rows running down; s and t are linear on each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Interpolation {
    /// Not at all: every texel is flat, as flakes are.
    None = 0,
    /// Two triangles between the middles of four texels.
    Linear = 1,
    /// Bicubic by Catmull and Rom, between the middles of sixteen texels, in 4 × 4 parts of two triangles each.
    CatmullRom = 2,
}

impl Interpolation {
    /// Every interpolation, in order of its code.
    pub const ALL: &'static [Self] = &[Self::None, Self::Linear, Self::CatmullRom];

    /// The interpolation stored as `code`, if there is one.
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::None),
            1 => Some(Self::Linear),
            2 => Some(Self::CatmullRom),
            _ => None,
        }
    }

    /// The word used on the command line and in metadata.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Linear => "linear",
            Self::CatmullRom => "catmull-rom",
        }
    }
}

/// Parts along a side of a square between middles, under [`Interpolation::CatmullRom`].
pub const CATMULL_ROM_PARTS: usize = 4;

/// Weights of four texels in a row at 0, 1/4, … 1 of the way from the second to the third: Catmull and Rom's cubic of tension ½.
pub const CATMULL_ROM: [[f64; 4]; CATMULL_ROM_PARTS + 1] = {
    const fn at(x: f64) -> [f64; 4] {
        let (square, cube) = (x * x, x * x * x);
        [
            0.5 * (2.0 * square - x - cube),
            0.5 * (2.0 - 5.0 * square + 3.0 * cube),
            0.5 * (x + 4.0 * square - 3.0 * cube),
            0.5 * (cube - square),
        ]
    }
    [at(0.0), at(0.25), at(0.5), at(0.75), at(1.0)]
};

/// The lattice of lobes that stands for a map of smooth normals.
///
/// Lobes are Gaussians of position, of standard deviation [`LobeLattice::DEVIATION`] times their spacing, and of normals about
/// a plane through the lobe's normal. With one a texel they stand at the middles of texels, with four a quarter of a
/// texel to the sides of these, on the bilinear interpolation of the map. Curved ones have the slope of that plane, J: half the
/// difference of the normals a texel before and a texel after it, or with four a texel, the slope of the bilinear interpolation.
/// Flat ones have none. Beyond the border of a map that does not repeat, lobes are flat and have the normal of the border's
/// nearest one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LobeLattice {
    /// Whether lobes follow the slope of normals over the map.
    pub curved: bool,
    /// Lobes along each side of a texel: 1, or 2 for four lobes a texel.
    pub per_side: u8,
}

impl LobeLattice {
    /// Every lattice: curved and flat lobes, one and four a texel.
    pub const ALL: &'static [Self] = &[
        Self::new(true, 1),
        Self::new(false, 1),
        Self::new(true, 2),
        Self::new(false, 2),
    ];

    const fn new(curved: bool, per_side: u8) -> Self {
        Self { curved, per_side }
    }

    /// The word used on the command line and in metadata: `curved` or `flat`, with `-4` if there are four lobes a texel.
    pub const fn name(self) -> &'static str {
        match (self.curved, self.per_side) {
            (true, 1) => "curved",
            (true, _) => "curved-4",
            (false, 1) => "flat",
            (false, _) => "flat-4",
        }
    }

    /// Standard deviation σh of a lobe's position as a share of the spacing of lobes, `1 / √(8 ln 2)`: a full width at half
    /// maximum of one spacing \[YHMR16\].
    pub const DEVIATION: f64 = 0.424_660_900_144_009_5;

    /// Columns and rows of lobes on a map of `width` × `height` texels.
    pub const fn size(self, width: u32, height: u32) -> [u32; 2] {
        let per_side = self.per_side as u32;
        [width.wrapping_mul(per_side), height.wrapping_mul(per_side)]
    }
}
