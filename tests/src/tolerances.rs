//! How far answers may be off, each with its reason.

/// A bin's weight against the oracle, absolute: what the project promises. Both sides are f64 and agree far better
/// (about 1e-15 for ordinary footprints); the promise leaves room for single precision on a later fast path.
pub const WEIGHT: f64 = 1e-6;

/// Weights of ordinary footprints (a hundredth of a texel to a few tiles): rounding of a clipped unit square, times
/// the number of texels summed.
pub const WEIGHT_ROUNDING: f64 = 1e-11;

/// The sum of all weights against 1.
pub const WEIGHT_SUM: f64 = 1e-6;

/// `ndf` against the oracle of the same setting, relative, where it exceeds [`NDF_FLOOR`] of the peak.
pub const NDF: f64 = 1e-5;

/// Share of the kernel's peak below which `ndf` is compared absolutely.
pub const NDF_FLOOR: f64 = 1e-6;

/// Energy of a kernel under the default setting: 45 bins lose at most 8.5e-5, quadrature a little more.
pub const ENERGY: f64 = 1e-3;
