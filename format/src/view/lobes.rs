//! Lobes of position and normal, under a box pyramid.

use super::bin_tables::elements;
use super::{BoxPyramid, PyramidBox};
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::{LobeLattice, PYRAMID_SIDE};
use crate::records::{
    CurvedLobeBlock, CurvedWideLobeBlock, Instance, LOBE_INDEX, LOBE_MOMENTS, LOBE_SPREADS, LOBES,
    LobeBlock, LobeIndex, LobeMoments, LobeSlopes, LobeSpreads, Structure, WIDE_LOBES,
    WideLobeBlock, WideLobeSlopes,
};
use crate::section::{FourCc, SectionId};
use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

/// The lobes of one map.
#[derive(Clone, Copy, Debug)]
pub struct Lobes<'a> {
    /// What they are.
    pub lattice: LobeLattice,
    /// The boxes of their normals.
    pub pyramid: BoxPyramid<'a>,
    /// The section of blocks.
    pub id: SectionId,
    /// For each node of level 1, where its blocks lie.
    pub index: &'a [LobeIndex],
    /// How far lobes spread in the children of every node; empty for flat lobes.
    pub spreads: &'a [LobeSpreads],
    /// Moments of the children of every node.
    pub moments: &'a [LobeMoments],
    /// Blocks in 16 bits.
    blocks: Blocks<'a, LobeBlock, CurvedLobeBlock>,
    /// Blocks in full.
    wide_blocks: Blocks<'a, WideLobeBlock, CurvedWideLobeBlock>,
}

/// Blocks with or without slopes.
#[derive(Clone, Copy, Debug)]
enum Blocks<'a, F, C> {
    Flat(&'a [F]),
    Curved(&'a [C]),
}

impl<'a, F, C> Blocks<'a, F, C>
where
    F: FromBytes + Immutable + KnownLayout + Unaligned,
    C: FromBytes + Immutable + KnownLayout + Unaligned,
{
    /// Those of section `kind`; none if it is absent.
    fn open(
        container: &Container<'a>,
        instance: &Instance,
        kind: FourCc,
        is_curved: bool,
    ) -> Result<Self, Finding> {
        let id = instance.section(kind);
        if container.find(id).is_none() {
            return Ok(Self::Flat(&[]));
        }
        Ok(if is_curved {
            Self::Curved(container.elements(id)?)
        } else {
            Self::Flat(container.elements(id)?)
        })
    }

    const fn len(&self) -> usize {
        match self {
            Self::Flat(blocks) => blocks.len(),
            Self::Curved(blocks) => blocks.len(),
        }
    }
}

/// The lobes of a block.
#[derive(Clone, Copy, Debug)]
pub enum LobesOfBlock<'a> {
    /// In 16 bits; slopes unless lobes are flat.
    Narrow(&'a LobeBlock, Option<&'a LobeSlopes>),
    /// In full; slopes unless lobes are flat.
    Wide(&'a WideLobeBlock, Option<&'a WideLobeSlopes>),
    /// Merged: those of the cell's moments.
    Merged,
}

/// One lobe of a lattice, or a cell as one lobe: what its normals are at its middle, and how they lean from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeNormal {
    /// The point (s, t) at the middle.
    pub normal: [f64; 2],
    /// J: ∂s/∂x, ∂s/∂y, ∂t/∂x, ∂t/∂y per spacing of the lattice.
    pub slope: [f64; 4],
}

/// A cell as one lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellLobe {
    /// Normal and slope.
    pub lobe: LobeNormal,
    /// Variance of s, covariance, variance of t about the plane.
    pub residual: [f64; 3],
}

impl<'a> Lobes<'a> {
    /// The lobes stored with `instance` itself, or `None` if it stores none. O(1).
    ///
    /// # Errors
    /// If one of its sections is missing, or has not as many elements as others say.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        let Structure::Lobes(lattice) = instance.structure else {
            return Ok(None);
        };
        let Some(pyramid) = BoxPyramid::open(container, instance)? else {
            return Ok(None);
        };
        let (nodes, lowest) = (pyramid.layout.node_count(), pyramid.layout.lowest_count());
        let lobes = Self {
            lattice,
            pyramid,
            id: instance.section(LOBES),
            index: elements(container, instance, LOBE_INDEX, lowest as usize)?,
            spreads: counted(
                container,
                instance,
                (
                    LOBE_SPREADS,
                    if lattice.curved { nodes as usize } else { 0 },
                ),
            )?,
            moments: elements(container, instance, LOBE_MOMENTS, nodes as usize)?,
            blocks: Blocks::open(container, instance, LOBES, lattice.curved)?,
            wide_blocks: Blocks::open(container, instance, WIDE_LOBES, lattice.curved)?,
        };
        Ok(Some(lobes))
    }

    /// The lobes of the map that `instance` was baked from: its own, or those of the first other instance of the same map,
    /// method and structure that stores them. O(instances).
    ///
    /// # Errors
    /// As [`open`](Self::open), and if no instance stores them.
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        super::of_map(container, instance, Self::open)?
            .ok_or(Finding::new(Fault::SectionMissing).within(instance.section(LOBE_INDEX)))
    }

    /// How many blocks are stored in 16 bits, and how many in full.
    pub const fn block_counts(&self) -> [usize; 2] {
        [self.blocks.len(), self.wide_blocks.len()]
    }

    /// That something of the lobes is not there.
    pub fn damaged(&self) -> Finding {
        Finding::new(Fault::SectionCount).within(self.id)
    }

    /// The lobes of child `child` of the node of level 1 at `place`.
    ///
    /// # Errors
    /// If they are not stored.
    #[inline]
    pub fn block(&self, place: usize, child: u32) -> Result<LobesOfBlock<'a>, Finding> {
        let index = self.index.get(place).ok_or_else(|| self.damaged())?;
        let bit = 1_u32 << (child & 15);
        let before = bit.wrapping_sub(1);
        let (narrow, wide) = (u32::from(index.narrow.get()), u32::from(index.wide.get()));
        let at = |first: u32, mask: u32| first.wrapping_add((mask & before).count_ones()) as usize;
        if narrow & bit != 0 {
            let at = at(index.first.get(), narrow);
            let block = match self.blocks {
                Blocks::Flat(blocks) => blocks.get(at).map(|block| (block, None)),
                Blocks::Curved(blocks) => {
                    let block = blocks.get(at);
                    block.map(|block| (&block.normals, Some(&block.slopes)))
                }
            };
            let (block, slopes) = block.ok_or_else(|| self.damaged())?;
            return Ok(LobesOfBlock::Narrow(block, slopes));
        }
        if wide & bit != 0 {
            let at = at(index.first_wide.get(), wide);
            let block = match self.wide_blocks {
                Blocks::Flat(blocks) => blocks.get(at).map(|block| (block, None)),
                Blocks::Curved(blocks) => {
                    let block = blocks.get(at);
                    block.map(|block| (&block.normals, Some(&block.slopes)))
                }
            };
            let (block, slopes) = block.ok_or_else(|| self.damaged())?;
            return Ok(LobesOfBlock::Wide(block, slopes));
        }
        Ok(LobesOfBlock::Merged)
    }

    /// The most that a lobe spreads in child `child` of the node at `place`; 0 for flat lobes.
    #[inline]
    pub fn spread(&self, place: usize, child: u32) -> f64 {
        self.spreads.get(place).map_or(0.0, |spreads| {
            let greatest = spreads.greatest.get(child as usize).copied().unwrap_or(0);
            f64::from(greatest) * f64::from(spreads.step.get())
        })
    }

    /// Child `child` of the node at `place` as one lobe; `bounds` is the child's box.
    ///
    /// # Errors
    /// If its moments are not stored.
    #[inline]
    pub fn cell(&self, place: usize, child: u32, bounds: &PyramidBox) -> Result<CellLobe, Finding> {
        let moments = self.moments.get(place).ok_or_else(|| self.damaged())?;
        moments.cell(child, bounds).ok_or_else(|| self.damaged())
    }

    /// Lobe number `number` of child `child` of the node of level 1 at `place`, whose box is `bounds`. In f64; what queries do
    /// in blocks.
    ///
    /// # Errors
    /// If it is not stored.
    pub fn lobe(
        &self,
        place: usize,
        child: u32,
        number: u32,
        bounds: &PyramidBox,
    ) -> Result<LobeNormal, Finding> {
        let lobe = match self.block(place, child)? {
            LobesOfBlock::Narrow(block, slopes) => block.lobe(slopes, number as usize),
            LobesOfBlock::Wide(block, slopes) => block.lobe(slopes, number as usize),
            LobesOfBlock::Merged => {
                let (column, row) = (number % PYRAMID_SIDE, number / PYRAMID_SIDE);
                let cell = self.cell(place, child, bounds)?.lobe;
                let middle = 0.5 * f64::from(PYRAMID_SIDE - 1);
                Some(cell.at(f64::from(column) - middle, f64::from(row) - middle))
            }
        };
        lobe.ok_or_else(|| self.damaged())
    }
}

impl LobeNormal {
    /// How far normals range over one deviation of the lobe's position: σh |J|.
    #[inline]
    pub fn spread(&self) -> f64 {
        let squared: f64 = self.slope.iter().map(|slope| slope * slope).sum();
        LobeLattice::DEVIATION * libm::sqrt(squared)
    }

    /// The same plane seen from `x` columns and `y` rows farther on.
    #[inline]
    pub fn at(&self, x: f64, y: f64) -> Self {
        let [s_x, s_y, t_x, t_y] = self.slope;
        let [s, t] = self.normal;
        Self {
            normal: [s + s_x * x + s_y * y, t + t_x * x + t_y * y],
            slope: self.slope,
        }
    }
}

impl LobeBlock {
    /// Lobe `number` with its slope from `slopes`; `None` beyond 15.
    pub fn lobe(&self, slopes: Option<&LobeSlopes>, number: usize) -> Option<LobeNormal> {
        let (s, t) = (self.s.get(number)?.get(), self.t.get(number)?.get());
        let (x, y) = ((number % 4) as f64 - 1.5, (number / 4) as f64 - 1.5);
        let [s_x, s_y, t_x, t_y] = self.plane.map(|slope| f64::from(slope.get()));
        let component =
            |low: f32, step: f32, n: u16| f64::from(low) + f64::from(step) * f64::from(n);
        let [low_s, low_t] = self.low.map(|x| x.get());
        let [step_s, step_t] = self.step.map(|x| x.get());
        let normal = [
            component(low_s, step_s, s) + (s_x * x + s_y * y),
            component(low_t, step_t, t) + (t_x * x + t_y * y),
        ];
        let unit = f64::from(self.slope_step.get());
        let slope = match slopes {
            Some(slopes) => {
                let [s_x, s_y, t_x, t_y] = [&slopes.s_x, &slopes.s_y, &slopes.t_x, &slopes.t_y];
                let of = |lanes: &[zerocopy::little_endian::I16; 16]| {
                    Some(unit * f64::from(lanes.get(number)?.get()))
                };
                [of(s_x)?, of(s_y)?, of(t_x)?, of(t_y)?]
            }
            None => [0.0; 4],
        };
        Some(LobeNormal { normal, slope })
    }
}

impl WideLobeBlock {
    /// Lobe `number` with its slope from `slopes`; `None` beyond 15.
    pub fn lobe(&self, slopes: Option<&WideLobeSlopes>, number: usize) -> Option<LobeNormal> {
        let of =
            |lanes: &[zerocopy::little_endian::F32; 16]| Some(f64::from(lanes.get(number)?.get()));
        let slope = match slopes {
            Some(slopes) => [
                of(&slopes.s_x)?,
                of(&slopes.s_y)?,
                of(&slopes.t_x)?,
                of(&slopes.t_y)?,
            ],
            None => [0.0; 4],
        };
        Some(LobeNormal {
            normal: [of(&self.s)?, of(&self.t)?],
            slope,
        })
    }
}

impl LobeMoments {
    /// Child `child` as one lobe, `bounds` its box; `None` beyond 15.
    #[inline]
    pub fn cell(&self, child: u32, bounds: &PyramidBox) -> Option<CellLobe> {
        let lane = child as usize;
        let extent = bounds.extent();
        let mean = |n: u16, axis: usize| -> Option<f64> {
            Some(*bounds.low.get(axis)? + f64::from(n) / 65535.0 * *extent.get(axis)?)
        };
        let unit = f64::from(self.slope_step.get());
        let [s_x, s_y, t_x, t_y] = &self.slope;
        let slope = |lanes: &[zerocopy::little_endian::I16; 16]| {
            Some(unit * f64::from(lanes.get(lane)?.get()))
        };
        let deviation =
            |bytes: &[u8; 16], side: f64| Some(f64::from(*bytes.get(lane)?) / 255.0 * side);
        let [width, height] = extent;
        let (s, t) = (
            deviation(&self.deviation_s, width)?,
            deviation(&self.deviation_t, height)?,
        );
        let correlation = ((f64::from(*self.correlation.get(lane)?) - 127.0) / 127.0).min(1.0);
        Some(CellLobe {
            lobe: LobeNormal {
                normal: [
                    mean(self.mean_s.get(lane)?.get(), 0)?,
                    mean(self.mean_t.get(lane)?.get(), 1)?,
                ],
                slope: [slope(s_x)?, slope(s_y)?, slope(t_x)?, slope(t_y)?],
            },
            residual: [s * s, correlation * s * t, t * t],
        })
    }
}

/// The `count` elements of `kind`, which is absent if there are none.
fn counted<'a, T: FromBytes + Immutable + KnownLayout + Unaligned>(
    container: &Container<'a>,
    instance: &Instance,
    (kind, count): (FourCc, usize),
) -> Result<&'a [T], Finding> {
    if count == 0 {
        return Ok(&[]);
    }
    elements(container, instance, kind, count)
}
