//! Output that is either whole or not there.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Why an output file could not be published. The file of that name, if there was one, is as it was.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {}{}", .path.display(), .source, remedy(.source))]
pub struct PublishError {
    /// The output file.
    pub path: PathBuf,
    /// What went wrong.
    pub source: io::Error,
}

fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "; create it first, or name another",
        io::ErrorKind::PermissionDenied => "; check the folder's permissions",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; free some space and run the command again"
        }
        io::ErrorKind::FileTooLarge => {
            "; the file system or a limit of the session (ulimit -f) allows no file of this size"
        }
        _ => "",
    }
}

/// Writes a file at `path` by way of a temporary file in the same folder, renamed when `write` has succeeded.
///
/// Readers, also those that have the old file mapped, see the old file or the new one, never a part. On failure the
/// temporary file is removed and the old file stays. A symbolic link stays a link: the file it leads to is replaced.
///
/// # Errors
/// [`PublishError`] as for [`check_destination`], if the folder is not writable, the disk is full, or `write` fails.
pub fn publish<T>(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<T>,
) -> Result<T, PublishError> {
    let attempt = || {
        let (folder, target) = destination(path)?;
        // Opened here and not by the builder: its errors name the temporary file, which says nothing to the user.
        let mut file = tempfile::Builder::new()
            .prefix(".glintbake-")
            .suffix(".tmp")
            .make_in(folder, |temporary| {
                File::options()
                    .read(true)
                    .write(true)
                    .create_new(true)
                    .open(temporary)
            })?;
        let value = write(file.as_file_mut())?;
        // Some file systems report a full disk only now.
        file.as_file().sync_all()?;
        file.persist(target).map_err(|error| error.error)?;
        Ok(value)
    };
    attempt().map_err(|source| PublishError {
        path: path.to_path_buf(),
        source,
    })
}

/// Refuses a path that [`publish`] could not write to, before the work of making its content is done.
///
/// # Errors
/// [`PublishError`] if the folder is missing or no folder, or there is something other than a file at `path`.
pub fn check_destination(path: &Path) -> Result<(), PublishError> {
    destination(path).map(drop).map_err(|source| PublishError {
        path: path.to_path_buf(),
        source,
    })
}

/// The folder for the temporary file, and the path to rename it to.
fn destination(path: &Path) -> io::Result<(PathBuf, PathBuf)> {
    let target = match fs::metadata(path) {
        Ok(found) if found.is_dir() => {
            return Err(io::Error::new(
                io::ErrorKind::IsADirectory,
                "there is a folder of that name",
            ));
        }
        // Renaming would put a file in the place of the device.
        Ok(found) if !found.is_file() => {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "it is a pipe or a device, not a file",
            ));
        }
        Ok(_) if path.is_symlink() => fs::canonicalize(path)?,
        _ => path.to_path_buf(),
    };
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder.to_path_buf(),
        _ => PathBuf::from("."),
    };
    match fs::metadata(&folder) {
        Ok(found) if found.is_dir() => Ok((folder, target)),
        Ok(_) => Err(io::Error::new(
            io::ErrorKind::NotADirectory,
            format!("{} is not a folder", folder.display()),
        )),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Err(io::Error::new(
            io::ErrorKind::NotFound,
            format!("there is no folder {}", folder.display()),
        )),
        Err(error) => Err(error),
    }
}
