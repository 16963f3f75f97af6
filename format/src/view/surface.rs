//! Normals in rows, and global NDFs.

use super::bin_tables::elements;
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::records::{GLOBAL_NDF, GLOBAL_ROOT, Instance, NORMALS, SurfaceNormal, TileRoot};
use crate::section::SectionId;
use zerocopy::little_endian::U32;

/// The normals of one map.
#[derive(Clone, Copy, Debug)]
pub struct Normals<'a> {
    /// The section.
    pub id: SectionId,
    /// The map's columns and rows.
    pub size: [u32; 2],
    /// Normals at the middles of texels, row by row.
    pub normals: &'a [SurfaceNormal],
}

impl<'a> Normals<'a> {
    /// The normals stored with `instance` itself, or `None` if it stores none. O(1).
    ///
    /// # Errors
    /// If there are not as many as the map has texels.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        let id = instance.section(NORMALS);
        if container.find(id).is_none() {
            return Ok(None);
        }
        let count = instance.texel_count() as usize;
        Ok(Some(Self {
            id,
            size: [instance.width, instance.height],
            normals: elements(container, instance, NORMALS, count)?,
        }))
    }

    /// The normals of the map that `instance` was baked from: its own, or those of the first other instance of the same map,
    /// method and structure that stores them. O(instances).
    ///
    /// # Errors
    /// As [`open`](Self::open), and if no instance stores them.
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        super::of_map(container, instance, Self::open)?
            .ok_or(Finding::new(Fault::SectionMissing).within(instance.section(NORMALS)))
    }

    /// The normal of the texel in `column` and `row`, if there is one.
    #[inline(always)]
    pub fn normal(&self, column: u32, row: u32) -> Option<[f64; 2]> {
        let place = (row as usize)
            .wrapping_mul(self.size[0] as usize)
            .wrapping_add(column as usize);
        self.normals.get(place).map(|normal| normal.point())
    }

    /// The `N` normals from `column` on in `row`, if there are so many in the row.
    #[inline(always)]
    pub fn run<const N: usize>(&self, column: u32, row: u32) -> Option<&'a [SurfaceNormal; N]> {
        let end = (column as usize).checked_add(N)?;
        if end > self.size[0] as usize {
            return None;
        }
        let start = (row as usize)
            .wrapping_mul(self.size[0] as usize)
            .wrapping_add(column as usize);
        self.normals.get(start..)?.first_chunk()
    }
}

/// Largest side of a global NDF's image.
const MOST_PIXELS: usize = 4096;

/// The global NDF of one instance: a mixture of tents about the pixels of an image.
#[derive(Clone, Copy, Debug)]
pub struct GlobalNdf<'a> {
    /// The section of shares.
    pub id: SectionId,
    /// The middle of the first pixel, as a point of the disk.
    pub low: [f64; 2],
    /// From one pixel to the next, along s and along t; positive.
    pub pitch: [f64; 2],
    /// Pixels along a side.
    pub side: u32,
    /// Shares of the pixels, row by row, each with those before it, of `u32::MAX`.
    pub sums: &'a [U32],
}

impl<'a> GlobalNdf<'a> {
    /// The global NDF stored with `instance`. O(1).
    ///
    /// # Errors
    /// If it is missing, no square, or its pixels have no size.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        let id = instance.section(GLOBAL_NDF);
        let sums: &[U32] = container.elements(id)?;
        let side = sums.len().isqrt();
        if !(2..=MOST_PIXELS).contains(&side) || side.wrapping_mul(side) != sums.len() {
            return Err(Finding::new(Fault::SectionCount).within(id));
        }
        let root_id = instance.section(GLOBAL_ROOT);
        let root: &[TileRoot] = elements(container, instance, GLOBAL_ROOT, 1)?;
        let damaged = Finding::new(Fault::GlobalRoot).within(root_id);
        let root = root.first().ok_or(damaged)?;
        let [low, pitch] = [root.low, root.step].map(|pair| pair.map(|x| f64::from(x.get())));
        let is_low = |x: &f64| x.abs() <= 1e6;
        let is_pitch = |x: &f64| (1e-9..=1e6).contains(x);
        if !low.iter().all(is_low) || !pitch.iter().all(is_pitch) {
            return Err(damaged);
        }
        Ok(Self {
            id,
            low,
            pitch,
            side: side as u32,
            sums,
        })
    }

    /// The share of all before the pixel at `place`, of `u32::MAX`; all from the end on.
    #[inline]
    pub fn before(&self, place: usize) -> u32 {
        match place.checked_sub(1) {
            None => 0,
            Some(last) => self.sums.get(last).map_or(u32::MAX, |sum| sum.get()),
        }
    }

    /// The share of the pixel in `column` and `row` of all, in [0, 1]; 0 beyond the image.
    #[inline]
    pub fn share(&self, column: i64, row: i64) -> f64 {
        let pixels = 0..i64::from(self.side);
        if !pixels.contains(&column) || !pixels.contains(&row) {
            return 0.0;
        }
        let place = (row as usize)
            .wrapping_mul(self.side as usize)
            .wrapping_add(column as usize);
        let share = self
            .before(place.wrapping_add(1))
            .saturating_sub(self.before(place));
        f64::from(share) / f64::from(u32::MAX)
    }
}
