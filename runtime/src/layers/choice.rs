//! Which lobe of which layer a sample is drawn from.

use super::layer::Layer;
use super::lobe;
use crate::error::QueryError;
use crate::microfacet::brdf::{self, mirrored};
use core::f64::consts::PI;
use glintbake_format::model::Footprint;
use glintbake_format::records::MAX_LAYERS;

/// The part of all samples that is spread over lobes alike, whatever light they are thought to send: the estimate knows one of
/// two directions, and may be off by much.
const SPREAD: f64 = 0.25;

/// One of the two lobes that a layer can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lobe {
    /// What facets mirror.
    Gloss,
    /// What comes back from under the gloss of a base.
    Diffuse,
}

/// Both lobes, in the order of shares.
const LOBES: [Lobe; 2] = [Lobe::Gloss, Lobe::Diffuse];

/// The share of samples that each lobe is given, for one footprint and one outgoing direction. They add up to 1, or are all 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    shares: [[f64; 2]; MAX_LAYERS],
}

impl Choice {
    /// The shares of `layers`, the top first, under `footprint`, for an `outgoing` direction above the horizon.
    pub(super) fn new<'l, 'a: 'l>(
        layers: impl Iterator<Item = &'l Layer<'a>>,
        footprint: &Footprint,
        outgoing: [f64; 3],
    ) -> Result<Self, QueryError> {
        let [.., cosine] = outgoing;
        let mut estimates = [[None; 2]; MAX_LAYERS];
        let mut left = 1.0;
        for (layer, slots) in layers.zip(&mut estimates) {
            let opacity = layer.opacity(&layer.placed(footprint))?;
            if opacity > 0.0 {
                let [gloss, diffuse, passed] = layer.estimates(cosine);
                *slots = [
                    Some(left * opacity * gloss),
                    layer.is_diffuse().then_some(left * opacity * diffuse),
                ];
                if !layer.lets_pass() && opacity == 1.0 {
                    break;
                }
                left *= (1.0 - opacity) + opacity * passed;
            }
        }
        let all = || estimates.as_flattened().iter().flatten();
        let (sum, count) = (all().sum::<f64>(), all().count() as f64);
        let share = |estimate: Option<f64>| match estimate {
            Some(estimate) if sum > 0.0 => (1.0 - SPREAD) * estimate / sum + SPREAD / count,
            Some(_) => 1.0 / count,
            None => 0.0,
        };
        Ok(Self {
            shares: estimates.map(|lobes| lobes.map(share)),
        })
    }

    /// The lobes of layer `place` with their shares.
    pub(super) fn of_layer(&self, place: usize) -> impl Iterator<Item = (Lobe, f64)> {
        let shares = self.shares.get(place).copied().unwrap_or_default();
        LOBES.into_iter().zip(shares)
    }

    /// The layer and lobe that `uniform`, in [0, 1), falls to, and where in its share, in [0, 1) again; `None` if there is no
    /// lobe at all.
    pub(super) fn pick(&self, uniform: f64) -> Option<(usize, Lobe, f64)> {
        let mut rest = uniform;
        let mut last = None;
        for (place, shares) in self.shares.iter().enumerate() {
            for (lobe, &share) in LOBES.into_iter().zip(shares) {
                if share > 0.0 {
                    // Below 1 though the quotient may be rounded up to it, and so for what rounding leaves after the last.
                    let within = (rest / share).clamp(0.0, 1.0 - 0.5 * f64::EPSILON);
                    if rest < share {
                        return Some((place, lobe, within));
                    }
                    rest -= share;
                    last = Some((place, lobe, within));
                }
            }
        }
        last
    }
}

impl Lobe {
    /// A direction of light drawn from this lobe of `layer`, under `footprint` as the layer sees it.
    pub(super) fn sample(
        self,
        layer: &Layer<'_>,
        footprint: &Footprint,
        outgoing: [f64; 3],
        uniform: [f64; 4],
    ) -> Result<Option<[f64; 3]>, QueryError> {
        let [.., first, second] = uniform;
        match (self, layer.ndf()) {
            (Self::Gloss, Some(ndf)) => brdf::sample(ndf, footprint, outgoing, uniform),
            (Self::Gloss, None) => {
                let half = lobe::sample(layer.lobe_roughness(), [first, second]);
                Ok(mirrored(outgoing, half))
            }
            (Self::Diffuse, _) => Ok(cosine_weighted([first, second])),
        }
    }

    /// The density of [`sample`](Self::sample).
    pub(super) fn pdf(
        self,
        layer: &Layer<'_>,
        footprint: &Footprint,
        incoming: [f64; 3],
        outgoing: [f64; 3],
        half: [f64; 3],
    ) -> Result<f64, QueryError> {
        match (self, layer.ndf()) {
            (Self::Gloss, Some(ndf)) => brdf::pdf(ndf, footprint, incoming, outgoing),
            (Self::Gloss, None) => Ok(lobe::pdf(layer.lobe_roughness(), incoming, half)),
            (Self::Diffuse, _) => Ok(incoming[2] / PI),
        }
    }
}

/// A direction of density cos θ / π, from two uniform numbers in [0, 1); `None` at the horizon itself.
fn cosine_weighted([first, second]: [f64; 2]) -> Option<[f64; 3]> {
    let (radius, angle) = (libm::sqrt(first), 2.0 * PI * second);
    let height = libm::sqrt(1.0 - first);
    let direction = [radius * libm::cos(angle), radius * libm::sin(angle), height];
    (height > 0.0).then_some(direction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_falls_to_a_lobe_in_proportion_to_its_share() {
        let mut shares = [[0.0; 2]; MAX_LAYERS];
        shares[1] = [0.2, 0.3];
        shares[4] = [0.5, 0.0];
        let choice = Choice { shares };
        let mut counts = [0; 3];
        for number in 0..1000 {
            let uniform = (f64::from(number) + 0.5) / 1000.0;
            let (place, lobe, within) = choice.pick(uniform).unwrap();
            assert!((0.0..1.0).contains(&within));
            let (slot, start, share) = match (place, lobe) {
                (1, Lobe::Gloss) => (0, 0.0, 0.2),
                (1, Lobe::Diffuse) => (1, 0.2, 0.3),
                (4, Lobe::Gloss) => (2, 0.5, 0.5),
                other => panic!("{other:?} has no share"),
            };
            assert!((start + within * share - uniform).abs() < 1e-12);
            counts[slot] += 1;
        }
        assert_eq!(counts, [200, 300, 500]);
        // Shares that rounding leaves short of 1 still catch the largest number.
        let (place, _, within) = choice.pick(1.0 + 1e-12).unwrap();
        assert!(place == 4 && within < 1.0);
        let none = Choice {
            shares: [[0.0; 2]; MAX_LAYERS],
        };
        assert_eq!(none.pick(0.5), None);
    }
}
