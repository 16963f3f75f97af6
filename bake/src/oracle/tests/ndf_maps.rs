//! Footprints of many tiled copies, folded into one example, against the mean of parts small enough not to be folded.

use super::{Random, varied_map};
use crate::oracle::ndf_maps::{Prepared, Surface};
use glintbake_format::model::{Footprint, HalfVector, Wrap};
use glintbake_format::view::Copied;

#[test]
fn folded_footprints_are_the_mean_of_their_parts() {
    let sigma = 0.3;
    let surface = Surface {
        example: varied_map(4, 4, Wrap::Repeat),
        size: 4,
        copies: vec![Copied {
            centre: [2.0, 2.0],
            matrix: [[1.0, 0.25], [-0.5, 1.25]],
        }],
        is_scattered: false,
        scales_slopes: false,
        ground: [0.0; 2],
        ground_deviation: 1.0,
    };
    let mut random = Random(17);
    for [length, width] in [[3.7, 1.9], [9.3, 2.2], [2.0, 2.0]] {
        let edge_1 = random.vector(length);
        let [x, y] = random.vector(0.3);
        let whole = Footprint {
            centre: [random.unit(), random.unit()],
            edge_1,
            edge_2: [
                x - edge_1[1] * width / length,
                y + edge_1[0] * width / length,
            ],
        };
        let parts = 12;
        let part = |column: i32, row: i32| {
            let along = |index: i32| (f64::from(index) + 0.5) / f64::from(parts) - 0.5;
            let (a, b) = (along(column), along(row));
            let edge = |edge: [f64; 2]| edge.map(|along| along / f64::from(parts));
            Footprint {
                centre: [0, 1].map(|axis| {
                    whole.centre[axis] + a * whole.edge_1[axis] + b * whole.edge_2[axis]
                }),
                edge_1: edge(whole.edge_1),
                edge_2: edge(whole.edge_2),
            }
        };
        let parts_of_whole: Vec<Prepared> = (0..parts * parts)
            .map(|index| Prepared::new(surface.clone(), &part(index % parts, index / parts), sigma))
            .collect();
        let folded = Prepared::new(surface.clone(), &whole, sigma);
        for _ in 0..5 {
            let [s, t] = random.vector(0.8);
            let h = HalfVector { s, t };
            // Each is divided by the ripple of its own positions, 0.89 to 1.12.
            let (sum, total) = parts_of_whole
                .iter()
                .fold((0.0, 0.0), |(sum, total), part| {
                    let ripple = part.total();
                    (sum + part.ndf(h, sigma) * ripple, total + ripple)
                });
            let (mean, found) = (sum / total, folded.ndf(h, sigma));
            assert!(
                (found / mean - 1.0).abs() < 1e-5,
                "{length} x {width} at {h:?}: {found}, parts {mean}"
            );
        }
    }
}
