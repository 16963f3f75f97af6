//! Structures, one per file; none knows which method asks for it.

pub mod bin_map;
pub mod block_lists;
pub mod box_pyramid;
pub mod cluster_tree;
pub mod exact_normals;
pub mod forest;
pub mod global_ndf;
pub mod inverse_bin_map;
pub mod lobes;
pub mod masking;
pub mod mip_lobes;
mod morton;
pub mod ndf_maps;
pub(crate) mod numbers;
pub mod opacity;
pub mod pyramid;
pub mod quilt;
pub mod raster;
pub mod surface;
