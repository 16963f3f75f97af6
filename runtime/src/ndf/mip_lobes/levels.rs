//! Which levels answer for a footprint, and how much each.

use crate::ndf::lobes::placed::Placed;
use crate::overlap::EVEN_TILES;
use glintbake_format::model::MipLayout;

/// Binary logarithm of how many times as long as wide a footprint may be before its level is that of a wider one.
const LONGEST: f64 = 3.0;

/// How a level is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choice {
    /// Whether by the area alone, as \[TZX22\] eq. 8 has it; else by how wide the footprint is.
    pub is_by_area: bool,
    /// Levels above that, or below it if negative.
    pub bias: f64,
}

/// A level, and its share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share {
    /// `None` for the lobes themselves, below all levels.
    pub level: Option<u8>,
    pub share: f64,
}

impl Choice {
    /// λ: 0 for a footprint as wide as a texel.
    ///
    /// By area, λ = ½ log2 of it in texels, the paper's eq. 8 with C = ½: with the edges 2σ of a footprint along its axes, log2 of their
    /// geometric mean. That blurs long footprints across as far as along; so unless asked for, the shorter edge alone decides, up
    /// to a length of eight times that.
    fn lambda(self, layout: &MipLayout, placed: &Placed) -> f64 {
        let [least, greatest] = placed.footprint_variances();
        // log2 of 2σ; at most what it is when all of the surface begins to weigh evenly, which is as if σ were infinite.
        let most = f64::from(layout.top()) + libm::log2(2.0 * EVEN_TILES);
        let edge = |variance: f64| (1.0 + 0.5 * libm::log2(variance.max(1e-12))).min(most);
        let (short, long) = (edge(least), edge(greatest));
        let lambda = if self.is_by_area {
            0.5 * (short + long)
        } else {
            short.max(long - LONGEST)
        };
        lambda + self.bias
    }

    /// The levels of `layout` that answer, and their shares, of 1 together.
    ///
    /// Between two levels both count: `1 - frac λ` for the lower, `frac λ` for the upper one, which \[TZX22\] eq. 9 prints the other way
    /// round.
    pub fn levels(self, layout: &MipLayout, placed: &Placed) -> [Share; 2] {
        let (first, top) = (f64::from(layout.first_level), f64::from(layout.top()));
        let only = |level: Option<u8>| [Share { level, share: 1.0 }, Share { level, share: 0.0 }];
        let lambda = self.lambda(layout, placed);
        if first > top || lambda <= first - 1.0 {
            return only(None);
        }
        if lambda >= top {
            return only(Some(layout.top()));
        }
        let lower = libm::floor(lambda);
        let upper_share = lambda - lower;
        let level = |level: f64| (level >= first).then_some(level as u8);
        [
            Share {
                level: level(lower),
                share: 1.0 - upper_share,
            },
            Share {
                level: level(lower + 1.0),
                share: upper_share,
            },
        ]
    }
}
