use super::*;
use glintbake_format::model::Wrap;

/// Normals that change from texel to texel, with a constant corner.
fn map(width: u32, height: u32) -> NormalMap {
    let texels = (0..width * height)
        .map(|texel| {
            let (x, y) = (texel % width, texel / width);
            if x < width / 4 && y < height / 3 {
                return [0.25, if x % 8 < 4 { -0.5 } else { 0.125 }];
            }
            let (x, y) = (f64::from(x), f64::from(y));
            [
                (0.4 * libm::sin(x * 0.05 + y * 0.02)) as f32,
                (0.3 * libm::cos(y * 0.07 - x * 0.9)) as f32,
            ]
        })
        .collect();
    NormalMap::new(width, height, Wrap::Repeat, texels)
}

#[test]
fn sections_are_as_long_as_the_layout_says_for_any_size() {
    for [width, height] in [[1, 1], [5, 3], [64, 64], [65, 130], [300, 40], [1030, 70]] {
        let layout = ClusterLayout::new(width, height).unwrap();
        let sections = build(&map(width, height));
        assert_eq!(sections.roots.len() as u64, layout.root_count());
        assert_eq!(sections.nodes.len() as u64, layout.node_count());
        assert_eq!(sections.leaves.len() as u64, layout.leaf_count());
        let nodes = layout.level(0).node_count() as usize;
        assert!(sections.fine_starts.is_empty() || sections.fine_starts.len() == nodes);
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let map = map(200, 150);
    let [one, many] = [1, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| build(&map))
    });
    assert_eq!(one, many);
}
