//! How near to the sum over texels an answer has to be, and what a walk may do within that.

use super::cover::Coarse;
use super::walk::Limits;
use glintbake_format::model::Filter;

/// How near to the sum over all texels an answer has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// Calibrated: on maps measured so far, relative L1 errors over many queries stay below this.
    Fast(f64),
    /// Refined until the bound of [`ClusterTree::eval_bounded`](super::ClusterTree::eval_bounded) is at most this share of the
    /// density, or nothing is left to refine. Of the kernel `disk` alone; several times as slow.
    Strict(f64),
}

impl Accuracy {
    /// The relative L1 error of [`Self::default`].
    pub const DEFAULT: f64 = 2e-3;

    /// The error asked for.
    pub const fn eps(self) -> f64 {
        match self {
            Self::Fast(eps) | Self::Strict(eps) => eps,
        }
    }
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
    /// Knobs that keep relative L1 errors below `eps` on maps measured so far.
    pub fn of(eps: f64, filter: Filter) -> Self {
        // The error of a Gaussian in place of a cluster goes with the square of its variance.
        let ease = libm::sqrt((eps / Accuracy::DEFAULT).clamp(1e-12, 100.0));
        let tail = -libm::log((eps / Accuracy::DEFAULT).clamp(1e-12, 100.0));
        let exponent = match filter {
            Filter::Box => 6.5,
            Filter::Gaussian => 9.5,
        };
        Self {
            limits: Limits {
                exponent: (exponent + tail).clamp(3.0, 40.0) as f32,
                variance: (0.2 * ease) as f32,
                tail: (0.1 * ease * ease) as f32,
            },
            weight: 0.2 * ease,
            spread: 0.4 * libm::sqrt(ease),
        }
    }

    /// Everything opened, and nothing skipped but what is below e^-30.
    pub const fn finest() -> Self {
        Self {
            limits: Limits {
                exponent: 30.0,
                variance: 0.0,
                tail: 0.0,
            },
            weight: 0.0,
            spread: -1.0,
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
