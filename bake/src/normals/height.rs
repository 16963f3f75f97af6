//! Heights to normals.

use super::coding::without_negative_zero;
use crate::image::{Samples, each_type};
use glintbake_format::model::Wrap;
use rayon::prelude::*;

/// The grid of heights.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub width: usize,
    pub height: usize,
    pub wrap: Wrap,
}

/// Normals of the surface whose height is the sample times `texels_per_sample`; every sample must be finite.
///
/// (-∂h/∂column, ∂h/∂row, 1), normalised, as the documentation of the module says.
pub(super) fn convert(samples: &Samples, grid: Grid, texels_per_sample: f64) -> Vec<[f32; 2]> {
    each_type!(samples, samples => rows(samples, grid, texels_per_sample))
}

fn rows<S: Copy + Sync + Into<f64>>(samples: &[S], grid: Grid, scale: f64) -> Vec<[f32; 2]> {
    let mut texels = vec![[0.0; 2]; grid.width * grid.height];
    texels
        .par_chunks_mut(grid.width)
        .enumerate()
        .for_each(|(row, texels)| {
            let line = |row: usize| &samples[row * grid.width..][..grid.width];
            let at = |line: &[S], column: usize| -> f64 { line[column].into() };
            let down = Difference::at(row, grid.height, grid.wrap);
            let (above, here, below) = (line(down.before), line(row), line(down.after));
            for (column, texel) in texels.iter_mut().enumerate() {
                let right = Difference::at(column, grid.width, grid.wrap);
                let slope_right =
                    (at(here, right.after) - at(here, right.before)) * right.factor * scale;
                let slope_down = (at(below, column) - at(above, column)) * down.factor * scale;
                let length = (1.0 + slope_right * slope_right + slope_down * slope_down).sqrt();
                *texel = without_negative_zero([-slope_right / length, slope_down / length]);
            }
        });
    texels
}

/// The two samples whose difference, times `factor`, is the derivative at a third.
struct Difference {
    before: usize,
    after: usize,
    factor: f64,
}

impl Difference {
    fn at(index: usize, size: usize, wrap: Wrap) -> Self {
        if index > 0 && index + 1 < size {
            return Self {
                before: index - 1,
                after: index + 1,
                factor: 0.5,
            };
        }
        match wrap {
            Wrap::Repeat => Self {
                before: (index + size - 1) % size,
                after: (index + 1) % size,
                factor: 0.5,
            },
            // One-sided: half of it would bend the rim of every slope, and clamping continues that rim for ever.
            Wrap::Clamp => Self {
                before: index.saturating_sub(1),
                after: (index + 1).min(size - 1),
                factor: 1.0,
            },
        }
    }
}
