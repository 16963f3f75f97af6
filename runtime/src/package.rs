//! A package ready for queries.

use crate::error::QueryError;
use crate::layers::Material;
use crate::ndf::SurfaceNdf;
use glintbake_format::model::Method;
use glintbake_format::records::Instance;
use glintbake_format::{Container, Finding};

/// A package over borrowed bytes.
#[derive(Clone, Copy, Debug)]
pub struct Package<'a> {
    container: Container<'a>,
}

impl<'a> Package<'a> {
    /// The package in `bytes`; reads the header, the section table and the instance records, never the data.
    ///
    /// # Errors
    /// The first [`Finding`] in the header, the table or the instance records.
    pub fn open(bytes: &'a [u8]) -> Result<Self, Finding> {
        Container::open(bytes).map(|container| Self { container })
    }

    /// Header, section table and raw sections.
    pub const fn container(&self) -> &Container<'a> {
        &self.container
    }

    /// What the package can answer for: one instance per method and recipe, in order of their number.
    pub fn instances(&self) -> impl Iterator<Item = Instance> + use<'a> {
        self.container.instances().filter_map(Result::ok)
    }

    /// The first instance of `method` (any, if `None`) whose roughness is `roughness` (any, if `None`).
    ///
    /// Roughness is compared within one part in 10⁹, so that α and √2 σr of the same surface agree.
    pub fn find(&self, method: Option<Method>, roughness: Option<f64>) -> Option<Instance> {
        self.find_in_layer(None, method, roughness)
    }

    /// The same, among the instances of `layer` of a material (any, if `None`).
    pub fn find_in_layer(
        &self,
        layer: Option<u16>,
        method: Option<Method>,
        roughness: Option<f64>,
    ) -> Option<Instance> {
        self.instances().find(|instance| {
            let same_layer = layer.is_none_or(|layer| layer == instance.layer);
            let same_roughness = match (roughness, instance.roughness) {
                (None, _) => true,
                (Some(wanted), Some(baked)) => (wanted - baked).abs() <= 1e-9 * baked,
                (Some(_), None) => false,
            };
            method.is_none_or(|method| method == instance.method) && same_layer && same_roughness
        })
    }

    /// The layered material of the package, ready to be queried.
    ///
    /// # Errors
    /// As [`Material::open`].
    pub fn material(&self) -> Result<Material<'a>, QueryError> {
        Material::open(&self.container)
    }

    /// The P-NDF of instance `number`, ready to be queried.
    ///
    /// # Errors
    /// [`QueryError::NoSuchInstance`], or [`QueryError::Damaged`] if a section is missing or of the wrong size.
    pub fn ndf(&self, number: u16) -> Result<SurfaceNdf<'a>, QueryError> {
        let instance = self
            .instances()
            .find(|instance| instance.number == number)
            .ok_or(QueryError::NoSuchInstance(number))?;
        SurfaceNdf::open(&self.container, &instance)
    }
}
