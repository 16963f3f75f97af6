//! The vectorised exact scan: every texel under the footprint with its own normal, in single precision.
//!
//! What a renderer would write that has memory for the normals and nothing else: three planes of floats, rows under the
//! footprint eight texels at a time, texels that no light can reach skipped eight at a time. Texels on the outline of a
//! box count by their exact area; under a Gaussian texels count by the value of it and a texel convolved at their middle,
//! or by an average of 8 × 8 values where it is narrower than two texels. Compiled for whatever vectors the target has.

use super::parallelogram::{Parallelogram, Relation};
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, HalfVector, Kernel, Wrap};
use std::f32::consts::{LN_2, LOG2_E};
use std::f64::consts::{PI, SQRT_2};
use std::ops::Range;

/// Texels done at once: one register with AVX, two without.
const LANES: usize = 8;
/// Below it `e^x` counts as nothing: it is 0 in units that matter, and the exponential below ends at 2^-126.
const LEAST_EXPONENT: f32 = -80.0;
/// Standard deviations at which Gaussians end, as those of the methods do.
const CUT: f64 = 4.8;
/// Parts of a side of a texel under a narrow Gaussian.
const PARTS: u32 = 8;
/// Standard deviation in texels below which a Gaussian is narrow.
const NARROW: f64 = 2.0;

/// A map's normals in planes.
#[derive(Clone, Debug)]
pub struct ExactScan {
    width: u32,
    height: u32,
    s: Vec<f32>,
    t: Vec<f32>,
    z: Vec<f32>,
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
        let plane = |of: fn([f32; 2]) -> f32| map.texels().iter().map(|&texel| of(texel)).collect();
        Self {
            width: map.width(),
            height: map.height(),
            s: plane(|[s, _]| s),
            t: plane(|[_, t]| t),
            z: plane(|[s, t]| {
                let [s, t] = [f64::from(s), f64::from(t)];
                (1.0 - s * s - t * t).max(0.0).sqrt() as f32
            }),
        }
    }

    /// Bytes kept in memory.
    pub fn bytes(&self) -> u64 {
        12 * self.s.len() as u64
    }

    /// D at `half_vector` under `footprint`: the kernel's sum over all texels, [`Kernel::Disk`] or Beckmann's.
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
        let lobe = Lobe::new(half_vector, kernel, roughness);
        let sum = match filter {
            Filter::Box => self.box_sum(footprint, &lobe),
            Filter::Gaussian => self.gaussian_sum(footprint, &lobe),
        };
        sum * lobe.peak
    }

    fn box_sum(&self, footprint: &Footprint, lobe: &Lobe) -> f64 {
        let footprint = Parallelogram::new(footprint, self.width, self.height);
        let mut sum = 0.0;
        for copy in footprint.copies(self.width, self.height) {
            for row in copy.rows(self.height) {
                let (touched, inside) = copy.columns(row, self.width);
                let start = row as usize * self.width as usize;
                let place = |column: u32| start + column as usize;
                sum += self.run(place(inside.start)..place(inside.end), lobe);
                for column in (touched.start..inside.start).chain(inside.end..touched.end) {
                    let texel = [column as u16, row as u16];
                    let area = match copy.texel_relation(texel) {
                        Relation::Outside => continue,
                        Relation::Inside => 1.0,
                        Relation::Crossing => copy.clipped_area(texel),
                    };
                    sum += area * f64::from(self.texel(place(column), lobe, 0.0));
                }
            }
        }
        sum / footprint.area()
    }

    /// The sum over texels `places`, all of weight 1.
    // Kept apart, so that the compiler has all registers for the loop.
    #[inline(never)]
    fn run(&self, places: Range<usize>, lobe: &Lobe) -> f64 {
        let planes = [&self.s, &self.t, &self.z].map(|plane| &plane[places.clone()]);
        let [s, t, z] = planes.map(|plane| plane.as_chunks::<LANES>());
        let mut sums = [0.0_f32; LANES];
        let mut total = 0.0;
        for (part, ((s, t), z)) in s.0.iter().zip(t.0).zip(z.0).enumerate() {
            let exponents = lobe.exponents(s, t, z);
            if exponents
                .iter()
                .fold(false, |any, &x| any | (x > LEAST_EXPONENT))
            {
                let terms = lobe.terms(&exponents, s, t, z);
                for (sum, term) in sums.iter_mut().zip(terms) {
                    *sum += term;
                }
            }
            // Single precision adds up a thousand terms at most.
            if part % 128 == 127 {
                total += sums.iter().map(|&sum| f64::from(sum)).sum::<f64>();
                sums = [0.0; LANES];
            }
        }
        total += sums.iter().map(|&sum| f64::from(sum)).sum::<f64>();
        let rest = places.end - s.1.len();
        for place in rest..places.end {
            total += f64::from(self.texel(place, lobe, 0.0));
        }
        total
    }

    /// The term of one texel times `e^exponent`.
    fn texel(&self, place: usize, lobe: &Lobe, exponent: f32) -> f32 {
        let [s, t, z] = [&self.s, &self.t, &self.z].map(|plane| [plane[place]; LANES]);
        let exponents = lobe.exponents(&s, &t, &z).map(|x| x + exponent);
        if exponents[0] <= LEAST_EXPONENT {
            return 0.0;
        }
        lobe.terms(&exponents, &s, &t, &z)[0]
    }

    fn gaussian_sum(&self, footprint: &Footprint, lobe: &Lobe) -> f64 {
        let size = [f64::from(self.width), f64::from(self.height)];
        // Σ = (e1 e1ᵀ + e2 e2ᵀ) / 4, in texels.
        let [first, second] = [footprint.edge_1, footprint.edge_2]
            .map(|edge| [0.5 * edge[0] * size[0], 0.5 * edge[1] * size[1]]);
        let product = |i: usize, j: usize| first[i] * first[j] + second[i] * second[j];
        let (xx, xy, mut yy) = (product(0, 0), product(0, 1), product(1, 1));
        let mut determinant = (first[0] * second[1] - first[1] * second[0]).powi(2);
        assert!(determinant > 0.0, "baselines need a footprint with an area");
        let trace = xx + yy;
        let most = 0.5 * (trace + (trace * trace - 4.0 * determinant).max(0.0).sqrt());
        let least = determinant / most;
        let parts = if least < NARROW * NARROW { PARTS } else { 1 };
        if parts == 1 {
            // The Gaussian convolved with a texel, at its middle: the integral over it, to the fourth order.
            let texel = 1.0 / 12.0;
            determinant += texel * (xx + yy) + texel * texel;
            yy += texel;
        }
        let centre = [0, 1].map(|axis| {
            let centre = footprint.centre[axis];
            (centre - centre.floor()) * size[axis]
        });
        let reach = CUT * yy.sqrt();
        let rows = (centre[1] - reach).floor() as i64..=(centre[1] + reach).floor() as i64;
        let (mut sum, mut weights) = (0.0, 0.0);
        for row in rows {
            let start = row.rem_euclid(i64::from(self.height)) as usize * self.width as usize;
            for part in 0..parts {
                let y = row as f64 + (f64::from(part) + 0.5) / f64::from(parts) - centre[1];
                let rest = CUT * CUT - y * y / yy;
                if rest <= 0.0 {
                    continue;
                }
                // Along a row the Gaussian is one about `middle`, of variance det / yy.
                let (middle, variance) = (centre[0] + xy / yy * y, determinant / yy);
                let reach = (rest * variance).sqrt();
                let line = Line {
                    middle,
                    slope: -0.5 / variance,
                    exponent: -0.5 * y * y / yy,
                    columns: (middle - reach).floor() as i64..(middle + reach).floor() as i64 + 1,
                    parts,
                };
                self.gaussian_row(start, &line, lobe, &mut sum, &mut weights);
            }
        }
        sum / weights
    }

    /// Adds the texels of a row that begins at place `start`, and their weights.
    #[inline(never)]
    fn gaussian_row(
        &self,
        start: usize,
        line: &Line,
        lobe: &Lobe,
        sum: &mut f64,
        weights: &mut f64,
    ) {
        let mut column = line.columns.start;
        while column < line.columns.end {
            let first = column.rem_euclid(i64::from(self.width)) as usize;
            let count =
                (line.columns.end - column).min((self.width as usize - first) as i64) as usize;
            let place = start + first;
            let offset = (column as f64 - line.middle) as f32;
            let (mut done, mut sums, mut parts) = (0, [0.0_f32; LANES], [0.0_f32; LANES]);
            while done < count {
                let lanes = (count - done).min(LANES);
                let weight: [f32; LANES] =
                    std::array::from_fn(|lane| line.exponent_at(offset + (done + lane) as f32));
                let load = |plane: &[f32]| {
                    let mut values = [0.0; LANES];
                    values[..lanes].copy_from_slice(&plane[place + done..place + done + lanes]);
                    values
                };
                let (s, t, z) = (load(&self.s), load(&self.t), load(&self.z));
                let exponents = lobe.exponents(&s, &t, &z);
                let mut both: [f32; LANES] =
                    std::array::from_fn(|lane| exponents[lane] + weight[lane]);
                let mut plain = weight;
                for lane in lanes..LANES {
                    both[lane] = f32::NEG_INFINITY;
                    plain[lane] = f32::NEG_INFINITY;
                }
                if both
                    .iter()
                    .fold(false, |any, &x| any | (x > LEAST_EXPONENT))
                {
                    let terms = lobe.terms(&both, &s, &t, &z);
                    for (sum, term) in sums.iter_mut().zip(terms) {
                        *sum += term;
                    }
                }
                for (part, exponent) in parts.iter_mut().zip(plain) {
                    *part += exponential(exponent);
                }
                done += lanes;
            }
            *sum += sums.iter().map(|&sum| f64::from(sum)).sum::<f64>();
            *weights += parts.iter().map(|&part| f64::from(part)).sum::<f64>();
            column += count as i64;
        }
    }
}

/// A Gaussian along one line of a row of texels.
struct Line {
    /// Where it is highest, in texels.
    middle: f64,
    /// `-1/2` over its variance.
    slope: f64,
    /// The exponent there.
    exponent: f64,
    /// Columns it counts in.
    columns: Range<i64>,
    /// Points of a texel that are averaged.
    parts: u32,
}

impl Line {
    /// The exponent of the average over the texel whose left border is `x` from the middle.
    #[inline(always)]
    fn exponent_at(&self, x: f32) -> f32 {
        let (slope, exponent) = (self.slope as f32, self.exponent as f32);
        if self.parts == 1 {
            let x = x + 0.5;
            return exponent + slope * x * x;
        }
        let sum: f32 = (0..self.parts)
            .map(|part| {
                let x = x + (part as f32 + 0.5) / self.parts as f32;
                exponential(slope * x * x)
            })
            .sum();
        exponent + (sum / self.parts as f32).max(f32::MIN_POSITIVE).ln()
    }
}

/// The kernel about a half vector.
struct Lobe {
    half: [f32; 3],
    beckmann: bool,
    /// `-1/α²`, or `-1/(2 σr²)`.
    scale: f32,
    /// The density at the lobe's middle.
    peak: f64,
}

impl Lobe {
    fn new(half_vector: HalfVector, kernel: Kernel, roughness: f64) -> Self {
        let beckmann = kernel != Kernel::Disk;
        let deviation = roughness / SQRT_2;
        // Both are 1 / (π α²): 2 σr² is α².
        let peak = 1.0 / (PI * roughness * roughness);
        Self {
            half: half_vector.direction().map(|part| part as f32),
            beckmann,
            scale: if beckmann {
                (-1.0 / (roughness * roughness)) as f32
            } else {
                (-0.5 / (deviation * deviation)) as f32
            },
            peak,
        }
    }

    /// Squared chord between each normal and the half vector; on the disk if the kernel is.
    #[inline(always)]
    fn chord(&self, lane: usize, s: &[f32; LANES], t: &[f32; LANES], z: &[f32; LANES]) -> f32 {
        let [x, y] = [s[lane] - self.half[0], t[lane] - self.half[1]];
        let flat = x * x + y * y;
        let rise = z[lane] - self.half[2];
        if self.beckmann {
            flat + rise * rise
        } else {
            flat
        }
    }

    /// The exponent of each term. With the chord d, `cos θ = 1 - d²/2` and `sin²θ = d² (1 - d²/4)`: no small number comes
    /// from a difference of large ones, as in `1 - cos²θ` it would.
    #[inline(always)]
    fn exponents(&self, s: &[f32; LANES], t: &[f32; LANES], z: &[f32; LANES]) -> [f32; LANES] {
        std::array::from_fn(|lane| {
            let square = self.chord(lane, s, t, z);
            if !self.beckmann {
                return square * self.scale;
            }
            let cosine = (1.0 - 0.5 * square).max(1e-6);
            square * (1.0 - 0.25 * square) / (cosine * cosine) * self.scale
        })
    }

    /// Each term, as a share of the peak.
    #[inline(always)]
    fn terms(
        &self,
        exponents: &[f32; LANES],
        s: &[f32; LANES],
        t: &[f32; LANES],
        z: &[f32; LANES],
    ) -> [f32; LANES] {
        std::array::from_fn(|lane| {
            let term = exponential(exponents[lane]);
            if !self.beckmann {
                return term;
            }
            let cosine = 1.0 - 0.5 * self.chord(lane, s, t, z);
            let square = cosine.max(1e-6) * cosine.max(1e-6);
            // A flake shows only its front.
            if cosine > 0.0 {
                term / (square * square)
            } else {
                0.0
            }
        })
    }
}

/// `e^x` within 1e-6 for x from [`LEAST_EXPONENT`] to 0, and 0 below.
#[inline(always)]
fn exponential(x: f32) -> f32 {
    /// 1.5 · 2²³: adding it rounds to a whole number, which is then in the low bits.
    const WHOLE: f32 = 12_582_912.0;
    let y = x.max(LEAST_EXPONENT) * LOG2_E;
    let shifted = y + WHOLE;
    let rest = (y - (shifted - WHOLE)) * LN_2;
    let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    let series = 1.0
        + rest
            * (1.0
                + rest
                    * (0.5
                        + rest
                            * (1.0 / 6.0
                                + rest
                                    * (1.0 / 24.0 + rest * (1.0 / 120.0 + rest * (1.0 / 720.0))))));
    if x > LEAST_EXPONENT {
        series * power
    } else {
        0.0
    }
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
                        // Narrow Gaussians are averaged over points; else what single precision leaves of normals.
                        let bound = if filter == Filter::Gaussian && edge < 4.0 {
                            2e-2
                        } else {
                            2e-3
                        };
                        assert!(
                            (found - exact).abs() <= bound * exact,
                            "{filter:?} edge {edge} α {alpha}: {found} for {exact}"
                        );
                        lit += 1;
                    }
                }
            }
        }
        assert!(lit > 200, "{lit}");
    }
}
