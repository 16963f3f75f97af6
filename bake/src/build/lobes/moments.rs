//! Moments of the lobes of cells, and cells as one lobe.

use glintbake_format::model::LobeLattice;
use glintbake_format::records::LobeMoments;
use glintbake_format::view::{CellLobe, LobeNormal, PyramidBox};
use zerocopy::little_endian::{F32, I16, U16};

/// σh² in squared spacings.
const VARIANCE: f64 = LobeLattice::DEVIATION * LobeLattice::DEVIATION;

/// Sums over the lobes of a cell, positions from its middle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    count: f64,
    normal: [f64; 2],
    /// ss, st, tt.
    squares: [f64; 3],
    /// s x, s y, t x, t y.
    products: [f64; 4],
    position: [f64; 2],
}

impl Sums {
    /// Adds a lobe `place` from the middle. What it spreads by itself counts as well: σh² J Jᵀ, and σh² J with positions.
    pub fn add(&mut self, lobe: &LobeNormal, place: [f64; 2]) {
        let [s, t] = lobe.normal;
        let [s_x, s_y, t_x, t_y] = lobe.slope;
        self.merge(
            &Self {
                count: 1.0,
                normal: [s, t],
                squares: [
                    s * s + VARIANCE * (s_x * s_x + s_y * s_y),
                    s * t + VARIANCE * (s_x * t_x + s_y * t_y),
                    t * t + VARIANCE * (t_x * t_x + t_y * t_y),
                ],
                products: lobe.slope.map(|slope| VARIANCE * slope),
                position: [0.0; 2],
            },
            place,
        );
    }

    /// Adds a cell whose middle is `place` from this one's.
    pub fn merge(&mut self, other: &Self, [x, y]: [f64; 2]) {
        let [s, t] = other.normal;
        self.count += other.count;
        for (sum, more) in self.normal.iter_mut().zip(other.normal) {
            *sum += more;
        }
        for (sum, more) in self.squares.iter_mut().zip(other.squares) {
            *sum += more;
        }
        let shifted = [s * x, s * y, t * x, t * y];
        for ((sum, more), shift) in self.products.iter_mut().zip(other.products).zip(shifted) {
            *sum += more + shift;
        }
        let shifted = [other.count * x, other.count * y];
        for ((sum, more), shift) in self.position.iter_mut().zip(other.position).zip(shifted) {
            *sum += more + shift;
        }
    }

    /// The cell as one lobe; `side` is how many lobes a whole cell has along each side. The slope of a cell that is not whole
    /// is 0, as queries never ask for it.
    pub fn lobe(&self, side: f64) -> CellLobe {
        let mean = self.normal.map(|sum| sum / self.count);
        let [ss, st, tt] = self.squares.map(|sum| sum / self.count);
        let covariance = [
            ss - mean[0] * mean[0],
            st - mean[0] * mean[1],
            tt - mean[1] * mean[1],
        ];
        let is_whole = self.count >= side * side;
        // Positions of a whole cell: a lattice of side², each lobe with σh² of its own.
        let variance = VARIANCE + (side * side - 1.0) / 12.0;
        let slope = if is_whole {
            self.products.map(|product| product / self.count / variance)
        } else {
            [0.0; 4]
        };
        let [s_x, s_y, t_x, t_y] = slope;
        let explained = [
            s_x * s_x + s_y * s_y,
            s_x * t_x + s_y * t_y,
            t_x * t_x + t_y * t_y,
        ];
        let rest = |axis: usize| covariance[axis] - variance * explained[axis];
        CellLobe {
            lobe: LobeNormal {
                normal: mean,
                slope,
            },
            residual: [rest(0).max(0.0), rest(1), rest(2).max(0.0)],
        }
    }
}

/// The record of the cells of one node, with their boxes.
pub(super) fn encode(cells: &[Option<(CellLobe, PyramidBox)>; 16]) -> LobeMoments {
    let greatest = cells
        .iter()
        .flatten()
        .flat_map(|(cell, _)| cell.lobe.slope)
        .fold(0.0, |most: f64, slope| most.max(slope.abs()));
    let step = (greatest / 32767.0) as f32;
    // Rounded down, the step would leave the greatest beyond 16 bits.
    let step = if f64::from(step) * 32767.0 < greatest {
        step.next_up()
    } else {
        step
    };
    let mut moments = LobeMoments {
        slope_step: F32::new(step),
        mean_s: [U16::ZERO; 16],
        mean_t: [U16::ZERO; 16],
        slope: [[I16::ZERO; 16]; 4],
        deviation_s: [0; 16],
        deviation_t: [0; 16],
        correlation: [0; 16],
    };
    for (child, cell) in cells.iter().enumerate() {
        let Some((cell, bounds)) = cell else { continue };
        let [width, height] = bounds.extent();
        let mean = |axis: usize, side: f64| {
            let part = share(cell.lobe.normal[axis] - bounds.low[axis], side);
            U16::new((part * 65535.0).round() as u16)
        };
        moments.mean_s[child] = mean(0, width);
        moments.mean_t[child] = mean(1, height);
        for (lanes, slope) in moments.slope.iter_mut().zip(cell.lobe.slope) {
            let units = if step > 0.0 {
                slope / f64::from(step)
            } else {
                0.0
            };
            lanes[child].set(units.round().clamp(-32767.0, 32767.0) as i16);
        }
        let [ss, st, tt] = cell.residual;
        let (s, t) = (ss.sqrt(), tt.sqrt());
        moments.deviation_s[child] = (share(s, width) * 255.0).round() as u8;
        moments.deviation_t[child] = (share(t, height) * 255.0).round() as u8;
        let correlation = if s > 0.0 && t > 0.0 {
            (st / (s * t)).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        moments.correlation[child] = (127.0 + 127.0 * correlation).round() as u8;
    }
    moments
}

/// `part` of `side`, from 0 to 1; 0 of a side without extent.
fn share(part: f64, side: f64) -> f64 {
    if side > 0.0 {
        (part / side).clamp(0.0, 1.0)
    } else {
        0.0
    }
}
