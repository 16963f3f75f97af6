//! Plain f64 answers from normals, never from baked bytes.
//!
//! Everything here follows the papers' formulas term by term and writes out its own areas, bins and densities: of
//! `glintbake_format::model` it takes the plain words (`Filter`, `Footprint`, `HalfVector`, `Neighbourhood`,
//! `Wrap`) and none of the algorithms. Where a fast path and the oracle disagree, two independent derivations disagree.
//!
//! | answer | function | source |
//! |---|---|---|
//! | texel weights `w_k` of a parallelogram | [`box_weights`] | \[AWKK21\] eq. 12 |
//! | texel weights `w_k` of a Gaussian | [`gaussian_weights`] | \[YHJ*14\] §4, integrated over texels |
//! | flake kernel `D^α(h, m)` | [`beckmann`] | \[AWKK21\] eq. 14 |
//! | masking G1 of the map's own normals | [`masking`] | \[AWKK21\] eq. 5 |
//! | D and its pdf, Beckmann flakes | [`flake_bins`] | \[AWKK21\] eq. 11, 15, 18 |
//! | D and its pdf, specular flakes | [`specular_bins`] | \[ABKK20\] §2 |
//! | D and its pdf, Gaussians on the disk | [`disk`] | \[YHJ*14\] |
//! | the integral over a piecewise-linear surface | [`analytic`] | \[YHJ*14\] eq. 6 |
//! | the same by counting samples | [`binning`] | \[YHJ*14\] Fig. 9 |
//! | the sum over 4D lobes of position and normal | [`lobes`] | \[YHMR16\], \[TZX22\] eq. 3-6 |
//! | the same over copies of an example, in boxes | [`ndf_maps`] | \[XTXW24\] §6 |
//! | the model of `lean`: one lobe by MIP-mapped moments | [`lean`] | \[OB10\], \[Tok05\] |
//! | layered materials | [`layers`] | \[XTXW24\] eq. 3, \[AWKK21\] §6 |
//!
//! Cost is no concern: a query visits every texel under its footprint.

pub mod analytic;
mod beckmann;
pub mod binning;
mod direction;
pub mod disk;
mod double_double;
pub mod flake_bins;
mod gauss_legendre;
mod gaussian;
pub mod layers;
pub mod lean;
pub mod lobes;
mod masking;
pub mod ndf_maps;
mod polygon;
mod segment;
pub mod specular_bins;
mod surface;
mod texel_axis;
mod weights;

#[cfg(test)]
mod tests;

pub use beckmann::beckmann;
pub use gaussian::gaussian_weights;
pub use masking::{LEAST_COSINE, masking};
pub use weights::{MAX_SPAN_TILES, TexelWeight, box_weights, texel_weights};
