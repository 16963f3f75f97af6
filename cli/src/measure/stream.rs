//! Numbers that depend on a seed alone.

/// A stream of uniform numbers: a counter, mixed (a Weyl sequence, finalised as in `MurmurHash3`).
#[derive(Clone, Debug)]
pub struct Stream(u64);

/// 2⁶⁴ over the golden ratio, odd.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

impl Stream {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(STEP))
    }

    /// A stream of its own for part `part` of what this one is for.
    #[must_use]
    pub fn part(&self, part: u64) -> Self {
        Self(mix(self.0 ^ mix(part.wrapping_add(STEP))))
    }

    /// The next number in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(STEP);
        (mix(self.0) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The next `N` numbers in [0, 1).
    pub fn uniforms<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.uniform())
    }
}

const fn mix(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    bits = (bits ^ (bits >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    bits ^ (bits >> 33)
}
