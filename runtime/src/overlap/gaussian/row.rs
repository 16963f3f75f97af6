//! One row of texels under a Gaussian footprint, with what depends on the row alone at hand.

use super::GaussianFootprint;
use super::smooth::SmoothRow;
use super::thin::{Interval, Thin};
use core::ops::Range;

/// A row of texels under a Gaussian footprint.
#[derive(Clone, Debug)]
pub(crate) struct GaussianRow<'a> {
    columns: Range<i64>,
    cell: f64,
    centre: f64,
    kind: Kind<'a>,
}

#[derive(Clone, Copy, Debug)]
enum Kind<'a> {
    Smooth(SmoothRow<'a>),
    Thin(&'a Thin, Interval),
}

impl<'a> GaussianRow<'a> {
    pub(super) fn new(footprint: &'a GaussianFootprint, row: i64) -> Self {
        let y = footprint.offset(row as f64 + 0.5, 1);
        Self {
            columns: footprint.row_columns(row),
            cell: footprint.cell[0],
            centre: footprint.centre[0],
            kind: match &footprint.thin {
                None => Kind::Smooth(footprint.smooth.row(y)),
                Some(thin) => Kind::Thin(thin, thin.rows(y - 0.5, y + 0.5)),
            },
        }
    }

    /// The columns that can hold weight: those that meet the ellipse.
    pub fn columns(&self) -> Range<i64> {
        self.columns.clone()
    }

    /// Where the middle of column `column` lies, relative to the Gaussian's centre.
    #[inline(always)]
    fn middle(&self, column: i64) -> f64 {
        (column as f64 + 0.5 - self.cell) - self.centre
    }

    /// The weight of the texel in column `column`: 0 if it is not one of [`columns`](Self::columns).
    #[inline]
    pub fn weight(&self, column: i64) -> f64 {
        if !self.columns.contains(&column) {
            return 0.0;
        }
        let x = self.middle(column);
        match &self.kind {
            Kind::Smooth(row) => row.weight(x),
            Kind::Thin(thin, rows) => thin.share(&thin.columns(x - 0.5, x + 0.5), rows),
        }
    }

    /// The weights of the texels from column `first` on; all must be among [`columns`](Self::columns).
    ///
    /// For Gaussians of σ ≥ 2 texels this is vector code: half the time of one weight after the other.
    #[inline(always)]
    pub fn fill(&self, first: i64, weights: &mut [f64]) {
        match &self.kind {
            Kind::Smooth(row) => row.fill(self.middle(first), weights),
            Kind::Thin(..) => {
                for (weight, column) in weights.iter_mut().zip(first..) {
                    *weight = self.weight(column);
                }
            }
        }
    }
}
