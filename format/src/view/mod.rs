//! Typed views of sections: what the bytes of a package say, bounds-checked as they are read.
//!
//! Opening a view checks element counts, O(1); every later read checks its own bounds, as mapped bytes may change
//! under a reader. Nothing here panics or loops over more than it was asked for.

mod bin_index;
mod bin_map;
mod bin_tables;
mod block_lists;
mod clusters;
mod exact_normals;
mod inverse_bin_map;
mod masking;
mod pyramid;
mod raster;

pub use bin_index::BinIndex;
pub use bin_map::{BinMap, KeyLayout, Keys};
pub use bin_tables::{BinTables, Inverse};
pub use block_lists::{BlockList, BlockLists};
pub use clusters::{ClusterTree, LeafTexel};
pub use exact_normals::ExactNormals;
pub use inverse_bin_map::InverseBinMap;
pub use masking::MaskingTable;
pub use pyramid::{CellMoments, Means, Pyramid, PyramidLevel};
pub use raster::Raster;
