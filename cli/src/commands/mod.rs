//! The verbs, one file each.

pub mod bake;
mod bake_material;
mod describe;
pub mod expand;
pub mod inspect;
mod lattice;
mod open;
mod paths;
pub mod picture;
pub mod query;
mod reference;
pub mod report;
pub mod sample;
pub mod stress;
pub mod verify;
