//! What the stored numbers mean: words shared by the baker, the runtime and the readers of this specification.
//!
//! No algorithm over texels lives here, only the definitions a reader of a package must agree on.

mod bins;
mod blocks;
mod box_pyramid;
mod clusters;
mod footprint;
mod forest;
mod masking;
mod method;
mod mip_lobes;
mod ndf_maps;
mod normal;
mod pyramid;
mod surface;

pub use bins::{BinGrid, Binning, Neighbourhood, disk_grid_resolution};
pub use blocks::{
    BLOCK_SIDE, BLOCK_TEXELS, BlockLayout, PAGE_SIDE, PageLayout, TILE_SIDE, block_name,
    block_place,
};
pub use box_pyramid::{BoxPyramidLayout, PYRAMID_LEVELS, PYRAMID_SIDE};
pub use clusters::{
    CLUSTER_CHILDREN, CLUSTER_LEVELS, ClusterLayout, ClusterLevel, ClusterTile, TileShape,
};
pub use footprint::{Filter, Footprint, MAX_EDGE_TILES, Wrap};
pub use forest::{ForestShape, morton_index};
pub use masking::{MaskingGrid, MaskingPlace};
pub use method::{Kernel, METHODS, Method, beckmann_from_intrinsic, intrinsic_from_beckmann};
pub use mip_lobes::{MIP_LANES, MipLayout, QuiltLayout};
pub use ndf_maps::{NdfMapLayout, NdfPixels};
pub use normal::HalfVector;
pub use pyramid::PyramidLayout;
pub use surface::{CATMULL_ROM, CATMULL_ROM_PARTS, Interpolation, LobeLattice};
