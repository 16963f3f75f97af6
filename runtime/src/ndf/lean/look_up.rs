//! Mean and covariance of the normals under probes.

use super::probes::Probes;
use crate::error::QueryError;
use crate::overlap::Placement;
use glintbake_format::model::Wrap;
use glintbake_format::view::{CellMoments, Pyramid, PyramidLevel};

/// The moments under `probes` about the centre of `placement`: each probe bilinear between four cells of a level, linear
/// between two levels. At most 15 × 2 × 4 cells.
pub(super) fn moments(
    pyramid: &Pyramid<'_>,
    placement: &Placement,
    probes: &Probes,
    wrap: Wrap,
) -> Result<CellMoments, QueryError> {
    let lower = libm::floor(probes.level);
    let share = probes.level - lower;
    let mut blend = Blend::default();
    // Casts saturate, and the level is within the pyramid's.
    for (level, share) in [(lower as u32, 1.0 - share), (lower as u32 + 1, share)] {
        if share > 0.0 {
            let level = pyramid.level(level);
            let scale = scales(pyramid, &level);
            probes.for_each(&mut |offset, weight| {
                // The fraction first: it may be small beside the cell.
                let column = placement.cell[0] + (placement.centre[0] + offset[0]);
                let row = placement.cell[1] + (placement.centre[1] + offset[1]);
                let columns = Nearby::new(column * scale[0], level.size[0], wrap);
                let rows = Nearby::new(row * scale[1], level.size[1], wrap);
                blend.add_bilinear(&level, columns, rows, share * weight)
            })?;
        }
    }
    Ok(blend.moments())
}

/// Cells a texel, along each axis.
fn scales(pyramid: &Pyramid<'_>, level: &PyramidLevel<'_>) -> [f64; 2] {
    let [width, height] = pyramid.layout.map_size().map(f64::from);
    let [columns, rows] = level.size.map(f64::from);
    [columns / width, rows / height]
}

/// The two cells whose middles a place lies between, on one axis, and their shares.
#[derive(Clone, Copy, Debug)]
struct Nearby([(u32, f64); 2]);

impl Nearby {
    /// At `place`, in cells, of `count` cells that go on as `wrap` says.
    fn new(place: f64, count: u32, wrap: Wrap) -> Self {
        let from_middle = place - 0.5;
        let whole = libm::floor(from_middle);
        let share = from_middle - whole;
        let fold = |cell: i64| match wrap {
            Wrap::Repeat => cell.rem_euclid(i64::from(count)) as u32,
            Wrap::Clamp => cell.clamp(0, i64::from(count) - 1) as u32,
        };
        let cell = whole as i64;
        Self([
            (fold(cell), 1.0 - share),
            (fold(cell.saturating_add(1)), share),
        ])
    }
}

/// Moments of a mixture, one part at a time (West 1979): every term added is positive, whatever the order.
#[derive(Clone, Copy, Debug, Default)]
struct Blend {
    weight: f64,
    mean: [f64; 2],
    /// Weight times covariance.
    scatter: [f64; 3],
}

impl Blend {
    fn add_bilinear(
        &mut self,
        level: &PyramidLevel<'_>,
        columns: Nearby,
        rows: Nearby,
        weight: f64,
    ) -> Result<(), QueryError> {
        for (row, row_share) in rows.0 {
            for (column, column_share) in columns.0 {
                let share = weight * row_share * column_share;
                if share > 0.0 {
                    self.add(&level.cell(column, row)?, share);
                }
            }
        }
        Ok(())
    }

    /// The law of total covariance: within the part, and between its mean and that of the others.
    fn add(&mut self, part: &CellMoments, weight: f64) {
        let before = self.weight;
        self.weight += weight;
        let share = weight / self.weight;
        let between = before * share;
        let [s, t] = [part.mean[0] - self.mean[0], part.mean[1] - self.mean[1]];
        let [ss, st, tt] = part.covariance;
        self.mean = [self.mean[0] + share * s, self.mean[1] + share * t];
        self.scatter = [
            self.scatter[0] + weight * ss + between * s * s,
            self.scatter[1] + weight * st + between * s * t,
            self.scatter[2] + weight * tt + between * t * t,
        ];
    }

    fn moments(&self) -> CellMoments {
        // Shares of all parts add up to 1, so there is one.
        CellMoments {
            mean: self.mean,
            covariance: self.scatter.map(|sum| sum / self.weight),
        }
    }
}
