//! Mean and covariance of the normals under probes.

use crate::error::QueryError;
use crate::overlap::Placement;
use crate::pyramid::{Probes, for_each_cell};
use glintbake_format::model::Wrap;
use glintbake_format::view::{CellMoments, Pyramid};

/// The moments under `probes` about the centre of `placement`: each probe bilinear between four cells of a level, linear
/// between two levels. At most 15 × 2 × 4 cells.
pub(super) fn moments(
    pyramid: &Pyramid<'_>,
    placement: &Placement,
    probes: &Probes,
    wrap: Wrap,
) -> Result<CellMoments, QueryError> {
    let map_size = pyramid.layout.map_size();
    let mut blend = Blend::default();
    for (level, share) in probes.levels() {
        if share > 0.0 {
            let level = pyramid.level(level);
            let mut add = |column, row, weight: f64| {
                blend.add(&level.cell(column, row)?, weight);
                Ok(())
            };
            for_each_cell(
                placement, probes, map_size, level.size, wrap, share, &mut add,
            )?;
        }
    }
    Ok(blend.moments())
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
