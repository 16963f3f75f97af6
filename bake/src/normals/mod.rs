//! From planes to unit normals.

mod map;

pub use map::NormalMap;
