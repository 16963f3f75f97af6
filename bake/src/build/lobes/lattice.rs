//! Lobes of a map: normal and slope at each point of the lattice.

use crate::normals::NormalMap;
use glintbake_format::model::{LobeLattice, Wrap};
use glintbake_format::view::LobeNormal;

/// The lobes of one map.
#[derive(Clone, Copy)]
pub(in crate::build) struct Lattice<'m> {
    map: &'m NormalMap,
    kind: LobeLattice,
}

impl<'m> Lattice<'m> {
    pub fn new(map: &'m NormalMap, kind: LobeLattice) -> Self {
        Self { map, kind }
    }

    /// Columns and rows of lobes.
    pub fn size(&self) -> [u32; 2] {
        self.kind.size(self.map.width(), self.map.height())
    }

    /// The lobe in `column` and `row`, its slope per spacing of the lattice.
    pub fn lobe(&self, column: u32, row: u32) -> LobeNormal {
        let (x, y) = (i64::from(column), i64::from(row));
        let lobe = if self.kind.per_side == 1 {
            self.at_middle(x, y)
        } else {
            self.at_quarter(x, y)
        };
        if self.kind.curved {
            lobe
        } else {
            LobeNormal {
                slope: [0.0; 4],
                ..lobe
            }
        }
    }

    /// At the middle of a texel; the slope is half the difference of the texels to either side.
    fn at_middle(&self, x: i64, y: i64) -> LobeNormal {
        if !self.kind.curved {
            return LobeNormal {
                normal: self.texel(x, y),
                slope: [0.0; 4],
            };
        }
        let half = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] - b[0]), 0.5 * (a[1] - b[1])];
        let [s_x, t_x] = half(self.texel(x + 1, y), self.texel(x - 1, y));
        let [s_y, t_y] = half(self.texel(x, y + 1), self.texel(x, y - 1));
        LobeNormal {
            normal: self.texel(x, y),
            slope: [s_x, s_y, t_x, t_y],
        }
    }

    /// A quarter of a texel beside the middle, by bilinear interpolation of the four texels about the point.
    fn at_quarter(&self, x: i64, y: i64) -> LobeNormal {
        // An even number is the first of its texel's two: between the texel before, at 1/4, and its own, at 3/4.
        let part = |place: i64| {
            let before = (place + 1).div_euclid(2) - 1;
            (before, if place.rem_euclid(2) == 0 { 0.75 } else { 0.25 })
        };
        let ((i, p), (j, q)) = (part(x), part(y));
        let corners = [
            self.texel(i, j),
            self.texel(i + 1, j),
            self.texel(i, j + 1),
            self.texel(i + 1, j + 1),
        ];
        let component = |axis: usize| {
            let [a, b, c, d] = corners.map(|corner| corner[axis]);
            let value = (1.0 - q) * ((1.0 - p) * a + p * b) + q * ((1.0 - p) * c + p * d);
            // Half of the slope per texel: two lobes a texel.
            let along = 0.5 * ((1.0 - q) * (b - a) + q * (d - c));
            let down = 0.5 * ((1.0 - p) * (c - a) + p * (d - b));
            (value, along, down)
        };
        let ((s, s_x, s_y), (t, t_x, t_y)) = (component(0), component(1));
        LobeNormal {
            normal: [s, t],
            slope: [s_x, s_y, t_x, t_y],
        }
    }

    /// The normal of a texel of the endless map.
    fn texel(&self, x: i64, y: i64) -> [f64; 2] {
        let place = |x: i64, side: u32| match self.map.wrap() {
            Wrap::Repeat => x.rem_euclid(i64::from(side)),
            Wrap::Clamp => x.clamp(0, i64::from(side) - 1),
        } as usize;
        let (x, y) = (place(x, self.map.width()), place(y, self.map.height()));
        self.map.texels()[y * self.map.width() as usize + x].map(f64::from)
    }
}
