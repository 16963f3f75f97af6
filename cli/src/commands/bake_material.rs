//! `bake` of a material file: several maps to one package.

use super::bake::{Baked, is_up_to_date, warn, with_folder, write};
use super::paths;
use crate::args::BakeArgs;
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use glintbake_bake::material::{self, MaterialInputs};
use std::path::{Path, PathBuf};

/// Bakes the material that `arguments` name, unless its package is there already.
///
/// # Errors
/// [`Failure::Usage`] for options that the material file is to say; else as of images.
pub(super) fn bake(
    arguments: &BakeArgs,
    outputs: &[(&str, &Path)],
    console: &Console,
) -> Result<Baked, CommandError> {
    if let Some(option) = arguments.first_of_maps() {
        return Err(CommandError::new(
            Failure::Usage,
            format!(
                "{option}: a material file says of each of its maps how it is baked; leave the option out, and add the key {} to the \
                 layers that are meant",
                option.trim_start_matches("--").trim_start_matches("no-")
            ),
        ));
    }
    let recipe = material::read(&arguments.image)?;
    let maps: Vec<Option<PathBuf>> = recipe
        .layers
        .iter()
        .map(|layer| layer.map.as_ref().map(|map| map.path.clone()))
        .collect();
    let opacities = recipe
        .layers
        .iter()
        .filter_map(|layer| layer.opacity_map.clone());
    let mut inputs = vec![arguments.image.clone()];
    inputs.extend(maps.iter().flatten().cloned().chain(opacities));
    for input in &inputs {
        paths::check(Some(input), outputs)?;
    }
    let stages = console.stages();
    let files = MaterialInputs::open(&recipe, &stages)?;
    let up_to_date = !arguments.force && is_up_to_date(&arguments.output, recipe.hash(&files));
    if !up_to_date {
        let baked =
            material::bake(&recipe, &files, arguments.memory, &stages).map_err(|error| {
                // Of several maps the one that is meant.
                files
                    .files()
                    .fold(CommandError::from(error), |error, file| {
                        with_folder(error, file.identity(), file.path())
                    })
            })?;
        write(&arguments.output, &baked.plan, &stages)?;
        stages.clear();
        for (source, map) in baked.sources.iter().zip(&maps) {
            if let (Some(source), Some(map)) = (source, map) {
                warn(console, &source.statistics, map);
            }
        }
    }
    stages.clear();
    Ok(Baked {
        inputs,
        maps,
        up_to_date,
    })
}
