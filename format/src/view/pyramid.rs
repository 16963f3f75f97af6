//! Pyramids: moments of normals by level and cell.

use super::bin_tables::elements;
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::PyramidLayout;
use crate::records::{Instance, MEANS, NarrowMean, SPREADS, SpreadRecord, WideMean};
use crate::section::SectionId;

/// Means of either width, level by level.
#[derive(Clone, Copy, Debug)]
pub enum Means<'a> {
    /// To 16 bits.
    Narrow(&'a [NarrowMean]),
    /// To 32 bits.
    Wide(&'a [WideMean]),
}

/// The normals of one cell: their mean on the projected disk, and their covariance about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellMoments {
    /// Mean of s and of t, each in [-1, 1].
    pub mean: [f64; 2],
    /// Variance of s, covariance, variance of t: positive semi-definite, entries at most 1.
    pub covariance: [f64; 3],
}

/// The pyramid of one map.
#[derive(Clone, Copy, Debug)]
pub struct Pyramid<'a> {
    /// How its levels lie.
    pub layout: PyramidLayout,
    /// The section of means.
    pub id: SectionId,
    /// Means of all cells.
    pub means: Means<'a>,
    /// Spreads of the cells of all levels but level 0.
    pub spreads: &'a [SpreadRecord],
}

impl<'a> Pyramid<'a> {
    /// The pyramid stored with `instance` itself, or `None` if it stores none. O(1).
    ///
    /// # Errors
    /// If one of its two sections is missing, or has not as many elements as there are cells.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        let Some(layout) = instance.pyramid() else {
            return Ok(None);
        };
        let id = instance.section(MEANS);
        let Some(entry) = container.find(id) else {
            return Ok(None);
        };
        let count = layout.mean_count() as usize;
        let means = if entry.element_size.get() == size_of::<WideMean>() as u32 {
            Means::Wide(elements(container, instance, MEANS, count)?)
        } else {
            Means::Narrow(elements(container, instance, MEANS, count)?)
        };
        let count = layout.spread_count() as usize;
        let spreads = if count == 0 {
            &[]
        } else {
            elements(container, instance, SPREADS, count)?
        };
        Ok(Some(Self {
            layout,
            id,
            means,
            spreads,
        }))
    }

    /// The pyramid of the map that `instance` was baked from: its own, or that of the first other instance of the same map
    /// and method that stores one of the same levels. O(instances).
    ///
    /// # Errors
    /// As [`open`](Self::open), and if no instance stores it.
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        super::of_map(container, instance, Self::open)?
            .ok_or(Finding::new(Fault::SectionMissing).within(instance.section(MEANS)))
    }

    /// The cells of `level`.
    pub fn level(&self, level: u32) -> PyramidLevel<'a> {
        PyramidLevel {
            pyramid: *self,
            level,
            size: self.layout.size(level),
            first_mean: self.layout.first_mean(level) as usize,
            first_spread: self.layout.first_spread(level) as usize,
        }
    }
}

/// One level of a pyramid.
#[derive(Clone, Copy, Debug)]
pub struct PyramidLevel<'a> {
    pyramid: Pyramid<'a>,
    level: u32,
    /// Its columns and rows.
    pub size: [u32; 2],
    /// The places of its first mean and its first spread.
    first_mean: usize,
    first_spread: usize,
}

impl PyramidLevel<'_> {
    /// The place of the mean, and that of the spread, of the cell in `column` and `row`; `None` if there is no such cell.
    #[inline]
    pub fn places(&self, column: u32, row: u32) -> Option<[usize; 2]> {
        let [columns, rows] = self.size;
        let is_cell = column < columns && row < rows && self.level >= self.pyramid.layout.finest();
        let cell = (row as usize)
            .wrapping_mul(columns as usize)
            .wrapping_add(column as usize);
        is_cell.then_some([
            self.first_mean.wrapping_add(cell),
            self.first_spread.wrapping_add(cell),
        ])
    }

    /// The moments of the cell in `column` and `row`.
    ///
    /// # Errors
    /// If it is not stored.
    #[inline]
    pub fn cell(&self, column: u32, row: u32) -> Result<CellMoments, Finding> {
        self.find(column, row)
            .ok_or_else(|| Finding::new(Fault::SectionCount).within(self.pyramid.id))
    }

    #[inline]
    fn find(&self, column: u32, row: u32) -> Option<CellMoments> {
        let [mean, spread] = self.places(column, row)?;
        Some(CellMoments {
            mean: match self.pyramid.means {
                Means::Narrow(means) => means.get(mean)?.point(),
                Means::Wide(means) => means.get(mean)?.point(),
            },
            covariance: match self.level {
                0 => [0.0; 3],
                _ => self.pyramid.spreads.get(spread)?.covariance(),
            },
        })
    }
}
