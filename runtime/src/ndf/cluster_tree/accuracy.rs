//! How near to the sum over texels an answer has to be, and what a walk may do within that.

use super::cover::Coarse;
use super::walk::Limits;
use glintbake_format::model::Filter;

/// How near to the sum over all texels an answer has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// Calibrated: on maps measured so far, relative L1 errors over many queries stay below this.
    Fast(f64),
}

impl Accuracy {
    /// The relative L1 error of [`Self::default`].
    pub const DEFAULT: f64 = 2e-3;
}

impl Default for Accuracy {
    fn default() -> Self {
        Self::Fast(Self::DEFAULT)
    }
}

/// What a walk may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knobs {
    pub limits: Limits,
    /// How far the exponent of a Gaussian footprint may range over an accepted cluster.
    pub weight: f64,
    /// Greatest spread of bottom clusters of coarse tiles, root mean square, in units of σr.
    spread: f64,
}

impl Knobs {
    pub fn of(accuracy: Accuracy, filter: Filter) -> Self {
        let Accuracy::Fast(eps) = accuracy;
        // The error of a Gaussian in place of a cluster goes with the square of its variance.
        let ease = libm::sqrt((eps / Accuracy::DEFAULT).clamp(1e-12, 100.0));
        let tail = -libm::log((eps / Accuracy::DEFAULT).clamp(1e-12, 100.0));
        let exponent = match filter {
            Filter::Box => 7.5,
            Filter::Gaussian => 9.5,
        };
        Self {
            limits: Limits {
                exponent: (exponent + tail).clamp(3.0, 40.0) as f32,
                variance: (0.25 * ease) as f32,
            },
            weight: 0.5 * ease,
            spread: 0.5 * libm::sqrt(ease),
        }
    }

    /// When tiles without leaves serve a kernel of deviation `sigma`.
    pub fn coarse(&self, sigma: f64) -> Coarse {
        Coarse {
            spread: (self.spread * sigma) as f32,
            most: f32::MAX,
        }
    }
}
