//! The sum over texels, against hand-made cases and quadrature.

use super::super::disk::{Prepared, ndf, pdf};
use super::{in_texels, varied_map};
use crate::normals::NormalMap;
use glintbake_format::model::{Filter, HalfVector, Wrap};

#[test]
fn one_texel_is_one_gaussian_of_half_the_squared_roughness() {
    let map = NormalMap::new(1, 1, Wrap::Repeat, vec![[0.25, -0.5]]);
    let footprint = in_texels(&map, [0.5, 0.5], [1.0, 0.0], [0.0, 1.0]);
    let alpha: f64 = 0.1;
    let sigma = alpha / core::f64::consts::SQRT_2;
    for deviations in [0.0, 1.0, 3.0] {
        let h = HalfVector {
            s: 0.25,
            t: -0.5 + deviations * sigma,
        };
        // exp(-d²/2) / (2π σ²)
        let expected =
            libm::exp(-0.5 * deviations * deviations) / (core::f64::consts::PI * alpha * alpha);
        let density = ndf(&map, &footprint, Filter::Box, h, alpha);
        assert!((density / expected - 1.0).abs() < 1e-13);
        let cosine = libm::sqrt(1.0 - h.s * h.s - h.t * h.t);
        let drawn = pdf(&map, &footprint, Filter::Box, h, alpha);
        assert!((drawn / (expected * cosine) - 1.0).abs() < 1e-13);
    }
}

#[test]
fn two_texels_weigh_by_their_area() {
    let map = NormalMap::new(2, 1, Wrap::Repeat, vec![[0.3, 0.0], [-0.3, 0.0]]);
    // A quarter of the first texel, three quarters of the second.
    let footprint = in_texels(&map, [1.25, 0.5], [1.0, 0.0], [0.0, 1.0]);
    let prepared = Prepared::new(&map, &footprint, Filter::Box, 0.05);
    let [first, second] = [0.3, -0.3].map(|s| prepared.ndf(HalfVector { s, t: 0.0 }));
    assert!((second / first - 3.0).abs() < 1e-6, "{first} {second}");
}

#[test]
fn what_the_disk_holds_and_what_lies_beyond_add_up_to_one() {
    let map = varied_map(5, 4, Wrap::Clamp);
    for filter in [Filter::Box, Filter::Gaussian] {
        let footprint = in_texels(&map, [2.2, 1.4], [2.0, 1.0], [-1.0, 1.5]);
        // Normals lie within 0.6 of the middle, so nothing of these kernels lies beyond the rim.
        let prepared = Prepared::new(&map, &footprint, filter, 0.1);
        let steps = 400;
        let step = 2.0 / f64::from(steps);
        let mut inside = 0.0;
        for row in 0..steps {
            for column in 0..steps {
                let at = |place: i32| (f64::from(place) + 0.5) * step - 1.0;
                let h = HalfVector {
                    s: at(column),
                    t: at(row),
                };
                inside += prepared.ndf(h) * step * step;
            }
        }
        // The weights of a Gaussian footprint add up to 1 within the oracle's own quadrature.
        assert!((inside - 1.0).abs() < 1e-7, "{filter:?}: {inside}");
    }
    let rim = NormalMap::new(1, 1, Wrap::Repeat, vec![[1.0, 0.0]]);
    let footprint = in_texels(&rim, [0.5, 0.5], [1.0, 0.0], [0.0, 1.0]);
    let prepared = Prepared::new(&rim, &footprint, Filter::Box, 0.1);
    for outside in [[1.0 + 1e-15, 0.0], [0.9, 0.5], [f64::NAN, 0.0]] {
        let [s, t] = outside;
        let h = HalfVector { s, t };
        assert_eq!((prepared.ndf(h), prepared.pdf(h)), (0.0, 0.0));
    }
    assert!(prepared.ndf(HalfVector { s: 1.0, t: 0.0 }) > 0.0);
}
