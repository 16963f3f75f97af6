//! Output that is either whole or not there.

use std::fs::File;
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
        io::ErrorKind::NotFound => "; create the folder first, or name another with --output",
        io::ErrorKind::PermissionDenied => "; check the folder's permissions",
        io::ErrorKind::StorageFull | io::ErrorKind::FileTooLarge | io::ErrorKind::QuotaExceeded => {
            "; free some space and run the command again"
        }
        _ => "",
    }
}

/// Writes a file at `path` by way of a temporary file in the same folder, renamed when `write` has succeeded.
///
/// Readers, also those that have the old file mapped, see the old file or the new one, never a part. On failure the
/// temporary file is removed and the old file stays.
///
/// # Errors
/// [`PublishError`] if the folder is missing or not writable, the disk is full, or `write` fails.
pub fn publish<T>(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<T>,
) -> Result<T, PublishError> {
    let attempt = || {
        if path.is_dir() {
            return Err(io::Error::new(
                io::ErrorKind::IsADirectory,
                "there is a folder of that name",
            ));
        }
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".glintbake-").suffix(".tmp");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.tempfile_in(folder)?;
        let value = write(file.as_file_mut())?;
        // Some file systems report a full disk only now.
        file.as_file().sync_all()?;
        file.persist(path).map_err(|error| error.error)?;
        Ok(value)
    };
    attempt().map_err(|source| PublishError {
        path: path.to_path_buf(),
        source,
    })
}
