//! Answers P-NDF queries from the borrowed bytes of a `.glint` package: evaluate, sample, pdf, for a footprint and a
//! half vector.
//!
//! ```text
//! bytes (mapped, static or read) ──► Package::open ──► Package::ndf ──► eval / sample / pdf
//! ```
//!
//! - `no_std`, no allocation, no unsafe code (two calls behind the feature `simd`); the bytes are used where they lie.
//! - Any bytes are safe: opening checks the header and the section table, queries check every bound. Whether the
//!   *answers* are right is for `glintbake verify` to say.
//! - Arithmetic is f64 throughout: on a CPU scalar f64 costs what f32 costs, and a half vector in f32 is up to 0.04 %
//!   of a standard deviation off at a roughness of 1e-4, which the tail of a lobe multiplies by four.
//!
//! Texture space, half vectors and the density's normalisation are defined in [`glintbake_format::model`], which is
//! re-exported here as [`model`].
#![no_std]
#![cfg_attr(not(feature = "simd"), forbid(unsafe_code))]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unwrap_used
    )
)]

mod error;
mod fetch;
mod lanes;
pub mod layers;
pub mod microfacet;
pub mod ndf;
mod overlap;
mod package;
mod pyramid;
mod scan;
mod simd;

pub use error::QueryError;
pub use glintbake_format::model;
pub use glintbake_format::records::Instance;
pub use glintbake_format::{Fault, Finding};
pub use layers::{Composition, Layer, Material};
pub use ndf::{
    Accuracy, Analytic, BatchError, Bounded, ClusterTree, Facet, FlakeBins, GlobalNdf, Lean, Lobe,
    Lobes, MipLobes, Ndf, NdfMaps, Queries, Setting, SpecularBins, SurfaceNdf, TriangleForm,
};
pub use package::Package;
pub use simd::{Instructions, Work};
