//! Which files a command reads and writes, looked at before it does either.

use crate::exit::{CommandError, Failure};
use glintbake_bake::package::check_destination;
use std::path::{Path, PathBuf};

/// Refuses outputs that cannot be written, or would replace `input` or each other; each comes with its option.
///
/// # Errors
/// [`Failure::Usage`] for an output that is the input or another output, [`Failure::Output`] for the rest.
pub(super) fn check(input: Option<&Path>, outputs: &[(&str, &Path)]) -> Result<(), CommandError> {
    let clash = |option: &str, path: &Path, other: &str| {
        CommandError::new(
            Failure::Usage,
            format!(
                "{option} {}: it is {other}, which would be lost; name another file",
                path.display()
            ),
        )
    };
    for (place, &(option, path)) in outputs.iter().enumerate() {
        if input.is_some_and(|input| same_file(input, path)) {
            return Err(clash(option, path, "the input"));
        }
        for (other, earlier) in &outputs[..place] {
            if same_file(earlier, path) {
                return Err(clash(option, path, &format!("the file of {other} as well")));
            }
        }
        check_destination(path)?;
    }
    Ok(())
}

/// Whether two paths lead to the same place, whether or not a file is there yet.
fn same_file(one: &Path, other: &Path) -> bool {
    match (place(one), place(other)) {
        (Some(one), Some(other)) => one == other,
        _ => false,
    }
}

/// The path without links and dots; `None` if its folder is missing.
fn place(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok().or_else(|| {
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        Some(folder.canonicalize().ok()?.join(path.file_name()?))
    })
}
