//! What is known of the tiles and blocks of a page under a Gaussian, before lists are walked and while they are.

use super::blocks::{HALF_TILE, PAGE_TILES, ROW};
use glintbake_format::model::{BLOCK_SIDE, BLOCK_TEXELS};

/// The tiles of a page: the average weight of a texel, in units of the tiles' form's peak, where the tile stands for its
/// texels, 0 where it does not meet the ellipse, and [`OPENED`] where it is to be opened.
pub(super) struct Tiles(pub(super) [[f32; ROW]; ROW]);

pub(super) const OPENED: f32 = -1.0;

/// The tiles of a page if all stand for their texels: the average weight of a texel and its change per texel along x and
/// y, in units of the tiles' form's peak, all copies together.
pub(super) struct SlopingTiles(pub(super) [[[f32; 3]; ROW]; ROW]);

impl SlopingTiles {
    pub(super) const fn new() -> Self {
        Self([[[0.0; 3]; ROW]; ROW])
    }

    /// What tile number `tile` weighs.
    #[inline(always)]
    pub(super) fn tile(&self, tile: u16) -> [f32; 3] {
        let tile = usize::from(tile) % (ROW * ROW);
        self.0.as_flattened().get(tile).copied().unwrap_or_default()
    }

    /// What the block called `name` weighs a texel.
    #[inline(always)]
    pub(super) fn block(&self, name: u16) -> f32 {
        let [weight, slope_x, slope_y] = self.tile(name / BLOCK_TEXELS as u16);
        let offset = |block: u16| f32::from(block % 8) * BLOCK_SIDE as f32 - HALF_TILE;
        (weight + slope_x * offset(name) + slope_y * offset(name / 8)).max(0.0)
    }
}

impl Tiles {
    pub(super) const fn new() -> Self {
        Self([[0.0; ROW]; ROW])
    }

    #[inline(always)]
    pub(super) fn add_row(&mut self, row: u16, weights: &[f32; ROW]) {
        if let Some(sums) = self.0.get_mut(usize::from(row)) {
            for (sum, weight) in sums.iter_mut().zip(weights) {
                *sum += weight;
            }
        }
    }

    /// What tile number `tile` weighs.
    #[inline(always)]
    pub(super) fn get(&self, tile: u16) -> f32 {
        let tile = usize::from(tile) % (ROW * ROW);
        self.0.as_flattened().get(tile).copied().unwrap_or_default()
    }
}

/// Weights of the blocks of one tile, in units of the blocks' form's peak, and which blocks are to be opened.
#[derive(Clone, Copy)]
pub(super) struct BlockWeights {
    pub(super) weights: [f32; BLOCK_TEXELS],
    pub(super) opened: u64,
}

impl BlockWeights {
    pub(super) const NONE: Self = Self {
        weights: [0.0; BLOCK_TEXELS],
        opened: 0,
    };
}

/// A set of blocks of a page: one word a tile, a block's name over 64 being its tile's number.
pub(super) struct Opened([u64; (PAGE_TILES * PAGE_TILES) as usize]);

impl Opened {
    pub(super) const fn new() -> Self {
        Self([0; (PAGE_TILES * PAGE_TILES) as usize])
    }

    #[inline(always)]
    pub(super) fn add(&mut self, name: u16) {
        if let Some(word) = self.0.get_mut(usize::from(name >> 6)) {
            *word |= 1 << (name & 63);
        }
    }

    /// Adds the blocks `blocks` of tile number `tile`.
    #[inline(always)]
    pub(super) fn add_all(&mut self, tile: u16, blocks: u64) {
        if let Some(word) = self.0.get_mut(usize::from(tile)) {
            *word |= blocks;
        }
    }

    /// The tiles in row `row` of tiles.
    pub(super) fn row(&self, row: u16) -> &[u64] {
        let first = usize::from(row * PAGE_TILES);
        self.0
            .get(first..first + usize::from(PAGE_TILES))
            .unwrap_or_default()
    }
}
