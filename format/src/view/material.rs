//! Layered materials: the layers, and the opacity map of each.

use super::bin_tables::expect_count;
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::PyramidLayout;
use crate::records::{
    Instance, LayerNormals, LayerRecord, MATERIAL, MAX_LAYERS, MaterialLayer, OPACITY,
    OpacityLayout,
};
use crate::section::SectionId;

/// The layers of a package's material, the top first.
#[derive(Clone, Copy, Debug)]
pub struct MaterialLayers<'a> {
    records: &'a [LayerRecord],
}

impl<'a> MaterialLayers<'a> {
    /// The layers of `container`, or `None` if it holds no material. O(layers × instances).
    ///
    /// # Errors
    /// [`Fault::MaterialCount`] if there is none or more than [`MAX_LAYERS`], what [`MaterialLayer::from_record`] finds, and
    /// [`Fault::MaterialInstance`] if a layer names an instance that is not there or not of that layer.
    pub fn open(container: &Container<'a>) -> Result<Option<Self>, Finding> {
        let id = SectionId::shared(MATERIAL);
        if container.find(id).is_none() {
            return Ok(None);
        }
        let records: &[LayerRecord] = container.elements(id)?;
        if !(1..=MAX_LAYERS).contains(&records.len()) {
            let count = records.len() as u64;
            return Err(Finding::new(Fault::MaterialCount)
                .within(id)
                .values(MAX_LAYERS as u64, count));
        }
        let layers = Self { records };
        for (place, layer) in (0_u16..).zip(layers.iter()) {
            if let LayerNormals::Instance(number) = layer?.normals {
                find_instance(container, place, number)?;
            }
        }
        Ok(Some(layers))
    }

    /// How many layers there are.
    pub const fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there are none; never, of layers that opened.
    pub const fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// The layers, the top first.
    pub fn iter(&self) -> impl Iterator<Item = Result<MaterialLayer, Finding>> + use<'a> {
        (0..)
            .zip(self.records)
            .map(|(place, record)| MaterialLayer::from_record(record, place))
    }
}

/// Instance `number` of `container`, which must be of layer `place`.
///
/// # Errors
/// [`Fault::MaterialInstance`].
pub(crate) fn find_instance(
    container: &Container<'_>,
    place: u16,
    number: u16,
) -> Result<Instance, Finding> {
    let wrong = Finding::new(Fault::MaterialInstance)
        .within(SectionId::shared(MATERIAL))
        .at(u64::from(place));
    for instance in container.instances() {
        let instance = instance?;
        if instance.number == number {
            let layer = instance.layer;
            return if layer == place {
                Ok(instance)
            } else {
                Err(wrong.values(u64::from(place), u64::from(layer)))
            };
        }
    }
    Err(wrong)
}

/// The opacity map of a layer: level by level from the texels to one cell, a byte each.
#[derive(Clone, Copy, Debug)]
pub struct Opacity<'a> {
    /// Its size and wrap.
    pub layout: OpacityLayout,
    /// Its section.
    pub id: SectionId,
    values: &'a [u8],
}

impl<'a> Opacity<'a> {
    /// The opacity map of `layer`, at place `place` of the material; `None` if it has none. O(1).
    ///
    /// # Errors
    /// If the section is missing, or has not as many values as there are cells.
    pub fn open(
        container: &Container<'a>,
        place: u16,
        layer: &MaterialLayer,
    ) -> Result<Option<Self>, Finding> {
        let Some(layout) = layer.opacity_map else {
            return Ok(None);
        };
        let id = SectionId::of_instance(place, 0, OPACITY);
        let values: &[u8] = container.elements(id)?;
        expect_count(id, layout.levels.mean_count() as usize, values.len())?;
        Ok(Some(Self { layout, id, values }))
    }

    /// How its levels lie.
    pub const fn levels(&self) -> PyramidLayout {
        self.layout.levels
    }

    /// The place of the cell in `column` and `row` of `level`, which must be there.
    #[inline]
    pub fn place(&self, level: u32, column: u32, row: u32) -> usize {
        let [columns, _] = self.levels().size(level);
        let first = self.levels().first_mean(level) as usize;
        first
            .wrapping_add((row as usize).wrapping_mul(columns as usize))
            .wrapping_add(column as usize)
    }

    /// The number, 255 of which are opaque, of the cell in `column` and `row` of `level`; `None` if it is not stored.
    #[inline]
    pub fn number(&self, level: u32, column: u32, row: u32) -> Option<u8> {
        self.values.get(self.place(level, column, row)).copied()
    }

    /// The share that the layer covers of the cell in `column` and `row` of `level`, in [0, 1].
    ///
    /// # Errors
    /// If it is not stored.
    #[inline]
    pub fn value(&self, level: u32, column: u32, row: u32) -> Result<f64, Finding> {
        self.number(level, column, row)
            .map(|number| f64::from(number) / 255.0)
            .ok_or_else(|| Finding::new(Fault::SectionCount).within(self.id))
    }
}
