//! How near to the sum over texels an answer has to be, and what a walk may do within that.

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

/// Area in texels up to which boxes are small.
const SMALL_AREA: f64 = 1024.0;
/// How much further they reach.
const SMALL_REACH: f32 = 3.5;

/// What a walk may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knobs {
    pub limits: Limits,
    /// How far the exponent of a Gaussian footprint may range over an accepted cluster.
    pub weight: f64,
    /// The greatest cluster that a side of a box may cut and that is accepted all the same, as a share of the box.
    pub blur: f64,
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
                variance: (0.1 * ease) as f32,
                tail: (0.03 * ease * ease) as f32,
            },
            weight: 0.2 * ease,
            blur: 2.5e-4 * ease * ease,
        }
    }

    /// The same for a box of `area` texels: the smaller it is, the more of its answers are tails of one or two texels, which cost
    /// next to nothing there.
    pub fn for_box(self, area: f64) -> Self {
        if area <= SMALL_AREA {
            self.reaching(self.limits.exponent + SMALL_REACH)
        } else {
            self
        }
    }

    /// The same, with nothing skipped but what is below e^-`exponent`.
    pub fn reaching(mut self, exponent: f32) -> Self {
        if exponent > self.limits.exponent {
            self.limits.exponent = exponent;
        }
        self
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
            blur: 0.0,
        }
    }
}
