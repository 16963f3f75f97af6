//! `specular-bins`: the paper's 127 bins a side, coarser and finer.

use super::{Chart, Patch, Reference, Subject, Variant};
use glintbake_bake::MethodRecipe;
use glintbake_bake::oracle::specular_bins::{Prepared, bin_of, normal_at, solid_angle};
use glintbake_format::model::{Filter, HalfVector, Method};
use glintbake_runtime::Instance;

/// The paper's bins a side, and what a recipe takes that names none.
const DEFAULT_BINS: u32 = 127;

pub(super) struct SpecularBins;

impl Subject for SpecularBins {
    fn method(&self) -> Method {
        Method::SpecularBins
    }

    fn is_rough(&self) -> bool {
        false
    }

    fn variants(&self, filter: Filter) -> Vec<Variant> {
        let of = |bins, tolerance| self.variant(bins, tolerance);
        let mut variants = vec![of(DEFAULT_BINS, None), of(32, None), of(500, None)];
        if filter == Filter::Gaussian {
            variants.push(of(DEFAULT_BINS, Some(0.0)));
        }
        variants
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, _: f64) -> Box<dyn Reference> {
        let bins = bins_of(variant);
        Box::new(Mirrors {
            bins,
            prepared: Prepared::from_weights(patch.map, &patch.weights, bins),
        })
    }

    /// The method has no kernel: its truth is the average over the half vector's bin, which is its model.
    fn is_truth(&self, _: &Variant) -> bool {
        true
    }

    fn truth(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        self.model(variant, patch, roughness)
    }

    fn variants_of(&self, instance: &Instance, filter: Filter) -> Vec<Variant> {
        let bins = instance
            .bins()
            .map_or(DEFAULT_BINS, |bins| bins.grid.resolution());
        let mut variants = vec![self.variant(bins, None)];
        if filter == Filter::Gaussian {
            variants.push(self.variant(bins, Some(0.0)));
        }
        variants
    }

    fn peak(&self, variant: &Variant, _: f64) -> f64 {
        1.0 / solid_angle(bins_of(variant))
    }

    fn chart(&self, variant: &Variant, _: HalfVector, _: f64) -> Chart {
        Chart::Bins {
            bins: bins_of(variant),
        }
    }
}

impl SpecularBins {
    fn variant(&self, bins: u32, tolerance: Option<f64>) -> Variant {
        Variant {
            name: match tolerance {
                None => format!("{bins} bins"),
                Some(tolerance) => format!("{bins} bins, tolerance {tolerance}"),
            },
            is_paper: false,
            recipe: MethodRecipe {
                bins: Some(bins),
                ..MethodRecipe::new(self.method(), &[])
            },
            setting: None,
            tolerance,
        }
    }
}

fn bins_of(variant: &Variant) -> u32 {
    variant.recipe.bins.unwrap_or(DEFAULT_BINS)
}

struct Mirrors {
    bins: u32,
    prepared: Prepared,
}

impl Reference for Mirrors {
    fn ndf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.ndf(half_vector)
    }

    fn pdf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.pdf(half_vector)
    }

    fn draw(&self, patch: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        let [s, t] = patch.normal_by_weight(uniform[0]);
        let (column, row) = bin_of(HalfVector { s, t }, self.bins);
        let place = |bin: u32, part: f64| (f64::from(bin) + part) / f64::from(self.bins);
        Some(normal_at([
            place(column, uniform[2]),
            place(row, uniform[3]),
        ]))
    }
}
