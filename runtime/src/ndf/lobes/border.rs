//! Beyond the border of a map that does not repeat: flat lobes of the border's normals, without end.

use super::frame::Frame;
use super::gather::REACH;
use super::lattice::Line;
use super::placed::Placed;
use crate::error::QueryError;
use core::f64::consts::PI;
use glintbake_format::view::Lobes;

/// Most rows of a corner that are summed one by one; beyond, runs of as many as needed are taken at their middles.
const MOST_ROWS: f64 = 65_536.0;

/// The lobes beyond each side of the lattice, along one axis.
struct Side {
    /// Centre along rows, and across them.
    centre: [f64; 2],
    /// Number of lobes in a row, and of rows.
    size: [f64; 2],
    /// Variance along rows given the place across, variance across, and how the mean along rows leans.
    given: f64,
    across: f64,
    lean: f64,
}

impl Side {
    fn new(placed: &Placed, frame: &Frame, is_turned: bool) -> Self {
        let turn = |[x, y]: [f64; 2]| if is_turned { [y, x] } else { [x, y] };
        let [xx, yy, xy] = frame.total;
        let [_, across] = turn([xx, yy]);
        // det S = (1 / (2π amplitude))², which was found without cancellation.
        let root = 1.0 / (2.0 * PI * frame.amplitude);
        Self {
            centre: turn(placed.centre),
            size: turn(placed.size),
            given: root * root / across,
            across,
            lean: xy / across,
        }
    }

    /// The Gaussian along a row that is `off` rows from the centre.
    fn line(&self, off: f64) -> Line {
        Line {
            mean: self.centre[0] + self.lean * off,
            variance: self.given,
        }
    }

    /// The share of all that lies in a row `off` from the centre.
    fn share(&self, off: f64) -> f64 {
        libm::exp(-0.5 * off * off / self.across) / libm::sqrt(2.0 * PI * self.across)
    }

    /// What lies before the first lobe of rows `off` from the centre, and what behind the last.
    fn tails(&self, off: f64) -> [f64; 2] {
        let (line, share) = (self.line(off), self.share(off));
        let before = line.below(0.0);
        // Mirrored, what is behind the last lobe is before the first.
        let mirrored = Line {
            mean: self.size[0] - line.mean,
            ..line
        };
        [share * before, share * mirrored.below(0.0)]
    }

    /// The rows within reach from `low` up to `high`.
    fn rows(&self, low: f64, high: f64) -> [f64; 2] {
        let reach = REACH * libm::sqrt(self.across);
        [
            libm::floor(self.centre[1] - reach).clamp(low, high),
            libm::ceil(self.centre[1] + reach).clamp(low, high),
        ]
    }
}

/// Calls `add` with the normal of each flat lobe of the border and the weight, in units of all weights, of those beyond that
/// have it.
///
/// O(lobes of the border within reach).
///
/// # Errors
/// [`QueryError::Damaged`].
pub(super) fn beyond(
    lobes: &Lobes<'_>,
    placed: &Placed,
    frame: &Frame,
    add: &mut dyn FnMut([f64; 2], f64),
) -> Result<(), QueryError> {
    for is_turned in [false, true] {
        let side = Side::new(placed, frame, is_turned);
        let [mut row, end] = side.rows(0.0, side.size[1]);
        while row < end {
            let tails = side.tails(row + 0.5 - side.centre[1]);
            for (tail, along) in tails.into_iter().zip([0.0, side.size[0] - 1.0]) {
                if tail > 0.0 {
                    let place = if is_turned {
                        [row, along]
                    } else {
                        [along, row]
                    };
                    add(normal_at(lobes, place.map(|x| x as u32))?, tail);
                }
            }
            row += 1.0;
        }
    }
    corners(lobes, &Side::new(placed, frame, false), add)
}

/// The four quarters beyond both a side's ends and its first or last row.
fn corners(
    lobes: &Lobes<'_>,
    side: &Side,
    add: &mut dyn FnMut([f64; 2], f64),
) -> Result<(), QueryError> {
    let [columns, rows] = side.size;
    for (row, [low, end]) in [
        (0.0, side.rows(f64::NEG_INFINITY, 0.0)),
        (rows - 1.0, side.rows(rows, f64::INFINITY)),
    ] {
        let run = libm::ceil((end - low) / MOST_ROWS).max(1.0);
        let mut place = low;
        let mut sums = [0.0; 2];
        while place < end {
            let count = run.min(end - place);
            let tails = side.tails(place + 0.5 * count - side.centre[1]);
            sums = [sums[0] + count * tails[0], sums[1] + count * tails[1]];
            place += count;
        }
        for (sum, column) in sums.into_iter().zip([0.0, columns - 1.0]) {
            if sum > 0.0 {
                add(normal_at(lobes, [column, row].map(|x| x as u32))?, sum);
            }
        }
    }
    Ok(())
}

/// The normal of the lobe in `column` and `row`.
pub(super) fn normal_at(
    lobes: &Lobes<'_>,
    [column, row]: [u32; 2],
) -> Result<[f64; 2], QueryError> {
    Ok(lobe_at(lobes, [column, row])?.normal)
}

/// The lobe in `column` and `row`.
pub(super) fn lobe_at(
    lobes: &Lobes<'_>,
    [column, row]: [u32; 2],
) -> Result<glintbake_format::view::LobeNormal, QueryError> {
    let (place, child, bounds) = lobes
        .pyramid
        .block_at(column, row)?
        .ok_or(lobes.damaged())?;
    let number = 4 * (row % 4) + column % 4;
    let lobe = lobes.lobe(place, child, number, &bounds)?;
    Ok(if lobes.lattice.curved {
        lobe
    } else {
        glintbake_format::view::LobeNormal {
            slope: [0.0; 4],
            ..lobe
        }
    })
}
