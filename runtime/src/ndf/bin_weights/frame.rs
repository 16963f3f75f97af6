//! A footprint as seen from one tile, and what it weighs of blocks and texels there.

use super::keys::{ELSEWHERE, StoredKey};
use super::map_shape;
use super::sums::Sums;
use super::window::KeyRuns;
use crate::overlap::{Outline, Parallelogram, Probe, Relation, SquareProbe, TexelBox};
use core::ops::Range;
use glintbake_format::model::{BLOCK_SIDE, BLOCK_TEXELS, BlockLayout, Wrap};
use glintbake_format::view::BinTables;

const SIDE: f64 = BLOCK_SIDE as f64;
/// The area in texels of a small footprint.
const SMALL: f64 = 256.0;
/// Texels in a row of a block.
const LINE: usize = BLOCK_SIDE as usize;

/// The part of a footprint in one tile of the map; all of it if the map is clamped.
pub(super) struct Frame<'a> {
    pub tables: &'a BinTables<'a>,
    pub footprint: &'a Parallelogram,
    outline: Option<&'a Outline>,
    pub blocks: BlockLayout,
    probe: Probe<'a>,
    block_probe: SquareProbe,
    texel_probe: SquareProbe,
    /// The rows of texels that may hold weight, unless the frame is unbounded.
    rows: Range<u32>,
    /// Whether so few texels lie inside that they are better added one by one than counted in tables, which must be
    /// summed up in the end.
    is_small: bool,
    /// Whether the footprint reaches beyond the border of a clamped map, whose border texels then have no end.
    pub unbounded: bool,
}

impl<'a> Frame<'a> {
    pub fn new(
        tables: &'a BinTables<'a>,
        footprint: &'a Parallelogram,
        outline: Option<&'a Outline>,
    ) -> Self {
        let shape = map_shape(tables);
        let reach = f64::from(shape.width.max(shape.height));
        Self {
            tables,
            footprint,
            outline,
            blocks: BlockLayout::new(shape.width, shape.height),
            probe: Probe::new(footprint, outline),
            block_probe: SquareProbe::new(footprint, SIDE, reach),
            texel_probe: SquareProbe::new(footprint, 1.0, reach),
            rows: {
                // A cast saturates.
                let bounds = footprint.bounds();
                libm::floor(bounds.low[1] - 0.5) as u32
                    ..(libm::floor(bounds.high[1] + 0.5) as u32).saturating_add(1)
            },
            is_small: footprint.area() < SMALL,
            unbounded: shape.wrap == Wrap::Clamp && !shape.holds(footprint),
        }
    }

    /// Tests of squares of `side` texels, for a frame that is not unbounded.
    pub fn squares(&self, side: f64) -> SquareProbe {
        let shape = map_shape(self.tables);
        SquareProbe::new(
            self.footprint,
            side,
            f64::from(shape.width.max(shape.height)),
        )
    }

    /// The columns and the rows of blocks that the footprint's bounding box meets.
    pub fn block_bounds(&self) -> [Range<u32>; 2] {
        let TexelBox { low, high } = self.footprint.bounds();
        [
            self.within(low[0], high[0], self.blocks.columns),
            self.within(low[1], high[1], self.blocks.rows),
        ]
    }

    /// The rows of blocks that may hold weight.
    pub fn block_rows(&self) -> Range<u32> {
        let bounds = self.footprint.bounds();
        self.within(bounds.low[1], bounds.high[1], self.blocks.rows)
    }

    /// The columns of blocks in row `row` of blocks that may hold weight.
    pub fn block_columns(&self, row: u32) -> Range<u32> {
        let [low, high] = match self.outline {
            _ if self.unbounded => {
                let bounds = self.footprint.bounds();
                [bounds.low[0], bounds.high[0]]
            }
            Some(outline) => {
                let top = f64::from(row) * SIDE;
                outline.columns(self.footprint, top, top + SIDE)
            }
            None => {
                let touched = self.footprint.row_span(f64::from(row), SIDE, SIDE).touched;
                if touched.is_empty() {
                    return 0..0;
                }
                // Back to texels, to be rounded down again; from the last block's middle.
                [
                    touched.start as f64 * SIDE,
                    (touched.end as f64 - 0.5) * SIDE,
                ]
            }
        };
        if low > high {
            return 0..0;
        }
        self.within(low, high, self.blocks.columns)
    }

    /// The blocks, of `count` in a row, from the one that holds `low` to the one that holds `high`; the border's
    /// reach beyond the map if the frame is unbounded.
    fn within(&self, low: f64, high: f64, count: u32) -> Range<u32> {
        let block = |texel: f64| libm::floor(texel / SIDE);
        let last = f64::from(count) - 1.0;
        if self.unbounded {
            let first = block(low).clamp(0.0, last) as u32;
            return first..block(high).clamp(0.0, last) as u32 + 1;
        }
        if high < 0.0 || block(low) > last {
            return 0..0;
        }
        block(low).max(0.0) as u32..block(high).min(last) as u32 + 1
    }

    /// How block (`column`, `row`) lies to the footprint; crossing in doubt.
    #[inline(always)]
    pub fn block(&self, column: u32, row: u32) -> Relation {
        let (x, y) = (column * BLOCK_SIDE, row * BLOCK_SIDE);
        if self.unbounded {
            self.probe
                .relation(&self.texels([x, y], [x + BLOCK_SIDE, y + BLOCK_SIDE]))
        } else {
            self.block_probe.relation(x as f32, y as f32)
        }
    }

    /// How the eight blocks of a row from block (`column`, `row`) on lie to the footprint: a bit each for those inside and
    /// those crossing, the first lowest.
    #[inline(always)]
    pub fn eight_blocks(&self, column: u32, row: u32) -> [u8; 2] {
        if self.unbounded {
            let mut bits = [0; 2];
            for number in 0..8 {
                let relation = self.block(column + number, row);
                let [inside, crossing] = &mut bits;
                *inside |= u8::from(relation.inside) << number;
                *crossing |= u8::from(relation.crossing) << number;
            }
            return bits;
        }
        let (x, y) = (column * BLOCK_SIDE, row * BLOCK_SIDE);
        self.block_probe
            .row_of_eight(x as f32, y as f32, BLOCK_SIDE as f32)
    }

    /// Whether block (`column`, `row`) lies on the map with all its texels.
    #[inline(always)]
    pub fn is_whole(&self, column: u32, row: u32) -> bool {
        let instance = &self.tables.instance;
        ((column + 1) * BLOCK_SIDE <= instance.width) & ((row + 1) * BLOCK_SIDE <= instance.height)
    }

    /// The texture that the texels from `low` to `high`, which is not included, stand for: without end beyond the
    /// border of a clamped map.
    pub fn texels(&self, low: [u32; 2], high: [u32; 2]) -> TexelBox {
        let mut texels = TexelBox {
            low: low.map(f64::from),
            high: high.map(f64::from),
        };
        if self.unbounded {
            let instance = &self.tables.instance;
            let size = [instance.width, instance.height].map(f64::from);
            texels.low = texels
                .low
                .map(|low| if low <= 0.0 { f64::NEG_INFINITY } else { low });
            for (high, size) in texels.high.iter_mut().zip(size) {
                if *high >= size {
                    *high = f64::INFINITY;
                }
            }
        }
        texels
    }

    /// Adds the texels of block (`column`, `row`), which crosses the footprint's outline and has the keys `keys`, to
    /// the sums of their places.
    #[inline(always)]
    pub fn add_crossing_block<K: StoredKey>(
        &self,
        sums: &mut Sums,
        runs: &KeyRuns,
        keys: &[K; BLOCK_TEXELS],
        column: u32,
        row: u32,
    ) {
        let (left, top) = (column * BLOCK_SIDE, row * BLOCK_SIDE);
        let (width, height) = (self.tables.instance.width, self.tables.instance.height);
        let slow = self.unbounded | !self.is_whole(column, row);
        let rows = &self.rows;
        for (keys, row) in keys.as_chunks::<LINE>().0.iter().zip(top..height) {
            if (!slow & ((row < rows.start) | (row >= rows.end))) || !K::any_wanted(keys, runs) {
                continue;
            }
            let mut places = K::places(keys, runs);
            if slow {
                for (&place, column) in places.iter().zip(left..width) {
                    if place != ELSEWHERE {
                        self.add_texel(sums, u32::from(place), column, row);
                    }
                }
                continue;
            }
            // Texels inside are counted together; those on the outline, few, are weighed one by one.
            let mut crossing = [ELSEWHERE; LINE];
            let mut any_inside = false;
            let mut any_crossing = false;
            for ((place, crossing), column) in places.iter_mut().zip(&mut crossing).zip(left..) {
                let relation = self.texel_probe.relation(column as f32, row as f32);
                if relation.crossing {
                    *crossing = *place;
                }
                if !relation.inside {
                    *place = ELSEWHERE;
                }
                any_inside |= *place != ELSEWHERE;
                any_crossing |= *crossing != ELSEWHERE;
            }
            if any_inside {
                if self.is_small {
                    for place in places {
                        if place != ELSEWHERE {
                            sums.add_inside(u32::from(place), 1);
                        }
                    }
                } else {
                    sums.count(&places);
                }
            }
            if any_crossing {
                for (&place, column) in crossing.iter().zip(left..) {
                    if place != ELSEWHERE {
                        self.add_texel(sums, u32::from(place), column, row);
                    }
                }
            }
        }
    }

    /// Adds the texel in `column` and `row` to the sums of `place`.
    #[inline]
    fn add_texel(&self, sums: &mut Sums, place: u32, column: u32, row: u32) {
        if self.unbounded {
            let texel = self.texels([column, row], [column + 1, row + 1]);
            let relation = self.probe.relation(&texel);
            if relation.inside {
                sums.add_inside(place, 1);
            } else if relation.crossing {
                sums.add(place, self.footprint.weight(&texel));
            }
            return;
        }
        let (column, row) = (column as u16, row as u16);
        let relation = self.probe.texel(column, row);
        if relation.inside {
            sums.add_inside(place, 1);
        } else if relation.crossing {
            sums.add(place, self.probe.weight(column, row));
        }
    }
}
