//! Package files as bytes: mapped, or read where mapping is unwanted.
#![allow(
    unsafe_code,
    reason = "the one module that maps files; see the safety note in `open`"
)]

use std::fs::File;
use std::io::{self, Read};
use std::ops::Deref;
use std::path::Path;

/// The bytes of a package file.
#[derive(Debug)]
pub enum PackageBytes {
    /// Mapped: pages are read as they are touched.
    Mapped(memmap2::Mmap),
    /// Read into memory.
    Read(Vec<u8>),
}

impl Deref for PackageBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Read(bytes) => bytes,
        }
    }
}

/// The bytes of the file at `path`: mapped if `mapped`, else read whole.
///
/// Mapping costs a system call whatever the file's size. A file that another program *truncates* while it is mapped
/// raises SIGBUS on access; glintbake itself only ever replaces packages by rename, which leaves mappings whole.
///
/// # Errors
/// If the file cannot be opened, mapped or read.
pub fn open(path: &Path, mapped: bool) -> io::Result<PackageBytes> {
    // Asked before opening, for opening a pipe that nobody writes to would wait for ever.
    let found = std::fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "it is a folder, not a package",
        ));
    }
    if !found.is_file() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "it is a pipe or a device, not a package file",
        ));
    }
    let mut file = File::open(path)?;
    if mapped {
        // SAFETY: the bytes of a mapping may change when another process writes to the file, which would break the
        // promise of an immutable slice. All readers of these bytes go through zerocopy views of types for which
        // every bit pattern is valid, copy each value out before use, and check every bound anew at each access;
        // none keeps a value's validity across two reads. Files are published by rename, so that glintbake never
        // writes to a file that may be mapped; users who cannot promise the same choose `mapped = false`.
        let map = unsafe { memmap2::Mmap::map(&file)? };
        Ok(PackageBytes::Mapped(map))
    } else {
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        Ok(PackageBytes::Read(bytes))
    }
}
