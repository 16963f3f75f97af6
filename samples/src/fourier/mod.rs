//! The discrete Fourier transform, of any length.
//!
//! Our own, in plain `f64` arithmetic of a fixed order with roots of unity from `libm`: libraries choose their
//! instructions by the machine, and with them their rounding, but a sample has the same bytes everywhere.

mod bluestein;
mod complex;
mod stockham;

pub use complex::Complex;

use bluestein::Bluestein;
use stockham::Stockham;

/// The transform of sequences of one length.
pub enum Fourier {
    /// Length without prime factors above 5.
    Stockham(Stockham),
    /// Any other, at four to eight times the cost.
    Bluestein(Bluestein),
}

impl Fourier {
    /// The transform of `length` points, at least 1; its tables take 16 to 96 bytes a point.
    pub fn new(length: usize) -> Self {
        match Stockham::new(length) {
            Some(stockham) => Self::Stockham(stockham),
            None => Self::Bluestein(Bluestein::new(length)),
        }
    }

    /// Room for [`Fourier::transform`] to work in, for `lanes` sequences at once.
    pub fn spare(&self, lanes: usize) -> Vec<Complex> {
        let length = match self {
            Self::Stockham(stockham) => stockham.length(),
            Self::Bluestein(bluestein) => bluestein.spare_length(),
        };
        vec![Complex::ZERO; length * lanes]
    }

    /// Replaces each of `lanes` interleaved sequences x of n points by X, `X_k = ∑ x_j exp(+2πi jk/n)`: the inverse
    /// transform, without its factor 1/n.
    ///
    /// Point j of sequence l is `data[j * lanes + l]`. O(n log n); relative RMS error about 1e-16 · log₂ n.
    ///
    /// # Panics
    /// If `data` does not hold `lanes` sequences, or `spare` is not that of so many.
    pub fn transform(&self, data: &mut [Complex], spare: &mut [Complex], lanes: usize) {
        assert_eq!(data.len(), self.length() * lanes);
        match self {
            Self::Stockham(stockham) => stockham.transform(data, spare, lanes),
            Self::Bluestein(bluestein) => bluestein.transform(data, spare, lanes),
        }
    }

    fn length(&self) -> usize {
        match self {
            Self::Stockham(stockham) => stockham.length(),
            Self::Bluestein(bluestein) => bluestein.length(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Random, Stream, key};

    fn noise(count: usize) -> Vec<Complex> {
        let key = key(1, Stream::Noise, 0);
        (0..count as u64)
            .map(|k| {
                let [re, im] = Random::at(key, k, 0).gaussian_pair();
                Complex { re, im }
            })
            .collect()
    }

    /// The definition, with every root computed for itself.
    fn direct(data: &[Complex]) -> Vec<Complex> {
        let count = data.len();
        (0..count)
            .map(|k| {
                data.iter().enumerate().fold(Complex::ZERO, |sum, (j, &x)| {
                    sum + x * Complex::root(j * k % count, count)
                })
            })
            .collect()
    }

    fn transformed(data: &[Complex], lanes: usize) -> Vec<Complex> {
        let fourier = Fourier::new(data.len() / lanes);
        let mut result = data.to_vec();
        fourier.transform(&mut result, &mut fourier.spare(lanes), lanes);
        result
    }

    fn energy(data: &[Complex]) -> f64 {
        data.iter().map(|x| x.re * x.re + x.im * x.im).sum()
    }

    /// RMS of a − b over that of b.
    fn relative_error(a: &[Complex], b: &[Complex]) -> f64 {
        assert_eq!(a.len(), b.len());
        let differences: Vec<_> = a.iter().zip(b).map(|(&a, &b)| a - b).collect();
        (energy(&differences) / energy(b)).sqrt()
    }

    #[test]
    fn every_length_agrees_with_the_definition() {
        // All small ones, then powers of each radix, mixtures, primes and their squares.
        let long = [
            125, 127, 128, 169, 243, 251, 256, 360, 375, 500, 509, 512, 600, 625, 729, 961, 1009,
        ];
        for count in (1..=100).chain(long) {
            let data = noise(count);
            let error = relative_error(&transformed(&data, 1), &direct(&data));
            assert!(error < 2e-15, "{count} points: {error}");
        }
    }

    #[test]
    fn lanes_are_transformed_each_by_itself() {
        for (count, lanes) in [(1, 3), (12, 5), (64, 16), (60, 2), (37, 7)] {
            let data = noise(count * lanes);
            let found = transformed(&data, lanes);
            for lane in 0..lanes {
                let one = |all: &[Complex]| -> Vec<_> {
                    all.iter().skip(lane).step_by(lanes).copied().collect()
                };
                assert_eq!(
                    one(&found),
                    transformed(&one(&data), 1),
                    "{count} × {lanes}"
                );
            }
        }
    }

    #[test]
    fn twice_is_the_sequence_backwards_and_energy_is_kept() {
        for count in [1, 2, 6, 1000, 2048, 4096, 6561, 7919, 15625, 16381, 16384] {
            let data = noise(count);
            let once = transformed(&data, 1);
            // Parseval: ∑|X|² = n ∑|x|².
            let kept = energy(&once) / (count as f64 * energy(&data));
            assert!((kept - 1.0).abs() < 1e-14, "{count} points: {kept}");
            let twice: Vec<_> = transformed(&once, 1)
                .iter()
                .map(|x| x.scaled(1.0 / count as f64))
                .collect();
            let backwards: Vec<_> = (0..count).map(|k| data[(count - k) % count]).collect();
            let error = relative_error(&twice, &backwards);
            assert!(error < 4e-15, "{count} points: {error}");
        }
    }

    #[test]
    fn a_single_frequency_comes_out_in_its_place() {
        for count in [15, 16, 17] {
            let mut data = vec![Complex::ZERO; count];
            data[3] = Complex { re: 0.5, im: -2.0 };
            let wave = transformed(&data, 1);
            for (k, &x) in wave.iter().enumerate() {
                let expected = data[3] * Complex::root(3 * k, count);
                assert!(energy(&[x - expected]) < 1e-28, "{count} points, {k}");
            }
        }
    }
}
