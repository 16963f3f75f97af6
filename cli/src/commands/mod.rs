//! The verbs, one file each.

pub mod bake;
pub mod inspect;
mod open;
pub mod picture;
pub mod query;
pub mod sample;
pub mod verify;
