//! Height maps.

use super::{direction, heights, raster, with};
use crate::image::{Layout, Samples};
use crate::normals::*;
use glintbake_format::model::Wrap;
use std::f64::consts::PI;

#[test]
fn a_plane_keeps_its_slope_to_a_clamped_border() {
    // Rises by 2 texels per column and falls by 0.5 per row; h is exact in f32.
    let (width, height) = (7_u32, 5_u32);
    let samples: Vec<f32> = (0..height)
        .flat_map(|row| (0..width).map(move |column| 2.0 * column as f32 - 0.5 * row as f32))
        .collect();
    let options = with(|options| {
        options.input = Input::Height;
        options.wrap = Wrap::Clamp;
    });
    let (map, statistics) = decode(
        heights(width, height, Samples::F32(samples.clone())),
        &options,
    )
    .unwrap();
    // Uphill is to the right, so the normal leans left; uphill is up the picture, so it leans down.
    let expected = direction([-2.0, -0.5, 1.0]);
    assert!(
        map.texels().iter().all(|texel| *texel == expected),
        "{expected:?}"
    );
    assert_eq!(statistics.covariance, [0.0; 3]);
    assert_eq!(statistics.lengths, None);

    let repeat = with(|options| options.input = Input::Height);
    let (map, _) = decode(heights(width, height, Samples::F32(samples)), &repeat).unwrap();
    assert_eq!(map.texels()[8], expected, "the inside is the same");
    // Over the border the plane falls from column 6 to column 0: (2 - 12) / 2 = -5 a column.
    assert_eq!(map.texels()[7], direction([5.0, -0.5, 1.0]));
}

#[test]
fn a_sine_has_the_slope_of_its_central_differences() {
    let (size, waves, amplitude) = (64_u32, 3.0, 5.0);
    let phase = |index: u32| 2.0 * PI * waves * f64::from(index) / f64::from(size);
    let samples: Vec<f32> = (0..size)
        .flat_map(|row| {
            (0..size).map(move |column| {
                (0.5 + 0.25 * libm::sin(phase(column)) + 0.25 * libm::cos(phase(row))) as f32
            })
        })
        .collect();
    let options = with(|options| {
        options.input = Input::Height;
        options.height_scale = amplitude;
    });
    let (map, statistics) = decode(heights(size, size, Samples::F32(samples)), &options).unwrap();
    // Exactly, (sin(x + d) - sin(x - d)) / 2 = sin(d) cos(x): the derivative, with sin d for d.
    let slope = amplitude * 0.25 * libm::sin(phase(1));
    for (index, texel) in map.texels().iter().enumerate() {
        let (column, row) = (index as u32 % size, index as u32 / size);
        let right = slope * libm::cos(phase(column));
        let down = -slope * libm::sin(phase(row));
        let expected = direction([-right, down, 1.0]);
        for i in 0..2 {
            assert!(
                (texel[i] - expected[i]).abs() < 2e-6,
                "({column}, {row}): {texel:?} against {expected:?}"
            );
        }
    }
    assert!(statistics.mean[0].abs() < 1e-7 && statistics.mean[1].abs() < 1e-7);
}

#[test]
fn integer_heights_are_scaled_to_texels_of_white() {
    let options = with(|options| {
        options.input = Input::Height;
        options.height_scale = 10.0;
        options.wrap = Wrap::Clamp;
    });
    let (map, statistics) = decode(heights(2, 1, Samples::U8(vec![51, 102])), &options).unwrap();
    assert_eq!(map.texels(), [direction([-2.0, 0.0, 1.0]); 2]);
    assert_eq!(
        statistics.lattice,
        Some(Lattice {
            bits: 8,
            step: 10.0 / 255.0 / 2.0
        })
    );
    let (map, _) = decode(
        heights(1, 2, Samples::U16(vec![13_107, 0])),
        &with(|options| {
            options.input = Input::Height;
            options.height_scale = -5.0;
            options.wrap = Wrap::Clamp;
        }),
    )
    .unwrap();
    // Upside down the upper texel is the lower one, by 1: the surface rises down the picture, so it leans up.
    assert_eq!(map.texels(), [direction([0.0, 1.0, 1.0]); 2]);
    // Of red, green and blue, red counts.
    let colours = raster(2, 1, Layout::Rgb, Samples::U8(vec![51, 9, 200, 102, 90, 3]));
    let (coloured, _) = decode(colours, &options).unwrap();
    assert_eq!(coloured.texels(), [direction([-2.0, 0.0, 1.0]); 2]);
    // One texel has no slope, whatever surrounds it.
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let options = with(|options| {
            options.input = Input::Height;
            options.wrap = wrap;
        });
        let (map, _) = decode(heights(1, 1, Samples::U8(vec![77])), &options).unwrap();
        assert_eq!(map.texels()[0].map(f32::to_bits), [0, 0]);
    }
}

#[test]
fn bad_heights_are_named_and_repaired_before_slopes_are_taken() {
    let names = vec!["h".to_owned(), "other".to_owned()];
    let samples = [1.0, f32::NAN, f32::INFINITY, 0.0, 1.0, 5.0];
    let map = || {
        raster(
            3,
            1,
            Layout::Named(names.clone()),
            Samples::F32(samples.to_vec()),
        )
    };
    let options = with(|options| options.input = Input::Height);
    let error = decode(map(), &options).unwrap_err();
    assert_eq!(
        error.to_string(),
        "map.png: texel (1, 0) is inf: it is not a finite height; pass --repair to take the nearest valid texel"
    );
    let options = with(|options| {
        options.input = Input::Height;
        options.repair = true;
    });
    let (map, statistics) = decode(map(), &options).unwrap();
    assert_eq!(map.texels(), [[0.0; 2]; 3]);
    assert_eq!(statistics.repaired, 1);
}

#[test]
fn the_steepest_heights_stay_on_the_disk() {
    let samples = vec![f32::MAX, -f32::MAX, f32::MAX, 0.0];
    let options = with(|options| {
        options.input = Input::Height;
        options.height_scale = 1e9;
        options.wrap = Wrap::Clamp;
    });
    let (map, _) = decode(heights(2, 2, Samples::F32(samples)), &options).unwrap();
    for texel in map.texels() {
        let [s, t] = texel.map(f64::from);
        assert!(
            s * s + t * t <= 1.0 && s * s + t * t > 0.999_999,
            "{texel:?}"
        );
    }
}
