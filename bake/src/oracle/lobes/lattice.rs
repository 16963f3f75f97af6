//! The lobes that stand for a map, before any footprint: place, normal and slope.

use crate::normals::NormalMap;
use glintbake_format::model::{LobeLattice, Wrap};

/// The plane of normals of one lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::oracle) struct Seed {
    /// The point (s, t) at the lobe's middle.
    pub(in crate::oracle) normal: [f64; 2],
    /// Change of (s, t) per texel along columns, then along rows.
    pub(in crate::oracle) slope: [[f64; 2]; 2],
}

/// Texel `index` of the endless axis on an axis of `size` texels.
fn folded(index: i64, size: u32, wrap: Wrap) -> usize {
    let size = i64::from(size);
    let texel = match wrap {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::Clamp => index.clamp(0, size - 1),
    };
    // Below the size, which came from a u32.
    texel as usize
}

/// The texels on both sides of lobe `index`, with their shares; at the middle of a texel, the texel twice.
fn neighbours(index: i64, per_side: u8) -> [(i64, f64); 2] {
    if per_side == 1 {
        return [(index, 1.0), (index, 0.0)];
    }
    let texel = index.div_euclid(2);
    if index.rem_euclid(2) == 0 {
        [(texel - 1, 0.25), (texel, 0.75)]
    } else {
        [(texel, 0.75), (texel + 1, 0.25)]
    }
}

/// The lobe at (`column`, `row`) of the lattice, as the map's wrap mode continues it.
///
/// # Panics
/// If there are neither one nor two lobes a side of a texel.
pub(in crate::oracle) fn seed(
    map: &NormalMap,
    lattice: LobeLattice,
    column: i64,
    row: i64,
) -> Seed {
    assert!(
        matches!(lattice.per_side, 1 | 2),
        "{} lobes a side of a texel",
        lattice.per_side
    );
    let texel = |i: i64, j: i64| {
        let column = folded(i, map.width(), map.wrap());
        let row = folded(j, map.height(), map.wrap());
        map.texels()[row * map.width() as usize + column].map(f64::from)
    };
    let columns = neighbours(column, lattice.per_side);
    let rows = neighbours(row, lattice.per_side);
    let mut normal = [0.0; 2];
    for (j, down) in rows {
        for (i, across) in columns {
            let value = texel(i, j);
            for axis in 0..2 {
                normal[axis] += across * down * value[axis];
            }
        }
    }
    let mut slope = [[0.0; 2]; 2];
    if lattice.curved && lattice.per_side == 1 {
        let halved = |before: [f64; 2], after: [f64; 2]| {
            [0.5 * (after[0] - before[0]), 0.5 * (after[1] - before[1])]
        };
        slope = [
            halved(texel(column - 1, row), texel(column + 1, row)),
            halved(texel(column, row - 1), texel(column, row + 1)),
        ];
    } else if lattice.curved {
        // The slope along one axis of a bilinear patch is the interpolation of its two sides' along the other.
        let rise = |from: [f64; 2], to: [f64; 2], share: f64, sum: &mut [f64; 2]| {
            for axis in 0..2 {
                sum[axis] += share * (to[axis] - from[axis]);
            }
        };
        let [(left, _), (right, _)] = columns;
        let [(above, _), (below, _)] = rows;
        for (j, down) in rows {
            rise(texel(left, j), texel(right, j), down, &mut slope[0]);
        }
        for (i, across) in columns {
            rise(texel(i, above), texel(i, below), across, &mut slope[1]);
        }
    }
    Seed { normal, slope }
}
