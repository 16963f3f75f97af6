//! Sample points: well spread in each pixel, different from pixel to pixel, the same in every run.

/// Pairs of numbers for one pixel: scrambled (0, 2)-sequences in base 2 (Kollig and Keller 2002, "Efficient
/// Multidimensional Sampling"), one independent pair per dimension of the integrand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sequence {
    seed: u64,
}

impl Sequence {
    /// The sequence of pixel (`x`, `y`).
    pub(super) fn of_pixel(x: u32, y: u32) -> Self {
        Self {
            seed: mixed(u64::from(x) << 32 | u64::from(y)),
        }
    }

    /// Point number `index` of `count`, a power of two, of the pair called `pair`: two numbers in [0, 1).
    ///
    /// The `count` points of a pair hold one in each of `count` boxes of any shape; pairs are out of step with each
    /// other, as their points come in different orders.
    pub(super) fn point(&self, pair: u64, index: u32, count: u32) -> [f64; 2] {
        let scramble = mixed(self.seed ^ mixed(pair));
        let order = mixed(scramble) as u32 & (count - 1);
        let index = index ^ order;
        let x = index.reverse_bits() ^ scramble as u32;
        let y = sobol(index) ^ (scramble >> 32) as u32;
        [x, y].map(|bits| f64::from(bits) / 4_294_967_296.0)
    }
}

/// Sobol's second dimension, as bits of a fraction.
fn sobol(mut index: u32) -> u32 {
    let mut direction = 1_u32 << 31;
    let mut bits = 0;
    while index != 0 {
        if index & 1 != 0 {
            bits ^= direction;
        }
        index >>= 1;
        direction ^= direction >> 1;
    }
    bits
}

/// A number without order from one with (splitmix64's finaliser, Steele et al. 2014).
pub(super) fn mixed(seed: u64) -> u64 {
    let mut x = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_points_fill_every_grid_of_sixteen_boxes() {
        for pixel in 0..20 {
            let sequence = Sequence::of_pixel(pixel, 3 * pixel + 1);
            for pair in 0..5 {
                for columns in [1, 2, 4, 8, 16] {
                    let rows = 16 / columns;
                    let mut filled = [0; 16];
                    for index in 0..16 {
                        let [x, y] = sequence.point(pair, index, 16);
                        assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
                        let column = (x * f64::from(columns)) as usize;
                        let row = (y * f64::from(rows)) as usize;
                        filled[row * columns as usize + column] += 1;
                    }
                    assert_eq!(filled, [1; 16], "{columns} columns, pair {pair}");
                }
            }
        }
    }

    #[test]
    fn pixels_and_pairs_have_points_of_their_own() {
        let here = Sequence::of_pixel(5, 9);
        assert_ne!(
            here.point(0, 0, 16),
            Sequence::of_pixel(9, 5).point(0, 0, 16)
        );
        // Were pairs in step, the same index would find the same box in both.
        let in_step = (0..64)
            .filter(|&index| {
                let [a, b] = [0, 1].map(|pair| (here.point(pair, index, 64)[0] * 8.0) as u32);
                a == b
            })
            .count();
        assert!(in_step < 32, "{in_step} of 64 points are in step");
    }
}
