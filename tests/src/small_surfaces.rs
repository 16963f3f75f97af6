//! Packages of surfaces as another baker may write them: with a global NDF of nine pixels, where ours have a hundred to a side.

use glintbake_bake::PackagePlan;
use glintbake_bake::build::surface;
use glintbake_bake::normals::NormalMap;
use glintbake_format::SectionId;
use glintbake_format::model::{Filter, Interpolation, Method};
use glintbake_format::records::{
    GLOBAL_NDF, GLOBAL_ROOT, INSTANCES, Instance, METADATA, NORMALS, PYRAMID_NODES, PYRAMID_ROOT,
    Structure, TileRoot,
};
use zerocopy::little_endian::{F32, U32};

/// The bytes of `map` baked for `analytic` at each of `roughness`, of which the first has the surface.
pub fn package(map: &NormalMap, interpolation: Interpolation, roughness: &[f64]) -> Vec<u8> {
    let instances: Vec<_> = (1..)
        .zip(roughness)
        .map(|(number, &alpha)| Instance {
            layer: 0,
            number,
            method: Method::Analytic,
            wrap: map.wrap(),
            width: map.width(),
            height: map.height(),
            roughness: Some(alpha),
            filter: Filter::Gaussian,
            structure: Structure::Surface { interpolation },
        })
        .collect();
    let mut plan = PackagePlan::new([0; 32]);
    let records = instances.iter().map(|instance| instance.to_record());
    plan.add_critical(SectionId::shared(INSTANCES), records.collect());
    plan.add(SectionId::shared(METADATA), b"{}".to_vec());
    for (place, instance) in instances.iter().enumerate() {
        if place == 0 {
            let surface = surface::build(map, interpolation);
            plan.add(instance.section(NORMALS), surface.normals);
            plan.add(instance.section(PYRAMID_ROOT), surface.root);
            plan.add(instance.section(PYRAMID_NODES), surface.nodes);
        }
        let root = TileRoot {
            low: [F32::new(-0.5); 2],
            step: [F32::new(0.5); 2],
        };
        let pixels = (1..=9_u32).map(|pixel| U32::new(u32::MAX / 9 * pixel));
        let mut sums: Vec<_> = pixels.collect();
        sums[8] = U32::new(u32::MAX);
        plan.add(instance.section(GLOBAL_ROOT), vec![root]);
        plan.add(instance.section(GLOBAL_NDF), sums);
    }
    plan.to_bytes()
}
