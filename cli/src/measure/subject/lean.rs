//! `lean`: one Gaussian lobe from a pyramid of moments, its finest levels kept or left out.

use super::{Patch, Reference, Subject, Variant, draw};
use glintbake_bake::MethodRecipe;
use glintbake_bake::oracle::{disk, lean as oracle};
use glintbake_format::model::{Filter, HalfVector, Method, intrinsic_from_beckmann};

/// Finest levels worth comparing: every texel, and what is left for surfaces that are never seen near.
const FINEST_LEVELS: [u32; 3] = [0, 2, 4];

pub(super) struct Lean;

impl Subject for Lean {
    fn method(&self) -> Method {
        Method::Lean
    }

    fn is_rough(&self) -> bool {
        true
    }

    fn variants(&self, _: Filter) -> Vec<Variant> {
        FINEST_LEVELS
            .map(|level| Variant {
                name: format!("from level {level}"),
                is_paper: false,
                recipe: MethodRecipe {
                    finest_level: Some(level),
                    ..MethodRecipe::new(self.method(), &[])
                },
                setting: None,
                tolerance: None,
            })
            .to_vec()
    }

    fn is_truth(&self, _: &Variant) -> bool {
        false
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        let finest = variant.recipe.finest_level.unwrap_or(0);
        Box::new(Lobe(oracle::Prepared::new(
            patch.map,
            &patch.footprint,
            patch.filter,
            roughness,
            finest,
        )))
    }

    fn truth(&self, _: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        Box::new(Texels {
            deviation: intrinsic_from_beckmann(roughness),
            prepared: disk::Prepared::from_weights(patch.map, &patch.weights, roughness),
        })
    }
}

/// The model.
struct Lobe(oracle::Prepared);

impl Reference for Lobe {
    fn ndf(&self, half_vector: HalfVector) -> f64 {
        self.0.ndf(half_vector)
    }

    fn pdf(&self, half_vector: HalfVector) -> f64 {
        self.0.pdf(half_vector)
    }

    fn draw(&self, _: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        let [ss, st, tt] = self.0.covariance();
        // The root of the covariance that has nothing above its diagonal.
        let first = ss.sqrt();
        let across = st / first;
        let second = (tt - across * across).max(0.0).sqrt();
        let [x, y] = draw::standard_normal([uniform[2], uniform[3]]);
        let [s, t] = self.0.mean();
        draw::on_disk([s + first * x, t + across * x + second * y])
    }
}

/// The truth.
struct Texels {
    deviation: f64,
    prepared: disk::Prepared,
}

impl Reference for Texels {
    fn ndf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.ndf(half_vector)
    }

    fn pdf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.pdf(half_vector)
    }

    fn draw(&self, patch: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        let [s, t] = patch.normal_by_weight(uniform[0]);
        let [x, y] = draw::standard_normal([uniform[2], uniform[3]]);
        draw::on_disk([s + self.deviation * x, t + self.deviation * y])
    }
}
