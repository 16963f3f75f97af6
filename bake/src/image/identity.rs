//! Which file a package was baked from.

use super::error::ImageError;
use super::paged::{PAGE, PagedFile};
use super::read::open;
use crate::progress::{Progress, Stage};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The identity of an input by its content: what a recipe and a package's metadata remember of the file.
///
/// No folder is kept, so packages baked on two machines from the same file are the same bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// File name without its folder; characters that are not Unicode are replaced.
    pub name: String,
    /// Length in bytes.
    pub bytes: u64,
    /// BLAKE3 hash of the whole content.
    pub blake3: [u8; 32],
}

/// A file that has been hashed, and is decoded only as long as it is still the same bytes.
///
/// A file is read twice: once to learn whether it was baked before, and again to be decoded, in whatever order its
/// format asks for. So that a package never carries the hash of bytes it was not made from, a CRC-32 of every page of
/// 64 KiB is kept from the first reading (4 bytes each), and the second fails with [`ImageError::Changed`] at the
/// first page that differs.
#[derive(Clone, Debug)]
pub struct HashedFile {
    path: PathBuf,
    identity: InputFile,
    checksums: Arc<[u32]>,
}

impl HashedFile {
    /// The file at `path`, hashed.
    ///
    /// Streams it once through a buffer of 64 KiB: about 1 ms for each 1 to 2 MB, and no memory worth naming.
    ///
    /// # Errors
    /// [`ImageError::Open`], [`ImageError::NotAFile`] or [`ImageError::Io`].
    pub fn open(path: &Path, progress: &dyn Progress) -> Result<Self, ImageError> {
        let (mut file, length) = open(path)?;
        let mut hasher = blake3::Hasher::new();
        let mut checksums = Vec::new();
        let mut page = vec![0; PAGE];
        loop {
            let count = read_page(&mut file, &mut page).map_err(|source| ImageError::Io {
                file: path.display().to_string(),
                source,
            })?;
            if count == 0 {
                break;
            }
            hasher.update(&page[..count]);
            checksums.push(crc32fast::hash(&page[..count]));
            let done = hasher.count();
            progress.report(Stage::Hash, done, length.max(done));
        }
        Ok(Self {
            path: path.to_path_buf(),
            identity: InputFile {
                name: file_name(path),
                // Counted while hashing, so that length and hash describe the same bytes.
                bytes: hasher.count(),
                blake3: *hasher.finalize().as_bytes(),
            },
            checksums: checksums.into(),
        })
    }

    /// The path it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its name, length and hash.
    pub fn identity(&self) -> &InputFile {
        &self.identity
    }

    /// The file again, to be decoded.
    pub(super) fn reopen(&self) -> Result<PagedFile, ImageError> {
        let (file, _) = open(&self.path)?;
        Ok(PagedFile::new(
            file,
            self.identity.bytes,
            Some(self.checksums.clone()),
        ))
    }
}

/// The name, length and content hash of the file at `path`; see [`HashedFile::open`].
///
/// # Errors
/// [`ImageError::Open`], [`ImageError::NotAFile`] or [`ImageError::Io`].
pub fn identify(path: &Path) -> Result<InputFile, ImageError> {
    Ok(HashedFile::open(path, &())?.identity)
}

/// Fills `page` from `file`; the number of bytes there were, less than a page only at the end.
fn read_page(file: &mut impl Read, page: &mut [u8]) -> io::Result<usize> {
    let mut count = 0;
    while count < page.len() {
        match file.read(&mut page[count..]) {
            Ok(0) => break,
            Ok(more) => count += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(count)
}

/// The last component of `path`, as text.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
