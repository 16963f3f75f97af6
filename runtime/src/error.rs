//! Why a query has no answer.

use core::fmt;
use glintbake_format::model::{MAX_EDGE_TILES, Method};
use glintbake_format::{Finding, FourCc};

/// Why a query has no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QueryError {
    /// A coordinate of the footprint or the half vector is NaN or infinite. Check the caller's ray differentials.
    NotFinite,
    /// The footprint spans more tiles than [`MAX_EDGE_TILES`]. Query a footprint of one whole tile instead.
    FootprintTooLarge,
    /// A scan of the footprint would visit more texels than the limit. Use a binned setting, which need not scan.
    TooManyTexels {
        /// The most texels a scan of this map visits.
        limit: u64,
    },
    /// The setting means nothing for this method.
    SettingUnsupported(Method),
    /// The kernel is not one of this method.
    KernelUnsupported(Method),
    /// The filter is not one of this method.
    FilterUnsupported(Method),
    /// The method answers for boxes alone.
    BoxesOnly(Method),
    /// The roughness asked for is out of range.
    RoughnessRange {
        /// The least Beckmann roughness.
        least: f64,
        /// The greatest Beckmann roughness.
        most: f64,
    },
    /// The package was baked without a section that this query needs.
    NotBaked {
        /// Kind of the absent section.
        section: FourCc,
        /// The option of `glintbake bake` that adds it.
        option: &'static str,
    },
    /// No instance of the package has this number.
    NoSuchInstance(u16),
    /// The package is damaged. Verify it, then bake it again.
    Damaged(Finding),
}

impl From<Finding> for QueryError {
    fn from(finding: Finding) -> Self {
        Self::Damaged(finding)
    }
}

impl fmt::Display for QueryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => f.write_str("a coordinate of the query is not a finite number"),
            Self::FootprintTooLarge => write!(
                f,
                "the footprint spans more than {MAX_EDGE_TILES} tiles; query one whole tile for the map's average"
            ),
            Self::TooManyTexels { limit } => write!(
                f,
                "the exact setting would scan more than {limit} texels; use the binned setting for footprints this large"
            ),
            Self::SettingUnsupported(method) => {
                write!(f, "{} has no such setting; leave it out", method.name())
            }
            Self::KernelUnsupported(method) => write!(
                f,
                "{} has no such kernel; it has beckmann and disk",
                method.name()
            ),
            Self::FilterUnsupported(method) => write!(
                f,
                "{} is made for Gaussian footprints; ask with the filter gaussian",
                method.name()
            ),
            Self::BoxesOnly(method) => write!(
                f,
                "{} is made for boxes; ask with the filter box",
                method.name()
            ),
            Self::RoughnessRange { least, most } => write!(
                f,
                "the roughness must lie between {least} and {most} (Beckmann)"
            ),
            Self::NotBaked { section, option } => write!(
                f,
                "the package has no section {section}; bake it with {option}"
            ),
            Self::NoSuchInstance(number) => write!(f, "the package has no instance {number}"),
            Self::Damaged(finding) => write!(f, "the package is damaged: {finding}"),
        }
    }
}

impl core::error::Error for QueryError {}
