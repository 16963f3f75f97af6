//! `mip-lobes`: clustered lobes of two levels, by how many a cell has, and the levels of the paper.

use super::{Against, Bound, Ladder, Patch, Reference, Subject, Variant, disk_peak, find};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::{DEFAULT_CLUSTERS, MethodRecipe};
use glintbake_format::model::{Filter, Interpolation, LobeLattice, MIP_LANES, Method};
use glintbake_format::records::Structure;
use glintbake_runtime::Instance;

pub(super) struct MipLobes;

/// Clusters worth comparing, the default first.
const CLUSTERS: [u32; 3] = [DEFAULT_CLUSTERS, 16, 64];

/// Levels below those of every footprint: lobes as they are.
const UNCLUSTERED: f64 = -64.0;

/// What the lobes below all levels are.
const LATTICE: LobeLattice = LobeLattice {
    curved: true,
    per_side: 2,
};

impl Subject for MipLobes {
    fn method(&self) -> Method {
        Method::MipLobes
    }

    fn is_rough(&self) -> bool {
        true
    }

    fn variants(&self, filter: Filter) -> Vec<Variant> {
        if filter == Filter::Box {
            return Vec::new();
        }
        let mut variants = CLUSTERS.map(|clusters| variant(clusters, None)).to_vec();
        variants.push(paper(DEFAULT_CLUSTERS));
        variants.push(variant(DEFAULT_CLUSTERS, Some(UNCLUSTERED)));
        variants
    }

    fn is_truth(&self, _: &Variant) -> bool {
        false
    }

    fn surface(&self, variant: &Variant) -> Interpolation {
        find(Method::Lobes).surface(variant)
    }

    /// The plain sum of the lobes that clusters stand for: what clustering blurs is an error.
    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        find(Method::Lobes).model(&unclustered(variant), patch, roughness)
    }

    fn truth(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        find(Method::Lobes).truth(&unclustered(variant), patch, roughness)
    }

    fn seconds(
        &self,
        variant: &Variant,
        map: &NormalMap,
        texels: f64,
        roughness: f64,
        of: Against,
    ) -> f64 {
        find(Method::Lobes).seconds(&unclustered(variant), map, texels, roughness, of)
    }

    fn variants_of(&self, instance: &Instance, filter: Filter) -> Vec<Variant> {
        let Structure::MipLobes(layout) = instance.structure else {
            return Vec::new();
        };
        if filter == Filter::Box {
            return Vec::new();
        }
        let clusters = u32::from(layout.blocks) * MIP_LANES as u32;
        let lattice = LobeLattice {
            curved: true,
            per_side: layout.per_side,
        };
        let mut variants = vec![
            variant(clusters, None),
            paper(clusters),
            variant(clusters, Some(UNCLUSTERED)),
        ];
        for variant in &mut variants {
            variant.recipe.lattice = Some(lattice);
        }
        variants
    }

    fn peak(&self, _: &Variant, roughness: f64) -> f64 {
        disk_peak(roughness)
    }

    fn bound(&self, variant: &Variant, _: Filter, _: &NormalMap, _: f64) -> Bound {
        if variant.tolerance.is_some() {
            return Bound {
                relative: 1e-3,
                floor: 1.0,
                reason: "of the kernel's peak: footprints end at 4.5 deviations, and lobes are told apart in f32"
                    .to_owned(),
            };
        }
        Bound {
            relative: 1.0,
            floor: 1.0,
            reason: "clusters stand for their lobes' moments alone: no more than the kernel's peak, whatever they blur; how far they \
                     are off is in reports"
                .to_owned(),
        }
    }

    /// Lobes reach farther than texels, and cross the horizon where these do not.
    fn loss(&self, _: &Variant) -> Option<f64> {
        None
    }

    fn ladders(&self, filter: Filter) -> Vec<Ladder> {
        if filter == Filter::Box {
            return Vec::new();
        }
        let rungs = [1.0, 0.0, -1.5, UNCLUSTERED].map(|bias| Variant {
            name: format!("bias {bias}"),
            ..variant(DEFAULT_CLUSTERS, Some(bias))
        });
        vec![Ladder {
            name: "level",
            rungs: rungs.into(),
            against: Against::Model,
            exact: 1e-3,
            slack: 1.05,
        }]
    }
}

/// As `lobes` would ask for what `variant` clusters.
fn unclustered(variant: &Variant) -> Variant {
    Variant {
        is_paper: false,
        recipe: MethodRecipe {
            lattice: Some(variant.recipe.lattice.unwrap_or(LATTICE)),
            ..MethodRecipe::new(Method::Lobes, &[])
        },
        ..variant.clone()
    }
}

/// `clusters` a cell, levels moved by `bias`.
fn variant(clusters: u32, bias: Option<f64>) -> Variant {
    Variant {
        name: match bias {
            None => format!("{clusters} clusters"),
            Some(_) => "unclustered".to_owned(),
        },
        is_paper: false,
        recipe: MethodRecipe {
            clusters: Some(clusters),
            ..MethodRecipe::new(Method::MipLobes, &[])
        },
        setting: None,
        tolerance: bias,
    }
}

/// Levels by area alone.
fn paper(clusters: u32) -> Variant {
    Variant {
        name: "paper".to_owned(),
        is_paper: true,
        ..variant(clusters, None)
    }
}
