//! The transform of any length, by a convolution of a length that is easy.
//!
//! Bluestein (1970): with 2jk = j² + k² − (k − j)² and the chirp `w_j` = exp(πi j²/n),
//!
//! ```text
//!     X_k = ∑ x_j exp(2πi jk/n) = w_k ∑ (x_j w_j) · conj(w_(k−j))
//! ```
//!
//! a convolution with a chirp, made cyclic over m ≥ 2n − 1 points.

use super::{Complex, stockham::Stockham};

/// The chirp of one length, and the convolution with it.
pub struct Bluestein {
    /// `w_j`, j from 0 to n − 1.
    chirp: Vec<Complex>,
    /// Transform of conj(w) over m points, divided by m.
    kernel: Vec<Complex>,
    convolution: Stockham,
}

impl Bluestein {
    /// The transform of `length` points, at least 1.
    pub fn new(length: usize) -> Self {
        let convolution_length = (2 * length - 1).next_power_of_two();
        let convolution = Stockham::new(convolution_length).expect("a power of two");
        // j² modulo 2n first: the angle would lose its digits otherwise.
        let chirp: Vec<_> = (0..length)
            .map(|j| Complex::root(j * j % (2 * length), 2 * length))
            .collect();
        let mut kernel = vec![Complex::ZERO; convolution_length];
        for (j, w) in chirp.iter().enumerate() {
            let w = w.conjugate().scaled(1.0 / convolution_length as f64);
            kernel[j] = w;
            kernel[(convolution_length - j) % convolution_length] = w;
        }
        let mut spare = kernel.clone();
        convolution.transform(&mut kernel, &mut spare, 1);
        Self {
            chirp,
            kernel,
            convolution,
        }
    }

    /// The number of points.
    pub fn length(&self) -> usize {
        self.chirp.len()
    }

    /// The numbers that [`Bluestein::transform`] works with, for one lane.
    pub fn spare_length(&self) -> usize {
        2 * self.kernel.len()
    }

    /// Replaces each of `lanes` interleaved sequences x by X, `X_k = ∑ x_j exp(2πi jk/n)`.
    pub fn transform(&self, data: &mut [Complex], spare: &mut [Complex], lanes: usize) {
        let (work, spare) = spare.split_at_mut(self.kernel.len() * lanes);
        let (used, padding) = work.split_at_mut(data.len());
        multiply_rows(used, data, &self.chirp, lanes, |x, w| x * w);
        padding.fill(Complex::ZERO);
        self.convolution.transform(work, spare, lanes);
        // The inverse transform is the conjugate of the transform of the conjugate.
        for (row, &weight) in work.chunks_exact_mut(lanes).zip(&self.kernel) {
            for x in row {
                *x = (*x * weight).conjugate();
            }
        }
        self.convolution.transform(work, spare, lanes);
        multiply_rows(data, work, &self.chirp, lanes, |x, w| x.conjugate() * w);
    }
}

/// Sets each row of `to` to the `product` of that of `from` and its factor.
fn multiply_rows(
    to: &mut [Complex],
    from: &[Complex],
    factors: &[Complex],
    lanes: usize,
    product: impl Fn(Complex, Complex) -> Complex,
) {
    let rows = to.chunks_exact_mut(lanes).zip(from.chunks_exact(lanes));
    for ((to, from), &factor) in rows.zip(factors) {
        for (to, &from) in to.iter_mut().zip(from) {
            *to = product(from, factor);
        }
    }
}
