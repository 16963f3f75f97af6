//! Which options belong to which methods.

use crate::error::BakeError;
use crate::recipe::{DEFAULT_LEAF_SIZE, MethodRecipe};
use glintbake_format::model::{Interpolation, Kernel, LobeLattice, Method};
use glintbake_format::records::InverseKind;

/// An option that not every method has.
struct Owned {
    option: &'static str,
    /// Its value, if the recipe has one.
    value: fn(&MethodRecipe) -> Option<String>,
    /// Whose it is; the first is named to those who meant it.
    owners: &'static [Method],
    /// What other methods do not have.
    thing: &'static str,
}

const OPTIONS: &[Owned] = &[
    Owned {
        option: "--bins",
        value: |recipe| recipe.bins.map(|bins| bins.to_string()),
        owners: &[Method::SpecularBins, Method::FlakeBins],
        thing: "bins",
    },
    Owned {
        option: "--index",
        value: |recipe| recipe.inverse.map(InverseKind::name).map(str::to_owned),
        owners: &[Method::FlakeBins, Method::SpecularBins],
        thing: "bins whose texels are looked for",
    },
    Owned {
        option: "--leaf-size",
        value: |recipe| {
            let is_given = recipe.leaf_size != DEFAULT_LEAF_SIZE;
            is_given.then(|| recipe.leaf_size.to_string())
        },
        owners: &[Method::FlakeBins, Method::SpecularBins],
        thing: "forest",
    },
    Owned {
        option: "--finest-level",
        value: |recipe| recipe.finest_level.map(|level| level.to_string()),
        owners: &[Method::Lean],
        thing: "level to begin with",
    },
    Owned {
        option: "--kernel",
        value: |recipe| recipe.kernel.map(Kernel::name).map(str::to_owned),
        owners: &[Method::ClusterTree],
        thing: "kernel but the disk's",
    },
    Owned {
        option: "--exact-normals",
        value: |recipe| recipe.exact_normals.then(String::new),
        owners: &[Method::FlakeBins],
        thing: "second copy of the normals",
    },
    Owned {
        option: "--raster-normals",
        value: |recipe| recipe.raster_normals.then(String::new),
        owners: &[Method::ClusterTree],
        thing: "second copy of the normals",
    },
    Owned {
        option: "--lobes",
        value: |recipe| recipe.lattice.map(LobeLattice::name).map(str::to_owned),
        owners: &[Method::Lobes, Method::MipLobes],
        thing: "lobes",
    },
    Owned {
        option: "--merge-error",
        value: |recipe| recipe.merge_error.map(|error| error.to_string()),
        owners: &[Method::Lobes],
        thing: "lobes to merge",
    },
    Owned {
        option: "--interpolate",
        value: |recipe| {
            recipe
                .interpolation
                .map(Interpolation::name)
                .map(str::to_owned)
        },
        owners: &[Method::Analytic],
        thing: "surface between texels",
    },
    Owned {
        option: "--clusters",
        value: |recipe| recipe.clusters.map(|clusters| clusters.to_string()),
        owners: &[Method::MipLobes],
        thing: "lobes to cluster",
    },
    Owned {
        option: "--target",
        value: |recipe| {
            let [width, height] = recipe.quilt?.target;
            Some(format!("{width}x{height}"))
        },
        owners: &[Method::MipLobes],
        thing: "surface to quilt",
    },
    Owned {
        option: "--size",
        value: |recipe| {
            let size = recipe.ndf_maps.as_ref()?.size;
            Some(size.map_or_else(String::new, |size| size.to_string()))
        },
        owners: &[Method::NdfMaps],
        thing: "surface made of copies",
    },
];

/// Options that came with the methods that own them; each method that is older says in its own words why it has none of the
/// others.
const LATER: &[&str] = &[
    "--lobes",
    "--merge-error",
    "--interpolate",
    "--clusters",
    "--target",
    "--size",
];

/// Refuses every option that is another method's.
///
/// # Errors
/// [`BakeError::Option`].
pub(super) fn check(recipe: &MethodRecipe) -> Result<(), BakeError> {
    check_these(recipe, |_| true)
}

/// Refuses the options of `lobes` and `analytic` where the recipe is for neither.
///
/// # Errors
/// [`BakeError::Option`].
pub fn check_later(recipe: &MethodRecipe) -> Result<(), BakeError> {
    check_these(recipe, |option| LATER.contains(&option))
}

fn check_these(recipe: &MethodRecipe, is_meant: fn(&str) -> bool) -> Result<(), BakeError> {
    for owned in OPTIONS.iter().filter(|owned| is_meant(owned.option)) {
        if let Some(value) = (owned.value)(recipe)
            && !owned.owners.contains(&recipe.method)
        {
            let (method, thing, owner) =
                (recipe.method.name(), owned.thing, owned.owners[0].name());
            return Err(BakeError::Option {
                option: owned.option,
                value,
                reason: format!(
                    "{method} has no {thing}; leave the option out, or add --method {owner}"
                ),
            });
        }
    }
    Ok(())
}

/// Refuses footprints that are not Gaussian.
///
/// # Errors
/// [`BakeError::Option`].
pub(super) fn check_gaussian(recipe: &MethodRecipe) -> Result<(), BakeError> {
    use glintbake_format::model::Filter;
    if recipe.filter == Filter::Gaussian {
        return Ok(());
    }
    Err(BakeError::Option {
        option: "--filter",
        value: recipe.filter.name().to_owned(),
        reason: format!(
            "{} is made for Gaussian footprints; leave the option out, or use cluster-tree for boxes",
            recipe.method.name()
        ),
    })
}
