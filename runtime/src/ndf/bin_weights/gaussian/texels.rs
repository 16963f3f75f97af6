//! Texels under a Gaussian one by one, each with its exact weight.

use super::Target;
use crate::error::QueryError;
use crate::ndf::bin_weights::keys::{ELSEWHERE, StoredKey};
use crate::ndf::bin_weights::scan::missing;
use crate::overlap::{GaussianFootprint, GaussianRow};
use crate::scan::{Budget, MapShape};
use crate::simd::Work;
use core::array;
use core::hint::black_box;
use core::ops::Range;
use glintbake_format::model::{BLOCK_SIDE, BLOCK_TEXELS, Wrap};
use glintbake_format::view::{KeyLayout, Keys};

const SIDE: i64 = BLOCK_SIDE as i64;
/// Texels in a row of a block.
const LINE: usize = BLOCK_SIDE as usize;

/// The rows of texels of a row of blocks.
pub(super) type Rows<'a> = [GaussianRow<'a>; LINE];

/// The rows of texels from `top` on.
#[inline(always)]
pub(super) fn rows(footprint: &GaussianFootprint, top: i64) -> Rows<'_> {
    array::from_fn(|row| footprint.row(top + row as i64))
}

/// Adds the wanted texels of block (`column`, `row`), whose keys are `keys`, to the sums: `rows` are its rows, `left` is
/// where its first column lies in their footprint.
#[inline(always)]
pub(super) fn add_block<K: StoredKey>(
    target: &mut Target<'_>,
    rows: &Rows<'_>,
    keys: &[K; BLOCK_TEXELS],
    [column, row]: [u32; 2],
    left: i64,
    evenly: bool,
) {
    let instance = &target.tables.instance;
    let texels_wide = instance
        .width
        .saturating_sub(column * BLOCK_SIDE)
        .min(BLOCK_SIDE);
    let texels_high = instance
        .height
        .saturating_sub(row * BLOCK_SIDE)
        .min(BLOCK_SIDE);
    let lines = keys.as_chunks::<LINE>().0.iter().zip(rows);
    for (keys, row) in lines.take(texels_high as usize) {
        if !K::any_wanted(keys, target.runs) {
            continue;
        }
        let mut places = K::places(keys, target.runs);
        for place in places.iter_mut().skip(texels_wide as usize) {
            *place = ELSEWHERE;
        }
        let columns = row.columns();
        if evenly && columns.start <= left && left + SIDE <= columns.end {
            let mut weights = [0.0; LINE];
            row.fill(left, &mut weights);
            for (&place, weight) in places.iter().zip(weights) {
                if place != ELSEWHERE {
                    target.sums.add(u32::from(place), weight);
                }
            }
        } else {
            for (&place, column) in places.iter().zip(left..) {
                if place != ELSEWHERE {
                    target.sums.add(u32::from(place), row.weight(column));
                }
            }
        }
    }
}

/// Adds the weights of all wanted texels of the map's first tile under `footprint` to the sums.
pub(super) struct Scan<'s, 't> {
    pub target: &'s mut Target<'t>,
    pub footprint: &'s GaussianFootprint,
    pub budget: &'s mut Budget,
}

impl Work for Scan<'_, '_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        match self.target.tables.bin_map.keys {
            Keys::Narrow(keys) => self.scan(keys),
            Keys::Wide(keys) => self.scan(keys),
        }
    }
}

impl Scan<'_, '_> {
    #[inline(always)]
    fn scan<K: StoredKey>(self, keys: &[K]) -> Result<(), QueryError> {
        let Self {
            target,
            footprint,
            budget,
        } = self;
        let layout = target.tables.bin_map.layout;
        let instance = &target.tables.instance;
        let evenly = footprint.is_smooth();
        let mut space = [K::default(); BLOCK_TEXELS];
        for row in blocks(&footprint.rows(), instance.height) {
            let top = i64::from(row) * SIDE;
            let columns = blocks(&footprint.strip_columns(top, SIDE), instance.width);
            if columns.is_empty() {
                continue;
            }
            budget.spend(columns.len() as u64 * BLOCK_TEXELS as u64)?;
            if let KeyLayout::Blocks(layout) = layout {
                // Fetches the blocks all at once.
                for column in columns.clone() {
                    let block = keys.get(layout.block(column, row)..).unwrap_or_default();
                    black_box((block.first().copied(), block.get(BLOCK_TEXELS / 2).copied()));
                }
            }
            let rows = rows(footprint, top);
            for column in columns {
                let block = layout
                    .block(keys, column, row, &mut space)
                    .ok_or(missing(target.tables))?;
                let [first, second] = block.as_chunks::<{ BLOCK_TEXELS / 2 }>().0 else {
                    continue;
                };
                if K::any_wanted(first, target.runs) | K::any_wanted(second, target.runs) {
                    let left = i64::from(column) * SIDE;
                    add_block(target, &rows, block, [column, row], left, evenly);
                }
            }
        }
        Ok(())
    }
}

/// The blocks, of a map of `size` texels, that `texels` lie in.
fn blocks(texels: &Range<i64>, size: u32) -> Range<u32> {
    let size = i64::from(size);
    let (start, end) = (texels.start.clamp(0, size), texels.end.clamp(0, size));
    if start >= end {
        return 0..0;
    }
    (start / SIDE) as u32..(end as u64).div_ceil(SIDE as u64) as u32
}

/// Calls `visit` with `footprint` as seen from each tile of a map of `shape` that it meets; of a clamped map there is
/// but one. With `fold`, with one for each row of tiles: whoever is called knows that columns repeat.
#[inline(always)]
pub(super) fn for_each_copy(
    shape: MapShape,
    footprint: &GaussianFootprint,
    fold: bool,
    visit: &mut impl FnMut(&GaussianFootprint) -> Result<(), QueryError>,
) -> Result<(), QueryError> {
    if shape.wrap == Wrap::Clamp {
        return visit(footprint);
    }
    let (width, height) = (i64::from(shape.width), i64::from(shape.height));
    let rows = footprint.rows();
    for row in rows.start.div_euclid(height)..=(rows.end - 1).div_euclid(height) {
        let top = row * height;
        if fold {
            visit(&footprint.relative_to(0.0, top as f64))?;
            continue;
        }
        let columns = footprint.strip_columns(top, height);
        if columns.is_empty() {
            continue;
        }
        for column in columns.start.div_euclid(width)..=(columns.end - 1).div_euclid(width) {
            visit(&footprint.relative_to((column * width) as f64, top as f64))?;
        }
    }
    Ok(())
}

/// Calls `visit(column, row, weight)` for every texel of the map under `footprint`: once for each tile in which it meets
/// it, and the border's texels of a clamped map once more for what lies beyond.
///
/// # Errors
/// [`QueryError::TooManyTexels`] beyond 128 times the map, or what `visit` returns.
pub(crate) fn for_each_texel(
    shape: MapShape,
    footprint: &GaussianFootprint,
    visit: &mut impl FnMut(u32, u32, f64) -> Result<(), QueryError>,
) -> Result<(), QueryError> {
    let (width, height) = (i64::from(shape.width), i64::from(shape.height));
    if super::is_even(shape, footprint) {
        let weight = 1.0 / (f64::from(shape.width) * f64::from(shape.height));
        for row in 0..shape.height {
            for column in 0..shape.width {
                visit(column, row, weight)?;
            }
        }
        return Ok(());
    }
    let mut budget = Budget::for_gaussian(shape);
    for_each_copy(shape, footprint, false, &mut |footprint| {
        let rows = footprint.rows();
        for row in rows.start.clamp(0, height)..rows.end.clamp(0, height) {
            let line = footprint.row(row);
            let columns = line.columns();
            let columns = columns.start.clamp(0, width)..columns.end.clamp(0, width);
            budget.spend(columns.end.saturating_sub(columns.start).max(0) as u64)?;
            for column in columns {
                visit(column as u32, row as u32, line.weight(column))?;
            }
        }
        Ok(())
    })?;
    super::border::for_each_texel(shape, footprint, visit)
}
