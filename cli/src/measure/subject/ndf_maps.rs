//! `ndf-maps`: NDF images of a tiny map that tiles the surface, by how finely they are cut, and those of the paper.

use super::{
    Against, Bound, Ladder, Patch, Reference, Subject, Variant, disk_peak, one_of_each_question,
};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::ndf_maps::{Prepared, Surface};
use glintbake_bake::{MethodRecipe, NdfMapRecipe};
use glintbake_format::model::{
    Filter, HalfVector, Interpolation, Method, NdfPixels, Wrap, intrinsic_from_beckmann,
};
use glintbake_format::records::Structure;
use glintbake_format::view::Copied;
use glintbake_runtime::Instance;

pub(super) struct NdfMaps;

/// Pixels along a side of an image in \[XTXW24\] Table 3.
const PAPER: [u32; 2] = [128, 256];

/// Seconds that the oracle takes for a texel and a half vector, about.
const SECONDS: f64 = 2e-5;

impl Subject for NdfMaps {
    fn method(&self) -> Method {
        Method::NdfMaps
    }

    fn is_rough(&self) -> bool {
        true
    }

    fn variants(&self, filter: Filter) -> Vec<Variant> {
        if filter == Filter::Gaussian {
            return Vec::new();
        }
        let mut variants = vec![variant("splines", None, None)];
        variants.extend(PAPER.map(|side| variant(&format!("paper-{side}"), Some(side), None)));
        variants
    }

    fn is_truth(&self, _: &Variant) -> bool {
        true
    }

    fn surface(&self, _: &Variant) -> Interpolation {
        Interpolation::Linear
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        self.truth(variant, patch, roughness)
    }

    fn truth(&self, _: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        Box::new(Tiled::new(patch, roughness))
    }

    fn seconds(&self, _: &Variant, _: &NormalMap, texels: f64, _: f64, _: Against) -> f64 {
        SECONDS * texels
    }

    fn variants_of(&self, instance: &Instance, filter: Filter) -> Vec<Variant> {
        let Structure::NdfMaps(layout) = instance.structure else {
            return Vec::new();
        };
        let mut variants = one_of_each_question(self.variants(filter));
        if layout.pixels == NdfPixels::Points {
            for variant in &mut variants {
                variant.is_paper = true;
            }
        }
        variants
    }

    fn peak(&self, _: &Variant, roughness: f64) -> f64 {
        disk_peak(roughness)
    }

    fn bound(&self, variant: &Variant, _: Filter, _: &NormalMap, _: f64) -> Bound {
        if variant.is_paper {
            return Bound {
                relative: 1.0,
                floor: 1.0,
                reason: "pixels as far apart as the paper's miss narrow kernels: no more than the kernel's peak".to_owned(),
            };
        }
        let (relative, floor) = match variant.tolerance {
            Some(_) => (1.0, 1.0),
            None => (0.05, 1.0),
        };
        Bound {
            relative,
            floor,
            reason: "splines are within 0.4 % of a peak, cells of lobes within 0.3 %; tiles that are seen in part are divided until what \
                     chance may err by is a hundredth of the density"
                .to_owned(),
        }
    }

    /// Lobes reach farther than texels, and cross the horizon where these do not.
    fn loss(&self, _: &Variant) -> Option<f64> {
        None
    }

    /// Normals are drawn from lobes, however coarse the images are.
    fn draws_by_model(&self, variant: &Variant) -> bool {
        variant.is_paper
    }

    fn ladders(&self, filter: Filter) -> Vec<Ladder> {
        if filter == Filter::Gaussian {
            return Vec::new();
        }
        let rungs = [1e6, 0.2, 0.05, 0.004].map(|tolerance| Variant {
            name: format!("tolerance {tolerance}"),
            ..variant("", None, Some(tolerance))
        });
        vec![Ladder {
            name: "tolerance",
            rungs: rungs.into(),
            against: Against::Model,
            exact: 0.02,
            slack: 1.25,
        }]
    }

    fn suits_ladders(&self, map: &NormalMap) -> bool {
        map.width() == map.height() && matches!(map.width(), 16 | 32) && map.wrap() == Wrap::Repeat
    }
}

/// Images of `paper` pixels a side, or splines, asked with `tolerance`.
fn variant(name: &str, paper: Option<u32>, tolerance: Option<f64>) -> Variant {
    Variant {
        name: name.to_owned(),
        is_paper: paper.is_some(),
        recipe: MethodRecipe {
            ndf_maps: paper.map(|side| NdfMapRecipe {
                paper_pixels: Some(side),
                ..NdfMapRecipe::default()
            }),
            ..MethodRecipe::new(Method::NdfMaps, &[])
        },
        setting: None,
        tolerance,
    }
}

/// The map as the surface that its copies tile, each as it is.
struct Tiled {
    prepared: Prepared,
    sigma: f64,
}

impl Tiled {
    fn new(patch: &Patch<'_>, roughness: f64) -> Self {
        let size = patch.map.width();
        let half = 0.5 * f64::from(size);
        let surface = Surface {
            example: patch.map.clone(),
            size,
            copies: vec![Copied {
                centre: [half; 2],
                matrix: [[1.0, 0.0], [0.0, 1.0]],
            }],
            is_scattered: false,
            scales_slopes: false,
            ground: [0.0; 2],
            ground_deviation: 1.0,
        };
        let sigma = intrinsic_from_beckmann(roughness);
        Self {
            prepared: Prepared::new(surface, &patch.footprint, sigma),
            sigma,
        }
    }
}

impl Reference for Tiled {
    fn ndf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.ndf(half_vector, self.sigma)
    }

    fn pdf(&self, half_vector: HalfVector) -> f64 {
        let [.., cosine] = half_vector.direction();
        self.ndf(half_vector) * cosine.max(0.0)
    }

    fn draw(&self, _: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        self.prepared.draw(self.sigma, uniform)
    }
}
