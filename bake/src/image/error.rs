//! Why a file gave no raster.

use std::io;

/// Why a file gave no raster: every message names the file, the cause and what to do about it.
///
/// Grouped by who can mend it: the path ([`Open`](Self::Open), [`NotAFile`](Self::NotAFile)), the disk
/// ([`Io`](Self::Io)), whoever writes to the file ([`Changed`](Self::Changed)), the file ([`UnknownFormat`](Self::UnknownFormat) to [`TooLarge`](Self::TooLarge)), or the
/// options ([`Selection`](Self::Selection)).
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// There is no such file, or it may not be read: check the path and its permissions.
    #[error("{file}: cannot be opened: {source}; check the path and its permissions")]
    Open {
        /// The path as given.
        file: String,
        /// What the system said.
        source: io::Error,
    },

    /// The path leads to a folder, a pipe or a device: give the path of an image file.
    #[error("{file}: is {found}, not a file; give the path of an image")]
    NotAFile {
        /// The path as given.
        file: String,
        /// "a folder" or "a pipe or a device".
        found: &'static str,
    },

    /// Reading failed midway, for a reason outside the file: check the disk or the network behind it.
    #[error("{file}: reading failed: {source}; check the disk it lies on and try again")]
    Io {
        /// The path as given.
        file: String,
        /// What the system said.
        source: io::Error,
    },

    /// The file is no longer the bytes that were hashed before: run the command again when it is finished.
    #[error(
        "{file}: it changed while it was read; run the command again when nothing writes to it any more"
    )]
    Changed {
        /// The path as given.
        file: String,
    },

    /// The content is no image format this program knows: export as one that it reads.
    #[error(
        "{file}: {found}; export the map as PNG, TIFF, OpenEXR, TGA, WebP or JPEG and try again"
    )]
    UnknownFormat {
        /// The path as given.
        file: String,
        /// What it looks like instead.
        found: String,
    },

    /// The file ends before its image does: copy or export it again.
    #[error("{file}: the {format} file is cut off: {detail}; copy or export it again")]
    Truncated {
        /// The path as given.
        file: String,
        /// The format it starts as.
        format: &'static str,
        /// What was missing.
        detail: String,
    },

    /// The content contradicts its format: export the file again.
    #[error("{file}: the {format} file is damaged: {detail}; export it again")]
    Corrupt {
        /// The path as given.
        file: String,
        /// The format it starts as.
        format: &'static str,
        /// What the decoder said.
        detail: String,
    },

    /// A valid file with a feature that is not read: convert it as the message says.
    #[error(
        "{file}: this kind of {format} file is not read: {detail}; convert it to a plain 8 or 16 bit PNG or a flat \
         OpenEXR"
    )]
    Unsupported {
        /// The path as given.
        file: String,
        /// The format it is.
        format: &'static str,
        /// The feature.
        detail: String,
    },

    /// The header asks for more than the limits allow: scale the map down, cut it, or raise the limits.
    #[error("{file}: {detail}; scale the map down or cut it into tiles")]
    TooLarge {
        /// The path as given.
        file: String,
        /// The size and the limit.
        detail: String,
    },

    /// The layer or the channels asked for are not in the file: choose among those listed.
    #[error("{file}: {detail}; the file holds {available}")]
    Selection {
        /// The path as given.
        file: String,
        /// What was looked for.
        detail: String,
        /// The layers and channels there are.
        available: String,
    },
}

impl ImageError {
    /// The machine has no memory left for the rows of `file`.
    pub(crate) fn out_of_memory(file: &str) -> Self {
        Self::TooLarge {
            file: file.to_owned(),
            detail: "there is not enough memory for its texels".to_owned(),
        }
    }
}
