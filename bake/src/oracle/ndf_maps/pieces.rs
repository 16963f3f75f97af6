//! Which straight pieces of lines a footprint shows, and of which copy each is.

use super::{Piece, Prepared, Surface, inverse, times};
use crate::oracle::gauss_legendre::GaussLegendre;

/// A copy that may be seen, its centre in texels from that of the footprint.
pub(super) struct Near {
    pub(super) copy: usize,
    pub(super) centre: [f64; 2],
    /// Rows of M⁻¹.
    pub(super) inverse: [[f64; 2]; 2],
}

impl Surface {
    /// The copies within `reach` texels of `centre`, with the tiles of texture space they are in; of tiled ones, the first.
    pub(super) fn near(&self, centre: [f64; 2], reach: f64) -> Vec<Near> {
        if !self.is_scattered {
            let copy = self.copies[0];
            return vec![Near {
                copy: 0,
                centre: copy.centre,
                inverse: inverse(copy.matrix),
            }];
        }
        let size = f64::from(self.size);
        let half = 0.5 * f64::from(self.example.width());
        let mut near = Vec::new();
        for (number, copy) in self.copies.iter().enumerate() {
            let [[xx, xy], [yx, yy]] = copy.matrix;
            // No corner is farther than all entries together take it.
            let own = half * (xx.abs() + xy.abs() + yx.abs() + yy.abs());
            let tiles = |axis: usize| {
                let from = copy.centre[axis] - centre[axis];
                let low = ((-reach - own - from) / size).ceil() as i64;
                low..=((reach + own - from) / size).floor() as i64
            };
            for row in tiles(1) {
                for column in tiles(0) {
                    let shift = [column as f64 * size, row as f64 * size];
                    near.push(Near {
                        copy: number,
                        centre: [0, 1].map(|axis| copy.centre[axis] - centre[axis] + shift[axis]),
                        inverse: inverse(copy.matrix),
                    });
                }
            }
        }
        near
    }
}

impl Prepared {
    /// Adds the pieces of rows of the one example that the tiled footprint `centre + a e1 + b e2` shows.
    ///
    /// Rows a whole number of examples apart are one, and of a row the whole examples are one that counts as often, beside what is
    /// left of it.
    pub(super) fn fold(
        &mut self,
        only: &Near,
        centre: [f64; 2],
        [e1, e2]: [[f64; 2]; 2],
        width: f64,
        rule: &GaussLegendre,
    ) {
        let side = f64::from(self.surface.example.width());
        let from = [0, 1].map(|axis| centre[axis] - only.centre[axis]);
        let middle = times(only.inverse, from).map(|x| x + 0.5 * side);
        let [e1, e2] = [e1, e2].map(|edge| times(only.inverse, edge));
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
            .map(|(a, b)| [0, 1].map(|axis| middle[axis] + a * e1[axis] + b * e2[axis]));
        let area = (e1[0] * e2[1] - e1[1] * e2[0]).abs();
        let rows = corners.map(|[_, y]| y);
        let top = rows.into_iter().fold(f64::INFINITY, f64::min);
        let bottom = rows.into_iter().fold(f64::NEG_INFINITY, f64::max);
        // Where a corner lies, what rows show has a bend, or begins.
        let mut cuts = vec![0.0, side];
        cuts.extend(rows.map(|y| y.rem_euclid(side)));
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2) {
            // Where sides run almost along rows, what rows show changes the faster.
            let shift = steepest_at(&corners, side, 0.5 * (pair[0] + pair[1]));
            for (y, share) in strips(rule, pair[0], pair[1], width / shift.max(1.0)) {
                let mut whole = 0.0;
                let mut example = ((top - y) / side).floor();
                while y + example * side < bottom {
                    if let Some([left, right]) = across_at(&corners, y + example * side) {
                        let examples = ((right - left) / side).floor();
                        whole += examples;
                        let rest = [left + examples * side, right];
                        self.pieces.push(row(y, rest, share / area));
                    }
                    example += 1.0;
                }
                if whole > 0.0 {
                    self.pieces.push(row(y, [0.0, side], whole * share / area));
                }
            }
        }
    }

    /// Adds the pieces of the line through `middle` along `along`, its centre being `from_centre` of the footprint at `centre`.
    pub(super) fn line(
        &mut self,
        near: &[Near],
        centre: [f64; 2],
        middle: [f64; 2],
        along: [f64; 2],
        weight: f64,
    ) {
        let half = 0.5 * f64::from(self.surface.example.width());
        if !self.surface.is_scattered {
            let [only] = near else { return };
            // Copies go on without end, as the wrapped example does.
            let from = [0, 1].map(|axis| centre[axis] + middle[axis] - only.centre[axis]);
            self.pieces.push(Piece {
                copy: 0,
                origin: times(only.inverse, from).map(|x| x + half),
                step: times(only.inverse, along),
                range: [-0.5, 0.5],
                weight,
            });
            return;
        }
        let mut cuts = vec![-0.5, 0.5];
        // The copies that the line crosses.
        let mut met: Vec<&Near> = Vec::new();
        for own in near {
            let from = [0, 1].map(|axis| middle[axis] - own.centre[axis]);
            let (at, step) = (times(own.inverse, from), times(own.inverse, along));
            let (mut first, mut last) = (-0.5_f64, 0.5_f64);
            for axis in 0..2 {
                if step[axis] == 0.0 {
                    if at[axis].abs() > half {
                        last = first - 1.0;
                    }
                    continue;
                }
                let ends = [-half, half].map(|end| (end - at[axis]) / step[axis]);
                first = first.max(ends[0].min(ends[1]));
                last = last.min(ends[0].max(ends[1]));
            }
            if first <= last {
                cuts.extend([first, last]);
                met.push(own);
            }
        }
        for (place, own) in met.iter().enumerate() {
            for other in &met[..place] {
                // |p - c|² = |p - d|², linear in a.
                let apart = [0, 1].map(|axis| other.centre[axis] - own.centre[axis]);
                let rise = apart[0] * along[0] + apart[1] * along[1];
                let reach: f64 = (0..2)
                    .map(|axis| {
                        let between = 0.5 * (own.centre[axis] + other.centre[axis]);
                        apart[axis] * (between - middle[axis])
                    })
                    .sum();
                if rise != 0.0 {
                    cuts.push(reach / rise);
                }
            }
        }
        cuts.retain(|cut| (-0.5..=0.5).contains(cut));
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2) {
            let length = pair[1] - pair[0];
            if length <= 0.0 {
                continue;
            }
            let a = 0.5 * (pair[0] + pair[1]);
            let point = [0, 1].map(|axis| middle[axis] + a * along[axis]);
            let Some(owner) = owner(&met, point, half) else {
                self.bare += weight * length;
                continue;
            };
            let from = [0, 1].map(|axis| middle[axis] - owner.centre[axis]);
            self.pieces.push(Piece {
                copy: owner.copy,
                origin: times(owner.inverse, from).map(|x| x + half),
                step: times(owner.inverse, along),
                range: [pair[0], pair[1]],
                weight,
            });
        }
    }
}

/// Where strips of at most `width` have their lines between `from` and `to`, and what part of the whole each stands for.
pub(super) fn strips(
    rule: &GaussLegendre,
    from: f64,
    to: f64,
    width: f64,
) -> impl Iterator<Item = (f64, f64)> + '_ {
    let count = ((to - from) / width).ceil().max(1.0) as usize;
    (0..count).flat_map(move |strip| {
        let edge = |strip: usize| from + (to - from) * strip as f64 / count as f64;
        rule.nodes(edge(strip), edge(strip + 1))
    })
}

/// From where to where the row `y` is in the convex figure of `corners`.
fn across_at(corners: &[[f64; 2]; 4], y: f64) -> Option<[f64; 2]> {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for (place, from) in corners.iter().enumerate() {
        let to = corners[(place + 1) % corners.len()];
        if (from[1] < y) != (to[1] < y) {
            let x = from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
            left = left.min(x);
            right = right.max(x);
        }
    }
    (left < right).then_some([left, right])
}

/// How far a side of `corners` moves along the row `y`, or one whole examples of `side` away, from row to row, at most.
fn steepest_at(corners: &[[f64; 2]; 4], side: f64, y: f64) -> f64 {
    let mut steepest: f64 = 0.0;
    for (place, from) in corners.iter().enumerate() {
        let to = corners[(place + 1) % corners.len()];
        let (top, bottom) = (from[1].min(to[1]), from[1].max(to[1]));
        let last = y + ((bottom - y) / side).floor() * side;
        if last > top {
            steepest = steepest.max(((to[0] - from[0]) / (to[1] - from[1])).abs());
        }
    }
    steepest
}

/// The piece of row `y` of the first copy between two columns.
fn row(y: f64, range: [f64; 2], weight: f64) -> Piece {
    Piece {
        copy: 0,
        origin: [0.0, y],
        step: [1.0, 0.0],
        range,
        weight,
    }
}

/// The nearest centre of all copies that cover `point`.
fn owner<'n>(near: &[&'n Near], point: [f64; 2], half: f64) -> Option<&'n Near> {
    let from = |near: &Near| [0, 1].map(|axis: usize| point[axis] - near.centre[axis]);
    near.iter()
        .copied()
        .filter(|near| {
            times(near.inverse, from(near))
                .iter()
                .all(|x| x.abs() <= half)
        })
        .min_by(|x, y| {
            let square = |near: &Near| {
                let [x, y] = from(near);
                x * x + y * y
            };
            square(x).total_cmp(&square(y))
        })
}
