//! `cluster-tree`: moments of clusters in a tree over positions and normals, for every roughness.

use super::{Bake, BakeMethod, bins, masking, roughness};
use crate::build::{cluster_tree, raster};
use crate::error::BakeError;
use crate::normals::NormalMap;
use crate::progress::Stage;
use crate::recipe::{DEFAULT_LEAF_SIZE, MethodRecipe};
use glintbake_format::model::{Kernel, Method};
use glintbake_format::records::{
    FINE_BITS, FINE_STARTS, HALF_RASTER, Instance, LEAVES, NODES, RASTER, ROOTS, RasterLattice,
    Structure,
};

pub(super) struct ClusterTree;

impl BakeMethod for ClusterTree {
    fn method(&self) -> Method {
        Method::ClusterTree
    }

    fn check(&self, recipe: &MethodRecipe) -> Result<(), BakeError> {
        let refuse = |option, value: String, reason: &str, taker: Method| {
            let taker = taker.name();
            Err(BakeError::Option {
                option,
                value,
                reason: format!(
                    "cluster-tree {reason}; leave the option out, or add --method {taker}"
                ),
            })
        };
        if let Some(bins) = recipe.bins {
            let bins = bins.to_string();
            return refuse("--bins", bins, "has no bins", Method::SpecularBins);
        }
        if let Some(kind) = recipe.inverse {
            let reason = "has no bins whose texels are looked for";
            let kind = kind.name().to_owned();
            return refuse("--index", kind, reason, Method::FlakeBins);
        }
        if recipe.leaf_size != DEFAULT_LEAF_SIZE {
            let size = recipe.leaf_size.to_string();
            let reason = "has leaves of 16 texels";
            return refuse("--leaf-size", size, reason, Method::FlakeBins);
        }
        if let Some(level) = recipe.finest_level {
            let level = level.to_string();
            return refuse("--finest-level", level, "keeps every texel", Method::Lean);
        }
        if recipe.exact_normals {
            let reason = "keeps every normal, and with --raster-normals in a raster too";
            return refuse("--exact-normals", String::new(), reason, Method::FlakeBins);
        }
        if let Some(kernel @ Kernel::BinAverage) = recipe.kernel {
            let kernel = kernel.name().to_owned();
            return refuse("--kernel", kernel, "has no bins", Method::SpecularBins);
        }
        roughness::check_range(recipe)
    }

    fn bake(
        &self,
        map: &NormalMap,
        recipe: &MethodRecipe,
        bake: &mut Bake<'_>,
    ) -> Result<(), BakeError> {
        bins::check_sides(map)?;
        let roughness = roughness::or_default(recipe);
        for (place, &alpha) in roughness.iter().enumerate() {
            let instance = Instance {
                layer: bake.layer,
                number: bake.next_number(),
                method: Method::ClusterTree,
                wrap: map.wrap(),
                width: map.width(),
                height: map.height(),
                roughness: Some(alpha),
                filter: recipe.filter,
                structure: Structure::Clusters {
                    kernel: recipe.kernel.unwrap_or(Method::ClusterTree.kernel()),
                },
            };
            bake.begin(Stage::Structures);
            if place == 0 {
                let tree = cluster_tree::build(map);
                bake.plan.add(instance.section(ROOTS), tree.roots);
                bake.plan.add(instance.section(NODES), tree.nodes);
                bake.plan.add(instance.section(LEAVES), tree.leaves);
                if tree.fine.is_empty() {
                    let reason = "every leaf has its normals in 32 bits a texel";
                    bake.leave_out(&instance, "FINE", reason);
                } else {
                    bake.plan.add(instance.section(FINE_BITS), tree.fine);
                    bake.plan
                        .add(instance.section(FINE_STARTS), tree.fine_starts);
                }
                if recipe.raster_normals {
                    let (lattice, blocks) = raster::build(map);
                    let kind = match lattice {
                        RasterLattice::Whole => RASTER,
                        RasterLattice::Half => HALF_RASTER,
                    };
                    bake.plan.add(instance.section(kind), blocks);
                } else {
                    let reason = "not asked for; --raster-normals adds it";
                    bake.leave_out(&instance, "RAST", reason);
                }
            } else {
                let reason = "stored once, with the first roughness: the tree serves them all";
                bake.leave_out(&instance, "NODE", reason);
            }
            masking::add(map, recipe, &instance, bake);
            bake.instances.push(instance);
        }
        Ok(())
    }
}
