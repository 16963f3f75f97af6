//! Flakes with Beckmann roughness, exactly and binned \[AWKK21\].

use super::beckmann::beckmann;
use super::direction::{direction, dot, half_vector_direction};
use super::double_double::DoubleDouble;
use super::weights::{TexelWeight, box_weights};
use crate::normals::NormalMap;
use core::f64::consts::SQRT_2;
use glintbake_format::model::{Footprint, HalfVector, Neighbourhood};
use std::collections::BTreeMap;

/// Which sum is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Every texel with its own normal: the truth, eq. 11.
    Exact,
    /// Every texel with the centre of its bin, over the neighbourhood of the half vector's bin: eq. 15.
    Binned(Neighbourhood),
}

/// Bins per side for Beckmann roughness `alpha`: `ceil(5 / sin(atan(3 α / √2)))`, eq. 16.
pub fn resolution(alpha: f64) -> u32 {
    let cone_angle = libm::atan(3.0 * alpha / SQRT_2);
    libm::ceil(5.0 / libm::sin(cone_angle)) as u32
}

/// Weight `W_j = Σ w_k` of every bin (column, row) that holds a normal under the footprint; they sum to 1.
///
/// The bins are those of [`resolution`] for `alpha`, over the square around the projected disk: column from s, row
/// from t.
///
/// # Panics
/// As [`box_weights`].
pub fn bin_weights(
    map: &NormalMap,
    footprint: &Footprint,
    alpha: f64,
) -> BTreeMap<(u32, u32), f64> {
    bin_weights_of(map, &box_weights(map, footprint), alpha)
}

/// [`bin_weights`] of texels weighed by any filter.
///
/// # Panics
/// If a texel is not on the map.
pub fn bin_weights_of(
    map: &NormalMap,
    weights: &[TexelWeight],
    alpha: f64,
) -> BTreeMap<(u32, u32), f64> {
    let side = resolution(alpha);
    let mut bins: BTreeMap<(u32, u32), DoubleDouble> = BTreeMap::new();
    for ([s, t], weight) in weighted_normals(map, weights) {
        let sum = bins.entry(bin_of(s, t, side)).or_default();
        *sum = *sum + DoubleDouble::from(weight);
    }
    bins.into_iter()
        .map(|(bin, sum)| (bin, sum.value()))
        .collect()
}

/// Density `D(h)` under the footprint, per solid angle of h; 0 outside the closed unit disk.
///
/// # Panics
/// As [`box_weights`].
pub fn ndf(
    map: &NormalMap,
    footprint: &Footprint,
    h: HalfVector,
    alpha: f64,
    setting: Setting,
) -> f64 {
    Prepared::new(map, footprint, alpha, setting).ndf(h)
}

/// Density per solid angle with which the sampler of `setting` draws `h`; 0 outside the closed unit disk.
///
/// # Panics
/// As [`box_weights`].
pub fn pdf(
    map: &NormalMap,
    footprint: &Footprint,
    h: HalfVector,
    alpha: f64,
    setting: Setting,
) -> f64 {
    Prepared::new(map, footprint, alpha, setting).pdf(h)
}

/// The weights of one footprint, for many half vectors.
#[derive(Clone, Debug)]
pub struct Prepared {
    alpha: f64,
    flakes: Flakes,
}

#[derive(Clone, Debug)]
enum Flakes {
    Exact(Vec<([f64; 3], f64)>),
    Binned {
        side: u32,
        neighbourhood: Neighbourhood,
        bins: BTreeMap<(u32, u32), ([f64; 3], f64)>,
    },
}

impl Prepared {
    /// The flakes under `footprint`, for `alpha` and `setting`.
    ///
    /// # Panics
    /// As [`box_weights`].
    pub fn new(map: &NormalMap, footprint: &Footprint, alpha: f64, setting: Setting) -> Self {
        Self::from_weights(map, &box_weights(map, footprint), alpha, setting)
    }

    /// The flakes of the texels in `weights`, weighed by any filter (see [`texel_weights`](super::texel_weights)).
    ///
    /// # Panics
    /// If a texel is not on the map.
    pub fn from_weights(
        map: &NormalMap,
        weights: &[TexelWeight],
        alpha: f64,
        setting: Setting,
    ) -> Self {
        let flakes = match setting {
            Setting::Exact => Flakes::Exact(
                weighted_normals(map, weights)
                    .map(|([s, t], weight)| (direction(s, t), weight))
                    .collect(),
            ),
            Setting::Binned(neighbourhood) => {
                let side = resolution(alpha);
                let bins = bin_weights_of(map, weights, alpha)
                    .into_iter()
                    .map(|(bin, weight)| (bin, (bin_centre(bin, side), weight)))
                    .collect();
                Flakes::Binned {
                    side,
                    neighbourhood,
                    bins,
                }
            }
        };
        Self { alpha, flakes }
    }

    /// Density `D(h)` per solid angle of h; 0 outside the closed unit disk.
    ///
    /// Exact: `Σ_k w_k D^α(h, t_k)`, the distribution in eq. 11. Binned: `Σ_j W_j D^α(h, b_j)` over the bins j of the
    /// neighbourhood of h's bin, the distribution in eq. 15.
    pub fn ndf(&self, h: HalfVector) -> f64 {
        self.sum(h, |h, normal| beckmann(h, normal, self.alpha))
    }

    /// Density per solid angle of h with which the sampler draws it; 0 outside the closed unit disk.
    ///
    /// Each term of [`Self::ndf`] times `h·t_k`, or `h·b_j` (eq. 18, which leaves the factor out). The sampler gives
    /// nothing where the drawn normal is below the horizon or its neighbourhood does not hold the bin it was drawn
    /// for, so this integrates to a little less than 1.
    pub fn pdf(&self, h: HalfVector) -> f64 {
        self.sum(h, |h, normal| {
            beckmann(h, normal, self.alpha) * dot(h, normal)
        })
    }

    fn sum(&self, h: HalfVector, term: impl Fn([f64; 3], [f64; 3]) -> f64) -> f64 {
        let Some(direction) = half_vector_direction(h) else {
            return 0.0;
        };
        let add = |sum: DoubleDouble, &(normal, weight): &([f64; 3], f64)| {
            sum + DoubleDouble::product(weight, term(direction, normal))
        };
        let total = match &self.flakes {
            Flakes::Exact(texels) => texels.iter().fold(DoubleDouble::ZERO, add),
            Flakes::Binned {
                side,
                neighbourhood,
                bins,
            } => neighbours(bin_of(h.s, h.t, *side), *side, *neighbourhood)
                .filter_map(|bin| bins.get(&bin))
                .fold(DoubleDouble::ZERO, add),
        };
        total.value()
    }
}

/// Point of the disk and weight of each texel in `weights`.
fn weighted_normals(
    map: &NormalMap,
    weights: &[TexelWeight],
) -> impl Iterator<Item = ([f64; 2], f64)> {
    weights.iter().map(|texel| {
        let index = texel.row as usize * map.width() as usize + texel.column as usize;
        (map.texels()[index].map(f64::from), texel.weight)
    })
}

/// β of §5.2: `floor(b (0.5 s + 0.5))`, where 1 counts to the last bin; likewise for t.
pub(super) fn bin_of(s: f64, t: f64, side: u32) -> (u32, u32) {
    let place = |x: f64| {
        let bin = libm::floor(f64::from(side) * (0.5 * x + 0.5));
        bin.clamp(0.0, f64::from(side - 1)) as u32
    };
    (place(s), place(t))
}

/// β⁻¹(j, 0.5, 0.5) of §5.2, on the horizon where the middle of a border bin lies beyond the disk.
pub(super) fn bin_centre((column, row): (u32, u32), side: u32) -> [f64; 3] {
    let middle = |x: u32| (2.0 * f64::from(x) + 1.0) / f64::from(side) - 1.0;
    direction(middle(column), middle(row))
}

/// The centre, as a point of the disk, and the bin (column, row) of the normal (s, t), for Beckmann roughness `alpha`.
pub fn bin_of_normal([s, t]: [f64; 2], alpha: f64) -> ([f64; 2], (u32, u32)) {
    let side = resolution(alpha);
    let bin = bin_of(s, t, side);
    let [s, t, _] = bin_centre(bin, side);
    ([s, t], bin)
}

/// Whether `bin` is in `neighbourhood` of the bin `centre`: what a flake at the centre of `bin` sends out counts in eq. 15 only
/// for half vectors whose bin is such a `centre`.
pub fn neighbourhood_holds(
    centre: (u32, u32),
    bin: (u32, u32),
    neighbourhood: Neighbourhood,
) -> bool {
    let reach = match neighbourhood {
        Neighbourhood::Bins45 => 3,
        Neighbourhood::Bins21 => 2,
    };
    let (dx, dy) = (bin.0.abs_diff(centre.0), bin.1.abs_diff(centre.1));
    // A square without its corners.
    dx <= reach && dy <= reach && dx + dy < 2 * reach
}

/// The bins of the grid in the square around `centre`, without its corners: 7 × 7 or 5 × 5.
pub(super) fn neighbours(
    centre: (u32, u32),
    side: u32,
    neighbourhood: Neighbourhood,
) -> impl Iterator<Item = (u32, u32)> {
    let reach: i64 = match neighbourhood {
        Neighbourhood::Bins45 => 3,
        Neighbourhood::Bins21 => 2,
    };
    let in_grid = move |x: i64| u32::try_from(x).ok().filter(|&x| x < side);
    (-reach..=reach).flat_map(move |dy| {
        (-reach..=reach)
            .filter(move |dx| dx.abs() + dy.abs() < 2 * reach)
            .filter_map(move |dx| {
                let column = in_grid(i64::from(centre.0) + dx)?;
                Some((column, in_grid(i64::from(centre.1) + dy)?))
            })
    })
}
