//! Footprint against texels: how much of a box footprint's weight falls on an axis-aligned box of texels.
//!
//! - [`Outline`]: exact coverage in texture space, a row of texels at a time; for footprints that are not too thin.
//! - `clip`: the same in parameter space, one box at a time; slower, right for footprints of any shape.
//! - [`Probe`]: which boxes and texels need either at all; [`SquareProbe`]: the same for many squares of one size.
//! - `gaussian`: footprints that are Gaussians instead of boxes.

mod clip;
mod gaussian;
mod outline;
mod placement;
mod polygon;
mod probe;
mod rows;
mod squares;

pub(crate) use gaussian::{GaussianFootprint, GaussianRow, LOST, RADIUS};
pub(crate) use outline::{CoveredRow, Outline};
pub(crate) use placement::{EVEN_TILES, Placement};
pub(crate) use polygon::Polygon;
pub(crate) use probe::{Probe, Relation};
pub(crate) use squares::SquareProbe;

use crate::error::QueryError;
use glintbake_format::model::{Footprint, Wrap};

/// A box in texel units; sides may be infinite where the map is clamped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TexelBox {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

/// A box footprint in texel units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parallelogram {
    /// Whole part of the centre. Apart from the rest, so that the rest keeps all its digits.
    cell: [f64; 2],
    /// The centre relative to `cell`, in [0, 1] but for rounding.
    centre: [f64; 2],
    edge_1: [f64; 2],
    edge_2: [f64; 2],
    /// Half the width and height of the bounding box.
    extent: [f64; 2],
    /// |e1 × e2|: the area in texels.
    area: f64,
}

/// The greatest integer not above `value`, a coordinate of less than 2⁵³.
#[inline]
fn floor(value: f64) -> i64 {
    let truncated = value as i64;
    truncated - i64::from(value < truncated as f64)
}

impl Parallelogram {
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
        let Placement {
            cell,
            centre,
            edge_1,
            edge_2,
        } = Placement::new(footprint, width, height, wrap)?;
        Ok(Self {
            cell,
            centre,
            edge_1,
            edge_2,
            extent: [
                (edge_1[0].abs() + edge_2[0].abs()) * 0.5,
                (edge_1[1].abs() + edge_2[1].abs()) * 0.5,
            ],
            area: (edge_1[0] * edge_2[1] - edge_1[1] * edge_2[0]).abs(),
        })
    }

    /// The same footprint seen from the tile that begins at texel (`x`, `y`).
    pub fn relative_to(&self, x: f64, y: f64) -> Self {
        Self {
            cell: [self.cell[0] - x, self.cell[1] - y],
            ..*self
        }
    }

    /// The point at parameters (`a`, `b`) in [-1/2, 1/2]², in texels.
    fn point(&self, a: f64, b: f64) -> [f64; 2] {
        let [x, y] = self.offset(a, b);
        [self.cell[0] + x, self.cell[1] + y]
    }

    /// The same point relative to the centre's texel.
    fn offset(&self, a: f64, b: f64) -> [f64; 2] {
        [
            self.centre[0] + a * self.edge_1[0] + b * self.edge_2[0],
            self.centre[1] + a * self.edge_1[1] + b * self.edge_2[1],
        ]
    }

    /// Column and row of the texel, of this or any other tile, under the point at parameters (`a`, `b`).
    pub fn texel(&self, a: f64, b: f64) -> [i64; 2] {
        let [x, y] = self.offset(a, b);
        [
            self.cell[0] as i64 + libm::floor(x) as i64,
            self.cell[1] as i64 + libm::floor(y) as i64,
        ]
    }

    /// Weight of one texel that lies wholly inside.
    pub fn texel_weight(&self) -> f64 {
        1.0 / self.area
    }

    /// Both edges, in texels.
    pub fn edges(&self) -> [[f64; 2]; 2] {
        [self.edge_1, self.edge_2]
    }

    /// Where the point (`x`, `y`) lies relative to the centre.
    pub fn centred(&self, x: f64, y: f64) -> [f64; 2] {
        [
            (x - self.cell[0]) - self.centre[0],
            (y - self.cell[1]) - self.centre[1],
        ]
    }

    /// Area in texels.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The bounding box.
    pub fn bounds(&self) -> TexelBox {
        TexelBox {
            low: [
                self.cell[0] + self.centre[0] - self.extent[0],
                self.cell[1] + self.centre[1] - self.extent[1],
            ],
            high: [
                self.cell[0] + self.centre[0] + self.extent[0],
                self.cell[1] + self.centre[1] + self.extent[1],
            ],
        }
    }
}
