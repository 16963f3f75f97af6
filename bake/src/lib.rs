//! From normal maps to packages.
#![deny(missing_docs)]

pub mod image;
pub mod normals;
pub mod oracle;
