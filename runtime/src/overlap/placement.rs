//! A footprint laid on a map: validated, reduced to the first tile, in texels.

use crate::error::QueryError;
use glintbake_format::model::{Footprint, MAX_EDGE_TILES, Wrap};

/// Centre and edges of a footprint in texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// Whole part of the centre. Apart from the rest, so that the rest keeps all its digits.
    pub cell: [f64; 2],
    /// The centre relative to `cell`, in [0, 1] but for rounding.
    pub centre: [f64; 2],
    pub edge_1: [f64; 2],
    pub edge_2: [f64; 2],
}

impl Placement {
    /// `footprint` on a map of `width` × `height` texels, its centre reduced to the first tile where the map repeats.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`], [`QueryError::FootprintTooLarge`].
    pub fn new(
        footprint: &Footprint,
        width: u32,
        height: u32,
        wrap: Wrap,
    ) -> Result<Self, QueryError> {
        let Footprint {
            centre,
            edge_1,
            edge_2,
        } = *footprint;
        if ![centre, edge_1, edge_2]
            .iter()
            .flatten()
            .all(|coordinate| coordinate.is_finite())
        {
            return Err(QueryError::NotFinite);
        }
        if [edge_1, edge_2]
            .iter()
            .flatten()
            .any(|coordinate| coordinate.abs() > MAX_EDGE_TILES)
        {
            return Err(QueryError::FootprintTooLarge);
        }
        // Exact: a tile number is subtracted from a coordinate of the same magnitude, before anything is scaled.
        let reduce = |coordinate: f64| match wrap {
            Wrap::Repeat => coordinate - libm::floor(coordinate),
            // Beyond this no footprint reaches the map, and border texels extend without end.
            Wrap::Clamp => coordinate.clamp(-4.0 * MAX_EDGE_TILES, 4.0 * MAX_EDGE_TILES),
        };
        let size = [f64::from(width), f64::from(height)];
        let scale = |[x, y]: [f64; 2]| [x * size[0], y * size[1]];
        // The product of centre and size is rounded to the nearest f64, and can land on a texel's border though the
        // centre lies before it; the fused remainder brings back what rounding took.
        let centre = centre.map(reduce);
        let product = scale(centre);
        let rest = [
            libm::fma(centre[0], size[0], -product[0]),
            libm::fma(centre[1], size[1], -product[1]),
        ];
        let cell = product.map(libm::floor);
        Ok(Self {
            cell,
            centre: [
                (product[0] - cell[0]) + rest[0],
                (product[1] - cell[1]) + rest[1],
            ],
            edge_1: scale(edge_1),
            edge_2: scale(edge_2),
        })
    }
}
