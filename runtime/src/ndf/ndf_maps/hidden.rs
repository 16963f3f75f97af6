//! What the neighbours of a copy hide of it.
//!
//! A neighbour hides what it covers where its centre is the nearer one: five half planes. \[XTXW24\] §6.2 gives quarters of an
//! overlap to the nearer centre; point by point, the rule leaves no doubt where more than two overlap.

use super::frame::{Frame, Plane, Region};
use super::scattered::Candidate;
use glintbake_format::view::{MAX_NEIGHBOURS, NdfMaps};

/// The most pieces that neighbours leave of a tile. More are taken for hidden; no tile of a package that this project bakes has as
/// many.
const MAX_PIECES: usize = 24;

/// What one neighbour hides: the points where all of these are positive.
type Shadow = [Plane; 5];

/// What the neighbours of one copy hide.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hidden {
    shadows: [Shadow; MAX_NEIGHBOURS],
    count: usize,
}

const NOTHING: Plane = Plane {
    constant: 0.0,
    slope: [0.0; 2],
};

impl Hidden {
    /// Nothing.
    pub const NONE: Self = Self {
        shadows: [[NOTHING; 5]; MAX_NEIGHBOURS],
        count: 0,
    };

    /// What the neighbours of `candidate` hide under the footprint.
    pub fn of(maps: &NdfMaps<'_>, frame: &Frame, candidate: &Candidate) -> Self {
        let mut hidden = Self::NONE;
        let Candidate {
            number,
            copied,
            shift,
            ..
        } = *candidate;
        let size = f64::from(maps.layout.size);
        let example = f64::from(maps.layout.example());
        for neighbour in maps.neighbours_of(number) {
            let Some(other) = maps.copied(neighbour.get() as usize) else {
                continue;
            };
            // The shorter way around the surface.
            let shorter = |axis: f64| axis - size * libm::round(axis / size);
            let apart = [
                shorter(other.centre[0] - copied.centre[0]),
                shorter(other.centre[1] - copied.centre[1]),
            ];
            let centre = [
                copied.centre[0] + shift[0] + apart[0],
                copied.centre[1] + shift[1] + apart[1],
            ];
            let there = [centre[0] - other.centre[0], centre[1] - other.centre[1]];
            let [x, y] = frame.of_copy(&other, there, example).axes;
            let [first, second] = frame.edges;
            let dot = |[p, q]: [f64; 2]| p * apart[0] + q * apart[1];
            let nearer = Plane {
                constant: dot([
                    frame.centre[0] - centre[0] + 0.5 * apart[0],
                    frame.centre[1] - centre[1] + 0.5 * apart[1],
                ]),
                slope: [dot(first), dot(second)],
            };
            let beyond = |axis: Plane| Plane {
                constant: example - axis.constant,
                slope: axis.slope.map(|x| -x),
            };
            let shadow = [nearer, x, beyond(x), y, beyond(y)];
            // What lies wholly beyond the footprint hides nothing of it.
            if shadow.iter().all(|plane| plane.range()[1] > 0.0)
                && let Some(slot) = hidden.shadows.get_mut(hidden.count)
            {
                *slot = shadow;
                hidden.count += 1;
            }
        }
        hidden
    }

    /// The names of all shadows.
    pub const fn all(&self) -> Shadows {
        if self.count >= 64 {
            Shadows(u64::MAX)
        } else {
            Shadows((1 << self.count) - 1)
        }
    }

    fn each(&self, shadows: Shadows) -> impl Iterator<Item = (usize, &Shadow)> {
        self.shadows
            .iter()
            .take(self.count)
            .enumerate()
            .filter(move |(place, _)| shadows.0 >> place & 1 == 1)
    }

    /// Those of `shadows` that hide a part of `region`, and its area that they do not hide.
    pub fn left(&self, region: &Region, shadows: Shadows) -> (Shadows, f64) {
        let area = region.area();
        if shadows.0 == 0 || area <= 0.0 {
            return (shadows, area);
        }
        let mut met = Shadows(0);
        let mut hidden = 0.0;
        for (place, shadow) in self.each(shadows) {
            let mut part = *region;
            for plane in shadow {
                let corners = part.corners();
                let is_within = |corner: &[f64; 2]| plane.at(*corner) >= 0.0;
                if corners.iter().all(is_within) {
                    continue;
                }
                plane.above(0.0, &mut part);
                if part.is_empty() {
                    break;
                }
            }
            let own = part.area();
            if own > 1e-12 * area {
                met.0 |= 1 << place;
                hidden += own;
            }
        }
        if met.0.count_ones() < 2 {
            return (met, (area - hidden).max(0.0));
        }
        // Shadows overlap.
        let left = self.pieces(region, met);
        (met, left.regions().iter().map(Region::area).sum())
    }

    /// The pieces of `region` that `shadows` do not hide.
    pub fn pieces(&self, region: &Region, shadows: Shadows) -> Pieces {
        let mut pieces = Pieces::of(region);
        for (_, shadow) in self.each(shadows) {
            pieces = pieces.without(shadow);
        }
        pieces
    }
}

/// Which neighbours are meant, a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shadows(u64);

impl Shadows {
    pub const NONE: Self = Self(0);
}

/// Convex pieces of a region.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pieces {
    regions: [Region; MAX_PIECES],
    count: usize,
}

impl Pieces {
    fn of(region: &Region) -> Self {
        let mut pieces = Self {
            regions: [Region::EMPTY; MAX_PIECES],
            count: 0,
        };
        pieces.push(region);
        pieces
    }

    fn push(&mut self, region: &Region) {
        if !region.is_empty()
            && let Some(slot) = self.regions.get_mut(self.count)
        {
            *slot = *region;
            self.count += 1;
        }
    }

    pub fn regions(&self) -> &[Region] {
        self.regions.get(..self.count).unwrap_or_default()
    }

    fn without(&self, shadow: &Shadow) -> Self {
        let mut left = Self {
            regions: [Region::EMPTY; MAX_PIECES],
            count: 0,
        };
        for piece in self.regions() {
            let mut inside = *piece;
            for plane in shadow {
                let mut outside = inside;
                plane.negated().above(0.0, &mut outside);
                left.push(&outside);
                plane.above(0.0, &mut inside);
                if inside.is_empty() {
                    break;
                }
            }
        }
        left
    }
}
