//! The kinds of sample maps, by name.

use core::fmt;

/// A kind of sample normal map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Car paint: overlapping flakes of about 6 texels across, each with one normal.
    ///
    /// Flakes overlap like scales and cover everything; a flake shows 32 · `scale`² texels on average. Normals follow
    /// a GTR distribution of exponent [`FLAKE_GAMMA`](crate::FLAKE_GAMMA) whose α is `roughness`; the wing mirror of
    /// \[AWKK21\], figure 1, is roughness 0.002.
    Flakes,
    /// Metallic paint: cells of a Voronoi diagram, each with one normal.
    ///
    /// The flakes of \[YHJ*14\], section 7: centres are a maximal Poisson-disk sample, at least 4.7 · `scale` texels
    /// apart, so that flakes are of even size, 32 · `scale`² texels on average. Normals are constant over a flake and
    /// follow a Beckmann distribution of α = `roughness`.
    Voronoi,
    /// Polished metal with many fine grooves, straight or slightly bent, in all directions.
    ///
    /// Grooves are 1.6 to 4 · `scale` texels wide and 40 to 400 · `scale` texels long, rounded at the bottom and at
    /// the edges, and fade out at their ends; `roughness` is the slope of the steepest wall. Where grooves cross, the
    /// deeper one decides, as if both had been cut. `density` 1 covers about a third of the map.
    /// The ground has a grain of Beckmann α = 0.03 · `roughness`.
    Scratches,
    /// Brushed metal: streaks along u, so that normals spread mostly along t.
    ///
    /// A Gaussian height field of four octaves; streaks are 1 to 8 · `scale` texels thick and up to some hundred
    /// times as long. Slopes are Gaussian, `roughness` is the RMS length of the slope.
    Brushed,
    /// Brushed metal with shallow round dents.
    ///
    /// The blender of \[YHJ*14\], figure 10: to the heights of [`Brushed`](Self::Brushed) those of dents are added, 12
    /// to 48 · `scale` texels across and with walls about as steep as the brushing. `roughness` is the RMS length of
    /// the slope of both together, `density` 1 covers about a fifth of the map.
    Dents,
    /// A smooth, isotropic Gaussian height field, with bumps about 35 · `scale` texels across.
    ///
    /// The power spectrum is Gaussian too: heights d texels apart correlate as exp(−d²/(4·(8·`scale`)²)). Slopes are
    /// the field's own derivatives, Gaussian, with RMS length `roughness`.
    Waves,
    /// A smooth, isotropic height field of exactly Gaussian power spectrum, with bumps about 18 · `scale` texels
    /// across.
    ///
    /// The snail of \[YHJ*14\], section 7: amplitudes are given and phases random, summed by an inverse Fourier
    /// transform; slopes are the sum's own derivatives. Heights d texels apart correlate as exp(−d²/(4·(4·`scale`)²)),
    /// whatever the seed; slopes are nearly Gaussian, with RMS length `roughness`.
    Spectrum,
    /// A sea under wind along u: crests run along v, 128 · `scale` texels apart, with shorter waves of all directions.
    ///
    /// A Gaussian height field by inverse Fourier transform, of the JONSWAP spectrum (Hasselmann et al. 1973) with the
    /// directional spreading of Hasselmann et al. 1980; waves shorter than eight texels fade. `roughness` is the RMS
    /// length of the slope; a real sea's is 0.1 in a light breeze and 0.3 in a gale (Cox and Munk 1954).
    Ocean,
    /// Leather: pebbles of about 22 · `scale` texels with creases between them, wrinkles and fine pores.
    ///
    /// `roughness` is the RMS length of the slope, `density` scales the number of pores.
    Leather,
    /// No relief: every normal is (0, 0), exactly.
    Flat,
    /// White noise, for stress tests: every texel has its own Beckmann normal of α = `roughness`.
    Noise,
}

/// Every kind, in the order `--help` lists them.
pub const KINDS: &[Kind] = &[
    Kind::Flakes,
    Kind::Voronoi,
    Kind::Scratches,
    Kind::Brushed,
    Kind::Dents,
    Kind::Waves,
    Kind::Spectrum,
    Kind::Ocean,
    Kind::Leather,
    Kind::Flat,
    Kind::Noise,
];

impl Kind {
    /// The word used on the command line and in file names.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flakes => "flakes",
            Self::Voronoi => "voronoi",
            Self::Scratches => "scratches",
            Self::Brushed => "brushed",
            Self::Dents => "dents",
            Self::Waves => "waves",
            Self::Spectrum => "spectrum",
            Self::Ocean => "ocean",
            Self::Leather => "leather",
            Self::Flat => "flat",
            Self::Noise => "noise",
        }
    }

    /// The kind called `name`, if there is one; names are lower case.
    pub fn from_name(name: &str) -> Option<Self> {
        KINDS.iter().copied().find(|kind| kind.name() == name)
    }

    /// One line for `--help`: what the map shows and what roughness means for it.
    pub const fn description(self) -> &'static str {
        match self {
            Self::Flakes => {
                "car paint: overlapping flakes, one normal each; roughness is GTR alpha"
            }
            Self::Voronoi => {
                "metallic paint: even flakes, one normal each; roughness is Beckmann alpha"
            }
            Self::Scratches => "polished metal with fine grooves; roughness is the steepest slope",
            Self::Brushed => "brushed metal, streaks along u; roughness is the RMS slope",
            Self::Dents => "brushed metal with shallow round dents; roughness is the RMS slope",
            Self::Waves => "smooth Gaussian height field; roughness is the RMS slope",
            Self::Spectrum => {
                "height field of Gaussian spectrum by inverse FFT; roughness is RMS slope"
            }
            Self::Ocean => "wind waves running along u; roughness is the RMS slope",
            Self::Leather => "pebbled grain with creases and pores; roughness is the RMS slope",
            Self::Flat => "no relief; roughness is not used",
            Self::Noise => {
                "an independent normal per texel, for stress; roughness is Beckmann alpha"
            }
        }
    }

    /// The roughness that [`Options::new`](crate::Options::new) chooses: clearly visible, not yet theatrical.
    pub const fn default_roughness(self) -> f64 {
        match self {
            Self::Flakes => 0.12,
            Self::Voronoi => 0.12,
            Self::Scratches => 0.6,
            Self::Brushed | Self::Dents | Self::Ocean => 0.2,
            Self::Waves | Self::Spectrum => 0.25,
            Self::Leather => 0.35,
            Self::Flat => 0.0,
            Self::Noise => 0.3,
        }
    }

    /// The largest roughness the kind accepts: 1 where it is a GTR α (1 spreads evenly), else a slope of 100 (89.4°).
    pub const fn max_roughness(self) -> f64 {
        match self {
            Self::Flakes => 1.0,
            _ => 100.0,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
