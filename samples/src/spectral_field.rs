//! A periodic height field given by the amplitudes of its waves, with exact derivatives.
//!
//! On a tile of W × H texels the waves that repeat have k = 2π (m/W, n/H) radians a texel, m and n whole. With ĥ their
//! complex amplitudes, ĥ(−k) the conjugate of ĥ(k),
//!
//! ```text
//!     h(x, y) = ∑ ĥ(k) exp(i k·(x, y))        ∇h = ∑ i k ĥ(k) exp(i k·(x, y))
//! ```
//!
//! Slopes are thus those of the sum of waves itself, not differences between texels. Both are real, so that one complex
//! transform gives the two: ∂h/∂x + i ∂h/∂y has the amplitudes (i kx − ky) ĥ(k).

use core::f64::consts::TAU;

use rayon::prelude::*;

use crate::fourier::{Complex, Fourier};

/// Columns that are transformed at once: 128 bytes of each row, so that memory is read by whole cache lines.
const LANES: usize = 16;

/// Which wave of a tile: (m, n) waves along (columns, rows), 2|m| < width and 2|n| < height.
pub type Wave = [i64; 2];

/// The wave vector of `wave` on a tile of `size`, in radians per texel along (columns, rows).
pub fn wave_vector(wave: Wave, size: [u32; 2]) -> [f64; 2] {
    [0, 1].map(|axis| TAU * wave[axis] as f64 / f64::from(size[axis]))
}

/// Fills `slopes`, all zero, with (∂h/∂column, ∂h/∂row) of the field with the amplitudes ĥ that `amplitude` gives.
///
/// `amplitude` is asked for one wave of each pair ±k, that with n > 0 or with n = 0 and m > 0; `None` is 0. Constant
/// height (k = 0) has no slope, and waves of exactly two texels have none at the texels: those are left out, so that a
/// tile of 1 or 2 texels does not vary. Between rows and columns values are kept as `f32`, in `slopes` itself, which
/// adds an error of 3e-8 of the RMS slope; beyond it one byte a texel is needed. O(texels · log of the sides).
pub fn fill_slopes(
    size: [u32; 2],
    amplitude: impl Fn(Wave) -> Option<Complex> + Sync,
    slopes: &mut [[f32; 2]],
) {
    transform_rows(size, &amplitude, slopes);
    transform_columns(size, slopes);
}

/// Writes the amplitudes of ∂h/∂x + i ∂h/∂y, row n holding those of the waves with n along the rows, and transforms
/// rows.
fn transform_rows(
    size: [u32; 2],
    amplitude: &(impl Fn(Wave) -> Option<Complex> + Sync),
    slopes: &mut [[f32; 2]],
) {
    let [width, height] = size.map(|side| side as usize);
    let fourier = Fourier::new(width);
    let work = || (vec![Complex::ZERO; width], fourier.spare(1));
    let (first, rest) = slopes.split_at_mut(width);
    let (mut row, mut spare) = work();
    for m in 1..=longest(width) {
        if let Some(h) = amplitude([m, 0]) {
            add_pair(&mut row, None, [m, 0], size, h);
        }
    }
    fourier.transform(&mut row, &mut spare, 1);
    store(&row, first);
    // Rows n and −n hold the two waves of each pair. Between them, an even height leaves out its middle.
    let (positive, negative) = rest.split_at_mut((height - 1) / 2 * width);
    let negative = &mut negative[(height - 1) % 2 * width..];
    positive
        .par_chunks_mut(width)
        .zip(negative.par_chunks_mut(width).rev())
        .enumerate()
        .for_each_init(
            || (work(), vec![Complex::ZERO; width]),
            |((row, spare), opposite), (index, (positive, negative))| {
                let n = index as i64 + 1;
                row.fill(Complex::ZERO);
                opposite.fill(Complex::ZERO);
                let mut still = true;
                for m in -longest(width)..=longest(width) {
                    if let Some(h) = amplitude([m, n]) {
                        add_pair(row, Some(opposite), [m, n], size, h);
                        still = false;
                    }
                }
                if still {
                    return;
                }
                for (line, texels) in [(row, positive), (opposite, negative)] {
                    fourier.transform(line, spare, 1);
                    store(line, texels);
                }
            },
        );
}

/// The largest m with 2m < `side`.
fn longest(side: usize) -> i64 {
    (side as i64 - 1) / 2
}

/// Puts the slopes' amplitude at `wave`, where the heights' is `h`, into its row, and that at the opposite wave into
/// the row of that, the same one if `None`.
fn add_pair(
    row: &mut [Complex],
    opposite: Option<&mut [Complex]>,
    wave: Wave,
    size: [u32; 2],
    h: Complex,
) {
    let [kx, ky] = wave_vector(wave, size);
    let width = row.len() as i64;
    let derivative = Complex { re: -ky, im: kx };
    row[wave[0].rem_euclid(width) as usize] = derivative * h;
    opposite.unwrap_or(row)[(-wave[0]).rem_euclid(width) as usize] =
        Complex { re: ky, im: -kx } * h.conjugate();
}

fn store(line: &[Complex], texels: &mut [[f32; 2]]) {
    for (texel, x) in texels.iter_mut().zip(line) {
        *texel = [x.re as f32, x.im as f32];
    }
}

fn transform_columns(size: [u32; 2], slopes: &mut [[f32; 2]]) {
    let [width, height] = size.map(|side| side as usize);
    let fourier = Fourier::new(height);
    // For each block of columns, its part of every row: what a thread may write.
    let mut blocks: Vec<_> = (0..width.div_ceil(LANES))
        .map(|_| Vec::with_capacity(height))
        .collect();
    for row in slopes.chunks_exact_mut(width) {
        for (block, part) in blocks.iter_mut().zip(row.chunks_mut(LANES)) {
            block.push(part);
        }
    }
    blocks.into_par_iter().for_each_init(
        || (vec![Complex::ZERO; height * LANES], fourier.spare(LANES)),
        |(columns, spare), mut block| {
            columns.fill(Complex::ZERO);
            for (line, part) in columns.chunks_exact_mut(LANES).zip(&block) {
                for (x, &[re, im]) in line.iter_mut().zip(part.iter()) {
                    *x = Complex {
                        re: f64::from(re),
                        im: f64::from(im),
                    };
                }
            }
            fourier.transform(columns, spare, LANES);
            for (line, part) in columns.chunks_exact(LANES).zip(&mut block) {
                store(line, part);
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Random, Stream, key};

    /// Amplitudes without any pattern, a few left out.
    fn amplitude([m, n]: Wave) -> Option<Complex> {
        assert!(n > 0 || n == 0 && m > 0, "({m}, {n}) is not of the half");
        let key = key(8, Stream::Noise, 0);
        let mut random = Random::at(key, m.rem_euclid(1 << 20) as u64, n as u64);
        let [re, im] = random.gaussian_pair();
        (random.unit() < 0.9).then_some(Complex { re, im })
    }

    /// The derivatives of the real field 2 Re ∑ ĥ exp(i k·x) over the half of the waves, one wave after the other.
    fn direct(size: [u32; 2], [x, y]: [u32; 2]) -> [f64; 2] {
        let [m_end, n_end] = size.map(|side| i64::from(side.div_ceil(2)));
        let mut slope = [0.0; 2];
        for n in 0..n_end {
            for m in 1 - m_end..m_end {
                if n == 0 && m <= 0 {
                    continue;
                }
                let Some(Complex { re, im }) = amplitude([m, n]) else {
                    continue;
                };
                let k = wave_vector([m, n], size);
                let (sin, cos) = libm::sincos(k[0] * f64::from(x) + k[1] * f64::from(y));
                // d/dphase of 2 (re cos − im sin).
                let rate = -2.0 * (re * sin + im * cos);
                slope[0] += rate * k[0];
                slope[1] += rate * k[1];
            }
        }
        slope
    }

    #[test]
    fn slopes_are_those_of_the_sum_of_waves() {
        for size in [
            [16, 12],
            [13, 21],
            [1, 30],
            [31, 1],
            [2, 9],
            [40, 3],
            [35, 34],
        ] {
            let mut slopes = vec![[0.0; 2]; (size[0] * size[1]) as usize];
            fill_slopes(size, amplitude, &mut slopes);
            let expected: Vec<_> = (0..size[0] * size[1])
                .map(|i| direct(size, [i % size[0], i / size[0]]))
                .collect();
            let rms = |values: &[[f64; 2]]| {
                let sum: f64 = values.iter().map(|[a, b]| a * a + b * b).sum();
                (sum / values.len() as f64).sqrt()
            };
            let errors: Vec<_> = slopes
                .iter()
                .zip(&expected)
                .map(|(found, expected)| [0, 1].map(|i| f64::from(found[i]) - expected[i]))
                .collect();
            let error = rms(&errors) / rms(&expected);
            assert!(error < 1e-7, "{size:?}: {error}");
        }
    }

    #[test]
    fn tiles_of_two_texels_hold_no_wave() {
        for size in [[1, 1], [2, 1], [1, 2], [2, 2]] {
            let mut slopes = vec![[0.0; 2]; (size[0] * size[1]) as usize];
            fill_slopes(size, |_| unreachable!("no wave"), &mut slopes);
            assert!(slopes.iter().all(|&slope| slope == [0.0; 2]));
        }
    }
}
