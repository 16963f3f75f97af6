//! A walk down a box pyramid: to every block whose cells the footprint reaches and whose normals the half vector does.
//!
//! Distances are in standard deviations, of the footprint for positions and of the kernel for normals; a cell is passed over if
//! the sum of both, squared, is beyond the reach, as then no point of it has more than `exp(-reach² / 2)` of the peak.
//!
//! Normals of lobes spread over their positions. A lobe of slope J and position variance a = σh² under a footprint has its mean
//! at `s_i` + J K d, `|K d| ≤ √(a κ) |p|` with κ = a / λ, λ the least variance of S = a I + Σp and p the whitened distance, and the
//! variance J Q Jᵀ, `|Q| ≤ a (1 - a / Λ)`, Λ the greatest. With w = √a |J| its normals are so at most `w √κ reach` off and their
//! variance at most `w² (1 - a / Λ)` larger: `drift` and `blur`.
#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
)]

use crate::error::QueryError;
use crate::lanes::{BITS, LANES, Lanes, max};
use crate::simd::fetch;
use glintbake_format::model::PYRAMID_SIDE;
use glintbake_format::records::{BoxNode, LobeSpreads};
use glintbake_format::view::{BoxPyramid, PyramidBox};

/// What a walk looks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    /// The footprint's centre, in cells; cell (i, j) covers [i, i+1) × [j, j+1).
    pub centre: [f64; 2],
    /// `[a, b, c]` such that a point (x, y) off the centre is `(a x + b y, c y)` deviations away. All zero if every point
    /// weighs alike.
    pub whiten: [f64; 3],
    /// The half vector.
    pub normal: [f64; 2],
    /// One over the kernel's standard deviation.
    pub scale: f64,
    /// The square of the reach.
    pub reach_squared: f64,
    /// How far, at most, a normal moves with the footprint's place, of what its lobe spreads.
    pub drift: f64,
    /// How much of the square of what it spreads is left as its variance.
    pub blur: f64,
}

/// A cell that a walk has come to: a block of 4 × 4 cells of the grid on level 0, else what a node stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub level: u32,
    /// Column and row on its level.
    pub column: u32,
    pub row: u32,
    /// The place of the node that it is a child of, and which child.
    pub parent: usize,
    pub child: u32,
    /// Its box of normals.
    pub bounds: PyramidBox,
}

/// Who is told of cells.
pub(super) trait Visitor {
    /// How far lobes spread in the children of the node at `place`: `[s; 16]` in units of the first number. Of surfaces, not
    /// at all.
    #[inline(always)]
    fn spreads(&self, place: usize) -> Option<&LobeSpreads> {
        let _ = place;
        None
    }

    /// The node at `place` will be opened soon.
    #[inline(always)]
    fn expect(&self, place: usize) {
        let _ = place;
    }

    /// A cell within reach; whether it is done with. Blocks always are.
    fn cell(&mut self, cell: &Cell) -> Result<bool, QueryError>;
}

/// A node to open.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    bounds: PyramidBox,
    level: u32,
    column: u32,
    row: u32,
}

/// Nodes that may wait: a power of two.
const ROOM: usize = 256;
/// From this many on the newest is opened first, so that the subtree of each has room: 15 more for each of eight levels.
const CROWDED: usize = ROOM - 128;

/// Columns and rows of children, from the middle of their node.
const ACROSS: Lanes = {
    let mut lanes = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        lanes[lane] = (lane % 4) as f32 - 1.5;
        lane += 1;
    }
    lanes
};
const DOWN: Lanes = {
    let mut lanes = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        lanes[lane] = (lane / 4) as f32 - 1.5;
        lane += 1;
    }
    lanes
};

/// Tells `visitor` of every block of `pyramid` within reach, and of every node above one.
///
/// O(nodes within reach), on a stack of some 20 KB.
///
/// # Errors
/// What `visitor` returns, and [`QueryError::Damaged`].
#[inline(always)]
pub(super) fn walk<V: Visitor>(
    pyramid: &BoxPyramid<'_>,
    query: &Query,
    visitor: &mut V,
) -> Result<(), QueryError> {
    let top = Waiting {
        bounds: pyramid.root,
        level: pyramid.layout.top(),
        column: 0,
        row: 0,
    };
    let mut waiting = [top; ROOM];
    let (mut first, mut end) = (0_usize, 1_usize);
    while first != end {
        // Oldest first, so that what they need has had time to come from memory.
        let at = if end.wrapping_sub(first) < CROWDED {
            first = first.wrapping_add(1);
            first.wrapping_sub(1)
        } else {
            end = end.wrapping_sub(1);
            end
        };
        let node = waiting[at % ROOM];
        let parent = pyramid.layout.place(node.level, node.column, node.row);
        let stored = pyramid.node(node.level, node.column, node.row)?;
        let mut found = within_reach(stored, visitor.spreads(parent), &node, query);
        let level = node.level.wrapping_sub(1);
        while found != 0 {
            let child = found.trailing_zeros();
            found &= found.wrapping_sub(1);
            let Some(bounds) = node.bounds.child(stored, child) else {
                continue;
            };
            let cell = Cell {
                level,
                column: node
                    .column
                    .wrapping_mul(PYRAMID_SIDE)
                    .wrapping_add(child % PYRAMID_SIDE),
                row: node
                    .row
                    .wrapping_mul(PYRAMID_SIDE)
                    .wrapping_add(child / PYRAMID_SIDE),
                parent,
                child,
                bounds,
            };
            if visitor.cell(&cell)? || level == 0 {
                continue;
            }
            let place = pyramid.layout.place(level, cell.column, cell.row);
            if let Some(node) = pyramid.nodes.get(place) {
                fetch(node);
            }
            visitor.expect(place);
            waiting[end % ROOM] = Waiting {
                bounds,
                level,
                column: cell.column,
                row: cell.row,
            };
            end = end.wrapping_add(1);
        }
    }
    Ok(())
}

/// Which children of a node are within reach, a bit each.
#[inline(always)]
fn within_reach(
    stored: &BoxNode,
    spreads: Option<&LobeSpreads>,
    node: &Waiting,
    query: &Query,
) -> u32 {
    // Cells along a side of a child.
    let side = f64::from(1_u32 << (node.level.wrapping_mul(2) & 31));
    let [a, b, c] = query.whiten;
    let x = (f64::from(node.column) + 0.5) * 4.0 * side - query.centre[0];
    let y = (f64::from(node.row) + 0.5) * 4.0 * side - query.centre[1];
    let first = (a * x + b * y) as f32;
    let second = (c * y) as f32;
    let [a, b, c] = [a, b, c].map(|factor| (factor * side) as f32);
    let half_first = 0.5 * (a.abs() + b.abs());
    let half_second = 0.5 * c.abs();
    let low =
        [0, 1].map(|axis| ((node.bounds.low[axis] - query.normal[axis]) * query.scale) as f32);
    let step = [0, 1].map(|axis| (node.bounds.step[axis] * query.scale) as f32);
    // Far beyond what rounding to f32 does to distances.
    let reach = query.reach_squared as f32 * 1.001;
    let (greatest, unit) = match spreads {
        Some(spreads) => (
            &spreads.greatest,
            f64::from(spreads.step.get()) * query.scale,
        ),
        None => (&[0; LANES], 0.0),
    };
    let drift = (unit * query.drift) as f32;
    let blur = (unit * unit * query.blur) as f32;
    let mut bits = [0_u32; LANES];
    for lane in 0..LANES {
        let (low_s, high_s) = (
            f32::from(stored.low_s[lane]),
            f32::from(stored.high_s[lane]),
        );
        let (low_t, high_t) = (
            f32::from(stored.low_t[lane]),
            f32::from(stored.high_t[lane]),
        );
        let spread = f32::from(greatest[lane]);
        let off = spread * drift;
        let s = max(low[0] + low_s * step[0], -(low[0] + high_s * step[0])) - off;
        let t = max(low[1] + low_t * step[1], -(low[1] + high_t * step[1])) - off;
        let (s, t) = (max(s, 0.0), max(t, 0.0));
        let along = max(
            (first + a * ACROSS[lane] + b * DOWN[lane]).abs() - half_first,
            0.0,
        );
        let across = max((second + c * DOWN[lane]).abs() - half_second, 0.0);
        let left = reach - (along * along + across * across);
        let is_near = s * s + t * t <= left * (1.0 + blur * spread * spread);
        let is_there = (low_s <= high_s) & (low_t <= high_t);
        bits[lane] = if is_near & is_there { BITS[lane] } else { 0 };
    }
    let mut all = 0;
    for lane in 0..LANES {
        all |= bits[lane];
    }
    all
}
