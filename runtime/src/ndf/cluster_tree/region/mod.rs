//! The footprint as nodes and leaves see it: which boxes of texels it misses, covers or cuts, and what it weighs them.
//!
//! Boxes are tested in single precision relative to the footprint's centre, with slack for all rounding: what is in doubt counts
//! as cut. Texels under a box have a share in closed form, all sixteen of a leaf at once, but of footprints thinner than a
//! twentieth of a texel, which are weighed in double precision.

mod gaussian;
mod parallelogram;

pub(super) use gaussian::GaussianRegion;
pub(super) use parallelogram::BoxRegion;

use super::lanes::{Lanes, Place, Spread, Texels};

/// A tile of the tree as the footprint sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Origin {
    /// First column and row, tile copies counted on.
    pub texel: [i64; 2],
    /// The same relative to the footprint's centre, in texels.
    pub offset: [f32; 2],
}

/// A footprint.
pub(super) trait Region: Copy {
    /// Whether texels beyond those that are met have weight.
    const HAS_TAIL: bool;

    /// How far the mean product of weight and term of a cluster's texels, in the box `place`, can be from `weight` times their
    /// mean term, as a share of the greatest term, in units of [`unit`](Self::unit).
    fn weight_error(&self, place: Place, weight: f32) -> f32;

    /// How the box `place` lies, whose normals' exponents are at least `exponent`: it may hold weight of exponents up to
    /// `limit` in all if the first number is at most 0, and all its texels weigh the same if the second is.
    fn relation(&self, place: Place, exponent: f32, limit: f32) -> [f32; 2];

    /// The mean weight of a cluster in the box `place`, whose normals' exponents are at least `exponent`, and what is at most 0
    /// if it hardly depends on where the cluster's texels lie. Not asked of a cluster that is inside.
    fn cluster_weight(&self, place: Place, spread: Spread, exponent: f32) -> [f32; 2];

    /// The greatest number of texels of a cluster that is not inside and may be weighed as a whole.
    fn most_blurred(&self) -> f32;

    /// What the first `count` texels weigh, in units of [`unit`](Self::unit); others any number.
    fn weights(
        &self,
        texels: &Texels,
        origin: &Origin,
        first: [u8; 2],
        count: u32,
        weights: &mut Lanes,
    );

    /// The weight of a texel that counts 1 in sums.
    fn unit(&self) -> f64;
}
