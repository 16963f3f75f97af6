//! Numbers that look random and depend on their seed alone.

/// A Weyl sequence, finalised as in `MurmurHash3`.
#[derive(Clone, Debug)]
pub struct Numbers(u64);

/// The golden ratio, as a fraction of 2⁶⁴.
const STEP: u64 = 0x9E37_79B9_7F4A_7C15;

impl Numbers {
    /// The numbers of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(STEP))
    }

    /// The numbers of a seed made of `words`, in their order.
    pub fn of(words: &[&str]) -> Self {
        let bytes = words.iter().flat_map(|word| word.bytes().chain([0]));
        let hash = bytes.fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3)
        });
        Self(hash)
    }

    /// The next number in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(STEP);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 33)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
        bits = (bits ^ (bits >> 33)).wrapping_mul(0xC4CE_B9FE_1A85_EC53);
        ((bits ^ (bits >> 33)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The next number in [`low`, `high`).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// The next four numbers in [0, 1), as samplers want them.
    pub fn four(&mut self) -> [f64; 4] {
        std::array::from_fn(|_| self.uniform())
    }
}
