//! A footprint along one axis of the map, in texels.

use super::double_double::DoubleDouble;
use super::weights::MAX_SPAN_TILES;
use core::ops::RangeInclusive;
use glintbake_format::model::Wrap;

/// Components shorter than this many texels count as zero, which keeps every product within the range of f64.
const SHORTEST_TEXELS: f64 = 1e-100;

/// One coordinate of a footprint and of the texel borders around it, in texels relative to the centre.
///
/// Texels are numbered along the endless axis, texel k between the borders k and k + 1; [`Self::fold`] gives the
/// texel of the map. Coordinates are kept as distances from the centre because a footprint of 1e-4 texel on a map
/// of 16384 columns would otherwise lose eight of its sixteen digits.
pub(super) struct TexelAxis {
    size: u32,
    wrap: Wrap,
    /// The border nearest to the centre, a whole number.
    nearest_border: f64,
    /// Centre minus that border, in [-1/2, 1/2] texel, without rounding error.
    offset: DoubleDouble,
    edges: [DoubleDouble; 2],
}

impl TexelAxis {
    /// The axis of a map `size` texels long, for a footprint given in tiles.
    pub(super) fn new(centre: f64, edges: [f64; 2], size: u32, wrap: Wrap) -> Self {
        let texels = f64::from(size);
        let centre = match wrap {
            // The fraction that truncation leaves is always a f64; `c - floor(c)` is not for small negative c.
            Wrap::Repeat => centre - libm::trunc(centre),
            // Beyond this no footprint reaches the map any more, and nothing changes.
            Wrap::Clamp => centre.clamp(-2.0 * MAX_SPAN_TILES, 2.0 * MAX_SPAN_TILES + 1.0),
        };
        let position = DoubleDouble::product(centre, texels);
        let nearest_border = libm::round(position.value());
        let edges = edges.map(|edge| {
            let component = DoubleDouble::product(edge, texels);
            if component.value().abs() < SHORTEST_TEXELS {
                DoubleDouble::ZERO
            } else {
                component
            }
        });
        Self {
            size,
            wrap,
            nearest_border,
            offset: position - DoubleDouble::from(nearest_border),
            edges,
        }
    }

    /// The component of each edge.
    pub(super) fn edges(&self) -> [DoubleDouble; 2] {
        self.edges
    }

    /// Length of the footprint's shadow on this axis.
    pub(super) fn extent(&self) -> f64 {
        self.edges[0].value().abs() + self.edges[1].value().abs()
    }

    /// Where texels k - 1 and k meet.
    pub(super) fn border(&self, k: i64) -> DoubleDouble {
        DoubleDouble::from(k as f64 - self.nearest_border) - self.offset
    }

    /// Where texel k begins; `None` for a clamped border texel, which extends without end.
    pub(super) fn lower(&self, k: i64) -> Option<DoubleDouble> {
        (self.wrap == Wrap::Repeat || k > 0).then(|| self.border(k))
    }

    /// Where texel k ends; `None` for a clamped border texel, which extends without end.
    pub(super) fn upper(&self, k: i64) -> Option<DoubleDouble> {
        (self.wrap == Wrap::Repeat || k < i64::from(self.size) - 1).then(|| self.border(k + 1))
    }

    /// The texels that hold the positions between `from` and `to`, perhaps with one more on either side.
    pub(super) fn texels_between(&self, from: f64, to: f64) -> RangeInclusive<i64> {
        let (first, last) = (self.texel_at(from), self.texel_at(to));
        match self.wrap {
            Wrap::Repeat => first - 1..=last + 1,
            Wrap::Clamp => {
                let end = i64::from(self.size) - 1;
                (first - 1).clamp(0, end)..=(last + 1).clamp(0, end)
            }
        }
    }

    /// The texel at `position`, before folding; a border belongs to the texel that it begins.
    pub(super) fn texel_at(&self, position: f64) -> i64 {
        let from_border = self.offset + DoubleDouble::from(position);
        let whole = libm::floor(from_border.value());
        // The high half may have been rounded up to a whole number that the sum itself does not reach.
        let below = from_border < DoubleDouble::from(whole);
        self.nearest_border as i64 + whole as i64 - i64::from(below)
    }

    /// The texel of the map that stands at place k of the endless axis.
    pub(super) fn fold(&self, k: i64) -> u32 {
        let size = i64::from(self.size);
        let folded = match self.wrap {
            Wrap::Repeat => k.rem_euclid(size),
            Wrap::Clamp => k.clamp(0, size - 1),
        };
        // Below the size, which came from a u32.
        folded as u32
    }
}
