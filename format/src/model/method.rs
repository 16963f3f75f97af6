//! The methods a package can be baked for, by name and by number.

/// A way to answer P-NDF queries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u16)]
pub enum Method {
    /// Binned NDF over an inverse bin map, Beckmann flakes \[AWKK21\].
    FlakeBins = 1,
    /// Equal-solid-angle bins over an inverse bin map, specular flakes \[ABKK20\].
    SpecularBins = 2,
    /// One Gaussian lobe per cell of a MIP pyramid \[OB10\].
    Lean = 3,
    /// Moments of clusters in a tree over positions and normals: this project's own, docs/cluster-tree.md.
    ClusterTree = 4,
    /// Gaussian lobes of position and normal \[YHMR16\].
    Lobes = 5,
    /// Integrals over the triangles of a piecewise linear normal map \[YHJ*14\].
    Analytic = 6,
    /// Clustered Gaussian lobes, level by level, over a surface quilted from a sample \[TZX22\].
    MipLobes = 7,
    /// Images of the NDFs of the tiles of a tiny example, whose copies make up the surface \[XTXW24\].
    NdfMaps = 8,
}

/// Every method this version knows, in order of its code.
pub const METHODS: &[Method] = &[
    Method::FlakeBins,
    Method::SpecularBins,
    Method::Lean,
    Method::ClusterTree,
    Method::Lobes,
    Method::Analytic,
    Method::MipLobes,
    Method::NdfMaps,
];

impl Method {
    /// The method stored as `code`, if this version knows it.
    pub fn from_code(code: u16) -> Option<Self> {
        METHODS.iter().copied().find(|method| method.code() == code)
    }

    /// The method called `name` on the command line, if this version knows it.
    pub fn from_name(name: &str) -> Option<Self> {
        METHODS.iter().copied().find(|method| method.name() == name)
    }

    /// The number stored in an instance record.
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// The word used on the command line, in metadata and as the name of this method's room in every crate.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FlakeBins => "flake-bins",
            Self::SpecularBins => "specular-bins",
            Self::Lean => "lean",
            Self::ClusterTree => "cluster-tree",
            Self::Lobes => "lobes",
            Self::Analytic => "analytic",
            Self::MipLobes => "mip-lobes",
            Self::NdfMaps => "ndf-maps",
        }
    }

    /// The kernel its answers are densities of; answers of two methods compare only within one kernel. Of a method that
    /// has several, the one it takes unless told otherwise.
    pub const fn kernel(self) -> Kernel {
        match self {
            Self::FlakeBins | Self::ClusterTree => Kernel::Beckmann,
            Self::SpecularBins => Kernel::BinAverage,
            Self::Lean | Self::Lobes | Self::Analytic | Self::MipLobes | Self::NdfMaps => {
                Kernel::Disk
            }
        }
    }
}

/// The distribution each texel's normal is spread by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Kernel {
    /// Beckmann distribution about each texel's normal; texture area is microfacet area.
    Beckmann = 1,
    /// No kernel: the density averaged over the half vector's bin.
    BinAverage = 2,
    /// Gaussian of standard deviation `α / √2` about each texel's normal on the projected disk; what it leaves of the disk
    /// is the probability of no vector \[YHJ*14\].
    Disk = 3,
}

impl Kernel {
    /// The kernel stored as `code`, if this version knows it.
    pub const fn from_code(code: u16) -> Option<Self> {
        match code {
            1 => Some(Self::Beckmann),
            2 => Some(Self::BinAverage),
            3 => Some(Self::Disk),
            _ => None,
        }
    }

    /// The word used in metadata and in the header of query results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Beckmann => "beckmann",
            Self::BinAverage => "bin-average",
            Self::Disk => "disk",
        }
    }
}

/// Beckmann roughness α of a flake whose normals spread with standard deviation `sigma` on the projected disk.
///
/// `α = √2 σr` (Heitz 2014, slope variance of the Beckmann distribution); meant near the pole, where slopes and
/// projected normals agree.
pub fn beckmann_from_intrinsic(sigma: f64) -> f64 {
    core::f64::consts::SQRT_2 * sigma
}

/// Intrinsic roughness σr that corresponds to Beckmann roughness `alpha`; the inverse of [`beckmann_from_intrinsic`].
pub fn intrinsic_from_beckmann(alpha: f64) -> f64 {
    alpha / core::f64::consts::SQRT_2
}
