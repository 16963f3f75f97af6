//! The patch of texture under a pixel, and how texture space continues beyond one tile.

/// The longest edge of a footprint, in tiles, that a query accepts.
///
/// The tiles a footprint's outline crosses are visited one by one, so this bounds the time of a query.
/// Beyond it a surface is so distant that one average over the whole map (a footprint of exactly one tile)
/// is what a renderer wants.
pub const MAX_EDGE_TILES: f64 = 256.0;

/// A pixel's footprint in texture space: the parallelogram `centre + a edge_1 + b edge_2`, a, b in [-1/2, 1/2].
///
/// Units: one tile of the map is the unit square, `u` runs right along columns, `v` runs down along rows.
/// `edge_1` and `edge_2` are the texture-space ray differentials of the pixel. Either or both may vanish or be
/// parallel: the weights are then the limit of thin parallelograms, that is the image of a uniform (a, b).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Centre, in tiles; any finite value, it is reduced modulo the tile before use.
    pub centre: [f64; 2],
    /// First edge, in tiles.
    pub edge_1: [f64; 2],
    /// Second edge, in tiles.
    pub edge_2: [f64; 2],
}

impl Footprint {
    /// The axis-aligned square of `edge` texels a side around `centre` on a map of `width` × `height` texels.
    pub fn square(centre: [f64; 2], edge: f64, width: u32, height: u32) -> Self {
        Self {
            centre,
            edge_1: [edge / f64::from(width), 0.0],
            edge_2: [0.0, edge / f64::from(height)],
        }
    }
}

/// How texture space continues beyond the unit tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u16)]
pub enum Wrap {
    /// The tile repeats in both directions.
    #[default]
    Repeat = 0,
    /// The border texels extend without end.
    Clamp = 1,
}

impl Wrap {
    /// The wrap mode stored as `code`, if there is one.
    pub const fn from_code(code: u16) -> Option<Self> {
        match code {
            0 => Some(Self::Repeat),
            1 => Some(Self::Clamp),
            _ => None,
        }
    }

    /// The word used on the command line and in metadata.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Repeat => "repeat",
            Self::Clamp => "clamp",
        }
    }
}

/// How a footprint weighs the texture below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u16)]
pub enum Filter {
    /// Uniform over the parallelogram \[AWKK21\].
    #[default]
    Box = 0,
    /// Gaussian with covariance `(e1 e1ᵀ + e2 e2ᵀ) / 4` \[YHJ*14\].
    Gaussian = 1,
}

impl Filter {
    /// The filter stored as `code`, if there is one.
    pub const fn from_code(code: u16) -> Option<Self> {
        match code {
            0 => Some(Self::Box),
            1 => Some(Self::Gaussian),
            _ => None,
        }
    }

    /// The word used on the command line and in metadata.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Gaussian => "gaussian",
        }
    }
}
