//! Package files, opened with errors that name the file.

use crate::args::{OpenArgs, QuerySettings, SettingArgs};
use crate::exit::{CommandError, Failure};
use glintbake_bake::package::{self, PackageBytes};
use glintbake_format::check;
use glintbake_runtime::{Material, Package, QueryError};
use std::path::Path;

/// The bytes of the file at `path`.
pub(super) fn bytes(path: &Path, no_mmap: bool) -> Result<PackageBytes, CommandError> {
    package::open(path, !no_mmap).map_err(|error| {
        CommandError::new(
            Failure::Input,
            format!("{}: cannot be opened: {error}", path.display()),
        )
    })
}

/// The package in `bytes`, the content of the file at `path`.
pub(super) fn package<'a>(path: &Path, bytes: &'a [u8]) -> Result<Package<'a>, CommandError> {
    Package::open(bytes).map_err(|finding| CommandError::from(finding).in_file(path.display()))
}

/// The bytes of the package `arguments` name, its checksums compared unless it is trusted.
pub(super) fn checked(arguments: &OpenArgs) -> Result<PackageBytes, CommandError> {
    let path = &arguments.package;
    let bytes = bytes(path, arguments.no_mmap)?;
    let package = package(path, &bytes)?;
    if !arguments.trust {
        let mut first = None;
        check::checksums(package.container(), &mut |finding| {
            first.get_or_insert(finding);
        });
        if let Some(finding) = first {
            return Err(CommandError::from(finding).in_file(path.display()));
        }
    }
    Ok(bytes)
}

/// The layered material in `bytes`, the content of the file `arguments` name; `None` if it holds none.
pub(super) fn material<'a>(
    arguments: &OpenArgs,
    bytes: &'a [u8],
) -> Result<Option<Material<'a>>, CommandError> {
    let path = &arguments.package;
    match Material::open(package(path, bytes)?.container()) {
        Ok(material) => Ok(Some(material)),
        Err(QueryError::NotBaked { .. }) => Ok(None),
        Err(error) => Err(CommandError::from(error).in_file(path.display())),
    }
}

/// What `settings` choose of the package in `bytes`, the content of the file `arguments` name.
pub(super) fn choose<'a>(
    arguments: &OpenArgs,
    settings: &SettingArgs,
    bytes: &'a [u8],
) -> Result<QuerySettings<'a>, CommandError> {
    let path = &arguments.package;
    settings
        .choose(&package(path, bytes)?)
        .map_err(|error| error.in_file(path.display()))
}

/// The same, to be asked for densities with bounds.
pub(super) fn choose_strict<'a>(
    arguments: &OpenArgs,
    settings: &SettingArgs,
    bytes: &'a [u8],
) -> Result<QuerySettings<'a>, CommandError> {
    let path = &arguments.package;
    settings
        .choose_strict(&package(path, bytes)?)
        .map_err(|error| error.in_file(path.display()))
}
