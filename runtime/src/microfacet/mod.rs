//! What turns a P-NDF into a BRDF: distribution, masking, Fresnel, and the glue between them.

pub mod beckmann;
pub mod brdf;
pub mod fresnel;
mod masking;
pub(crate) mod vector;

pub use masking::Masking;
