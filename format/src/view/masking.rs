//! Masking of the map's own normals: the table over directions.

use super::bin_tables::elements;
use crate::container::Container;
use crate::finding::Finding;
use crate::model::MaskingGrid;
use crate::records::{Instance, MASKING, MaskingValue};

/// The masking table of one map.
#[derive(Clone, Copy, Debug)]
pub struct MaskingTable<'a> {
    values: &'a [MaskingValue],
}

impl<'a> MaskingTable<'a> {
    /// The table stored with `instance` itself, or `None` if there is none. O(1).
    ///
    /// # Errors
    /// If it has not [`MaskingGrid::COUNT`] values.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        if container.find(instance.section(MASKING)).is_none() {
            return Ok(None);
        }
        let values = elements(container, instance, MASKING, MaskingGrid::COUNT)?;
        Ok(Some(Self { values }))
    }

    /// The table of the map that `instance` was baked from, whichever of its instances, of any method, stores it for
    /// all; `None` if none does. O(instances).
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        for other in container.instances() {
            let other = other?;
            if other.layer == instance.layer
                && (other.width, other.height) == (instance.width, instance.height)
                && let Some(table) = Self::open(container, &other)?
            {
                return Ok(Some(table));
            }
        }
        Ok(None)
    }

    /// The excess stored at `column`, counted around without end, and `row`, of which those above the last have the
    /// last one's.
    #[inline]
    pub fn excess(&self, column: u32, row: u32) -> f64 {
        let column = column % MaskingGrid::COLUMNS;
        let row = row.min(MaskingGrid::ROWS - 1);
        let place = row.wrapping_mul(MaskingGrid::COLUMNS).wrapping_add(column);
        self.values
            .get(place as usize)
            .map_or(0.0, |value| value.excess())
    }
}
