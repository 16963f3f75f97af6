//! Instance records: what was baked, by which method, and with which numbers.

use crate::finding::{Fault, Finding};
use crate::model::{BinGrid, Binning, Filter, Method, Wrap};
use crate::records::INSTANCES;
use crate::section::SectionId;
use core::ops::RangeInclusive;
use zerocopy::little_endian::{F64, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Roughnesses an instance may have: far more than any bake allows, and such that the density of a lobe, whose peak is
/// 1 / (π α²), is a finite number everywhere.
const ROUGHNESS: RangeInclusive<f64> = 1e-9..=1e9;

/// How keys of a bin map find their bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum IndexKind {
    /// A key is the bin's number.
    Dense = 0,
    /// A key is a place in the rising list of occupied bins.
    Sparse = 1,
}

impl IndexKind {
    /// The word used in metadata.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dense => "dense",
            Self::Sparse => "sparse",
        }
    }
}

/// How the texels of a bin are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum InverseKind {
    /// An inverse bin map of texel positions, and a forest over its long lists, \[AWKK21\] §5.4.
    Forest = 0,
    /// For each key a list of the blocks that hold it, and how many texels each.
    Tiles = 1,
    /// Not at all: the bin map under the footprint is scanned.
    None = 2,
}

impl InverseKind {
    /// Every kind, in order of its code.
    pub const ALL: &'static [Self] = &[Self::Forest, Self::Tiles, Self::None];

    /// The kind stored as `code`, if there is one.
    pub const fn from_code(code: u16) -> Option<Self> {
        match code {
            0 => Some(Self::Forest),
            1 => Some(Self::Tiles),
            2 => Some(Self::None),
            _ => None,
        }
    }

    /// The word used on the command line and in metadata.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Forest => "forest",
            Self::Tiles => "tiles",
            Self::None => "none",
        }
    }
}

/// An instance record as it lies in the file. 64 bytes.
#[derive(
    Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct InstanceRecord {
    /// 0: layer of the material.
    pub layer: U16,
    /// 2: number of the instance, from 1 in order of the records.
    pub number: U16,
    /// 4: method code.
    pub method: U16,
    /// 6: wrap mode.
    pub wrap: U16,
    /// 8: columns of the map, 1 to 65535.
    pub width: U32,
    /// 12: rows of the map, 1 to 65535.
    pub height: U32,
    /// 16: Beckmann roughness α; 0 for a method without a kernel.
    pub roughness: F64,
    /// 24: bins per side.
    pub bin_resolution: U32,
    /// 28: the longest list that is scanned without a tree; 0 without a forest.
    pub leaf_size: U32,
    /// 32: binning.
    pub binning: U16,
    /// 34: filter of a query that names none.
    pub filter: U16,
    /// 36: index kind.
    pub index: U16,
    /// 38: inverse kind.
    pub inverse: U16,
    /// 40: number of keys the index has.
    pub key_count: U32,
    /// 44: zero.
    pub reserved: [u8; 20],
}

const _: () = assert!(
    size_of::<InstanceRecord>() == 64,
    "an instance record is 64 bytes"
);

/// An instance with its numbers checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Layer of the material.
    pub layer: u16,
    /// Number of the instance, from 1.
    pub number: u16,
    /// Method it was baked for.
    pub method: Method,
    /// How texture space continues.
    pub wrap: Wrap,
    /// Columns of the map, 1 to 65535.
    pub width: u32,
    /// Rows of the map, 1 to 65535.
    pub height: u32,
    /// Beckmann roughness α, 1e-9 to 1e9; `None` for a method without a kernel.
    pub roughness: Option<f64>,
    /// The bins.
    pub grid: BinGrid,
    /// How the texels of a bin are found.
    pub inverse: InverseKind,
    /// The longest list that is scanned without a tree, at least 1; 0 without a forest.
    pub leaf_size: u32,
    /// Filter of a query that names none.
    pub filter: Filter,
    /// How keys find their bin.
    pub index: IndexKind,
    /// Number of keys the index has.
    pub key_count: u32,
}

impl Instance {
    /// Texels of the map; fits a u32 as both sides are at most 65535.
    pub const fn texel_count(&self) -> u32 {
        self.width.wrapping_mul(self.height)
    }

    /// The name of this instance's section of `kind`.
    pub const fn section(&self, kind: crate::section::FourCc) -> SectionId {
        SectionId::of_instance(self.layer, self.number, kind)
    }

    /// The record that stores this instance.
    pub fn to_record(self) -> InstanceRecord {
        InstanceRecord {
            layer: U16::new(self.layer),
            number: U16::new(self.number),
            method: U16::new(self.method.code()),
            wrap: U16::new(self.wrap as u16),
            width: U32::new(self.width),
            height: U32::new(self.height),
            roughness: F64::new(self.roughness.unwrap_or(0.0)),
            bin_resolution: U32::new(self.grid.resolution()),
            leaf_size: U32::new(self.leaf_size),
            binning: U16::new(self.grid.binning() as u16),
            filter: U16::new(self.filter as u16),
            index: U16::new(self.index as u16),
            inverse: U16::new(self.inverse as u16),
            key_count: U32::new(self.key_count),
            reserved: [0; 20],
        }
    }

    /// The instance stored in `record`, found at place `place` of its section.
    ///
    /// # Errors
    /// [`Fault::UnknownMethod`], [`Fault::InstanceNumber`] or [`Fault::InstanceField`], with the record's place.
    pub fn from_record(record: &InstanceRecord, place: u64) -> Result<Self, Finding> {
        let finding = |fault| {
            Finding::new(fault)
                .within(SectionId::shared(INSTANCES))
                .at(place)
        };
        let expected_number = place.wrapping_add(1);
        let number = record.number.get();
        if u64::from(number) != expected_number {
            return Err(finding(Fault::InstanceNumber).values(expected_number, u64::from(number)));
        }
        let method = Method::from_code(record.method.get()).ok_or(finding(Fault::UnknownMethod))?;
        let field = finding(Fault::InstanceField);
        let side = |value: U32| match value.get() {
            side @ 1..=0xFFFF => Ok(side),
            other => Err(field.values(0xFFFF, u64::from(other))),
        };
        let binning = Binning::from_code(record.binning.get()).ok_or(field)?;
        let expected_binning = match method {
            Method::FlakeBins => Binning::DiskGrid,
            Method::SpecularBins => Binning::EqualSolidAngle,
        };
        if binning != expected_binning {
            return Err(field);
        }
        let roughness = match (method, record.roughness.get()) {
            (Method::FlakeBins, alpha) if ROUGHNESS.contains(&alpha) => Some(alpha),
            (Method::SpecularBins, 0.0) => None,
            _ => return Err(field),
        };
        let index = match record.index.get() {
            0 => IndexKind::Dense,
            1 => IndexKind::Sparse,
            other => return Err(field.values(1, u64::from(other))),
        };
        let inverse = InverseKind::from_code(record.inverse.get())
            .ok_or(field.values(2, u64::from(record.inverse.get())))?;
        let grid = BinGrid::new(binning, record.bin_resolution.get()).ok_or(field)?;
        let key_count = record.key_count.get();
        let instance = Self {
            layer: record.layer.get(),
            number,
            method,
            wrap: Wrap::from_code(record.wrap.get()).ok_or(field)?,
            width: side(record.width)?,
            height: side(record.height)?,
            roughness,
            grid,
            inverse,
            leaf_size: record.leaf_size.get(),
            filter: Filter::from_code(record.filter.get()).ok_or(field)?,
            index,
            key_count,
        };
        let keys_fit = match index {
            IndexKind::Dense => key_count == grid.count(),
            IndexKind::Sparse => key_count <= grid.count() && key_count <= instance.texel_count(),
        };
        let leaves_fit = (instance.leaf_size > 0) == (inverse == InverseKind::Forest);
        if !keys_fit || key_count == 0 || key_count == u32::MAX || !leaves_fit {
            return Err(field);
        }
        // Also catches reserved bytes, and a negative zero where zero is canonical.
        if instance.to_record().as_bytes() != record.as_bytes() {
            return Err(finding(Fault::ReservedNotZero));
        }
        Ok(instance)
    }
}
