//! Gaussians so wide that every tile stands for its texels, with its slope.

use super::Target;
use super::blocks::{HALF_TILE, Page, TOGETHER, folds};
use super::forms::{Forms, exp_half};
use super::tables::SlopingTiles;
use super::texels::for_each_copy;
use crate::error::QueryError;
use crate::ndf::bin_weights::block_lists::WindowLists;
use crate::ndf::bin_weights::map_shape;
use crate::overlap::GaussianFootprint;
use crate::simd::Work;
use glintbake_format::model::{PAGE_SIDE, TILE_SIDE};
use glintbake_format::view::BlockLists;

/// Adds the weights of all wanted texels of the map under `footprint`, all tiles of which stand for their texels, to the
/// sums: all copies of a tile are weighed together, and lists are walked but once.
pub(super) struct WideTraversal<'s, 't> {
    pub target: &'s mut Target<'t>,
    pub footprint: &'s GaussianFootprint,
    pub forms: &'s Forms,
    pub lists: &'s BlockLists<'s>,
}

impl Work for WideTraversal<'_, '_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            target,
            footprint,
            forms,
            lists,
        } = self;
        let shape = map_shape(target.tables);
        let fold = folds(shape, footprint);
        for number in 0..lists.layout.count() {
            let corner = [number % lists.layout.columns, number / lists.layout.columns]
                .map(|place| place * PAGE_SIDE);
            let mut all = SlopingTiles::new();
            let mut meets = false;
            for_each_copy(shape, footprint, fold, &mut |footprint| {
                let page = Page::new(target.tables, forms, footprint, corner, fold);
                meets |= !page.rows.meets.is_empty();
                page.add_slopes(&mut all);
                Ok(())
            })?;
            if !meets {
                continue;
            }
            let mut window = WindowLists::NONE;
            window.find(lists, number, target.runs)?;
            for (place, list) in window.as_slice() {
                // In several sums, for one would wait for itself.
                let mut sums = [0.0_f32; TOGETHER];
                if list.tiles.is_empty() {
                    let chunks = list.blocks.chunks(TOGETHER);
                    for (names, counts) in chunks.zip(list.counts.chunks(TOGETHER)) {
                        for ((name, &count), sum) in names.iter().zip(counts).zip(&mut sums) {
                            *sum += f32::from(count) * all.block(name.get());
                        }
                    }
                } else {
                    for records in list.tiles.chunks(TOGETHER) {
                        for (record, sum) in records.iter().zip(&mut sums) {
                            let [weight, _, _] = all.tile(record.tile.get());
                            *sum += f32::from(record.texels.get()) * weight;
                        }
                    }
                }
                let sum: f64 = sums.into_iter().map(f64::from).sum();
                target.sums.add(*place, forms.tile.peak * sum);
            }
        }
        Ok(())
    }
}

impl Page<'_> {
    /// Adds what the tiles in the rows that may hold weight weigh, and their slopes, to `all`.
    #[inline(always)]
    fn add_slopes(&self, all: &mut SlopingTiles) {
        for row in self.rows.meets.clone() {
            let y = f32::from(row) * TILE_SIDE as f32 + HALF_TILE + self.origin[1];
            let Some(tiles) = all.0.get_mut(usize::from(row)) else {
                return;
            };
            for ([sum, sum_x, sum_y], column) in tiles.iter_mut().zip(0_u16..) {
                let x = f32::from(column) * TILE_SIDE as f32 + HALF_TILE + self.origin[0];
                let x = self.fold(x);
                let meets = self.forms.block.distance_squared(x, y) <= self.forms.tile_rule.end;
                let average = exp_half(self.forms.tile.distance_squared(x, y));
                let weight = if meets { average } else { 0.0 };
                let [slope_x, slope_y] = self.forms.tile.slope(x, y);
                *sum += weight;
                *sum_x -= weight * slope_x;
                *sum_y -= weight * slope_y;
            }
        }
    }
}
