//! From normals and a recipe to a package.

use crate::error::BakeError;
use crate::metadata;
use crate::methods::{self, Bake};
use crate::normals::NormalMap;
use crate::package::PackagePlan;
use crate::progress::Progress;
use crate::recipe::{Recipe, Source};
use glintbake_format::SectionId;
use glintbake_format::records::{INSTANCES, Instance, METADATA};

/// Refuses a recipe that cannot be baked, before any input is read.
///
/// # Errors
/// [`BakeError::Option`] with the first option that is out of range or not the method's.
pub fn check(recipe: &Recipe) -> Result<(), BakeError> {
    if recipe.methods.is_empty() {
        return Err(BakeError::Option {
            option: "--method",
            value: String::new(),
            reason: "name at least one method".to_owned(),
        });
    }
    for method in &recipe.methods {
        methods::check_later(method)?;
        baker(method.method).check(method)?;
    }
    Ok(())
}

/// The package of `map` by `recipe`, ready to be written; `source` is where the map came from, if from a file.
///
/// The same map, recipe and source give the same bytes, whatever the number of threads.
///
/// # Errors
/// As [`check`]; [`BakeError::MapTooLarge`].
pub fn bake(
    map: &NormalMap,
    recipe: &Recipe,
    source: Option<&Source>,
) -> Result<PackagePlan, BakeError> {
    bake_with_progress(map, recipe, source, &())
}

/// [`bake`], telling `progress` which instance is binned or built.
///
/// # Errors
/// As [`bake`].
pub fn bake_with_progress(
    map: &NormalMap,
    recipe: &Recipe,
    source: Option<&Source>,
    progress: &dyn Progress,
) -> Result<PackagePlan, BakeError> {
    check(recipe)?;
    let inputs: Vec<_> = source.iter().map(|source| &source.input).collect();
    let mut bake = Bake {
        layer: 0,
        plan: PackagePlan::new(recipe.hash(&inputs)),
        instances: Vec::new(),
        left_out: Vec::new(),
        chosen: Vec::new(),
        quilted: Vec::new(),
        ndf_mapped: Vec::new(),
        progress,
        instance_count: recipe.instance_count(),
    };
    for method in &recipe.methods {
        baker(method.method).bake(map, method, &mut bake)?;
    }
    let metadata = metadata::text(recipe, source, &bake);
    let records: Vec<_> = bake
        .instances
        .into_iter()
        .map(Instance::to_record)
        .collect();
    let mut plan = bake.plan;
    plan.add_critical(SectionId::shared(INSTANCES), records);
    plan.add(SectionId::shared(METADATA), metadata.into_bytes());
    Ok(plan)
}

/// The baker of `method`.
pub(crate) fn baker(method: glintbake_format::model::Method) -> &'static dyn methods::BakeMethod {
    methods::find(method).expect("every method of the format is in the registry")
}
