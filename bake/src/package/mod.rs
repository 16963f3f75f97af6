//! Packages on disk: planned, written, published by rename, mapped.

mod map;
mod plan;
mod publish;

pub use map::{PackageBytes, open};
pub use plan::PackagePlan;
pub use publish::{PublishError, check_destination, publish};
