//! The vectorised exact scan: every texel under the footprint with its own normal, in single precision.
//!
//! What a renderer would write that has memory for the normals and nothing else. Normals are kept in 32 bits a component, to
//! a 2^31st, in squares of 4 × 4 texels, upper and lower halves apart: the upper halves of a square are one line of a
//! cache, and all that is read of a square that no light can reach. That costs a dozen instructions on 16-bit lanes. Lit
//! squares are weighed, by exact areas under a box (`coverage`) and by the Gaussian's integral over each texel
//! (`gaussian`), and the kernel is evaluated for 16 normals at once (`lobe`). The vectors are those that queries of
//! the runtime get.

mod coverage;
mod gaussian;
mod lobe;

use coverage::Coverage;
use gaussian::Gaussian;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, HalfVector, Kernel, Wrap};
use glintbake_runtime::{Instructions, Work};
use lobe::Lobe;
use std::hint::black_box;
use std::ops::Range;

/// Texels along a side of a square.
const SIDE: usize = 4;
/// Texels of a square, row by row.
const LANES: usize = SIDE * SIDE;
/// Squares of a row that are tested before any is weighed, where few are lit and where most are: there, the memory's
/// answers are best waited for while others are weighed.
const TESTED: [usize; 2] = [16, 1];
/// Places for lit squares that wait to be weighed.
const WAITING: usize = 64;
/// Squares whose terms add up in single precision before they go on in double precision.
const TOGETHER: usize = 256;

/// A number for each texel of a square.
type Lanes = [f32; LANES];

/// The upper halves of the normals of a square.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct High {
    s: [i16; LANES],
    t: [i16; LANES],
}

/// The lower halves.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Low {
    s: [u16; LANES],
    t: [u16; LANES],
}

/// A map's normals in squares.
#[derive(Clone, Debug)]
pub struct ExactScan {
    size: [u32; 2],
    /// Squares in a row of them.
    pitch: usize,
    high: Vec<High>,
    low: Vec<Low>,
    /// 1 for texels of the map, 0 for those that pad the squares of its last column; of its last row.
    padding: [Lanes; 2],
    instructions: Instructions,
}

/// A footprint as squares see it, one copy of a repeating map at a time.
trait Region: Copy {
    /// Middle of the footprint, and half the sides of its bounding box, in texels.
    fn bounds(&self) -> ([f64; 2], [f64; 2]);

    /// Columns, in texels, in which the middles of squares lie that touch it, of those whose middles are `y` from its own;
    /// from its middle, and perhaps a few more.
    fn span(&self, y: f64) -> [f64; 2];

    /// How much of the exponent at which terms end is left for the kernel in the square whose middle is at `middle` from
    /// the footprint's, as a share: 1 or less, and nothing if negative.
    fn left(&self, middle: [f64; 2]) -> f64;

    /// Sets the weight of each texel of that square.
    fn weigh(&self, middle: [f64; 2], weights: &mut Lanes);
}

impl ExactScan {
    /// The normals of `map`.
    ///
    /// # Panics
    /// If `map` does not repeat.
    pub fn new(map: &NormalMap) -> Self {
        assert_eq!(
            map.wrap(),
            Wrap::Repeat,
            "the baselines are for maps that repeat"
        );
        let size = [map.width(), map.height()];
        let [pitch, rows] = size.map(|size| (size as usize).div_ceil(SIDE));
        let mut high = vec![
            High {
                s: [0; LANES],
                t: [0; LANES]
            };
            pitch * rows
        ];
        let mut low = vec![
            Low {
                s: [0; LANES],
                t: [0; LANES]
            };
            pitch * rows
        ];
        for (row, texels) in map.texels().chunks_exact(size[0] as usize).enumerate() {
            for (column, texel) in texels.iter().enumerate() {
                let place = row / SIDE * pitch + column / SIDE;
                let lane = row % SIDE * SIDE + column % SIDE;
                let [s, t] = texel.map(|part| fixed(f64::from(part)));
                let (high, low) = (&mut high[place], &mut low[place]);
                (high.s[lane], low.s[lane]) = ((s >> 16) as i16, s as u16);
                (high.t[lane], low.t[lane]) = ((t >> 16) as i16, t as u16);
            }
        }
        let last = size.map(|size| (size as usize - 1) % SIDE);
        let exists = |is_there: bool| if is_there { 1.0 } else { 0.0 };
        Self {
            size,
            pitch,
            high,
            low,
            padding: [
                std::array::from_fn(|lane| exists(lane % SIDE <= last[0])),
                std::array::from_fn(|lane| exists(lane / SIDE <= last[1])),
            ],
            instructions: Instructions::Fastest,
        }
    }

    /// The same scan with other instructions; the fastest unless this says otherwise.
    #[must_use]
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.instructions = instructions;
        self
    }

    /// Bytes kept in memory.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.high) + size_of_val(&*self.low)) as u64
    }

    /// D at `half_vector` under `footprint`: the kernel's sum over all texels, [`Kernel::Disk`] or Beckmann's.
    ///
    /// Terms below e^−16.6 of the kernel's peak, which single precision would not notice beside the peak, count as 0.
    ///
    /// # Panics
    /// If the footprint has no area.
    pub fn eval(
        &self,
        footprint: &Footprint,
        half_vector: HalfVector,
        filter: Filter,
        kernel: Kernel,
        roughness: f64,
    ) -> f64 {
        if !half_vector.is_on_disk() {
            return 0.0;
        }
        let lobe = Lobe::new(half_vector, roughness);
        let sum = match filter {
            Filter::Box => self.sum(Coverage::new(footprint, self.size), lobe, kernel),
            Filter::Gaussian => self.sum(Gaussian::new(footprint, self.size), lobe, kernel),
        };
        sum * lobe.peak()
    }

    /// Where the square in a column and row of squares is.
    #[inline(always)]
    fn square(&self, [column, row]: [u16; 2]) -> usize {
        usize::from(row) * self.pitch + usize::from(column)
    }

    fn sum<R: Region>(&self, region: R, lobe: Lobe, kernel: Kernel) -> f64 {
        if kernel == Kernel::Disk {
            self.instructions.run(Scan::<R, false> {
                map: self,
                region,
                lobe,
            })
        } else {
            self.instructions.run(Scan::<R, true> {
                map: self,
                region,
                lobe,
            })
        }
    }
}

/// Fixed-point numbers in a length of 1: a bit less than 2³⁰, so that differences fit an `i32`.
const UNIT: f64 = 1_073_676_288.0;

/// A component of a normal in fixed point, from 0 to 2³¹.
fn fixed(component: f64) -> i32 {
    (component.clamp(-1.0, 1.0) * UNIT).round() as i32 + (1 << 30)
}

/// A query: the sum of terms by their weights.
struct Scan<'a, R, const BECKMANN: bool> {
    map: &'a ExactScan,
    region: R,
    lobe: Lobe,
}

impl<R: Region, const BECKMANN: bool> Work for Scan<'_, R, BECKMANN> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let (centre, extent) = self.region.bounds();
        let size = self.map.size.map(f64::from);
        let columns = copies(centre[0], extent[0], size[0]);
        let rows = copies(centre[1], extent[1], size[1]);
        let mut sum = Sum {
            lanes: [0.0; LANES],
            count: 0,
            total: 0.0,
        };
        for row in rows {
            for column in columns.clone() {
                let centre = [
                    centre[0] - column as f64 * size[0],
                    centre[1] - row as f64 * size[1],
                ];
                self.add_copy(centre, extent, &mut sum);
            }
        }
        sum.flush();
        sum.total
    }
}

/// The copies of a map `size` texels long that a footprint touches which runs `extent` to either side of `centre`.
#[inline(always)]
fn copies(centre: f64, extent: f64, size: f64) -> Range<i64> {
    let first = ((centre - extent) / size).floor() as i64;
    let last = ((centre + extent) / size).floor() as i64;
    first..last + 1
}

/// Column and row of squares that wait to be weighed.
struct Lit {
    places: [[u16; 2]; WAITING],
    count: usize,
    /// Squares tested since there were none.
    tested: usize,
}

/// A sum: in single precision by lane for a while, then in double precision.
struct Sum {
    lanes: Lanes,
    count: usize,
    total: f64,
}

impl Sum {
    #[inline(always)]
    fn flush(&mut self) {
        let mut sum = 0.0;
        for lane in self.lanes {
            sum += f64::from(lane);
        }
        self.total += sum;
        self.lanes = [0.0; LANES];
        self.count = 0;
    }
}

impl<R: Region, const BECKMANN: bool> Scan<'_, R, BECKMANN> {
    /// Adds the squares of the map under the footprint if that lies around `centre`.
    #[inline(always)]
    fn add_copy(&self, centre: [f64; 2], extent: [f64; 2], sum: &mut Sum) {
        const TEXELS: f64 = SIDE as f64;
        let pitch = self.map.pitch;
        let rows = self.map.high.len() / pitch;
        // Casts saturate.
        let first_row = ((centre[1] - extent[1]) / TEXELS) as usize;
        let end_row = ((centre[1] + extent[1]) / TEXELS).ceil() as usize;
        // From the footprint's middle to that of the first square.
        let start = [0.5 * TEXELS - centre[0], 0.5 * TEXELS - centre[1]];
        let mut lit = Lit {
            places: [[0; 2]; WAITING],
            count: 0,
            tested: 0,
        };
        let mut most_are_lit = false;
        for row in first_row..end_row.min(rows) {
            let y = start[1] + row as f64 * TEXELS;
            let [from, to] = self.region.span(y);
            let mut column = ((from - start[0]) / TEXELS).ceil() as usize;
            let end = ((to - start[0]) / TEXELS + 1.0).max(0.0) as usize;
            let end = end.min(pitch);
            while column < end {
                let next = end.min(column + TESTED[usize::from(most_are_lit)]);
                self.test(row, column..next, &mut lit);
                column = next;
                let is_full = lit.count > WAITING - TESTED[0];
                if is_full | most_are_lit | (lit.tested > 4 * WAITING) {
                    most_are_lit = 2 * lit.count > lit.tested;
                    self.weigh(start, &mut lit, sum);
                }
            }
        }
        self.weigh(start, &mut lit, sum);
    }

    /// Adds to `lit` those squares of a row that may be lit. Without a branch, which on most maps would be guessed wrong as
    /// often as a square is lit.
    #[inline(always)]
    fn test(&self, row: usize, columns: Range<usize>, lit: &mut Lit) {
        let start = row * self.map.pitch;
        let squares = &self.map.high[start + columns.start..start + columns.end];
        lit.tested += squares.len();
        for (square, column) in squares.iter().zip(columns) {
            lit.places[lit.count] = [column as u16, row as u16];
            lit.count += usize::from(self.lobe.reaches(square, self.lobe.reach));
        }
    }

    /// Adds the squares that wait, of a map whose first square's middle is at `start`.
    #[inline(always)]
    fn weigh(&self, start: [f64; 2], lit: &mut Lit, sum: &mut Sum) {
        let map = self.map;
        let places = &lit.places[..lit.count];
        (lit.count, lit.tested) = (0, 0);
        // Asks for all lines that will be read, so that they arrive while others are waited for.
        let mut asked = 0;
        for place in places {
            asked ^= map.low[map.square(*place)].s[0];
        }
        black_box(asked);
        for place in places {
            let [column, row] = [usize::from(place[0]), usize::from(place[1])];
            let middle = [
                start[0] + (column * SIDE) as f64,
                start[1] + (row * SIDE) as f64,
            ];
            let square = map.square(*place);
            let (high, low) = (&map.high[square], &map.low[square]);
            let left = self.region.left(middle);
            if left < 1.0 && !(left > 0.0 && self.lobe.reaches(high, self.lobe.reach_of(left))) {
                continue;
            }
            let mut weights = [0.0; LANES];
            self.region.weigh(middle, &mut weights);
            let is_last = [
                column + 1 == map.pitch,
                square + map.pitch >= map.high.len(),
            ];
            for (padding, is_last) in map.padding.iter().zip(is_last) {
                if is_last {
                    for (weight, share) in weights.iter_mut().zip(padding) {
                        *weight *= share;
                    }
                }
            }
            self.lobe
                .add::<BECKMANN>(high, low, &weights, &mut sum.lanes);
        }
        sum.count += places.len();
        if sum.count >= TOGETHER {
            sum.flush();
        }
    }
}

#[inline(always)]
fn max(one: f32, other: f32) -> f32 {
    if one > other { one } else { other }
}

#[inline(always)]
fn min(one: f32, other: f32) -> f32 {
    if one < other { one } else { other }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::subject::{self, Patch};
    use glintbake_format::model::Method;
    use glintbake_samples::{Kind, Options, generate};

    #[test]
    fn the_scan_is_the_truth_within_single_precision() {
        let options = Options {
            width: 61,
            height: 40,
            seed: 3,
            ..Options::new(Kind::Waves, 1)
        };
        let sample = generate(Kind::Waves, &options).unwrap();
        let map = NormalMap::new(61, 40, Wrap::Repeat, sample.normals);
        let scan = ExactScan::new(&map);
        let subject = subject::find(Method::FlakeBins);
        let mut lit = 0;
        for filter in [Filter::Box, Filter::Gaussian] {
            let variant = &subject.variants(filter)[0];
            for (case, edge) in [0.6, 3.0, 9.0, 30.0, 75.0].into_iter().enumerate() {
                let angle = 0.4 + case as f64;
                let footprint = Footprint {
                    centre: [0.9 - 0.13 * case as f64, 0.2],
                    edge_1: [edge * angle.cos() / 61.0, edge * angle.sin() / 40.0],
                    edge_2: [-edge * angle.sin() / 80.0, edge * angle.cos() / 60.0],
                };
                let patch = Patch::new(&map, &footprint, filter);
                for alpha in [0.003, 0.05, 0.6] {
                    let truth = subject.truth(variant, &patch, alpha);
                    for step in 0..8 {
                        let uniform = [0.1, 0.7, 0.3, 0.9]
                            .map(|x: f64| (x + 0.137 * f64::from(step)).fract());
                        let Some(h) = truth.draw(&patch, uniform) else {
                            continue;
                        };
                        let exact = truth.ndf(h);
                        let found = scan.eval(&footprint, h, filter, Kernel::Beckmann, alpha);
                        let bound = match filter {
                            Filter::Box => 2e-6,
                            Filter::Gaussian => 1e-4,
                        };
                        assert!(
                            (found - exact).abs() <= bound * exact,
                            "{filter:?} edge {edge} α {alpha}: {found} for {exact}"
                        );
                        let portable = scan.clone().with_instructions(Instructions::Portable);
                        let same = portable.eval(&footprint, h, filter, Kernel::Beckmann, alpha);
                        assert_eq!(found, same, "{filter:?} edge {edge} α {alpha}");
                        lit += 1;
                    }
                }
            }
        }
        assert!(lit > 200, "{lit}");
    }
}
