//! A Gaussian footprint on a lattice of lobes: in spacings, with the copies of the map it reaches.

use crate::error::QueryError;
use crate::overlap::{EVEN_TILES, Placement};
use core::f64::consts::PI;
use core::ops::Range;
use glintbake_format::model::{Footprint, LobeLattice, Wrap};

/// σh² in squared spacings.
pub(in crate::ndf) const POSITION_VARIANCE: f64 = LobeLattice::DEVIATION * LobeLattice::DEVIATION;

/// A footprint on a lattice of lobes.
#[derive(Clone, Copy, Debug)]
pub(in crate::ndf) struct Placed {
    /// Centre in spacings: lobe (i, j) is at (i + ½, j + ½).
    pub centre: [f64; 2],
    /// The columns of E, Σp = E Eᵀ.
    pub half_edges: [[f64; 2]; 2],
    /// Whether all columns, and all rows, weigh alike.
    pub even: [bool; 2],
    /// Columns and rows of the lattice.
    pub size: [f64; 2],
    /// Whether the map repeats.
    pub is_repeated: bool,
}

impl Placed {
    /// `footprint` on the lattice `lattice` over a map of `width` × `height` texels.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`], [`QueryError::FootprintTooLarge`].
    pub fn new(
        footprint: &Footprint,
        [width, height]: [u32; 2],
        wrap: Wrap,
        lattice: LobeLattice,
    ) -> Result<Self, QueryError> {
        let placement = Placement::new(footprint, width, height, wrap)?;
        let per_side = f64::from(lattice.per_side);
        let [x, y] = placement.cell;
        let [dx, dy] = placement.centre;
        let half_edges = [placement.edge_1, placement.edge_2]
            .map(|edge| edge.map(|component| 0.5 * per_side * component));
        let size = lattice.size(width, height).map(f64::from);
        let even = match wrap {
            Wrap::Repeat => even_axes(half_edges, size),
            Wrap::Clamp => [false; 2],
        };
        Ok(Self {
            centre: [per_side * (x + dx), per_side * (y + dy)],
            half_edges,
            even,
            size,
            is_repeated: wrap == Wrap::Repeat,
        })
    }

    /// The least and the greatest variance in any direction that does not weigh all lobes alike, σh² of the lobes included.
    pub fn variances(&self) -> [f64; 2] {
        self.footprint_variances()
            .map(|variance| POSITION_VARIANCE + variance)
    }

    /// The same of the footprint alone; infinite in directions that weigh all lobes alike.
    pub fn footprint_variances(&self) -> [f64; 2] {
        let [xx, yy, _] = covariance(self.half_edges);
        match self.even {
            [true, true] => [f64::INFINITY; 2],
            [false, true] => [xx, f64::INFINITY],
            [true, false] => [yy, f64::INFINITY],
            [false, false] => {
                let area = cross(self.half_edges);
                let sum = xx + yy;
                let root = libm::sqrt(((sum - 2.0 * area) * (sum + 2.0 * area)).max(0.0));
                let greatest = 0.5 * (sum + root);
                let least = if greatest > 0.0 {
                    area * area / greatest
                } else {
                    0.0
                };
                [least, greatest]
            }
        }
    }
}

/// `|e1 × e2|` of the columns of E: the root of det Σp.
pub(in crate::ndf) fn cross([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    (a * d - b * c).abs()
}

/// xx, yy and xy of Σp.
pub(in crate::ndf) fn covariance([[a, b], [c, d]]: [[f64; 2]; 2]) -> [f64; 3] {
    [a * a + c * c, b * b + d * d, a * b + c * d]
}

/// Whether the copies of a repeating Gaussian add up evenly along x, and along y.
///
/// The wave of the wave vector g has the amplitude `exp(-2π² gᵀ Σ g)`, in tiles. Of all with a given component along y, the
/// least exponent is that of the variance of y given x, and likewise for x.
fn even_axes(half_edges: [[f64; 2]; 2], [width, height]: [f64; 2]) -> [bool; 2] {
    let [xx, yy, _] = covariance(half_edges);
    let area = cross(half_edges);
    let is_even =
        |other: f64, side: f64| other > 0.0 && area / libm::sqrt(other) >= EVEN_TILES * side;
    // Where an axis has no extent at all, the other varies by itself.
    let alone =
        |own: f64, other: f64, side: f64| other == 0.0 && libm::sqrt(own) >= EVEN_TILES * side;
    [
        is_even(yy, width) || alone(xx, yy, width),
        is_even(xx, height) || alone(yy, xx, height),
    ]
}

/// `Σ N(u; i, S)` over all points i of an endless lattice of spacing 1, where u lies `offset` from one of them: by Poisson's
/// summation, `1 + 2 Σ exp(-2π² gᵀ S g) cos(2π g·u)` over half of the whole wave vectors g.
///
/// Lobes are as wide as they are so that this is nearly 1, but it ranges from 0.89 to 1.12 under the least footprints. Left out are
/// waves of less than 1e-9, as S is at least σh². Axes that weigh evenly have no waves.
pub(in crate::ndf) fn lattice_sum(
    offset: [f64; 2],
    [xx, yy, xy]: [f64; 3],
    even: [bool; 2],
) -> f64 {
    const WAVES: [[f64; 2]; 10] = [
        [1.0, 0.0],
        [0.0, 1.0],
        [1.0, 1.0],
        [1.0, -1.0],
        [2.0, 0.0],
        [0.0, 2.0],
        [2.0, 1.0],
        [2.0, -1.0],
        [1.0, 2.0],
        [1.0, -2.0],
    ];
    let mut sum = 1.0;
    for [x, y] in WAVES {
        if (even[0] && x != 0.0) || (even[1] && y != 0.0) {
            continue;
        }
        let exponent = 2.0 * PI * PI * (x * x * xx + y * y * yy + 2.0 * x * y * xy);
        if exponent < 22.0 {
            let phase = 2.0 * PI * (x * offset[0] + y * offset[1]);
            sum += 2.0 * libm::exp(-exponent) * libm::cos(phase);
        }
    }
    sum
}

/// The tiles of `side` that the interval meets.
pub(in crate::ndf) fn span(low: f64, high: f64, side: f64) -> Range<i64> {
    let first = libm::floor(low / side) as i64;
    let last = libm::floor(high / side) as i64;
    first..last.saturating_add(1)
}
