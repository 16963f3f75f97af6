//! Small footprints by the raster of normals: every texel under them, sixteen at a time.
//!
//! What a tree has to descend to, a raster has at hand: a block of 4 × 4 texels is one cache line, and a box of 2 × 2 texels meets
//! two or three of them. Weights are exact areas in closed form ([`areas`]), or a Gaussian's values; terms are those of the
//! kernel, sixteen at once. Blocks whose normals are all too far from the half vector are not weighed.

mod areas;
mod block;
mod weigh;

use super::accuracy::Knobs;
use super::lanes::{self, LANES};
use super::lobe::Lobe;
use super::walk::{Centre, Sink};
use crate::error::QueryError;
use crate::overlap::{GaussianFootprint, Outline, Parallelogram, TexelBox};
use crate::scan::MapShape;
use crate::simd::{Instructions, Work};
use areas::{Areas, Place};
use block::{Frame, distances, terms};
use core::hint::black_box;
use core::ops::Range;
use glintbake_format::Fault;
use glintbake_format::Finding;
use glintbake_format::model::Wrap;
use glintbake_format::records::{RASTER_SIDE, RasterBlock};
use glintbake_format::view::{ClusterTree, Raster};
use weigh::{AnyBox, Block, NarrowGaussian, SmoothGaussian, Weigh, WideBox};

const SIDE: i64 = RASTER_SIDE as i64;

/// The exponent beyond which terms are nothing: those of normals in a block that is summed anyway.
const LEAST_TERM: f32 = 40.0;

/// What a raster's rounding adds to the relative L1 error, in steps over σr: the mean distance a step moves a normal by, times
/// the mean slope of the kernel.
const ROUNDING: f64 = 0.32;

/// Texels in the bounding box of a footprint whose blocks are asked for before any is looked at.
const FETCHED: i64 = 256;

/// Everything of a query but its footprint.
pub(super) struct Query<'q, 'a, L> {
    pub raster: &'q Raster<'a>,
    /// Of the same map.
    pub tree: &'q ClusterTree<'a>,
    pub shape: MapShape,
    pub centre: Centre,
    pub lobe: L,
    /// Terms of e^-this and less may be left out.
    pub limit: f32,
}

impl<'q, 'a, L: Lobe> Query<'q, 'a, L> {
    pub fn new(
        raster: &'q Raster<'a>,
        tree: &'q ClusterTree<'a>,
        shape: MapShape,
        centre: Centre,
        lobe: L,
        knobs: Knobs,
    ) -> Self {
        Self {
            raster,
            tree,
            shape,
            centre,
            lobe,
            limit: knobs.limits.exponent,
        }
    }
}

/// Whether a raster's normals are near enough for a kernel of deviation `sigma` and the relative L1 error `eps`.
pub(super) fn is_fine_enough(raster: &Raster<'_>, sigma: f64, eps: f64) -> bool {
    let [_, step] = raster.lattice.offset_and_step();
    ROUNDING * step <= eps * sigma
}

/// The most texels that are scanned: about as many as take as long by the tree, which gets by with the fewer the narrower the
/// kernel is. Measured, see docs/cluster-tree.md.
fn most_texels(sigma: f64) -> f64 {
    (2.4e4 * sigma).clamp(64.0, 2048.0)
}

/// Whether a footprint of about `texels` texels within `bounds` is scanned rather than looked for in the tree.
#[inline]
fn serves(shape: MapShape, bounds: &TexelBox, texels: f64, sigma: f64) -> bool {
    let [width, height] = [f64::from(shape.width), f64::from(shape.height)];
    texels <= most_texels(sigma)
        && (shape.wrap == Wrap::Clamp
            || (bounds.high[0] - bounds.low[0] <= width
                && bounds.high[1] - bounds.low[1] <= height))
}

/// Whether `footprint` is scanned, for a kernel of deviation `sigma`.
#[inline]
pub(super) fn serves_box(shape: MapShape, footprint: &Parallelogram, sigma: f64) -> bool {
    serves(shape, &footprint.bounds(), footprint.area(), sigma)
}

/// Whether the Gaussian `footprint` is scanned, for a kernel of deviation `sigma`.
#[inline]
pub(super) fn serves_gaussian(shape: MapShape, footprint: &GaussianFootprint, sigma: f64) -> bool {
    let texels = footprint.support_texels();
    serves(shape, &footprint.bounds(), texels, sigma)
}

/// Hands `sink` the texels under `footprint`.
pub(super) fn under_box<L: Lobe, S: Sink>(
    query: &Query<'_, '_, L>,
    footprint: &Parallelogram,
    mut sink: S,
) -> Result<S, QueryError> {
    let bounds = footprint.bounds();
    sink = Instructions::Fastest.run(UnderBox {
        query,
        footprint,
        sink,
    })?;
    if query.shape.wrap == Wrap::Clamp && !query.shape.holds(footprint) {
        super::border::for_each_border_texel(query.tree, &bounds, &mut |texel, part| {
            query.border_texel(texel, footprint.weight(&part), &mut sink)
        })?;
    }
    Ok(sink)
}

/// Hands `sink` the texels under the Gaussian `footprint`.
pub(super) fn under_gaussian<L: Lobe, S: Sink>(
    query: &Query<'_, '_, L>,
    footprint: &GaussianFootprint,
    mut sink: S,
) -> Result<S, QueryError> {
    let bounds = footprint.bounds();
    sink = Instructions::Fastest.run(UnderGaussian {
        query,
        footprint,
        sink,
    })?;
    if query.shape.wrap == Wrap::Clamp {
        let rectangles = footprint.rectangles();
        super::border::for_each_border_texel(query.tree, &bounds, &mut |texel, part| {
            let [low, high] = [part.low, part.high].map(|[x, y]| footprint.centred(x, y));
            let weight = rectangles.share([low[0], high[0]], [low[1], high[1]]);
            query.border_texel(texel, weight, &mut sink)
        })?;
    }
    Ok(sink)
}

impl<L: Lobe> Query<'_, '_, L> {
    /// Adds `texel` of the border, whose endless part weighs `weight`.
    fn border_texel<S: Sink>(
        &self,
        [column, row]: [u32; 2],
        weight: f64,
        sink: &mut S,
    ) -> Result<(), QueryError> {
        if weight <= 0.0 {
            return Ok(());
        }
        let normal = self.raster.normal(column, row)?;
        let Centre { point, scale } = self.centre;
        let offset = [
            (normal[0] - point[0]) * scale,
            (normal[1] - point[1]) * scale,
        ];
        let [s, t] = offset.map(|x| x as f32);
        let [exponent, factor] = self.lobe.exponent(s, t);
        let term = factor * lanes::exponential(-exponent);
        if S::STRICT {
            let [_, step] = self.raster.lattice.offset_and_step();
            // In no unit but its own.
            sink.unit(1.0);
            let distance = 0.5 * (s * s + t * t);
            sink.error(weight as f32 * rounding_error((step * scale) as f32, distance));
        }
        if exponent <= LEAST_TERM {
            sink.exact(f64::from(term) * weight, weight, offset);
        }
        Ok(())
    }
}

/// How far a term whose normal is half a step off in s and in t, of `step` in units of σr, can be from the true one, if normals
/// are at least `exponent` away.
fn rounding_error(step: f32, exponent: f32) -> f32 {
    let near = lanes::max(2.0 * exponent, 0.0);
    let distance = near * lanes::inverse_root(lanes::max(near, 1e-30));
    let inner = lanes::max(distance - step, 0.0);
    // Steepest at a distance of 1.
    let steepest = lanes::max(inner, 1.0);
    1.00001 * step * steepest * lanes::exponential(-0.5 * steepest * steepest)
}

/// The work of [`under_box`]: all of it, so that what is kept in vectors need not be copied from narrower ones.
struct UnderBox<'s, 'q, 'a, L, S> {
    query: &'s Query<'q, 'a, L>,
    footprint: &'s Parallelogram,
    sink: S,
}

impl<L: Lobe, S: Sink> Work for UnderBox<'_, '_, '_, L, S> {
    type Output = Result<S, QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            query,
            footprint,
            sink,
        } = self;
        let reach = Reach::new(query, &footprint.bounds());
        let origin = footprint.centred(0.0, 0.0);
        // Bounds of errors count exact weights.
        let areas = if S::STRICT {
            None
        } else {
            Areas::new(footprint)
        };
        match areas {
            Some(areas) => {
                let unit = footprint.texel_weight();
                let weigh = WideBox { areas, unit };
                Scan {
                    query,
                    origin,
                    weigh,
                    sink,
                }
                .run(&reach)
            }
            None => {
                let outline = Outline::new(footprint);
                let weigh = AnyBox { footprint, outline };
                Scan {
                    query,
                    origin,
                    weigh,
                    sink,
                }
                .run(&reach)
            }
        }
    }
}

/// The work of [`under_gaussian`].
struct UnderGaussian<'s, 'q, 'a, L, S> {
    query: &'s Query<'q, 'a, L>,
    footprint: &'s GaussianFootprint,
    sink: S,
}

impl<L: Lobe, S: Sink> Work for UnderGaussian<'_, '_, '_, L, S> {
    type Output = Result<S, QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            query,
            footprint,
            sink,
        } = self;
        let TexelBox { low, high } = footprint.bounds();
        let origin = footprint.centred(0.0, 0.0);
        // Whole texels that meet the ellipse count.
        let bounds = TexelBox {
            low: low.map(|x| x - 1.0),
            high: high.map(|x| x + 1.0),
        };
        let reach = Reach::new(query, &bounds);
        // Bounds of errors count exact weights of narrow ones.
        let smooth = if S::STRICT && !footprint.is_smooth() {
            None
        } else {
            SmoothGaussian::new(footprint, query.limit)
        };
        match smooth {
            Some(weigh) => Scan {
                query,
                origin,
                weigh,
                sink,
            }
            .run(&reach),
            None => Scan {
                query,
                origin,
                weigh: NarrowGaussian { footprint },
                sink,
            }
            .run(&reach),
        }
    }
}

/// Asks memory for a block.
#[inline(always)]
fn fetch_block(raster: &Raster<'_>, column: i64, row: i64) {
    let place = raster.place(column as u32, row as u32);
    if let Some(RasterBlock([word, ..])) = raster.blocks.get(place) {
        black_box(*word);
    }
}

/// The texels that a footprint reaches, and the copies of the map they lie in.
struct Reach {
    size: [i64; 2],
    texels: [Range<i64>; 2],
    copies: [Range<i64>; 2],
}

impl Reach {
    /// What is in `bounds`. Few blocks are asked for at once: what else there is to prepare need not wait for them.
    #[inline(always)]
    fn new<L: Lobe>(query: &Query<'_, '_, L>, bounds: &TexelBox) -> Self {
        let size = [i64::from(query.shape.width), i64::from(query.shape.height)];
        let TexelBox { low, high } = *bounds;
        let texels = [
            floor(low[0])..floor(high[0]) + 1,
            floor(low[1])..floor(high[1]) + 1,
        ];
        let clamp = query.shape.wrap == Wrap::Clamp;
        let is_held = |reach: &Range<i64>, size: i64| reach.start >= 0 && reach.end <= size;
        let copies = |reach: &Range<i64>, size: i64| {
            if clamp || is_held(reach, size) {
                0..1
            } else {
                reach.start.div_euclid(size)..(reach.end - 1).div_euclid(size) + 1
            }
        };
        let copies = [copies(&texels[0], size[0]), copies(&texels[1], size[1])];
        let reach = Self {
            size,
            texels,
            copies,
        };
        let [columns, rows] = reach.blocks([0; 2]);
        if reach.is_small() {
            for row in rows {
                for column in columns.clone() {
                    fetch_block(query.raster, column, row);
                }
            }
        }
        reach
    }

    /// Whether there are few blocks.
    #[inline(always)]
    fn is_small(&self) -> bool {
        let [columns, rows] = &self.texels;
        (columns.end - columns.start) * (rows.end - rows.start) <= FETCHED
    }

    /// Columns and rows of the blocks of the copy that begins at texel `copy`.
    #[inline(always)]
    fn blocks(&self, copy: [i64; 2]) -> [Range<i64>; 2] {
        let blocks = |reach: &Range<i64>, copy: i64, size: i64| {
            let (first, end) = ((reach.start - copy).max(0), (reach.end - copy).min(size));
            if first < end {
                first / SIDE..(end - 1) / SIDE + 1
            } else {
                0..0
            }
        };
        let ([x, y], [width, height]) = (&self.texels, self.size);
        [blocks(x, copy[0], width), blocks(y, copy[1], height)]
    }
}

/// A scan of the blocks in a box.
struct Scan<'s, 'q, 'a, L, W, S> {
    query: &'s Query<'q, 'a, L>,
    /// Where texel (0, 0) lies relative to the footprint's centre.
    origin: [f64; 2],
    weigh: W,
    sink: S,
}

/// The greatest integer not above `value`, a coordinate of less than 2⁵³.
#[inline(always)]
fn floor(value: f64) -> i64 {
    let truncated = value as i64;
    truncated - i64::from(value < truncated as f64)
}

impl<L: Lobe, W: Weigh, S: Sink> Scan<'_, '_, '_, L, W, S> {
    #[inline(always)]
    fn run(mut self, reach: &Reach) -> Result<S, QueryError> {
        let frame = Frame::new(self.query.raster.lattice, self.query.centre);
        self.sink.unit(self.weigh.unit());
        let [columns, rows] = &reach.copies;
        for row in rows.clone() {
            for column in columns.clone() {
                let copy = [column * reach.size[0], row * reach.size[1]];
                self.copy(&frame, reach, copy)?;
            }
        }
        Ok(self.sink)
    }

    /// Scans what of `reach` lies in the copy of the map that begins at texel `copy`.
    #[inline(always)]
    fn copy(&mut self, frame: &Frame, reach: &Reach, copy: [i64; 2]) -> Result<(), QueryError> {
        let (raster, size) = (self.query.raster, reach.size);
        let [columns, rows] = reach.blocks(copy);
        for row in rows {
            if !reach.is_small() {
                for column in columns.clone() {
                    fetch_block(raster, column, row + 1);
                }
            }
            for column in columns.clone() {
                let within = [SIDE * column, SIDE * row];
                let texel = [copy[0] + within[0], copy[1] + within[1]];
                let block = Block {
                    texel,
                    corner: [
                        (self.origin[0] + texel[0] as f64) as f32,
                        (self.origin[1] + texel[1] as f64) as f32,
                    ],
                    room: [(size[0] - within[0]) as f32, (size[1] - within[1]) as f32],
                };
                let place = raster.place(column as u32, row as u32);
                self.block(frame, &block, place)?;
            }
            self.sink.flush();
        }
        Ok(())
    }

    #[inline(always)]
    fn block(&mut self, frame: &Frame, block: &Block, place: usize) -> Result<(), QueryError> {
        let Query { raster, lobe, .. } = self.query;
        if self.weigh.place(block, 0.0) == Place::Outside {
            return Ok(());
        }
        let damaged = Finding::new(Fault::SectionCount).within(raster.id);
        let record = raster.blocks.get(place).ok_or(damaged)?;
        let normals = frame.normals(record);
        let least = lanes::least(&distances(&normals));
        if S::STRICT {
            self.count_errors(frame, block, least);
        }
        if least > self.query.limit {
            return Ok(());
        }
        let relation = self.weigh.place(block, least);
        if relation == Place::Outside {
            return Ok(());
        }
        let [s, t] = normals;
        let weights = if relation == Place::Inside && block.is_whole() {
            [1.0; LANES]
        } else {
            self.weigh.weights(block)
        };
        let terms = terms(lobe, &normals, &weights);
        self.sink.terms(&terms, &weights, &s, &t);
        Ok(())
    }

    /// Adds to the error what rounding of normals, or leaving out all of a block, can have changed.
    fn count_errors(&mut self, frame: &Frame, block: &Block, least: f32) {
        let weights = self.weigh.weights(block);
        let weight: f32 = weights.iter().sum();
        let most = lanes::exponential(-least);
        let off = if least > self.query.limit {
            most
        } else {
            // The tail that lies between the limits of normals alone, and of normals and weights together.
            let tail = lanes::exponential(-self.query.limit);
            rounding_error(frame.step, least) + tail
        };
        self.sink.error(1.00001 * weight * off);
    }
}
