//! `lobes`: Gaussians of position and normal, curved or flat, one or four a texel, and the papers' plain sum.

use super::{Against, Bound, Ladder, Patch, Reference, Subject, Variant, disk_peak, interpolated};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::lobes::Prepared;
use glintbake_bake::{DEFAULT_MERGE_ERROR, MethodRecipe};
use glintbake_format::model::{
    Filter, HalfVector, Interpolation, LobeLattice, Method, intrinsic_from_beckmann,
};
use glintbake_format::records::Structure;
use glintbake_runtime::Instance;

pub(super) struct Lobes;

/// What a recipe takes that names no lobes.
const CURVED: LobeLattice = LobeLattice {
    curved: true,
    per_side: 1,
};

/// Lobes worth comparing, the default first.
const LATTICES: [LobeLattice; 3] = [
    CURVED,
    LobeLattice {
        curved: false,
        ..CURVED
    },
    LobeLattice {
        per_side: 2,
        ..CURVED
    },
];

/// Seconds that a lobe of a plain sum takes.
const SECONDS_A_LOBE: f64 = 3e-8;

impl Subject for Lobes {
    fn method(&self) -> Method {
        Method::Lobes
    }

    fn is_rough(&self) -> bool {
        true
    }

    fn variants(&self, filter: Filter) -> Vec<Variant> {
        if filter == Filter::Box {
            return Vec::new();
        }
        let mut variants = LATTICES.map(|lattice| variant(lattice, false)).to_vec();
        variants.insert(1, variant(CURVED, true));
        variants
    }

    fn is_truth(&self, _: &Variant) -> bool {
        false
    }

    /// Lobes stand for the surface between the middles of texels.
    fn surface(&self, _: &Variant) -> Interpolation {
        Interpolation::Linear
    }

    fn model(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        let lattice = variant.recipe.lattice.unwrap_or(CURVED);
        Box::new(Sum {
            roughness,
            prepared: Prepared::new(patch.map, &patch.footprint, lattice, !variant.is_paper),
            is_raw: variant.is_paper,
        })
    }

    fn truth(&self, variant: &Variant, patch: &Patch<'_>, roughness: f64) -> Box<dyn Reference> {
        interpolated::truth(self.surface(variant), patch, roughness)
    }

    fn seconds(
        &self,
        variant: &Variant,
        map: &NormalMap,
        texels: f64,
        roughness: f64,
        of: Against,
    ) -> f64 {
        let per_side = f64::from(variant.recipe.lattice.unwrap_or(CURVED).per_side);
        match of {
            Against::Model => SECONDS_A_LOBE * per_side * per_side * texels,
            Against::Truth => interpolated::seconds(self.surface(variant), map, texels, roughness),
        }
    }

    fn variants_of(&self, instance: &Instance, filter: Filter) -> Vec<Variant> {
        let Structure::Lobes(lattice) = instance.structure else {
            return Vec::new();
        };
        match filter {
            Filter::Box => Vec::new(),
            Filter::Gaussian => vec![variant(lattice, false), variant(lattice, true)],
        }
    }

    fn peak(&self, _: &Variant, roughness: f64) -> f64 {
        disk_peak(roughness)
    }

    fn bound(&self, variant: &Variant, _: Filter, _: &NormalMap, roughness: f64) -> Bound {
        let sigma = intrinsic_from_beckmann(roughness);
        let merging = variant.recipe.merge_error.unwrap_or(DEFAULT_MERGE_ERROR);
        Bound {
            relative: PRUNED + ROUNDED + CELLS + 2.0 * merging + SINGLE / sigma,
            floor: 1.0,
            reason: format!(
                "of the kernel's peak: lobes end at 5 deviations (5e-5), blocks round normals by 2e-4 of a deviation (2e-4) \
                 and merge within {merging} of a lobe, cells of 0.4 deviations count as one lobe (6e-4), and normals are \
                 told apart in f32"
            ),
        }
    }

    /// Lobes reach farther than texels, and cross the horizon where these do not.
    fn loss(&self, _: &Variant) -> Option<f64> {
        None
    }

    /// Merging is the one choice there is, and lobes of maps that are not smooth have nothing to merge: its errors are held in
    /// tests/suite/lobes.rs.
    fn ladders(&self, _: Filter) -> Vec<Ladder> {
        Vec::new()
    }
}

/// What all lobes have beyond five deviations of position and normal together: `25 / 2 exp(-25 / 2)`, and `exp(-25 / 2)`.
const PRUNED: f64 = 5e-5;
/// A normal moved by 2e-4 of the kernel's deviation changes its Gaussian by 0.61 times that, and a slope its covariance.
const ROUNDED: f64 = 2e-4;
/// Cells of less than 0.4 deviations of normals, smaller than the footprint, count as one Gaussian of their moments.
const CELLS: f64 = 6e-4;
/// Half a unit in the last place of normals in f32, times the steepest slope of a Gaussian.
const SINGLE: f64 = 4e-8;

/// Lobes of `lattice`, normalised, or summed as the papers do.
fn variant(lattice: LobeLattice, is_paper: bool) -> Variant {
    let name = match (lattice.curved, lattice.per_side) {
        _ if is_paper => "paper",
        (true, 1) => "curved",
        (true, _) => "curved-4",
        (false, 1) => "flat",
        (false, _) => "flat-4",
    };
    Variant {
        name: name.to_owned(),
        is_paper,
        recipe: MethodRecipe {
            lattice: Some(lattice),
            ..MethodRecipe::new(Method::Lobes, &[])
        },
        setting: None,
        tolerance: None,
    }
}

/// The plain sum over lobes.
struct Sum {
    roughness: f64,
    prepared: Prepared,
    is_raw: bool,
}

impl Reference for Sum {
    fn ndf(&self, half_vector: HalfVector) -> f64 {
        self.prepared.ndf(half_vector, self.roughness)
    }

    /// Samples are those of the quotient, however the sum is made.
    fn pdf(&self, half_vector: HalfVector) -> f64 {
        let pdf = self.prepared.pdf(half_vector, self.roughness);
        if self.is_raw {
            pdf / self.prepared.total()
        } else {
            pdf
        }
    }

    fn draw(&self, _: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        self.prepared.draw(self.roughness, uniform)
    }
}
