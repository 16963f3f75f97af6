//! Typed views of sections: what the bytes of a package say, bounds-checked as they are read.
//!
//! Opening a view checks element counts, O(1); every later read checks its own bounds, as mapped bytes may change
//! under a reader. Nothing here panics or loops over more than it was asked for.

mod bin_index;
mod bin_map;
mod bin_tables;
mod block_lists;
mod box_pyramid;
mod clusters;
mod exact_normals;
mod inverse_bin_map;
mod lobes;
mod masking;
mod material;
mod mip_lobes;
mod ndf_maps;
mod pyramid;
mod raster;
mod surface;

pub use bin_index::BinIndex;
pub use bin_map::{BinMap, KeyLayout, Keys};
pub use bin_tables::{BinTables, Inverse};
pub use block_lists::{BlockList, BlockLists};
pub use box_pyramid::{BoxPyramid, PyramidBox};
pub use clusters::{ClusterTree, LeafTexel};
pub use exact_normals::ExactNormals;
pub use inverse_bin_map::InverseBinMap;
pub use lobes::{CellLobe, LobeNormal, Lobes, LobesOfBlock};
pub use masking::MaskingTable;
pub use material::{MaterialLayers, Opacity};
pub use mip_lobes::{MipLobes, NO_CELL};
pub use ndf_maps::{Copied, MAX_NEIGHBOURS, NdfMaps};
pub use pyramid::{CellMoments, Means, Pyramid, PyramidLevel};
pub use raster::Raster;
pub use surface::{GlobalNdf, Normals};

use crate::container::Container;
use crate::finding::Finding;
use crate::records::Instance;

/// What `open` finds with `instance` itself, or else with the first other instance of the same map and method that keeps the
/// same of it: instances that differ in roughness alone share their sections. O(instances).
fn of_map<'a, T>(
    container: &Container<'a>,
    instance: &Instance,
    open: impl Fn(&Container<'a>, &Instance) -> Result<Option<T>, Finding>,
) -> Result<Option<T>, Finding> {
    if let Some(own) = open(container, instance)? {
        return Ok(Some(own));
    }
    for other in container.instances() {
        let other = other?;
        if instance.keeps_the_same_as(&other)
            && let Some(shared) = open(container, &other)?
        {
            return Ok(Some(shared));
        }
    }
    Ok(None)
}
