//! Texel weights against cases worked out by hand.

use super::super::texel_axis::TexelAxis;
use super::{by_texel, checked_weights, difference, flat_map, in_texels};
use crate::oracle::{MAX_SPAN_TILES, box_weights};
use glintbake_format::model::{Footprint, Wrap};
use std::collections::BTreeMap;

fn assert_weights(
    centre: [f64; 2],
    edge_1: [f64; 2],
    edge_2: [f64; 2],
    expected: &[((u32, u32), f64)],
) {
    let map = flat_map(8, 4, Wrap::Repeat);
    // Eighths and quarters are exact, so nothing but the oracle's own arithmetic is at stake.
    let weights = checked_weights(&map, &in_texels(&map, centre, edge_1, edge_2));
    let expected: BTreeMap<(u32, u32), f64> = expected.iter().copied().collect();
    assert!(
        difference(&weights, &expected) < 1e-15,
        "{weights:?} instead of {expected:?}"
    );
    assert_eq!(
        weights.keys().collect::<Vec<_>>(),
        expected.keys().collect::<Vec<_>>(),
        "texels without area must be left out"
    );
}

#[test]
fn a_square_on_texel_borders_takes_whole_texels() {
    assert_weights(
        [3.0, 2.0],
        [2.0, 0.0],
        [0.0, 2.0],
        &[
            ((2, 1), 0.25),
            ((3, 1), 0.25),
            ((2, 2), 0.25),
            ((3, 2), 0.25),
        ],
    );
}

#[test]
fn a_texel_under_its_own_square_takes_everything() {
    assert_weights([3.5, 2.5], [1.0, 0.0], [0.0, 1.0], &[((3, 2), 1.0)]);
}

#[test]
fn a_shifted_square_is_shared_by_the_areas() {
    // One texel square, a quarter texel to the right and an eighth down from the texel (3, 1).
    assert_weights(
        [3.75, 1.625],
        [1.0, 0.0],
        [0.0, 1.0],
        &[
            ((3, 1), 0.75 * 0.875),
            ((4, 1), 0.25 * 0.875),
            ((3, 2), 0.75 * 0.125),
            ((4, 2), 0.25 * 0.125),
        ],
    );
}

#[test]
fn a_diamond_is_cut_into_triangles() {
    // |x| + |y| ≤ 2 around a corner of texels: area 8; per quadrant the near texel is whole (1), two are halves.
    let mut expected = Vec::new();
    for (column, row, part) in [(0, 0, 1.0), (1, 0, 0.5), (0, 1, 0.5)] {
        for (x, y) in [
            (4 + column, 2 + row),
            (3 - column, 2 + row),
            (4 + column, 1 - row),
            (3 - column, 1 - row),
        ] {
            expected.push(((x, y), part / 8.0));
        }
    }
    assert_weights([4.0, 2.0], [2.0, 2.0], [2.0, -2.0], &expected);
}

#[test]
fn orientation_and_order_of_the_edges_do_not_matter() {
    let map = flat_map(8, 4, Wrap::Repeat);
    let (e, f) = ([1.7, 0.4], [-0.6, 2.1]);
    let minus = |[x, y]: [f64; 2]| [-x, -y];
    let reference = checked_weights(&map, &in_texels(&map, [3.3, 1.8], e, f));
    for (edge_1, edge_2) in [(f, e), (minus(e), f), (e, minus(f)), (minus(f), minus(e))] {
        let weights = checked_weights(&map, &in_texels(&map, [3.3, 1.8], edge_1, edge_2));
        assert!(difference(&weights, &reference) < 1e-15);
    }
}

#[test]
fn a_triangle_cut_off_by_a_border_has_its_area() {
    // The corner (4.25, 2.5) of a diamond of half diagonal 1.25 reaches 0.25 beyond the border u = 4: 1/16 of 3.125.
    let map = flat_map(8, 4, Wrap::Repeat);
    let weights = checked_weights(
        &map,
        &in_texels(&map, [3.0, 2.5], [1.25, 1.25], [1.25, -1.25]),
    );
    assert!((weights[&(4, 2)] - 0.0625 / 3.125).abs() < 1e-16);
}

#[test]
fn slivers_along_a_border_are_split_by_it() {
    // 2000 × 1e-9 texels, a quarter above and three quarters below the border v = 2, of a map that is wide enough.
    let map = flat_map(4096, 4, Wrap::Repeat);
    let thin = libm::exp2(-30.0);
    let footprint = in_texels(
        &map,
        [2048.0, 2.0 + 0.25 * thin],
        [2000.0, 0.0],
        [0.0, thin],
    );
    let weights = checked_weights(&map, &footprint);
    assert_eq!(weights.len(), 4000);
    for (&(_, row), &weight) in &weights {
        let part = if row == 1 { 0.25 } else { 0.75 };
        assert!((weight - part / 2000.0).abs() < 1e-16, "{row}: {weight}");
    }
}

#[test]
fn small_footprints_on_large_maps_keep_their_digits() {
    // 1e-4 texel wide on a border 12345 texels from the origin: one part in 2³⁸ of a texel off the border.
    let map = flat_map(16384, 2, Wrap::Repeat);
    let off = libm::exp2(-38.0);
    let edge = 1.0 / 8192.0;
    let footprint = in_texels(&map, [12345.0 + off, 1.5], [edge, 0.0], [0.0, edge]);
    let weights = checked_weights(&map, &footprint);
    let right = 0.5 + off / edge;
    assert!((weights[&(12345, 1)] - right).abs() < 1e-15);
    assert!((weights[&(12344, 1)] - (1.0 - right)).abs() < 1e-15);
}

#[test]
fn answers_are_the_same_bits_every_time() {
    let map = flat_map(13, 7, Wrap::Repeat);
    let footprint = in_texels(&map, [3.1, 9.7], [40.3, 2.2], [-7.1, 33.3]);
    assert_eq!(
        by_texel(&box_weights(&map, &footprint)),
        by_texel(&box_weights(&map, &footprint))
    );
}

#[test]
#[should_panic(expected = "span at most")]
fn endless_footprints_are_refused() {
    let map = flat_map(2, 2, Wrap::Repeat);
    let footprint = Footprint {
        centre: [0.0, 0.0],
        edge_1: [MAX_SPAN_TILES, 0.0],
        edge_2: [1.0, 1.0],
    };
    box_weights(&map, &footprint);
}

#[test]
#[should_panic(expected = "finite")]
fn footprints_that_are_not_numbers_are_refused() {
    let map = flat_map(2, 2, Wrap::Clamp);
    let footprint = Footprint {
        centre: [f64::NAN, 0.0],
        edge_1: [0.0, 0.0],
        edge_2: [1.0, 1.0],
    };
    box_weights(&map, &footprint);
}

#[test]
fn a_centre_that_rounds_onto_a_border_stays_where_it_is() {
    // The f64 0.7 is 2⁻⁵¹ / 10 below seven tenths, but 0.7 * 10.0 is 7.
    let map = flat_map(10, 1, Wrap::Repeat);
    let edge = libm::exp2(-40.0);
    let mut footprint = in_texels(&map, [0.0, 0.5], [edge, 0.0], [0.0, 0.5]);
    footprint.centre[0] = 0.7;
    let weights = checked_weights(&map, &footprint);
    let left = 0.5 + libm::exp2(-51.0) / edge;
    assert!((weights[&(6, 0)] - left).abs() < 1e-15, "{weights:?}");
    footprint.edge_1 = [0.0; 2];
    footprint.edge_2 = [0.0; 2];
    assert_eq!(
        checked_weights(&map, &footprint),
        BTreeMap::from([((6, 0), 1.0)])
    );
}

#[test]
fn texels_are_half_open_to_the_last_digit() {
    let axis = |centre| TexelAxis::new(centre, [0.0; 2], 1, Wrap::Repeat);
    assert_eq!(axis(0.0).texel_at(0.0), 0);
    assert_eq!(axis(0.0).texel_at(-1e-300), -1);
    // 1 - 1e-20 has no f64 but lies in texel 0.
    assert_eq!(axis(-1e-20).texel_at(1.0), 0);
    assert_eq!(axis(1e-20).texel_at(1.0), 1);
    assert_eq!(axis(1e-20).texel_at(-1.0), -1);
    assert_eq!(axis(-1e-20).texel_at(-1.0), -2);
}
