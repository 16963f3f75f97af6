//! `lean`: one Gaussian lobe from a pyramid of moments, its finest levels kept or left out.

use super::{Bound, Ladder, Patch, Reference, Subject, Variant, draw};
use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::{disk, lean as oracle};
use glintbake_format::model::{Filter, HalfVector, Method, intrinsic_from_beckmann};
use glintbake_runtime::Instance;

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
        FINEST_LEVELS.map(|level| self.variant(level)).to_vec()
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

    fn bound(&self, _: &Variant, _: Filter, _: &NormalMap, roughness: f64) -> Bound {
        bound_of_moments(intrinsic_from_beckmann(roughness), roughness)
    }

    fn loss(&self, _: &Variant) -> Option<f64> {
        None
    }

    fn variants_of(&self, instance: &Instance, _: Filter) -> Vec<Variant> {
        let level = instance.pyramid().map_or(0, |layout| layout.finest());
        vec![self.variant(level)]
    }

    /// Tolerances mean nothing to a single lobe; finer levels are no nearer to the truth of any one footprint.
    fn ladders(&self, _: Filter) -> Vec<Ladder> {
        Vec::new()
    }

    fn truth(&self, _: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        Box::new(Texels {
            deviation: intrinsic_from_beckmann(roughness),
            prepared: disk::Prepared::from_weights(patch.map, &patch.weights, roughness),
        })
    }
}

impl Lean {
    fn variant(&self, finest_level: u32) -> Variant {
        Variant {
            name: format!("from level {finest_level}"),
            is_paper: false,
            recipe: MethodRecipe {
                finest_level: Some(finest_level),
                ..MethodRecipe::new(self.method(), &[])
            },
            setting: None,
            tolerance: None,
        }
    }
}

/// How far what is stored moves a lobe, in widths of the narrowest there is.
fn bound_of_moments(deviation: f64, alpha: f64) -> Bound {
    // Means are within half a step of 16 bits, or of 32 for narrow lobes.
    let step = if alpha >= 0.01 { 1.53e-5 } else { 2.4e-10 };
    // A spread d is within 1.6e-5 √d, which changes the variance d² + σr² most, by 1.8e-5 / √σr of itself, at d = √3 σr. Down
    // to the floor, 3.7 widths out, the density changes by up to 3.7 steps and by 8 times what the variance does.
    let relative = 4.0 * step / deviation + 8.0 * 1.8e-5 / deviation.sqrt();
    Bound {
        relative: relative + 1e-6,
        floor: 1e-3,
        reason:
            "means and spreads of the pyramid are stored in 16 bits, means of narrow lobes in 32"
                .to_owned(),
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
