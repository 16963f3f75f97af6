//! Records of layered materials: one for each layer, the top first.

use super::MATERIAL;
use crate::finding::{Fault, Finding};
use crate::model::{PyramidLayout, Wrap};
use crate::section::SectionId;
use core::ops::RangeInclusive;
use zerocopy::little_endian::{F32, U16};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The most layers a material may have; a runtime keeps them without an allocator.
pub const MAX_LAYERS: usize = 8;

/// What a layer does with light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum LayerKind {
    /// A dielectric: reflects by its index of refraction, and lets the rest pass to what lies below.
    Coat = 1,
    /// Metal flakes, scratches, brushes: reflect by F0, and let nothing pass but where they leave gaps.
    Glints = 2,
    /// A glossy surface over a diffuse one; the last layer as a rule.
    Base = 3,
}

impl LayerKind {
    /// Every kind, in order of its code.
    pub const ALL: &'static [Self] = &[Self::Coat, Self::Glints, Self::Base];

    /// The kind stored as `code`, if there is one.
    pub fn from_code(code: u16) -> Option<Self> {
        Self::ALL.iter().copied().find(|&kind| kind as u16 == code)
    }

    /// The kind called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// The word used in materials, on the command line and in metadata.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Coat => "coat",
            Self::Glints => "glints",
            Self::Base => "base",
        }
    }
}

/// A layer as it lies in the file. 64 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct LayerRecord {
    /// 0: kind.
    pub kind: U16,
    /// 2: number of the instance that its normals are distributed by; 0 for a lobe of `roughness`.
    pub instance: U16,
    /// 4: how often its map repeats along u and v.
    pub scale: [F32; 2],
    /// 12: reflectance at normal incidence, by colour; 0 for coats.
    pub f0: [F32; 3],
    /// 24: albedo of what lies under the gloss of a base, or what a coat lets pass to and fro at normal incidence, by colour;
    /// 0 for glints.
    pub colour: [F32; 3],
    /// 36: Beckmann roughness of a lobe; 0 with an instance.
    pub roughness: F32,
    /// 40: how much of the surface the layer covers, times the opacity map if there is one.
    pub opacity: F32,
    /// 44: index of refraction of a coat; 0 for others.
    pub ior: F32,
    /// 48: columns and rows of the opacity map; 0 without one.
    pub opacity_size: [U16; 2],
    /// 52: wrap of the opacity map; 0 without one.
    pub opacity_wrap: U16,
    /// 54: zero.
    pub reserved: [u8; 10],
}

const _: () = assert!(
    size_of::<LayerRecord>() == 64,
    "a layer's record is 64 bytes"
);

/// What a layer's normals are distributed by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayerNormals {
    /// The P-NDF of this instance.
    Instance(u16),
    /// One Beckmann lobe of this roughness α about the surface's normal, 1e-4 to 1.
    Lobe(f32),
}

/// The size of an opacity map, and how it goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpacityLayout {
    /// Its levels.
    pub levels: PyramidLayout,
    /// How it continues beyond the unit tile.
    pub wrap: Wrap,
}

/// A layer with its numbers checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialLayer {
    /// What it does with light.
    pub kind: LayerKind,
    /// What its normals are distributed by.
    pub normals: LayerNormals,
    /// How often its maps repeat along u and v in the unit square of the material, 1e-3 to 1e3.
    pub scale: [f32; 2],
    /// Reflectance at normal incidence by colour, in [0, 1]; 0 for coats, whose is that of their index.
    pub f0: [f32; 3],
    /// Albedo of what lies under the gloss of a base, or what a coat lets pass to and fro at normal incidence, by colour, in
    /// [0, 1]; 0 for glints.
    pub colour: [f32; 3],
    /// How much of the surface the layer covers, in [0, 1], times the opacity map if there is one.
    pub opacity: f32,
    /// Index of refraction of a coat, 1 to 4; 0 for others.
    pub ior: f32,
    /// The opacity map, if there is one.
    pub opacity_map: Option<OpacityLayout>,
}

impl MaterialLayer {
    /// How often a layer's maps may repeat in the unit square of the material.
    pub const SCALE: RangeInclusive<f32> = 1e-3..=1e3;

    /// Roughnesses of lobes: the peak of their density, 1 / (π α²), is a number worth having throughout.
    pub const ROUGHNESS: RangeInclusive<f32> = 1e-4..=1.0;

    /// Indices of refraction of coats: from none to more than diamond's.
    pub const IOR: RangeInclusive<f32> = 1.0..=4.0;

    /// What part of light a layer may send back, or let pass, and of the surface it may cover.
    pub const SHARE: RangeInclusive<f32> = 0.0..=1.0;

    /// The record that stores this layer.
    pub fn to_record(self) -> LayerRecord {
        let (instance, roughness) = match self.normals {
            LayerNormals::Instance(number) => (number, 0.0),
            LayerNormals::Lobe(roughness) => (0, roughness),
        };
        let (size, wrap) = self
            .opacity_map
            .map_or(([0; 2], 0), |map| (map.levels.map_size(), map.wrap as u16));
        LayerRecord {
            kind: U16::new(self.kind as u16),
            instance: U16::new(instance),
            scale: self.scale.map(F32::new),
            f0: self.f0.map(F32::new),
            colour: self.colour.map(F32::new),
            roughness: F32::new(roughness),
            opacity: F32::new(self.opacity),
            ior: F32::new(self.ior),
            // At most 65535, as every layout's.
            opacity_size: size.map(|side| U16::new(side as u16)),
            opacity_wrap: U16::new(wrap),
            reserved: [0; 10],
        }
    }

    /// The layer stored in `record`, found at place `place` of its section.
    ///
    /// # Errors
    /// [`Fault::MaterialLayer`] or [`Fault::ReservedNotZero`] (also of a field that means nothing for the kind), with the
    /// record's place.
    pub fn from_record(record: &LayerRecord, place: u64) -> Result<Self, Finding> {
        let finding = |fault| {
            Finding::new(fault)
                .within(SectionId::shared(MATERIAL))
                .at(place)
        };
        let wrong = finding(Fault::MaterialLayer);
        let [f0, colour] = [record.f0, record.colour].map(|rgb| rgb.map(F32::get));
        let layer = Self {
            kind: LayerKind::from_code(record.kind.get()).ok_or(wrong)?,
            normals: match record.instance.get() {
                0 => LayerNormals::Lobe(record.roughness.get()),
                number => LayerNormals::Instance(number),
            },
            scale: record.scale.map(F32::get),
            f0,
            colour,
            opacity: record.opacity.get(),
            ior: record.ior.get(),
            opacity_map: opacity_of(record, wrong)?,
        };
        if !layer.is_sound() {
            return Err(wrong);
        }
        // Also catches fields that mean nothing here, and a negative zero where zero is canonical.
        if layer.to_record().as_bytes() != record.as_bytes() {
            return Err(finding(Fault::ReservedNotZero));
        }
        Ok(layer)
    }

    /// Whether every number is in its range, and of the kind. What is not a number is in none.
    pub fn is_sound(&self) -> bool {
        let share = |value: &f32| Self::SHARE.contains(value) && value.is_sign_positive();
        let is_none = |rgb: [f32; 3]| rgb.map(f32::to_bits) == [0; 3];
        let normals = match self.normals {
            LayerNormals::Instance(number) => number > 0 && self.kind != LayerKind::Base,
            LayerNormals::Lobe(roughness) => Self::ROUGHNESS.contains(&roughness),
        };
        let kind = match self.kind {
            LayerKind::Coat => Self::IOR.contains(&self.ior) && is_none(self.f0),
            LayerKind::Glints => self.ior.to_bits() == 0 && is_none(self.colour),
            LayerKind::Base => self.ior.to_bits() == 0,
        };
        normals
            && kind
            && self.scale.iter().all(|scale| Self::SCALE.contains(scale))
            && self.f0.iter().chain(&self.colour).all(share)
            && share(&self.opacity)
    }
}

/// The opacity map of `record`; `wrong` is the finding if it has none such.
fn opacity_of(record: &LayerRecord, wrong: Finding) -> Result<Option<OpacityLayout>, Finding> {
    let [width, height] = record.opacity_size.map(|side| u32::from(side.get()));
    if (width, height) == (0, 0) {
        return Ok(None);
    }
    Ok(Some(OpacityLayout {
        levels: PyramidLayout::new(width, height, 0).ok_or(wrong)?,
        wrap: Wrap::from_code(record.opacity_wrap.get()).ok_or(wrong)?,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: MaterialLayer = MaterialLayer {
        kind: LayerKind::Base,
        normals: LayerNormals::Lobe(0.3),
        scale: [1.0, 2.0],
        f0: [0.04; 3],
        colour: [0.1, 0.2, 0.3],
        opacity: 1.0,
        ior: 0.0,
        opacity_map: None,
    };

    #[test]
    fn records_come_back_as_the_layers_they_store() {
        let coat = MaterialLayer {
            kind: LayerKind::Coat,
            normals: LayerNormals::Instance(7),
            f0: [0.0; 3],
            ior: 1.5,
            opacity: 0.25,
            opacity_map: Some(OpacityLayout {
                levels: PyramidLayout::new(65_535, 1, 0).unwrap(),
                wrap: Wrap::Clamp,
            }),
            ..BASE
        };
        let glints = MaterialLayer {
            kind: LayerKind::Glints,
            normals: LayerNormals::Instance(1),
            colour: [0.0; 3],
            ..BASE
        };
        for layer in [BASE, coat, glints] {
            assert_eq!(MaterialLayer::from_record(&layer.to_record(), 0), Ok(layer));
        }
    }

    #[test]
    fn numbers_out_of_range_are_no_layer() {
        let wrong = [
            MaterialLayer {
                opacity: 1.001,
                ..BASE
            },
            MaterialLayer {
                opacity: f32::NAN,
                ..BASE
            },
            MaterialLayer {
                opacity: -0.0,
                ..BASE
            },
            MaterialLayer {
                scale: [0.0, 1.0],
                ..BASE
            },
            MaterialLayer {
                scale: [1.0, f32::INFINITY],
                ..BASE
            },
            MaterialLayer {
                f0: [0.1, f32::NAN, 0.1],
                ..BASE
            },
            MaterialLayer {
                colour: [0.1, 0.1, 2.0],
                ..BASE
            },
            MaterialLayer {
                normals: LayerNormals::Lobe(0.0),
                ..BASE
            },
            MaterialLayer {
                normals: LayerNormals::Lobe(f32::NAN),
                ..BASE
            },
            MaterialLayer {
                normals: LayerNormals::Instance(1),
                ..BASE
            },
            MaterialLayer { ior: 1.5, ..BASE },
            MaterialLayer {
                kind: LayerKind::Glints,
                ..BASE
            },
            MaterialLayer {
                kind: LayerKind::Coat,
                ior: 0.9,
                f0: [0.0; 3],
                ..BASE
            },
            MaterialLayer {
                kind: LayerKind::Coat,
                ior: 1.5,
                ..BASE
            },
        ];
        for layer in wrong {
            let finding = MaterialLayer::from_record(&layer.to_record(), 3).unwrap_err();
            assert_eq!(finding.fault, Fault::MaterialLayer, "{layer:?}");
            assert_eq!(finding.element, Some(3));
        }
        let mut stray = BASE.to_record();
        stray.opacity_wrap = U16::new(1);
        let finding = MaterialLayer::from_record(&stray, 0).unwrap_err();
        assert_eq!(finding.fault, Fault::ReservedNotZero);
        let mut flat = BASE.to_record();
        flat.opacity_size = [U16::new(3), U16::ZERO];
        let finding = MaterialLayer::from_record(&flat, 0).unwrap_err();
        assert_eq!(finding.fault, Fault::MaterialLayer);
    }
}
