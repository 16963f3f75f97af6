//! How far a bake has come, for whoever shows it.

/// What a bake is doing, in the order in which it does it.
///
/// Binning and building take turns where a package has several instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The input is hashed; counted in bytes.
    Hash,
    /// The input is decoded into normals; counted in rows.
    Read,
    /// Normals are sorted into bins; counted in instances.
    Bins,
    /// Structures are built over the bins; counted in instances.
    Structures,
    /// The package is written; counted in bytes.
    Write,
}

impl Stage {
    /// The word for it: "hashing", "reading", "binning", "building" or "writing".
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hash => "hashing",
            Self::Read => "reading",
            Self::Bins => "binning",
            Self::Structures => "building",
            Self::Write => "writing",
        }
    }
}

/// Hears how far a bake has come.
///
/// Called some dozens to some thousands of times a bake, from one thread at a time; what it does is waited for.
/// `()` is the listener that does nothing.
pub trait Progress: Sync {
    /// `done` of `total` units of `stage` are done.
    ///
    /// `done` rises to `total` where rows or bytes are counted (again from 0 where a map must be read twice); of
    /// instances it counts those before the one in work.
    fn report(&self, stage: Stage, done: u64, total: u64) {
        let _ = (stage, done, total);
    }
}

impl Progress for () {}
