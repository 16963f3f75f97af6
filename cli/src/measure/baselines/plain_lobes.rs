//! The plain sum of lobes: every lobe within four standard deviations of the footprint, sixteen at a time.
//!
//! What a renderer would write first, and what a structure over lobes has to beat: normals and slopes in six arrays of f32, 24
//! bytes a lobe, read in rows, with the vectors that the runtime has. \[YHMR16\] eq. 6 in the form of \[TZX22\] eq. 6, without the
//! inverse of a 4 × 4 matrix, divided by the sum of weights.
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Footprint, HalfVector, LobeLattice};
use glintbake_runtime::{Instructions, Work};
use std::f64::consts::PI;

const LANES: usize = 16;

/// Standard deviations of position that are summed.
const REACH: f64 = 4.0;

/// The lobes of a repeating map, one a texel.
#[derive(Clone, Debug)]
pub struct PlainLobes {
    size: [usize; 2],
    is_curved: bool,
    /// s, t, ∂s/∂x, ∂s/∂y, ∂t/∂x, ∂t/∂y; rows are as long as the map's, and sixteen more at the end of all.
    fields: [Vec<f32>; 6],
}

impl PlainLobes {
    /// The lobes of `map`, which repeats whatever it says; slopes of 0 unless `is_curved`.
    pub fn new(map: &NormalMap, is_curved: bool) -> Self {
        let (width, height) = (map.width() as usize, map.height() as usize);
        let at = |x: usize, y: usize| map.texels()[(y % height) * width + x % width];
        let mut fields: [Vec<f32>; 6] =
            core::array::from_fn(|_| Vec::with_capacity(width * height + LANES));
        for y in 0..height {
            for x in 0..width {
                let half = |a: [f32; 2], b: [f32; 2]| [0.5 * (a[0] - b[0]), 0.5 * (a[1] - b[1])];
                let [s_x, t_x] = half(at(x + 1, y), at(x + width - 1, y));
                let [s_y, t_y] = half(at(x, y + 1), at(x, y + height - 1));
                let [s, t] = at(x, y);
                let factor = if is_curved { 1.0 } else { 0.0 };
                let values = [s, t, factor * s_x, factor * s_y, factor * t_x, factor * t_y];
                for (field, value) in fields.iter_mut().zip(values) {
                    field.push(value);
                }
            }
        }
        for field in &mut fields {
            field.resize(width * height + LANES, 0.0);
        }
        Self {
            size: [width, height],
            is_curved,
            fields,
        }
    }

    /// The density at `half_vector` for the kernel's deviation `sigma`, to about 3e-4: what lies beyond four deviations is left out.
    pub fn eval(&self, footprint: &Footprint, half_vector: HalfVector, sigma: f64) -> f64 {
        let [width, height] = self.size.map(|side| side as f64);
        let half = |[x, y]: [f64; 2]| [0.5 * x * width, 0.5 * y * height];
        let (e1, e2) = (half(footprint.edge_1), half(footprint.edge_2));
        let variance = LobeLattice::DEVIATION * LobeLattice::DEVIATION;
        let [xx, yy, xy] = [
            e1[0] * e1[0] + e2[0] * e2[0] + variance,
            e1[1] * e1[1] + e2[1] * e2[1] + variance,
            e1[0] * e1[1] + e2[0] * e2[1],
        ];
        let determinant = xx * yy - xy * xy;
        let given = (determinant / yy).sqrt();
        let inverse = [yy / determinant, xx / determinant, -xy / determinant];
        // Q = A - A S⁻¹ A, by a triangular root.
        let q = [
            variance - variance * variance * inverse[0],
            variance - variance * variance * inverse[1],
            -variance * variance * inverse[2],
        ];
        let root = q[0].max(0.0).sqrt();
        let lean = if root > 0.0 { q[2] / root } else { 0.0 };
        let rest = (q[1] - lean * lean).max(0.0).sqrt();
        let sum = Instructions::default().run(Sum {
            lobes: self,
            centre: [
                (footprint.centre[0] - footprint.centre[0].floor()) * width,
                (footprint.centre[1] - footprint.centre[1].floor()) * height,
            ],
            whiten: [1.0 / given, -xy / yy / given, 1.0 / yy.sqrt()],
            shift: [
                variance * inverse[0],
                variance * inverse[2],
                variance * inverse[1],
            ]
            .map(|x| x as f32),
            spread: [root, lean, rest].map(|x| (x / sigma) as f32),
            normal: [half_vector.s, half_vector.t],
            scale: 1.0 / sigma,
        });
        let (amount, weight) = sum;
        amount / weight / (2.0 * PI * sigma * sigma)
    }
}

struct Sum<'l> {
    lobes: &'l PlainLobes,
    centre: [f64; 2],
    /// p = (a x + b y, c y).
    whiten: [f64; 3],
    /// K: xx, xy, yy.
    shift: [f32; 3],
    /// A root of Q in deviations of the kernel: (a, 0), (b, c).
    spread: [f32; 3],
    normal: [f64; 2],
    scale: f64,
}

impl Work for Sum<'_> {
    type Output = (f64, f64);

    #[inline(always)]
    fn run(self) -> (f64, f64) {
        let [a, b, c] = self.whiten;
        let [width, height] = self.lobes.size;
        let first_row = (self.centre[1] - REACH / c - 0.5).ceil() as i64;
        let last_row = (self.centre[1] + REACH / c - 0.5).floor() as i64;
        let (mut amount, mut weight) = (0.0, 0.0);
        for row in first_row..=last_row {
            let y = self.centre[1] - (row as f64 + 0.5);
            let across = c * y;
            let left = (REACH * REACH - across * across).max(0.0).sqrt();
            let middle = self.centre[0] + b / a * y;
            let mut column = (middle - left / a - 0.5).ceil() as i64;
            let end = (middle + left / a - 0.5).floor() as i64 + 1;
            let line = row.rem_euclid(height as i64) as usize * width;
            while column < end {
                let start = column.rem_euclid(width as i64) as usize;
                let count = ((end - column) as usize).min(width - start).min(LANES);
                let x = self.centre[0] - (column as f64 + 0.5);
                let p = [(a * x + b * y) as f32, across as f32];
                let place = [x as f32, y as f32];
                let part = if self.lobes.is_curved {
                    self.curved(line + start, count, place, p)
                } else {
                    self.flat(line + start, count, p)
                };
                amount += f64::from(part[0]);
                weight += f64::from(part[1]);
                column += count as i64;
            }
        }
        (amount, weight)
    }
}

impl Sum<'_> {
    #[inline(always)]
    fn lanes(&self, field: usize, start: usize) -> &[f32; LANES] {
        let lanes = &self.lobes.fields[field][start..start + LANES];
        lanes.try_into().expect("sixteen lanes")
    }

    #[inline(always)]
    fn curved(&self, start: usize, count: usize, place: [f32; 2], first: [f32; 2]) -> [f32; 2] {
        let fields: [&[f32; LANES]; 6] = core::array::from_fn(|field| self.lanes(field, start));
        let (scale, a) = (self.scale as f32, self.whiten[0] as f32);
        let normal = self.normal.map(|x| x as f32);
        let [k_xx, k_xy, k_yy] = self.shift;
        let [g, h, k] = self.spread;
        let (mut amounts, mut weights) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let [s_x, s_y, t_x, t_y] = [2, 3, 4, 5].map(|field: usize| fields[field][lane]);
            let column = lane as f32;
            let (x, p) = (place[0] - column, first[0] - a * column);
            let (dx, dy) = (k_xx * x + k_xy * place[1], k_xy * x + k_yy * place[1]);
            let s = (normal[0] - fields[0][lane] - s_x * dx - s_y * dy) * scale;
            let t = (normal[1] - fields[1][lane] - t_x * dx - t_y * dy) * scale;
            let (f_s, f_t) = (s_x * g + s_y * h, t_x * g + t_y * h);
            let (g_s, g_t) = (s_y * k, t_y * k);
            let cross = f_s * g_t - f_t * g_s;
            let determinant = 1.0 + f_s * f_s + f_t * f_t + g_s * g_s + g_t * g_t + cross * cross;
            let (u, v) = (f_s * t - f_t * s, g_s * t - g_t * s);
            let normal_squared = (s * s + t * t + u * u + v * v) / determinant;
            let position_squared = p * p + first[1] * first[1];
            let kept = if lane < count { 1.0 } else { 0.0 };
            let share = kept * exponential(-0.5 * position_squared);
            weights[lane] = share;
            amounts[lane] = share * exponential(-0.5 * normal_squared) / determinant.sqrt();
        }
        [total(&amounts), total(&weights)]
    }

    #[inline(always)]
    fn flat(&self, start: usize, count: usize, first: [f32; 2]) -> [f32; 2] {
        let fields: [&[f32; LANES]; 2] = core::array::from_fn(|field| self.lanes(field, start));
        let (scale, a) = (self.scale as f32, self.whiten[0] as f32);
        let normal = self.normal.map(|x| x as f32);
        let (mut amounts, mut weights) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let p = first[0] - a * lane as f32;
            let s = (normal[0] - fields[0][lane]) * scale;
            let t = (normal[1] - fields[1][lane]) * scale;
            let kept = if lane < count { 1.0 } else { 0.0 };
            let share = kept * exponential(-0.5 * (p * p + first[1] * first[1]));
            weights[lane] = share;
            amounts[lane] = share * exponential(-0.5 * (s * s + t * t));
        }
        [total(&amounts), total(&weights)]
    }
}

/// `e^x` for x up to 0, within 1e-6 of it: 2 to a whole number, and a polynomial for the rest.
#[inline(always)]
fn exponential(x: f32) -> f32 {
    let y = if x > -80.0 { x } else { -80.0 } * core::f32::consts::LOG2_E;
    let shifted = y + 12_582_912.0;
    let rest = (y - (shifted - 12_582_912.0)) * core::f32::consts::LN_2;
    let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    let series = 1.0
        + rest
            * (1.0
                + rest
                    * (0.5
                        + rest
                            * (1.0 / 6.0
                                + rest * (1.0 / 24.0 + rest * (1.0 / 120.0 + rest / 720.0)))));
    series * power
}

#[inline(always)]
fn total(lanes: &[f32; LANES]) -> f32 {
    let mut eighths = [0.0; 8];
    for lane in 0..8 {
        eighths[lane] = lanes[lane] + lanes[lane + 8];
    }
    let mut quarters = [0.0; 4];
    for lane in 0..4 {
        quarters[lane] = eighths[lane] + eighths[lane + 4];
    }
    let [a, b, c, d] = quarters;
    (a + c) + (b + d)
}
