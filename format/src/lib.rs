#![doc = include_str!("../FORMAT.md")]
#![no_std]
#![forbid(unsafe_code)]
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

pub mod check;
mod container;
mod finding;
mod header;
pub mod model;
pub mod records;
mod section;
pub mod version;
pub mod view;

pub use container::Container;
pub use finding::{Fault, Finding};
pub use header::{HEADER_LENGTH, Header};
pub use section::{ENTRY_LENGTH, FLAG_CRITICAL, FourCc, SectionEntry, SectionId};
