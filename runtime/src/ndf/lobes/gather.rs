//! Sums over the lobes that a footprint and a half vector reach.

use super::frame::Frame;
use super::placed::{POSITION_VARIANCE, Placed, span};
use super::term::{BlockFrame, Term, plane};
use crate::error::QueryError;
use crate::lanes::{LANES, Lanes};
use crate::ndf::box_pyramid::{Cell, Query, Visitor, walk};
use crate::simd::{Work, fetch};
use core::ops::Range;
use glintbake_format::model::PYRAMID_SIDE;
use glintbake_format::records::{
    LobeBlock, LobeSlopes, LobeSpreads, WideLobeBlock, WideLobeSlopes,
};
use glintbake_format::view::{Lobes, LobesOfBlock, PyramidBox};
use zerocopy::little_endian::F32;

/// Standard deviations, of position and normal together, that a lobe reaches. What lies beyond is `exp(-5² / 2)` of a lobe's peak
/// at most, 4e-6, and 5e-5 of all that lobes have. Boxes of the pyramid are made for this reach.
pub(super) const REACH: f64 = 5.0;

/// The greatest diagonal of the box of normals of a cell that counts as one lobe, squared, and four times what lobes spread, squared,
/// in squared deviations of the kernel.
const NARROW: f64 = 0.16;

/// The greatest squared side of such a cell, in least variances of its lobe's total position covariance.
const SMALL: f64 = 0.35;

/// Sides of the box of normals of a block, in deviations of the kernel, from which its lobes are summed in f64. In f32 a lobe is
/// off by 6e-8 of the box, where 5 deviations are 1.5e-3 deviations here.
const STIFF: f64 = 4000.0;

/// Most levels of cells.
const LEVELS: usize = 9;

/// Blocks that wait for memory.
const PENDING: usize = 16;

/// Who adds up.
pub(super) trait Sink {
    /// Whether each lobe is wanted by itself.
    const EACH: bool;

    /// So much of the density, in units of `1 / 2π` of the kernel's variance.
    fn add(&mut self, amount: f64);

    /// A lobe, or a cell as one, that weighs `weight` with its distance of positions.
    fn term(&mut self, term: &Term, weight: f64);
}

/// The sum of a query's terms.
pub(super) struct Total(pub f64);

impl Sink for Total {
    const EACH: bool = false;

    #[inline(always)]
    fn add(&mut self, amount: f64) {
        // Lobes of damaged packages may be no numbers, and then are none.
        if amount > 0.0 && amount < f64::INFINITY {
            self.0 += amount;
        }
    }

    #[inline(always)]
    fn term(&mut self, _: &Term, _: f64) {}
}

/// A query, and what it has found so far.
pub(super) struct Gather<'q, S> {
    pub lobes: &'q Lobes<'q>,
    pub placed: &'q Placed,
    pub normal: [f64; 2],
    /// σr.
    pub sigma: f64,
    pub sink: S,
}

impl<S: Sink> Gather<'_, S> {
    /// Visits every copy of the map that the footprint reaches.
    ///
    /// # Errors
    /// [`QueryError::Damaged`].
    #[inline(always)]
    fn copies(self) -> Result<S, QueryError> {
        let frame = Frame::of_lobes(self.placed);
        let [width, height] = self.placed.size;
        let [least, greatest] = self.placed.variances();
        let levels = core::array::from_fn(|level| {
            let side = f64::from(4_u32.wrapping_pow(level as u32 + 1));
            // A cell's lobes are a lattice of side², each of variance σh².
            let variance = POSITION_VARIANCE + (side * side - 1.0) / 12.0;
            (side * side <= SMALL * least).then(|| Frame::new(self.placed, variance))
        });
        let mut found = Found {
            lobes: self.lobes,
            block_frame: BlockFrame::new(&frame),
            amplitude: frame.amplitude,
            frame,
            levels,
            centre: self.placed.centre,
            normal: self.normal,
            sigma: self.sigma,
            scale: 1.0 / self.sigma,
            drift: REACH * libm::sqrt(POSITION_VARIANCE / least),
            blur: 1.0 - POSITION_VARIANCE / greatest,
            pending: [const { None }; PENDING],
            count: 0,
            sink: self.sink,
        };
        let copies = Copies::new(self.placed, &found.frame);
        for row in copies.rows.clone() {
            for column in copies.columns(row) {
                found.centre = [
                    self.placed.centre[0] - column as f64 * width,
                    self.placed.centre[1] - row as f64 * height,
                ];
                let query = Query {
                    centre: found.centre,
                    whiten: found.frame.whiten,
                    normal: self.normal,
                    scale: found.scale,
                    reach_squared: REACH * REACH,
                    drift: found.drift,
                    blur: found.blur,
                };
                walk(&self.lobes.pyramid, &query, &mut found)?;
                found.drain()?;
            }
        }
        Ok(found.sink)
    }
}

impl<S: Sink> Work for Gather<'_, S> {
    type Output = Result<S, QueryError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.copies()
    }
}

/// The copies of a repeating map that a footprint reaches; of a clamped one, the map.
struct Copies {
    rows: Range<i64>,
    placed: Placed,
    whiten: [f64; 3],
}

impl Copies {
    fn new(placed: &Placed, frame: &Frame) -> Self {
        let reach = REACH * libm::sqrt(frame.total[1]);
        let rows = span(
            placed.centre[1] - reach,
            placed.centre[1] + reach,
            placed.size[1],
        );
        Self {
            rows: if placed.even[1] || !placed.is_repeated {
                0..1
            } else {
                rows
            },
            placed: *placed,
            whiten: frame.whiten,
        }
    }

    /// The columns of copies in `row` that the ellipse of reach meets.
    fn columns(&self, row: i64) -> Range<i64> {
        let Placed {
            centre,
            size,
            even,
            is_repeated,
            ..
        } = self.placed;
        if even[0] || !is_repeated {
            return 0..1;
        }
        let [a, b, c] = self.whiten;
        // Rows of the copy, from the centre and within reach.
        let limit = if c > 0.0 { REACH / c } else { 0.0 };
        let low = (row as f64 * size[1] - centre[1]).clamp(-limit, limit);
        let high = ((row + 1) as f64 * size[1] - centre[1]).clamp(-limit, limit);
        let middle = |y: f64| centre[0] - b / a * y;
        let (first, last) = (middle(low).min(middle(high)), middle(low).max(middle(high)));
        span(first - REACH / a, last + REACH / a, size[0])
    }
}

/// A block that has been found.
struct Pending<'q> {
    stored: LobesOfBlock<'q>,
    column: u32,
    row: u32,
    parent: usize,
    child: u32,
    bounds: PyramidBox,
}

struct Found<'q, S> {
    lobes: &'q Lobes<'q>,
    frame: Frame,
    block_frame: BlockFrame,
    amplitude: f64,
    /// For each level whose cells may count as one lobe, that lobe's frame.
    levels: [Option<Frame>; LEVELS],
    /// The footprint's centre over this copy of the map.
    centre: [f64; 2],
    normal: [f64; 2],
    sigma: f64,
    scale: f64,
    /// See `box_pyramid`.
    drift: f64,
    blur: f64,
    pending: [Option<Pending<'q>>; PENDING],
    count: usize,
    sink: S,
}

impl<S: Sink> Visitor for Found<'_, S> {
    #[inline(always)]
    fn spreads(&self, place: usize) -> Option<&LobeSpreads> {
        self.lobes.spreads.get(place)
    }

    #[inline(always)]
    fn expect(&self, place: usize) {
        if let Some(spreads) = self.lobes.spreads.get(place) {
            fetch(spreads);
        }
        if let Some(index) = self.lobes.index.get(place) {
            fetch(index);
        }
    }

    #[inline(always)]
    fn cell(&mut self, cell: &Cell) -> Result<bool, QueryError> {
        if let Some(Some(frame)) = self.levels.get(cell.level as usize) {
            let [across, down] = cell.bounds.extent().map(|side| side * self.scale);
            let spread = self.lobes.spread(cell.parent, cell.child) * self.scale;
            if across * across + down * down + 16.0 * spread * spread <= NARROW
                && self.is_whole(cell)
            {
                let frame = *frame;
                self.whole(cell, &frame)?;
                return Ok(true);
            }
        }
        if cell.level > 0 {
            return Ok(false);
        }
        let stored = self.lobes.block(cell.parent, cell.child)?;
        match stored {
            LobesOfBlock::Narrow(block, slopes) => {
                fetch(block);
                fetch(&block.t[LANES - 1]);
                if let Some(slopes) = slopes {
                    fetch(slopes);
                    fetch(&slopes.t_x);
                }
            }
            LobesOfBlock::Wide(block, slopes) => {
                fetch(&block.s);
                fetch(&block.t);
                if let Some(slopes) = slopes {
                    fetch(&slopes.s_x);
                    fetch(&slopes.s_y);
                    fetch(&slopes.t_x);
                    fetch(&slopes.t_y);
                }
            }
            LobesOfBlock::Merged => {}
        }
        if let Some(place) = self.pending.get_mut(self.count) {
            *place = Some(Pending {
                stored,
                column: cell.column,
                row: cell.row,
                parent: cell.parent,
                child: cell.child,
                bounds: cell.bounds,
            });
        }
        self.count = self.count.wrapping_add(1);
        if self.count >= PENDING {
            self.drain()?;
        }
        Ok(true)
    }
}

impl<S: Sink> Found<'_, S> {
    /// Whether every lobe of `cell` is on the lattice.
    #[inline(always)]
    fn is_whole(&self, cell: &Cell) -> bool {
        let [columns, rows] = self.lobes.pyramid.layout.cells();
        let shift = (cell.level.wrapping_add(1).wrapping_mul(2)) & 31;
        let end = |place: u32| u64::from(place.wrapping_add(1)) << shift;
        end(cell.column) <= u64::from(columns) && end(cell.row) <= u64::from(rows)
    }

    /// Counts `cell` as one lobe.
    #[inline(always)]
    fn whole(&mut self, cell: &Cell, frame: &Frame) -> Result<(), QueryError> {
        let side = f64::from(1_u32 << (cell.level.wrapping_add(1).wrapping_mul(2) & 31));
        let one = self.lobes.cell(cell.parent, cell.child, &cell.bounds)?;
        let offset = [
            self.centre[0] - (f64::from(cell.column) + 0.5) * side,
            self.centre[1] - (f64::from(cell.row) + 0.5) * side,
        ];
        let variance = self.sigma * self.sigma;
        let [ss, st, tt] = one.residual;
        let term = Term::new(frame, offset, &one.lobe, [ss + variance, st, tt + variance]);
        self.one(&term, frame.amplitude * side * side);
        Ok(())
    }

    /// Counts a lobe of which `amplitude` is the weight but for its distance of positions.
    #[inline(always)]
    fn one(&mut self, term: &Term, amplitude: f64) {
        if S::EACH {
            let weight = amplitude * libm::exp(-0.5 * term.position_squared);
            self.sink.term(term, weight);
        } else {
            let (exponent, factor) = term.exponent(self.normal);
            let variance = self.sigma * self.sigma;
            self.sink
                .add(amplitude * factor * variance * libm::exp(-exponent));
        }
    }

    /// Adds up the blocks that wait.
    #[inline(always)]
    fn drain(&mut self) -> Result<(), QueryError> {
        let count = core::mem::take(&mut self.count).min(PENDING);
        for number in 0..count {
            let Some(pending) = self.pending.get_mut(number).and_then(Option::take) else {
                continue;
            };
            let first = [
                self.centre[0] - f64::from(PYRAMID_SIDE * pending.column) - 0.5,
                self.centre[1] - f64::from(PYRAMID_SIDE * pending.row) - 0.5,
            ];
            match pending.stored {
                _ if S::EACH => self.each(&pending, first)?,
                LobesOfBlock::Narrow(block, slopes) => {
                    let normals = self.narrow_normals(block);
                    match slopes {
                        None => self.add_flat(&pending, &normals, first),
                        Some(slopes) if self.is_near(&pending, &normals, first) => {
                            let slopes = self.narrow_slopes(block, slopes);
                            self.add_curved(&pending, &normals, &slopes, first);
                        }
                        Some(_) => {}
                    }
                }
                LobesOfBlock::Wide(block, slopes) if !self.is_stiff(&pending) => {
                    let normals = self.wide_normals(block);
                    match slopes {
                        None => self.add_flat(&pending, &normals, first),
                        Some(slopes) => {
                            let slopes = self.wide_slopes(slopes);
                            self.add_curved(&pending, &normals, &slopes, first);
                        }
                    }
                }
                LobesOfBlock::Wide(..) => self.each(&pending, first)?,
                LobesOfBlock::Merged => {
                    let cell = self
                        .lobes
                        .cell(pending.parent, pending.child, &pending.bounds)?
                        .lobe;
                    let [s, t] = cell.normal;
                    let normal = [self.normal[0] - s, self.normal[1] - t];
                    let slope = cell.slope.map(|x| (x * self.scale) as f32);
                    let normals = plane(normal.map(|x| (x * self.scale) as f32), slope);
                    if self.lobes.lattice.curved {
                        let slopes = slope.map(|slope| [slope; LANES]);
                        self.add_curved(&pending, &normals, &slopes, first);
                    } else {
                        self.add_flat(&pending, &normals, first);
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether normals vary too much over a block for f32 to keep lobes apart.
    #[inline(always)]
    fn is_stiff(&self, pending: &Pending<'_>) -> bool {
        let [across, down] = pending.bounds.extent();
        let spread = self.lobes.spread(pending.parent, pending.child);
        (across + down + 5.0 * spread) * self.scale > STIFF
    }

    /// Whether a lobe of the block may be within reach, by each one's own normal and the most that any of them spreads.
    ///
    /// With the bound of `box_pyramid`, and `(x - D)² ≥ 0.9 x² - 9 D²` for what normals drift.
    #[inline(always)]
    fn is_near(&self, pending: &Pending<'_>, normals: &[Lanes; 2], offset: [f64; 2]) -> bool {
        let spread = self.lobes.spread(pending.parent, pending.child) * self.scale;
        let widened = 1.0 + self.blur * spread * spread;
        let drift = self.drift * spread;
        let p = self.frame.whitened(offset).map(|x| x as f32);
        let reach = (1.001 * REACH * REACH + 9.0 * drift * drift / widened) as f32;
        let least = self.block_frame.least(normals, p, (0.9 / widened) as f32);
        least <= reach
    }

    #[inline(always)]
    fn add_curved(
        &mut self,
        pending: &Pending<'_>,
        normals: &[Lanes; 2],
        slopes: &[Lanes; 4],
        offset: [f64; 2],
    ) {
        let counts = self.counts(pending);
        let p = self.frame.whitened(offset).map(|x| x as f32);
        let sum = self.block_frame.curved(normals, slopes, p, &counts);
        self.sink.add(self.amplitude * f64::from(sum));
    }

    #[inline(always)]
    fn add_flat(&mut self, pending: &Pending<'_>, normals: &[Lanes; 2], offset: [f64; 2]) {
        let counts = self.counts(pending);
        let p = self.frame.whitened(offset).map(|x| x as f32);
        let sum = self.block_frame.flat(normals, p, &counts);
        self.sink.add(self.amplitude * f64::from(sum));
    }

    /// 1 for each lobe of a block that is on the lattice.
    #[inline(always)]
    fn counts(&self, pending: &Pending<'_>) -> Lanes {
        let [columns, rows] = self.lobes.pyramid.layout.cells();
        let x = columns.saturating_sub(PYRAMID_SIDE * pending.column);
        let y = rows.saturating_sub(PYRAMID_SIDE * pending.row);
        let mut counts = [1.0; LANES];
        if x < PYRAMID_SIDE || y < PYRAMID_SIDE {
            for (lane, count) in (0_u32..).zip(&mut counts) {
                let is_there = lane % PYRAMID_SIDE < x && lane / PYRAMID_SIDE < y;
                *count = if is_there { 1.0 } else { 0.0 };
            }
        }
        counts
    }

    /// The half vector less the normals of a block, in deviations of the kernel.
    #[inline(always)]
    #[expect(
        clippy::indexing_slicing,
        clippy::needless_range_loop,
        reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
    )]
    fn narrow_normals(&self, block: &LobeBlock) -> [Lanes; 2] {
        let relative = |axis: usize| {
            let low = f64::from(block.low[axis].get());
            ((self.normal[axis] - low) * self.scale) as f32
        };
        let scaled = |number: F32| (f64::from(number.get()) * self.scale) as f32;
        let step = block.step.map(scaled);
        let mut normals = plane([relative(0), relative(1)], block.plane.map(scaled));
        for lane in 0..LANES {
            normals[0][lane] -= step[0] * f32::from(block.s[lane].get());
            normals[1][lane] -= step[1] * f32::from(block.t[lane].get());
        }
        normals
    }

    #[inline(always)]
    #[expect(
        clippy::indexing_slicing,
        clippy::needless_range_loop,
        reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
    )]
    fn narrow_slopes(&self, block: &LobeBlock, slopes: &LobeSlopes) -> [Lanes; 4] {
        let unit = (f64::from(block.slope_step.get()) * self.scale) as f32;
        let mut lanes = [[0.0; LANES]; 4];
        for lane in 0..LANES {
            lanes[0][lane] = unit * f32::from(slopes.s_x[lane].get());
            lanes[1][lane] = unit * f32::from(slopes.s_y[lane].get());
            lanes[2][lane] = unit * f32::from(slopes.t_x[lane].get());
            lanes[3][lane] = unit * f32::from(slopes.t_y[lane].get());
        }
        lanes
    }

    #[inline(always)]
    #[expect(
        clippy::indexing_slicing,
        clippy::needless_range_loop,
        reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
    )]
    fn wide_normals(&self, block: &WideLobeBlock) -> [Lanes; 2] {
        let scale = self.scale as f32;
        let [s, t] = self.normal;
        // What f32 leaves of the half vector, so that differences are exact to the stored numbers.
        let (s_high, t_high) = (s as f32, t as f32);
        let s_low = ((s - f64::from(s_high)) * self.scale) as f32;
        let t_low = ((t - f64::from(t_high)) * self.scale) as f32;
        let mut normals = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            normals[0][lane] = (s_high - block.s[lane].get()) * scale + s_low;
            normals[1][lane] = (t_high - block.t[lane].get()) * scale + t_low;
        }
        normals
    }

    #[inline(always)]
    #[expect(
        clippy::indexing_slicing,
        clippy::needless_range_loop,
        reason = "arrays of 16 by numbers below 16, which compilers see and checked indexing would hide from them"
    )]
    fn wide_slopes(&self, slopes: &WideLobeSlopes) -> [Lanes; 4] {
        let scale = self.scale as f32;
        let mut lanes = [[0.0; LANES]; 4];
        for lane in 0..LANES {
            lanes[0][lane] = scale * slopes.s_x[lane].get();
            lanes[1][lane] = scale * slopes.s_y[lane].get();
            lanes[2][lane] = scale * slopes.t_x[lane].get();
            lanes[3][lane] = scale * slopes.t_y[lane].get();
        }
        lanes
    }

    /// Counts the lobes of a block one by one, in f64.
    #[inline(never)]
    fn each(&mut self, pending: &Pending<'_>, first: [f64; 2]) -> Result<(), QueryError> {
        let counts = self.counts(pending);
        let variance = self.sigma * self.sigma;
        for (number, count) in (0_u32..).zip(counts) {
            if count == 0.0 {
                continue;
            }
            let lobe = self
                .lobes
                .lobe(pending.parent, pending.child, number, &pending.bounds)?;
            let offset = [
                first[0] - f64::from(number % PYRAMID_SIDE),
                first[1] - f64::from(number / PYRAMID_SIDE),
            ];
            let lobe = if self.lobes.lattice.curved {
                lobe
            } else {
                // The plane of a merged block is where its flat lobes lie.
                glintbake_format::view::LobeNormal {
                    slope: [0.0; 4],
                    ..lobe
                }
            };
            let term = Term::new(&self.frame, offset, &lobe, [variance, 0.0, variance]);
            if term.position_squared > 2.0 * REACH * REACH {
                continue;
            }
            let amplitude = self.amplitude;
            self.one(&term, amplitude);
        }
        Ok(())
    }
}
