//! Why a material file gave no material.

use std::io;

/// Why a material file gave no material: every message names the file, the line and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum MaterialError {
    /// The file cannot be read: check the path and its permissions.
    #[error("{file}: cannot be read: {source}; check the path and its permissions")]
    Open {
        /// The path as given.
        file: String,
        /// What the system said.
        source: io::Error,
    },
    /// It is no TOML, a key is unknown, or a value of another kind than the key's.
    #[error("{file}, line {line}: {message}")]
    Syntax {
        /// The path as given.
        file: String,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
    },
    /// A key is missing, not the layer's, or has a value that cannot be baked.
    #[error("{file}, line {line}: {key} of layer {layer}: {reason}")]
    Key {
        /// The path as given.
        file: String,
        /// The line of the key, or of the layer if the key is missing; from 1.
        line: usize,
        /// The layer, from 0 for the top one.
        layer: usize,
        /// The key.
        key: String,
        /// What is wrong with it and what to write instead.
        reason: String,
    },
    /// No layer, or too many.
    #[error("{file}: has {count} layers; give 1 to {most}, each begun by a line [[layer]]")]
    Count {
        /// The path as given.
        file: String,
        /// Layers there are.
        count: usize,
        /// Layers there may be.
        most: usize,
    },
    /// The image of an opacity map has no channel of its own for it.
    #[error("{file}: {found} where an opacity map has one grey channel, or an alpha; {remedy}")]
    Opacity {
        /// The image.
        file: String,
        /// What it has instead.
        found: String,
        /// What to do.
        remedy: &'static str,
    },
}
