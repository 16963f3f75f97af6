//! The transform of lengths without prime factors above 5.
//!
//! Stockham's self-sorting algorithm (Cochran et al. 1967; Van Loan 1992, §1.7), decimation in frequency: each stage
//! splits every remaining sequence of n points into r of n/r and writes them where the next stage reads, so that
//! nothing is ever put into bit-reversed order. With `stride` sequences interleaved it is the same algorithm from its
//! later stages on, which is how `lanes` transforms are made at once.

use super::Complex;

/// Roots of unity and radices of one length.
pub struct Stockham {
    /// `exp(2πi k/n)`.
    roots: Vec<Complex>,
    /// Their product is n.
    radices: Vec<usize>,
}

impl Stockham {
    /// The transform of `length` points, if 2, 3 and 5 are its only prime factors.
    pub fn new(length: usize) -> Option<Self> {
        let mut rest = length;
        let mut radices = Vec::new();
        for radix in [4, 2, 3, 5] {
            while rest.is_multiple_of(radix) {
                radices.push(radix);
                rest /= radix;
            }
        }
        (rest == 1).then(|| Self {
            roots: (0..length).map(|k| Complex::root(k, length)).collect(),
            radices,
        })
    }

    /// The number of points.
    pub fn length(&self) -> usize {
        self.roots.len()
    }

    /// Replaces each of `lanes` interleaved sequences x by X, `X_k = ∑ x_j exp(2πi jk/n)`, using `spare` of the same
    /// length.
    pub fn transform(&self, data: &mut [Complex], spare: &mut [Complex], lanes: usize) {
        let mut stride = lanes;
        let (mut from, mut to) = (&mut *data, &mut *spare);
        for &radix in &self.radices {
            match radix {
                4 => self.stage(from, to, stride, butterfly_4),
                2 => self.stage(from, to, stride, butterfly_2),
                3 => self.stage(from, to, stride, butterfly_3),
                _ => self.stage(from, to, stride, butterfly_5),
            }
            stride *= radix;
            (from, to) = (to, from);
        }
        if self.radices.len() % 2 == 1 {
            data.copy_from_slice(spare);
        }
    }

    /// One stage: `stride` interleaved sequences, each split into R.
    #[inline]
    fn stage<const R: usize>(
        &self,
        from: &[Complex],
        to: &mut [Complex],
        stride: usize,
        butterfly: impl Fn([Complex; R]) -> [Complex; R],
    ) {
        let count = from.len() / (stride * R);
        let root_step = self.length() / (count * R);
        for p in 0..count {
            let twiddles: [Complex; R] = core::array::from_fn(|k| self.roots[k * p * root_step]);
            let inputs: [&[Complex]; R] = core::array::from_fn(|j| {
                let start = stride * (p + count * j);
                &from[start..start + stride]
            });
            let outputs = to[stride * R * p..].chunks_exact_mut(stride);
            let outputs: [&mut [Complex]; R] = collect(outputs);
            for q in 0..stride {
                let sums = butterfly(core::array::from_fn(|j| inputs[j][q]));
                outputs[0][q] = sums[0];
                for k in 1..R {
                    outputs[k][q] = sums[k] * twiddles[k];
                }
            }
        }
    }
}

/// The first R items.
fn collect<T, const R: usize>(mut items: impl Iterator<Item = T>) -> [T; R] {
    core::array::from_fn(|_| items.next().expect("R outputs of a stage"))
}

fn butterfly_2([a, b]: [Complex; 2]) -> [Complex; 2] {
    [a + b, a - b]
}

fn butterfly_3([a, b, c]: [Complex; 3]) -> [Complex; 3] {
    /// sin(2π/3).
    const SIN: f64 = 0.866_025_403_784_438_6;
    let sum = b + c;
    let middle = a - sum.scaled(0.5);
    let turned = (b - c).times_i().scaled(SIN);
    [a + sum, middle + turned, middle - turned]
}

fn butterfly_4([a, b, c, d]: [Complex; 4]) -> [Complex; 4] {
    let [even, odd] = [a + c, b + d];
    let [even_difference, odd_difference] = [a - c, (b - d).times_i()];
    [
        even + odd,
        even_difference + odd_difference,
        even - odd,
        even_difference - odd_difference,
    ]
}

fn butterfly_5([a, b, c, d, e]: [Complex; 5]) -> [Complex; 5] {
    /// cos and sin of 2π/5 and 4π/5.
    const COS: [f64; 2] = [0.309_016_994_374_947_4, -0.809_016_994_374_947_5];
    const SIN: [f64; 2] = [0.951_056_516_295_153_5, 0.587_785_252_292_473_1];
    let [outer, inner] = [b + e, c + d];
    let [outer_turned, inner_turned] = [(b - e).times_i(), (c - d).times_i()];
    let first = a + outer.scaled(COS[0]) + inner.scaled(COS[1]);
    let second = a + outer.scaled(COS[1]) + inner.scaled(COS[0]);
    let first_turned = outer_turned.scaled(SIN[0]) + inner_turned.scaled(SIN[1]);
    let second_turned = outer_turned.scaled(SIN[1]) - inner_turned.scaled(SIN[0]);
    [
        a + outer + inner,
        first + first_turned,
        second + second_turned,
        second - second_turned,
        first - first_turned,
    ]
}
