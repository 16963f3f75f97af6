//! Instance records: what was baked, by which method, and with which numbers.

use crate::finding::{Fault, Finding};
use crate::model::{
    BinGrid, Binning, BoxPyramidLayout, ClusterLayout, Filter, Interpolation, Kernel, LobeLattice,
    Method, MipLayout, NdfMapLayout, NdfPixels, PyramidLayout, QuiltLayout, Wrap,
};
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
    /// 24: bins per side; 0 without bins.
    pub bin_resolution: U32,
    /// 28: the longest list that is scanned without a tree; 0 without a forest.
    pub leaf_size: U32,
    /// 32: binning; 0 without bins.
    pub binning: U16,
    /// 34: filter of a query that names none.
    pub filter: U16,
    /// 36: index kind; 0 without bins.
    pub index: U16,
    /// 38: inverse kind; 0 without bins.
    pub inverse: U16,
    /// 40: number of keys the index has; 0 without bins.
    pub key_count: U32,
    /// 44: finest level of a pyramid; 0 without one.
    pub finest_level: U32,
    /// 48: kernel of a query that names none, for a method that has several; else 0.
    pub kernel: U16,
    /// 50: interpolation of normals; 0 for a method that does not interpolate.
    pub interpolation: u8,
    /// 51: lobes along a side of a texel, 1 or 2; 0 without lobes.
    pub lobes_per_side: u8,
    /// 52: 1 for curved lobes; else 0.
    pub lobes_curved: u8,
    /// 53: binary logarithm of the texels from one patch of a quilt to the next; 0 without a quilt.
    pub patch_log: u8,
    /// 54: columns, or rows, that blocks of a quilt share; 0 without a quilt.
    pub overlap: u8,
    /// 55: binary logarithm of what origins of blocks are multiples of; 0 without a quilt.
    pub grid_log: u8,
    /// 56: the lowest level of clustered lobes, from 1; 0 without these.
    pub first_level: u8,
    /// 57: blocks of sixteen lobes of each cell, from 1; 0 without clustered lobes.
    pub cell_blocks: u8,
    /// 58: how pixels of NDF images are read; 0 without these.
    pub ndf_pixels: u8,
    /// 59: of NDF maps, 1 if copies are scattered, plus 2 if their scale changes slopes; else 0.
    pub ndf_copies: u8,
    /// 60: columns and rows of the sample, or of the example; 0 without either.
    pub sample: [U16; 2],
}

const _: () = assert!(
    size_of::<InstanceRecord>() == 64,
    "an instance record is 64 bytes"
);

/// Normals by bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bins {
    /// The bins.
    pub grid: BinGrid,
    /// How the texels of a bin are found.
    pub inverse: InverseKind,
    /// The longest list that is scanned without a tree, at least 1; 0 without a forest.
    pub leaf_size: u32,
    /// How keys find their bin.
    pub index: IndexKind,
    /// Number of keys the index has.
    pub key_count: u32,
}

/// What an instance keeps of the map's normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// The bin of each texel, and what finds the texels of a bin.
    Bins(Bins),
    /// Moments of the normals in the cells of a [`PyramidLayout`].
    Pyramid {
        /// The finest level stored, 0 for the texels themselves.
        finest_level: u32,
    },
    /// A tree over positions and normals, in the tiles of a [`ClusterLayout`].
    Clusters {
        /// Kernel of a query that names none: Beckmann's or the disk's.
        kernel: Kernel,
    },
    /// Lobes of position and normal, under a box pyramid over their lattice.
    Lobes(LobeLattice),
    /// Clustered lobes of position and normal, level by level, of a map or of a surface quilted from a sample.
    MipLobes(MipLayout),
    /// Images of the NDFs of the tiles of an example, and how its copies make up the surface.
    NdfMaps(NdfMapLayout),
    /// The normals themselves, under a box pyramid over the squares between them.
    Surface {
        /// How normals continue between texels.
        interpolation: Interpolation,
    },
}

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
    /// Filter of a query that names none.
    pub filter: Filter,
    /// What it keeps of the map's normals.
    pub structure: Structure,
}

impl Instance {
    /// Texels of the map; fits a u32 as both sides are at most 65535.
    pub const fn texel_count(&self) -> u32 {
        self.width.wrapping_mul(self.height)
    }

    /// Whether `other` keeps the same of the same map, for the same method: what one of them stores of it serves both.
    pub fn keeps_the_same_as(&self, other: &Self) -> bool {
        let structures_agree = match (self.structure, other.structure) {
            // A tree serves every kernel.
            (Structure::Clusters { .. }, Structure::Clusters { .. }) => true,
            (own, other) => own == other,
        };
        structures_agree
            && (self.layer, self.method) == (other.layer, other.method)
            && (self.width, self.height) == (other.width, other.height)
    }

    /// The name of this instance's section of `kind`.
    pub const fn section(&self, kind: crate::section::FourCc) -> SectionId {
        SectionId::of_instance(self.layer, self.number, kind)
    }

    /// The bins, of a method that has them.
    pub const fn bins(&self) -> Option<Bins> {
        match self.structure {
            Structure::Bins(bins) => Some(bins),
            _ => None,
        }
    }

    /// The layout of the pyramid, of a method that has one.
    pub const fn pyramid(&self) -> Option<PyramidLayout> {
        match self.structure {
            Structure::Pyramid { finest_level } => {
                PyramidLayout::new(self.width, self.height, finest_level)
            }
            _ => None,
        }
    }

    /// The layout of the cluster tree, of a method that has one.
    pub const fn clusters(&self) -> Option<ClusterLayout> {
        match self.structure {
            Structure::Clusters { .. } => ClusterLayout::new(self.width, self.height),
            _ => None,
        }
    }

    /// The layout of the box pyramid, of a method that has one.
    pub const fn box_pyramid(&self) -> Option<BoxPyramidLayout> {
        match self.structure {
            Structure::Lobes(lattice) => {
                let [columns, rows] = lattice.size(self.width, self.height);
                BoxPyramidLayout::new(columns, rows)
            }
            Structure::Surface { .. } => BoxPyramidLayout::new(self.width, self.height),
            _ => None,
        }
    }

    /// The kernel of a query that names none.
    pub const fn kernel(&self) -> Kernel {
        match self.structure {
            Structure::Clusters { kernel } => kernel,
            _ => self.method.kernel(),
        }
    }

    /// The record that stores this instance.
    pub fn to_record(self) -> InstanceRecord {
        let record = InstanceRecord {
            layer: U16::new(self.layer),
            number: U16::new(self.number),
            method: U16::new(self.method.code()),
            wrap: U16::new(self.wrap as u16),
            width: U32::new(self.width),
            height: U32::new(self.height),
            roughness: F64::new(self.roughness.unwrap_or(0.0)),
            bin_resolution: U32::ZERO,
            leaf_size: U32::ZERO,
            binning: U16::ZERO,
            filter: U16::new(self.filter as u16),
            index: U16::ZERO,
            inverse: U16::ZERO,
            key_count: U32::ZERO,
            finest_level: U32::ZERO,
            kernel: U16::ZERO,
            interpolation: 0,
            lobes_per_side: 0,
            lobes_curved: 0,
            patch_log: 0,
            overlap: 0,
            grid_log: 0,
            first_level: 0,
            cell_blocks: 0,
            ndf_pixels: 0,
            ndf_copies: 0,
            sample: [U16::ZERO; 2],
        };
        match self.structure {
            Structure::Bins(bins) => InstanceRecord {
                bin_resolution: U32::new(bins.grid.resolution()),
                leaf_size: U32::new(bins.leaf_size),
                binning: U16::new(bins.grid.binning() as u16),
                index: U16::new(bins.index as u16),
                inverse: U16::new(bins.inverse as u16),
                key_count: U32::new(bins.key_count),
                ..record
            },
            Structure::Pyramid { finest_level } => InstanceRecord {
                finest_level: U32::new(finest_level),
                ..record
            },
            Structure::Clusters { kernel } => InstanceRecord {
                kernel: U16::new(kernel as u16),
                ..record
            },
            Structure::Lobes(lattice) => InstanceRecord {
                lobes_per_side: lattice.per_side,
                lobes_curved: u8::from(lattice.curved),
                ..record
            },
            Structure::MipLobes(layout) => {
                let record = InstanceRecord {
                    lobes_per_side: layout.per_side,
                    lobes_curved: 1,
                    first_level: layout.first_level,
                    cell_blocks: layout.blocks,
                    ..record
                };
                match layout.quilt {
                    None => record,
                    Some(quilt) => InstanceRecord {
                        patch_log: quilt.patch_log,
                        overlap: quilt.overlap,
                        grid_log: quilt.grid_log,
                        sample: quilt.sample.map(|side| U16::new(side as u16)),
                        ..record
                    },
                }
            }
            Structure::NdfMaps(layout) => InstanceRecord {
                ndf_pixels: layout.pixels as u8,
                ndf_copies: u8::from(layout.is_scattered) | (u8::from(layout.scales_slopes) << 1),
                sample: [U16::new(layout.example() as u16); 2],
                ..record
            },
            Structure::Surface { interpolation } => InstanceRecord {
                interpolation: interpolation as u8,
                ..record
            },
        }
    }

    /// The instance stored in `record`, found at place `place` of its section.
    ///
    /// # Errors
    /// [`Fault::UnknownMethod`], [`Fault::InstanceNumber`], [`Fault::InstanceField`] or [`Fault::ReservedNotZero`] (also
    /// of a field that means nothing for the method), with the record's place.
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
        let (width, height) = (side(record.width)?, side(record.height)?);
        let roughness = match (method.kernel(), record.roughness.get()) {
            (Kernel::Beckmann | Kernel::Disk, alpha) if ROUGHNESS.contains(&alpha) => Some(alpha),
            (Kernel::BinAverage, 0.0) => None,
            _ => return Err(field),
        };
        let texels = width.wrapping_mul(height);
        let structure = match method {
            Method::FlakeBins => bins_of(record, Binning::DiskGrid, texels, field)?,
            Method::SpecularBins => bins_of(record, Binning::EqualSolidAngle, texels, field)?,
            Method::Lean => {
                let finest_level = record.finest_level.get();
                PyramidLayout::new(width, height, finest_level)
                    .ok_or(field.values(0, u64::from(finest_level)))?;
                Structure::Pyramid { finest_level }
            }
            Method::ClusterTree => match Kernel::from_code(record.kernel.get()) {
                Some(kernel @ (Kernel::Beckmann | Kernel::Disk)) => Structure::Clusters { kernel },
                _ => return Err(field.values(1, u64::from(record.kernel.get()))),
            },
            Method::Lobes => match (record.lobes_per_side, record.lobes_curved) {
                (per_side @ (1 | 2), curved @ (0 | 1)) => Structure::Lobes(LobeLattice {
                    curved: curved == 1,
                    per_side,
                }),
                (other, _) => return Err(field.values(1, u64::from(other))),
            },
            Method::MipLobes => Structure::MipLobes(mip_of(record, [width, height], field)?),
            Method::NdfMaps => Structure::NdfMaps(ndf_maps_of(record, [width, height], field)?),
            Method::Analytic => Structure::Surface {
                interpolation: Interpolation::from_code(record.interpolation)
                    .ok_or(field.values(2, u64::from(record.interpolation)))?,
            },
        };
        let instance = Self {
            layer: record.layer.get(),
            number,
            method,
            wrap: Wrap::from_code(record.wrap.get()).ok_or(field)?,
            width,
            height,
            roughness,
            filter: Filter::from_code(record.filter.get()).ok_or(field)?,
            structure,
        };
        // Also catches fields of other structures, and a negative zero where zero is canonical.
        if instance.to_record().as_bytes() != record.as_bytes() {
            return Err(finding(Fault::ReservedNotZero));
        }
        Ok(instance)
    }
}

/// The MIP lobes of `record`, of a surface of `size` texels; `field` is the finding if there are none such.
fn mip_of(record: &InstanceRecord, size: [u32; 2], field: Finding) -> Result<MipLayout, Finding> {
    let sample = record.sample.map(|side| u32::from(side.get()));
    let quilt = match record.patch_log {
        0 => None,
        patch_log => Some(
            QuiltLayout::new(size, sample, patch_log, record.overlap, record.grid_log)
                .ok_or(field.values(0, u64::from(patch_log)))?,
        ),
    };
    let layout = MipLayout {
        size,
        per_side: record.lobes_per_side,
        first_level: record.first_level,
        blocks: record.cell_blocks,
        quilt,
    };
    if layout.is_sound() && record.wrap.get() == Wrap::Repeat as u16 {
        Ok(layout)
    } else {
        Err(field.values(1, u64::from(record.first_level)))
    }
}

/// The NDF maps of `record`, of a surface of `size` texels; `field` is the finding if there are none such.
fn ndf_maps_of(
    record: &InstanceRecord,
    size: [u32; 2],
    field: Finding,
) -> Result<NdfMapLayout, Finding> {
    let example = record.sample.map(|side| u32::from(side.get()));
    let pixels = NdfPixels::from_code(record.ndf_pixels)
        .ok_or(field.values(1, u64::from(record.ndf_pixels)))?;
    let layout = NdfMapLayout {
        size: size[0],
        example_log: example[0].trailing_zeros().min(31) as u8,
        pixels,
        is_scattered: record.ndf_copies & 1 == 1,
        scales_slopes: record.ndf_copies & 2 == 2,
    };
    let is_square = size[0] == size[1] && example == [layout.example(); 2];
    if is_square && layout.is_sound() {
        Ok(layout)
    } else {
        Err(field.values(u64::from(layout.example()), u64::from(example[0])))
    }
}

/// The bins of `record`, which must be laid out by `expected` and not have more keys than a map of `texels` texels can;
/// `field` is the finding if they are not.
fn bins_of(
    record: &InstanceRecord,
    expected: Binning,
    texels: u32,
    field: Finding,
) -> Result<Structure, Finding> {
    let binning = Binning::from_code(record.binning.get()).ok_or(field)?;
    if binning != expected {
        return Err(field);
    }
    let index = match record.index.get() {
        0 => IndexKind::Dense,
        1 => IndexKind::Sparse,
        other => return Err(field.values(1, u64::from(other))),
    };
    let inverse = InverseKind::from_code(record.inverse.get())
        .ok_or(field.values(2, u64::from(record.inverse.get())))?;
    let bins = Bins {
        grid: BinGrid::new(binning, record.bin_resolution.get()).ok_or(field)?,
        inverse,
        leaf_size: record.leaf_size.get(),
        index,
        key_count: record.key_count.get(),
    };
    let keys_fit = match index {
        IndexKind::Dense => bins.key_count == bins.grid.count(),
        IndexKind::Sparse => bins.key_count <= bins.grid.count() && bins.key_count <= texels,
    };
    let leaves_fit = (bins.leaf_size > 0) == (inverse == InverseKind::Forest);
    if !keys_fit || bins.key_count == 0 || bins.key_count == u32::MAX || !leaves_fit {
        return Err(field);
    }
    Ok(Structure::Bins(bins))
}
