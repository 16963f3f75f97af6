//! `flake-bins`: 45 bins, the paper's 21, and each texel's own normal.

use super::{
    Against, Bound, Ladder, Patch, Reference, Subject, Variant, bound_of_weights, draw,
    tolerance_ladder,
};
use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::flake_bins::{self as oracle, Prepared};
use glintbake_format::model::{Filter, HalfVector, Method, Neighbourhood};
use glintbake_format::records::InverseKind;
use glintbake_runtime::Setting;

pub(super) struct FlakeBins;

impl Subject for FlakeBins {
    fn method(&self) -> Method {
        Method::FlakeBins
    }

    fn is_rough(&self) -> bool {
        true
    }

    fn variants(&self, filter: Filter) -> Vec<Variant> {
        let recipe = || MethodRecipe::new(self.method(), &[]);
        let binned = |neighbourhood: Neighbourhood| Variant {
            name: neighbourhood.name().to_owned(),
            is_paper: false,
            recipe: recipe(),
            setting: Some(Setting::Binned(neighbourhood)),
            tolerance: None,
        };
        let mut variants = vec![
            binned(Neighbourhood::Bins45),
            Variant {
                name: "paper".to_owned(),
                is_paper: true,
                recipe: MethodRecipe {
                    inverse: Some(InverseKind::Forest),
                    leaf_size: 10,
                    ..recipe()
                },
                ..binned(Neighbourhood::Bins21)
            },
            Variant {
                name: Setting::Exact.name().to_owned(),
                is_paper: false,
                recipe: MethodRecipe {
                    exact_normals: true,
                    ..recipe()
                },
                setting: Some(Setting::Exact),
                tolerance: None,
            },
        ];
        if filter == Filter::Gaussian {
            variants.push(Variant {
                name: "bins-45, tolerance 0".to_owned(),
                tolerance: Some(0.0),
                ..binned(Neighbourhood::Bins45)
            });
        }
        variants
    }

    fn is_truth(&self, variant: &Variant) -> bool {
        variant.setting == Some(Setting::Exact)
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        let setting = match variant.setting {
            Some(Setting::Exact) => oracle::Setting::Exact,
            Some(Setting::Binned(neighbourhood)) => oracle::Setting::Binned(neighbourhood),
            None => oracle::Setting::Binned(Neighbourhood::default()),
        };
        reference(patch, roughness, setting)
    }

    fn truth(&self, _: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        reference(patch, roughness, oracle::Setting::Exact)
    }

    fn bound(&self, variant: &Variant, filter: Filter, map: &NormalMap, roughness: f64) -> Bound {
        if variant.setting != Some(Setting::Exact) {
            return bound_of_weights(filter, variant.tolerance);
        }
        // Exact normals never weigh texels together.
        let of_weights = bound_of_weights(filter, Some(0.0));
        Bound {
            relative: of_weights.relative + stored_normals_bound(map, roughness),
            reason: format!(
                "{}; exact normals are stored in 2^-16 of a bin, which tilts those at the rim the most",
                of_weights.reason
            ),
            ..of_weights
        }
    }

    fn ladders(&self, filter: Filter) -> Vec<Ladder> {
        let mut rungs = self.variants(filter);
        rungs.retain(|variant| variant.tolerance.is_none());
        if filter == Filter::Gaussian {
            // Errors of bins, not of weights.
            for rung in &mut rungs {
                rung.tolerance = Some(0.0);
            }
        }
        // The paper's bins, more of them, each texel's own normal.
        rungs.swap(0, 1);
        let settings = Ladder {
            name: "setting",
            rungs,
            against: Against::Truth,
            exact: 2e-4,
            slack: 1.05,
        };
        match filter {
            Filter::Box => vec![settings],
            Filter::Gaussian => vec![settings, tolerance_ladder(self.variants(filter))],
        }
    }
}

/// Relative error of a lobe's density, down to 1e-6 of its peak, by the rounding of stored normals.
fn stored_normals_bound(map: &NormalMap, alpha: f64) -> f64 {
    /// Tangents in α up to which a lobe is above 1e-6 of its peak.
    const REACH: f64 = 4.0;
    // Half a step on each axis, and what f32 leaves of the map's own normals where these were stored before.
    let step = 2.0_f64.sqrt() / (65536.0 * f64::from(oracle::resolution(alpha))) + 6e-8;
    let lowest = map
        .texels()
        .iter()
        .map(|texel| {
            let [s, t] = texel.map(f64::from);
            (1.0 - s * s - t * t).max(0.0)
        })
        .fold(1.0, f64::min)
        .sqrt();
    // A step in the disk tilts a normal by step / z, at the rim by √(2 step).
    let tilt = step / lowest.max((0.5 * step).sqrt());
    let tangent = REACH * alpha;
    2.0 * REACH * tilt / alpha * (1.0 + tangent * tangent).min(16.0)
}

fn reference(patch: &Patch<'_>, alpha: f64, setting: oracle::Setting) -> Box<dyn Reference> {
    Box::new(Flakes {
        alpha,
        setting,
        prepared: Prepared::from_weights(patch.map, &patch.weights, alpha, setting),
    })
}

struct Flakes {
    alpha: f64,
    setting: oracle::Setting,
    prepared: Prepared,
}

impl Reference for Flakes {
    fn ndf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.ndf(half_vector)
    }

    fn pdf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.pdf(half_vector)
    }

    fn draw(&self, patch: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        let normal = patch.normal_by_weight(uniform[0]);
        let (centre, neighbourhood) = match self.setting {
            oracle::Setting::Exact => (normal, None),
            oracle::Setting::Binned(neighbourhood) => {
                let (centre, bin) = oracle::bin_of_normal(normal, self.alpha);
                (centre, Some((bin, neighbourhood)))
            }
        };
        let half_vector = draw::beckmann(centre, self.alpha, [uniform[2], uniform[3]])?;
        match neighbourhood {
            // The model looks for bins around the half vector's own, so what is drawn from beyond is lost.
            Some((bin, neighbourhood)) => {
                let (_, centre) = oracle::bin_of_normal([half_vector.s, half_vector.t], self.alpha);
                oracle::neighbourhood_holds(centre, bin, neighbourhood).then_some(half_vector)
            }
            None => Some(half_vector),
        }
    }
}
