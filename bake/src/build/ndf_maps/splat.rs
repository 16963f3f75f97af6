//! Gaussians added to an image of spline coefficients.

use glintbake_format::records::{NdfImage, pack_ndf};
use zerocopy::little_endian::{I32, U16, U32};

/// A Gaussian of normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Splat {
    /// What it integrates to.
    pub weight: f64,
    /// Its mean on the disk.
    pub mean: [f64; 2],
    /// Variance of s, covariance, variance of t.
    pub covariance: [f64; 3],
}

/// Standard deviations at which Gaussians end: 4e-6 of the peak.
const REACH: f64 = 5.0;

/// Densities at the nodes `(place + i) pitch`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Image {
    pub place: [i32; 2],
    pub size: [usize; 2],
    pub values: Vec<f64>,
}

impl Image {
    /// Zeros on the nodes from `low` up to, and without, `high`.
    pub fn zeros(low: [i32; 2], high: [i32; 2]) -> Self {
        let size = [0, 1].map(|axis| (high[axis] - low[axis]).max(0) as usize);
        Self {
            place: low,
            size,
            values: vec![0.0; size[0] * size[1]],
        }
    }

    /// The sum of `splats` at nodes of `pitch`, as far as they reach.
    pub fn of(splats: &[Splat], pitch: f64) -> Self {
        let mut low = [i32::MAX; 2];
        let mut high = [i32::MIN; 2];
        for splat in splats {
            let (least, most) = splat.nodes(pitch);
            for axis in 0..2 {
                low[axis] = low[axis].min(least[axis]);
                high[axis] = high[axis].max(most[axis] + 1);
            }
        }
        if splats.is_empty() {
            return Self::default();
        }
        let mut image = Self::zeros(low, high);
        for splat in splats {
            image.add(splat, pitch);
        }
        image
    }

    /// Adds `splat`, whose nodes must all be the image's.
    fn add(&mut self, splat: &Splat, pitch: f64) {
        let [ss, st, tt] = splat.covariance;
        let determinant = ss * tt - st * st;
        let (a, b, c) = (
            0.5 * pitch * pitch * tt / determinant,
            0.5 * pitch * pitch * st / determinant,
            0.5 * pitch * pitch * ss / determinant,
        );
        let peak = splat.weight / (core::f64::consts::TAU * determinant.sqrt());
        let (least, most) = splat.nodes(pitch);
        let middle = splat.mean.map(|mean| mean / pitch);
        // Of e^{-(a x² - 2 b x y + c y²)} a step in x is a factor, which itself changes by a factor at each step.
        let bend = libm::exp(-2.0 * a);
        for node in least[1]..=most[1] {
            let y = f64::from(node) - middle[1];
            // The columns within reach of this row.
            let centre = b * y / a;
            let room = 0.5 * REACH * REACH - (c - b * b / a) * y * y;
            if room <= 0.0 {
                continue;
            }
            let half = (room / a).sqrt();
            let first = (middle[0] + centre - half).ceil().max(f64::from(least[0])) as i32;
            let last = (middle[0] + centre + half).floor().min(f64::from(most[0])) as i32;
            let x = f64::from(first) - middle[0];
            let mut value = peak * libm::exp(-(a * x * x - 2.0 * b * x * y + c * y * y));
            let mut step = libm::exp(-(a * (2.0 * x + 1.0) - 2.0 * b * y));
            let start = (node - self.place[1]) as usize * self.size[0];
            for column in first..=last {
                self.values[start + (column - self.place[0]) as usize] += value;
                value *= step;
                step *= bend;
            }
        }
    }

    /// The mean of `images`, weighed by `weights`, which add up to one.
    pub fn mean(images: &[&Self], weights: &[f64]) -> Self {
        let filled = || images.iter().filter(|image| !image.values.is_empty());
        let edge = |axis: usize| {
            let low = filled().map(|image| image.place[axis]).min();
            let high = filled().map(|image| image.place[axis] + image.size[axis] as i32);
            (low.unwrap_or(0), high.max().unwrap_or(0))
        };
        let [x, y] = [edge(0), edge(1)];
        let mut mean = Self::zeros([x.0, y.0], [x.1, y.1]);
        for (image, weight) in images.iter().zip(weights) {
            for (row, values) in image.values.chunks(image.size[0].max(1)).enumerate() {
                let y = (image.place[1] - mean.place[1]) as usize + row;
                let x = (image.place[0] - mean.place[0]) as usize;
                let start = y * mean.size[0] + x;
                for (sum, value) in mean.values[start..].iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
        mean
    }

    /// The image in pixels of `unit`, without rows and columns of zeros at its sides, and where it lies if its first pixel is the
    /// one after `first` others.
    pub fn packed(&self, unit: f64, first: u32) -> (NdfImage, Vec<U16>) {
        let columns = self.size[0];
        let mut packed = vec![0; self.values.len()];
        let mut box_of = [[usize::MAX, 0], [usize::MAX, 0]];
        for (place, (pixel, &value)) in packed.iter_mut().zip(&self.values).enumerate() {
            *pixel = pack_ndf(value / unit);
            if *pixel > 0 {
                for (sides, at) in box_of.iter_mut().zip([place % columns, place / columns]) {
                    *sides = [sides[0].min(at), sides[1].max(at + 1)];
                }
            }
        }
        let [[left, right], [top, bottom]] = if box_of[0][1] == 0 {
            // Nothing is seen: a single pixel of zero.
            [[0, 1], [0, 1]]
        } else {
            box_of
        };
        let mut pixels = Vec::with_capacity((right - left) * (bottom - top));
        for row in top..bottom {
            for column in left..right {
                let pixel = packed.get(row * columns + column).copied();
                pixels.push(U16::new(pixel.unwrap_or(0)));
            }
        }
        let image = NdfImage {
            place: [
                I32::new(self.place[0] + left as i32),
                I32::new(self.place[1] + top as i32),
            ],
            size: [
                U16::new((right - left) as u16),
                U16::new((bottom - top) as u16),
            ],
            first: U32::new(first),
        };
        (image, pixels)
    }

    /// The image with the mass of each node, which stands in its middle or, if `is_whole`, half a pitch beyond, at where `to` takes
    /// it, by the weights of Catmull and Rom: these keep mass, mean and variance.
    pub fn moved(&self, pitch: f64, is_whole: bool, to: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        let shift = if is_whole { 0.5 } else { 0.0 };
        let mut moved: Vec<([f64; 2], f64)> = Vec::new();
        let mut low = [i32::MAX; 2];
        let mut high = [i32::MIN; 2];
        for (place, &value) in self.values.iter().enumerate() {
            if value <= 0.0 {
                continue;
            }
            let node = [place % self.size[0], place / self.size[0]];
            let normal = [0, 1]
                .map(|axis| (f64::from(self.place[axis]) + node[axis] as f64 + shift) * pitch);
            let at = to(normal).map(|x| x / pitch - shift);
            for axis in 0..2 {
                let first = at[axis].floor() as i32;
                low[axis] = low[axis].min(first - 1);
                high[axis] = high[axis].max(first + 3);
            }
            moved.push((at, value));
        }
        if moved.is_empty() {
            return Self::default();
        }
        let mut image = Self::zeros(low, high);
        for (at, value) in moved {
            let first = at.map(|x| x.floor());
            let [across, down] = [0, 1].map(|axis| catmull_rom(at[axis] - first[axis]));
            for (j, down) in down.into_iter().enumerate() {
                let row = (first[1] as i32 - 1 - image.place[1]) as usize + j;
                let column = (first[0] as i32 - 1 - image.place[0]) as usize;
                let start = row * image.size[0] + column;
                for (sum, across) in image.values[start..start + 4].iter_mut().zip(across) {
                    *sum += value * down * across;
                }
            }
        }
        for value in &mut image.values {
            *value = value.max(0.0);
        }
        image
    }

    /// The part of it on the nodes from `low` up to, and without, `high`, with zeros where it has none.
    pub fn within(&self, low: [i32; 2], high: [i32; 2]) -> Self {
        let mut part = Self::zeros(low, high);
        let [columns, rows] = part.size;
        for row in 0..rows {
            for column in 0..columns {
                let x = low[0] + column as i32 - self.place[0];
                let y = low[1] + row as i32 - self.place[1];
                if (0..self.size[0] as i32).contains(&x) && (0..self.size[1] as i32).contains(&y) {
                    part.values[row * columns + column] =
                        self.values[y as usize * self.size[0] + x as usize];
                }
            }
        }
        part
    }

    /// As [`packed`](Self::packed), with all rows and columns.
    pub fn packed_whole(&self, unit: f64, first: u32) -> (NdfImage, Vec<U16>) {
        let image = NdfImage {
            place: self.place.map(I32::new),
            size: self.size.map(|side| U16::new(side as u16)),
            first: U32::new(first),
        };
        let pixels = self
            .values
            .iter()
            .map(|value| U16::new(pack_ndf(value / unit)));
        (image, pixels.collect())
    }
}

/// The weights of the nodes -1, 0, 1 and 2 for what lies `x` past node 0.
fn catmull_rom(x: f64) -> [f64; 4] {
    let (square, cube) = (x * x, x * x * x);
    [
        0.5 * (-x + 2.0 * square - cube),
        0.5 * (2.0 - 5.0 * square + 3.0 * cube),
        0.5 * (x + 4.0 * square - 3.0 * cube),
        0.5 * (cube - square),
    ]
}

impl Splat {
    /// The first and the last node within reach, along either axis.
    fn nodes(&self, pitch: f64) -> ([i32; 2], [i32; 2]) {
        let [ss, _, tt] = self.covariance;
        let reach = [ss, tt].map(|variance| REACH * variance.sqrt());
        let node = |axis: usize, sign: f64| (self.mean[axis] + sign * reach[axis]) / pitch;
        (
            [0, 1].map(|axis| node(axis, -1.0).ceil() as i32),
            [0, 1].map(|axis| node(axis, 1.0).floor() as i32),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_of_splats_are_their_densities() {
        let splat = |weight, mean, covariance| Splat {
            weight,
            mean,
            covariance,
        };
        let splats = [
            splat(0.25, [0.1, -0.2], [1e-4, 3e-5, 2e-4]),
            splat(0.75, [0.12, -0.17], [1.1e-4, 0.0, 1e-4]),
        ];
        let pitch = 0.01;
        let image = Image::of(&splats, pitch);
        let mut sum = 0.0;
        for (place, value) in image.values.iter().enumerate() {
            let s = f64::from(image.place[0] + (place % image.size[0]) as i32) * pitch;
            let t = f64::from(image.place[1] + (place / image.size[0]) as i32) * pitch;
            let mut expected = 0.0;
            for Splat {
                weight,
                mean,
                covariance: [ss, st, tt],
            } in splats
            {
                let (x, y) = (s - mean[0], t - mean[1]);
                let determinant = ss * tt - st * st;
                let exponent = (tt * x * x - 2.0 * st * x * y + ss * y * y) / determinant;
                expected += weight / (core::f64::consts::TAU * determinant.sqrt())
                    * libm::exp(-0.5 * exponent);
            }
            // What lies beyond the reach is left out.
            assert!((value - expected).abs() < 1e-9 * expected + 0.02, "{s} {t}");
            sum += value * pitch * pitch;
        }
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
    }

    #[test]
    fn packing_trims_what_is_not_seen() {
        let mut image = Image::zeros([-3, 5], [7, 11]);
        image.values[2 * 10 + 4] = 1.0;
        image.values[4 * 10 + 5] = 0.5;
        let (record, pixels) = image.packed(1.0, 7);
        assert_eq!(record.place.map(I32::get), [1, 7]);
        assert_eq!(record.size.map(U16::get), [2, 3]);
        assert_eq!(pixels.len(), 6);
        let (record, pixels) = Image::default().packed(1.0, 7);
        assert_eq!(record.size.map(U16::get), [1, 1]);
        assert_eq!(pixels, [U16::ZERO]);
    }
}
