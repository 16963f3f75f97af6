//! `cluster-tree`: moments of clusters, within several errors, of both kernels.

use super::{Against, Bound, Ladder, Patch, Reference, Subject, Variant, find};
use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Kernel, Method, intrinsic_from_beckmann};
use glintbake_runtime::{Accuracy, Instance};

pub(super) struct ClusterTree;

/// Errors worth comparing, the default first.
const EPS: [f64; 3] = [Accuracy::DEFAULT, 1e-2, 1e-4];

/// Errors from coarse to next to none.
const RUNGS: [f64; 4] = [5e-2, 1e-2, 1e-3, 1e-5];

impl Subject for ClusterTree {
    fn method(&self) -> Method {
        Method::ClusterTree
    }

    fn is_rough(&self) -> bool {
        true
    }

    fn variants(&self, _: Filter) -> Vec<Variant> {
        let mut variants = EPS.map(|eps| self.variant(None, eps)).to_vec();
        variants.push(self.variant(Some(Kernel::Disk), Accuracy::DEFAULT));
        variants
    }

    /// The model is the sum over texels itself: what a variant leaves out or approximates is its error.
    fn is_truth(&self, _: &Variant) -> bool {
        true
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        self.truth(variant, patch, roughness)
    }

    /// The truths of the kernels are those of the methods that have one.
    fn truth(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        let other = find(match variant.kernel() {
            Kernel::Disk => Method::Lean,
            Kernel::Beckmann | Kernel::BinAverage => Method::FlakeBins,
        });
        // A truth of every texel's own normal is the same for all variants of a kernel.
        other.truth(&other.variants(patch.filter)[0], patch, roughness)
    }

    /// Every error and kernel can be asked of any tree.
    fn variants_of(&self, _: &Instance, filter: Filter) -> Vec<Variant> {
        self.variants(filter)
    }

    /// Leaves round normals to as much as a fifth of the narrowest lobe.
    fn rounds_normals(&self) -> bool {
        true
    }

    fn bound(&self, variant: &Variant, filter: Filter, map: &NormalMap, roughness: f64) -> Bound {
        let eps = variant.tolerance.unwrap_or(Accuracy::DEFAULT);
        // Gaussians as texels under them are weighed: see `Strict` of the runtime.
        let weights = match filter {
            Filter::Box => 2e-5,
            Filter::Gaussian => 2e-4,
        };
        Bound {
            relative: 2.0 * eps + weights + single_precision(map, roughness),
            floor: 0.5,
            reason: format!(
                "terms below {:.1e} of the peak are skipped and clusters stand for their texels, so that densities err by \
                 {eps} on average and by twice that at single half vectors; normals are told apart in f32",
                0.75 * eps
            ),
        }
    }

    fn ladders(&self, _: Filter) -> Vec<Ladder> {
        [None, Some(Kernel::Disk)]
            .map(|kernel| Ladder {
                name: match kernel {
                    None => "eps",
                    Some(_) => "eps of disk",
                },
                rungs: RUNGS.map(|eps| self.variant(kernel, eps)).into(),
                against: Against::Model,
                // What leaves round normals by.
                exact: 1e-3,
                slack: 1.05,
            })
            .into()
    }
}

impl ClusterTree {
    fn variant(&self, kernel: Option<Kernel>, eps: f64) -> Variant {
        Variant {
            name: match kernel {
                None => format!("eps {eps}"),
                Some(kernel) => format!("{}, eps {eps}", kernel.name()),
            },
            is_paper: false,
            recipe: MethodRecipe {
                kernel,
                ..MethodRecipe::new(self.method(), &[])
            },
            setting: None,
            tolerance: Some(eps),
        }
    }
}

/// How far single precision moves a density, relative, down to half of a lobe's peak.
fn single_precision(map: &NormalMap, alpha: f64) -> f64 {
    /// Distance from a lobe's middle at which half of its peak is left, in its deviations.
    const REACH: f64 = 1.18;
    // Twelve roundings from the root of a tile to a texel.
    let place = 12.0 * f64::from(f32::EPSILON);
    let lowest = map
        .texels()
        .iter()
        .map(|texel| {
            let [s, t] = texel.map(f64::from);
            (1.0 - s * s - t * t).max(0.0)
        })
        .fold(1.0, f64::min)
        .sqrt();
    // What moves a normal on the disk tilts it by 1 / z times that, at the rim by √(2 place).
    let tilt = place / lowest.max((0.5 * place).sqrt());
    REACH * tilt / intrinsic_from_beckmann(alpha)
}
