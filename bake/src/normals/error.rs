//! Why a raster gave no normals.

/// Why a raster gave no normals: every message names the input, the cause and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NormalsError {
    /// Texels that cannot be a normal (or a height), the first in reading order named: repaint them, or repair.
    #[error(
        "{name}: texel ({column}, {row}) is {value}: {reason}{}; pass --repair to take the nearest valid texel",
        others_like_it(*others)
    )]
    BadTexels {
        /// What the raster is called.
        name: String,
        /// Column of the first, from 0 at the left.
        column: u32,
        /// Row of the first, from 0 at the top.
        row: u32,
        /// Its samples as the file holds them.
        value: String,
        /// What is wrong with it.
        reason: &'static str,
        /// How many more there are.
        others: u64,
    },

    /// No texel is valid, so there is nothing to repair from: probably the wrong channels, range or kind of input.
    #[error(
        "{name}: none of its {texels} texels is valid (the first is {value}: {reason}); check --input, --channels and \
         --range"
    )]
    NoValidTexel {
        /// What the raster is called.
        name: String,
        /// Texels in the map.
        texels: u64,
        /// Samples of the first, as the file holds them.
        value: String,
        /// What is wrong with it.
        reason: &'static str,
    },

    /// The raster lacks the channels asked for: choose others, or another kind of input.
    #[error("{name}: --channels {channels} cannot be read from {present}; {remedy}")]
    Channels {
        /// What the raster is called.
        name: String,
        /// The word for the channels.
        channels: &'static str,
        /// The channels there are.
        present: String,
        /// What to pass instead.
        remedy: &'static str,
    },

    /// The machine has no memory left for the normals: scale the map down, or cut it.
    #[error(
        "{name}: there is not enough memory for {width} x {height} normals of 8 bytes; scale the map down or cut it \
         into tiles"
    )]
    Memory {
        /// What the raster is called.
        name: String,
        /// Columns of the map.
        width: u32,
        /// Rows of the map.
        height: u32,
    },

    /// An option that has no meaning for this input, or a value out of range: leave it out.
    #[error("{name}: {option} {reason}")]
    Option {
        /// What the raster is called.
        name: String,
        /// The option with its value, as on the command line.
        option: String,
        /// Why not, and what instead.
        reason: String,
    },
}

fn others_like_it(others: u64) -> String {
    match others {
        0 => String::new(),
        others => format!(", and {others} more are no better"),
    }
}
